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

"""The command line in this process, for tests: a verdict in JSON, and a refusal."""

from __future__ import annotations

import json
from typing import Any, Sequence

from heading_intercompare.cli import main

#: The norms of most tests of the command line.
NORMS = ('--set', 'norms.sigma_max_deg=0.3', '--set', 'norms.sigma_ref_max_deg=0.1')


def analyze_json(capsys: Any, *arguments: object, norms: Sequence[str] = NORMS,
                 ) -> tuple[dict[str, Any], list[str]]:
    """Return the verdict of `analyze` as JSON, and its notes."""
    capsys.readouterr()
    assert main(['analyze', *map(str, arguments), *norms, '--quiet', '--json', '-']) == 0
    verdict, notes = capsys.readouterr()
    return json.loads(verdict), notes.splitlines()


def refusal(capsys: Any, *arguments: object) -> str:
    """Return the one line with which a command rejects its arguments."""
    capsys.readouterr()
    assert main([*map(str, arguments)]) == 2
    out, err = capsys.readouterr()
    assert out == '' and err.count('\n') == 1
    assert err.startswith('heading-intercompare: error: ')
    return err.removeprefix('heading-intercompare: error: ').rstrip('\n')
