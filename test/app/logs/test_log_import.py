# Copyright 2026 The heading_intercompare authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""The import of a log says where its headings come from."""

from __future__ import annotations

import hashlib

from heading_intercompare.app.logs.log_import import import_log
from heading_intercompare.drivers.settings import DriverSettings


def test_a_log_comes_with_its_hash_and_what_was_not_taken(tmp_path):
    text = b't_ns,heading_deg\n1400000000000000000,1.0\n1400000001000000000,bad\n'
    (tmp_path / 'a.csv').write_bytes(text)
    shown = []
    found = import_log(str(tmp_path / 'a.csv'), DriverSettings(), shown.append)
    assert found.headings.heading_deg.tolist() == [1.0]
    assert shown[-1] == f'100% of {tmp_path}/a.csv read'
    assert found.sha256 == hashlib.sha256(text).hexdigest() and found.size == len(text)
    assert found.words_not_taken == '1 bad_field'
    assert found.origin['headings'] == 1 and found.origin['not_taken.bad_field'] == 1
