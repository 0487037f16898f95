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

"""Writes verdicts as JSON files and reads them back."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

from heading_intercompare.core.typed_reader import VerdictError
from heading_intercompare.core.verdict.verdict_document import Verdict
from heading_intercompare.replaced_file import replace_file

if TYPE_CHECKING:
    from heading_intercompare.core.sensors.sensors_verdict import SensorsVerdict


def render(verdict: Verdict | SensorsVerdict) -> str:
    """Return the verdict as JSON text; a figure that is not finite is null."""
    return json.dumps(verdict.to_dict(), indent=1, ensure_ascii=False, allow_nan=False) + '\n'


def write(verdict: Verdict | SensorsVerdict, path: str | Path) -> None:
    """Write the verdict."""
    # The name of a file may have bytes that are not UTF-8.
    replace_file(path, render(verdict), 'backslashreplace')


def parse(text: str | bytes) -> Verdict:
    """
    Return the verdict in a JSON text from `render` or from the report of a node.

    Raises
    ------
    VerdictError
        If the text is not JSON, or not a verdict; the message is one line.

    """
    verdict = parse_any(text)
    if not isinstance(verdict, Verdict):
        raise VerdictError('is a verdict on several sensors, not on one; take one of its '
                           'verdicts')
    return verdict


def parse_any(text: str | bytes) -> Verdict | SensorsVerdict:
    """Return the verdict on one sensor, or on several, in a JSON text; errors as `parse`."""
    # A node that writes the verdicts on one sensor needs nothing of several.
    from heading_intercompare.core.sensors.sensors_verdict import is_of_sensors, SensorsVerdict
    try:
        document = json.loads(text)
        kind = SensorsVerdict if is_of_sensors(document) else Verdict
        return kind.from_dict(document)
    except VerdictError:
        raise
    except UnicodeDecodeError:
        raise VerdictError('is not UTF-8') from None
    except RecursionError:
        raise VerdictError('is not JSON of a verdict: nested too deeply') from None
    except ValueError as error:
        raise VerdictError(f'is not JSON: {error}') from error


def read(path: str | Path) -> Verdict:
    """
    Read a verdict that `write` or a node has written.

    Raises
    ------
    OSError
        If the file cannot be read.
    VerdictError
        If the file holds no verdict; the message names the file and the problem.

    """
    try:
        return parse(Path(path).read_bytes())
    except VerdictError as error:
        raise VerdictError(f'{path}: {error}') from error


def read_any(path: str | Path) -> Verdict | SensorsVerdict:
    """Read a verdict on one sensor, or on several; errors as `read`."""
    try:
        return parse_any(Path(path).read_bytes())
    except VerdictError as error:
        raise VerdictError(f'{path}: {error}') from error
