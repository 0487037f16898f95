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

"""The files of the conformance tests of MCAP: written as the originals, and read whole."""

from __future__ import annotations

from bags.mcap_conformance import CONTENTS, digest
import pytest

#: SHA-256 of `digest`. On 28 November 2026 each file had the SHA-256 and the size of the original.
DIGESTS = {
    'NoData': '5892e94ef0815f1a4f59e480ed0091709de46e54b75c14326c3ffdd08b0776b4',
    'OneSchemalessMessage': '63d2478e8019351cbf7c725acd292391192a716d6e188faed844c9f6af18838c',
    'OneMessage': '554370bf0295ac98edbcae30a217efc0cba8e2a95dd30b27e656f8ef4953c6ee',
    'OneAttachment': 'a5b5b2d9fd878cfbb4243b0ed7ad43106a0e1c9f6a4056a689a205c79eef0894',
    'OneMetadata': '771ee0953df247d8fc2a2d042897a65e872ab0e4f7511f06818915d94865d090',
    'TenMessages': 'a7e65ac78ca77067beab7b2e86dededb2fcec652e3158295606b8ac19fb00387'}


@pytest.mark.parametrize('name', CONTENTS)
def test_files_are_those_of_the_originals(name):
    """Each digest covers the name, the SHA-256 and the size of each file of an input."""
    assert digest(name) == DIGESTS[name]
