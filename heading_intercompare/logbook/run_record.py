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

"""The record of a judged run in a logbook, by which it is judged together with other runs."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
import hashlib
import json
from typing import Any
import zlib

from heading_intercompare.core.conditions.shared_readings import Fingerprint
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.typed_reader import make_plain, read_plain, VerdictError
from heading_intercompare.core.verdict.run_evidence import RunEvidence
from heading_intercompare.core.verdict.verdict_document import (
    Input,
    read_settings,
    RunVerdict,
    Verdict,
)

#: Most grains of a fingerprint in a record, so that a day has some 25 kB.
_MOST_GRAINS = 4096


@dataclass(frozen=True, slots=True)
class RunRecord:
    """
    A judged run, with all that it takes to judge it together with others.

    Attributes
    ----------
    settings
        By which it was judged.
    inputs
        The sources of its readings; empty for a run that was judged live.
    run
        Its verdict, with its evidence.

    """

    settings: Settings
    inputs: tuple[Input, ...]
    run: RunVerdict


def encode_record(verdict: Verdict, run: RunVerdict) -> bytes | None:
    """Return the record of a run of a verdict; None if that was read, without its evidence."""
    if run.evidence is None:
        return None
    text = run.evidence.fingerprint
    if text is not None:
        text = _shorten(text)
    record = {'settings': verdict.settings.to_mapping(),
              'inputs': make_plain(_find_inputs(verdict, run)), 'run': make_plain(run),
              'evidence': make_plain(replace(run.evidence, fingerprint=text), exact=True)}
    return zlib.compress(json.dumps(record, sort_keys=True).encode())


@lru_cache(maxsize=64)
def _shorten(text: str) -> str:
    """Return a fingerprint with the grains of a record; a node asks for its runs repeatedly."""
    return Fingerprint.from_text(text).shorten(_MOST_GRAINS).to_text()


def _find_inputs(verdict: Verdict, run: RunVerdict) -> tuple[Input, ...]:
    """Return the inputs that a run came from; two logs have one source together."""
    named = tuple(entry for entry in verdict.inputs if entry.path == run.source)
    return named or tuple(entry for entry in verdict.inputs if entry.not_taken is not None)


def decode_record(data: bytes, digest_of_settings: str) -> RunRecord:
    """
    Return the record of a run, given the hash of its settings.

    Raises
    ------
    VerdictError
        If it is no record, or one of other settings.

    """
    try:
        record: Any = json.loads(zlib.decompress(data))
        settings, inputs, run, evidence = (
            record[key] for key in ('settings', 'inputs', 'run', 'evidence'))
    except (zlib.error, ValueError, TypeError, KeyError) as error:
        raise VerdictError(f'is no record of a run: {type(error).__name__}') from error
    return RunRecord(
        settings=read_settings(settings, digest_of_settings),
        inputs=read_plain(tuple[Input, ...], inputs, 'inputs'),
        run=replace(read_plain(RunVerdict, run, 'run'),
                    evidence=read_plain(RunEvidence, evidence, 'evidence')))


def hash_record(data: bytes) -> str:
    """Return the SHA-256 of a record, which its row holds."""
    return hashlib.sha256(data).hexdigest()
