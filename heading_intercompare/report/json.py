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

from dataclasses import replace
import json
from pathlib import Path
from typing import Callable, TYPE_CHECKING, TypeVar

import numpy as np

from heading_intercompare.core.typed_reader import VerdictError
from heading_intercompare.core.verdict.verdict_document import Verdict
from heading_intercompare.replaced_file import replace_file
from heading_intercompare.special_files import read_once

from .contents.identification import verdict_id

if TYPE_CHECKING:
    from heading_intercompare.core.sensors.sensors_verdict import SensorsVerdict

_Kind = TypeVar('_Kind')

NOT_JUDGED = 'printed from a file, not judged here'
"""What a verdict that was read says of itself."""

CONFIRMED = 'printed from a file, and judged again from its inputs, which agree'
"""What it says where its inputs were at hand and gave the same verdict."""


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
        If the text is not JSON, or not a verdict, or its figures contradict each other; the
        message is one line.

    """
    verdict = parse_any(text)
    if not isinstance(verdict, Verdict):
        raise VerdictError('is a verdict on several sensors, not on one; take one of its '
                           'verdicts')
    return verdict


def parse_any(text: str | bytes) -> Verdict | SensorsVerdict:
    """Return the verdict on one sensor, or on several, in a JSON text; errors as `parse`."""
    verdict = parse_unchecked(text)
    _check(verdict)
    return label(verdict, NOT_JUDGED)


def parse_unchecked(text: str | bytes) -> Verdict | SensorsVerdict:
    """Return the verdict in a JSON text as it stands, for one who judges its inputs himself."""
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


def label(verdict: Verdict | SensorsVerdict, words: str) -> Verdict | SensorsVerdict:
    """Return a verdict that says where it comes from, with its id; so do those in it."""
    if isinstance(verdict, Verdict):
        return _label_alone(verdict, words)
    return replace(verdict, provenance=_provenance(verdict, words), verdicts={
        name: _label_alone(of_sensor, words) for name, of_sensor in verdict.verdicts.items()})


def _label_alone(verdict: Verdict, words: str) -> Verdict:
    return replace(verdict, provenance=_provenance(verdict, words))


def _provenance(verdict: Verdict | SensorsVerdict, words: str) -> str:
    return f'{words}; verdict id {verdict_id(verdict)}'


def _check(verdict: Verdict | SensorsVerdict) -> None:
    """Raise VerdictError if a verdict does not follow from its own figures."""
    # Only now: they load what judges.
    from heading_intercompare.core.sensors.sensors_consistency import check_sensors_consistency
    from heading_intercompare.core.verdict.consistency import (
        check_consistency,
        ContradictionError,
    )
    try:
        with np.errstate(all='ignore'):
            if isinstance(verdict, Verdict):
                check_consistency(verdict)
            else:
                check_sensors_consistency(verdict)
    except VerdictError:
        raise
    except (ArithmeticError, LookupError, TypeError, ValueError) as error:
        # A changed figure may be anything, such as a variance below 0.
        raise ContradictionError(f'its figures give no verdict ({error}): the file was changed'
                           ) from error


def read(path: str | Path) -> Verdict:
    """
    Read a verdict that `write` or a node has written.

    Raises
    ------
    OSError
        If the file cannot be read.
    VerdictError
        If the file holds no verdict, or one that contradicts itself; the message names the file
        and the problem.

    """
    return _read(path, parse)


def read_unchecked(path: str | Path) -> Verdict | SensorsVerdict:
    """Read a verdict as it stands, for one whose signature or inputs are checked."""
    return _read(path, parse_unchecked)


def read_any(path: str | Path) -> Verdict | SensorsVerdict:
    """Read a verdict on one sensor, or on several; errors as `read`."""
    return _read(path, parse_any)


def _read(path: str | Path, parse_text: Callable[[bytes], _Kind]) -> _Kind:
    try:
        return parse_text(read_once(path))
    except VerdictError as error:
        raise type(error)(f'{path}: {error}') from error
