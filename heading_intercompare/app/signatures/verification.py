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

"""Whether a signature holds, and whether the inputs and recordings of a verdict are unchanged."""

from __future__ import annotations

from dataclasses import dataclass, replace
import os
from pathlib import Path
from typing import Iterable

from heading_intercompare.app.inputs import find_input, sha256
from heading_intercompare.app.sources.file_hash import hash_files
from heading_intercompare.bags.rosbag2.bag_chain import read_chain
from heading_intercompare.core.count_words import count_words
from heading_intercompare.core.sensors.sensors_verdict import SensorsVerdict
from heading_intercompare.core.verdict.verdict_document import Input, RecordedChunks, Verdict
from heading_intercompare.drivers.log_lines.log_files import is_several, list_files
from heading_intercompare.drivers.logs import LogReader
from heading_intercompare.readers.registry import is_verdict, sources_of
from heading_intercompare.report import json

from .manifest import compare_with_manifest, manifest_path, write_manifest
from .ssh_signature import read_signature, sign_file, signature_path, SignatureError

GOOD, BROKEN, UNKNOWN = 0, 1, 3
"""What a check says: it holds, it does not, nobody can tell; exit codes of ``verify``."""


@dataclass(frozen=True, slots=True)
class Checked:
    """What a check says of a path, in a line, and its meaning: `GOOD`, `BROKEN` or `UNKNOWN`."""

    line: str
    meaning: int


def sign_path(path: str, key: str) -> Path:
    """Sign a file, or the manifest of a folder; errors as `sign_file` and `hash_folder`."""
    return sign_file(write_manifest(path) if os.path.isdir(path) else path, key)


def verify_path(path: str, signers: str | None) -> list[Checked]:
    """
    Return what the signature of a file or a folder says; of a verdict also its bags and logs.

    Raises
    ------
    OSError
        If a file cannot be read.
    ValueError
        If `ssh-keygen` is not installed, or a folder has something that is no file.

    """
    if os.path.isdir(path):
        manifest = os.fspath(manifest_path(path))
        differences = compare_with_manifest(path) if os.path.exists(manifest) else []
        if not differences:
            return [_check_signature(path, manifest, signers)]
        return [Checked(f'{path}: changed, for it differs from {manifest}', BROKEN),
                *(Checked(f'  {line}', BROKEN) for line in differences),
                _check_signature(manifest, manifest, signers)]
    checked = _check_signature(path, path, signers)
    if checked.meaning == BROKEN or not is_verdict(path):
        return [checked]
    # A signed verdict may be that of an older rule, which gave other words.
    verdict = (json.read_unchecked if checked.meaning == GOOD else json.read_any)(path)
    return [checked, *(_check_input(entry, path) for entry in verdict.inputs),
            *(_check_recording(recording, path) for recording in _list_recordings(verdict))]


def _check_signature(path: str, signed: str, signers: str | None) -> Checked:
    """Return what the signature of a file says, which may stand for a folder."""
    try:
        signature = None if path != signed and not os.path.exists(signed) else read_signature(
            signed, signers)
    except SignatureError as error:
        return Checked(str(error), BROKEN)
    if signature is None:
        return Checked(f'{path}: not signed, for there is no {signature_path(signed)}', UNKNOWN)
    return Checked(f'{path}: {signature.words}', GOOD if signature.name else UNKNOWN)


def with_signature(verdict: Verdict | SensorsVerdict, path: str,
                   signers: str | None) -> Verdict | SensorsVerdict:
    """Return a verdict that knows who signed its file; errors as `read_signature`."""
    signature = read_signature(path, signers)
    if signature is None:
        return verdict
    words = signature.words
    if isinstance(verdict, Verdict):
        return replace(verdict, signed=words)
    return replace(verdict, signed=words, verdicts={
        name: replace(of_sensor, signed=words) for name, of_sensor in verdict.verdicts.items()})


def _check_input(entry: Input, verdict: str) -> Checked:
    """Return whether an input holds the data that were judged; it may not be at hand."""
    place = _find_place(entry.path, verdict)
    if place is None or entry.sha256 is None:
        why = 'not at hand' if place is None else 'of unknown SHA-256'
        return Checked(f'  input {entry.path}: {why}, so it is not checked', GOOD)
    try:
        digest = sha256(place) if entry.not_taken is None else hash_files(_list_log(place))
    except (OSError, ValueError) as error:
        return Checked(f'  input {place}: cannot be read: {error}', BROKEN)
    if digest == entry.sha256:
        return Checked(f'  input {place}: holds the data that were judged', GOOD)
    return Checked(f'  input {place}: holds other data than those that were judged (SHA-256 '
                   f'{digest}, not {entry.sha256})', BROKEN)


def _list_recordings(verdict: Verdict | SensorsVerdict) -> Iterable[RecordedChunks]:
    """Return what a verdict, or those on several sensors, say of recordings, each once."""
    verdicts = [verdict] if isinstance(verdict, Verdict) else verdict.verdicts.values()
    return dict.fromkeys(recording for of_sensor in verdicts
                         for recording in of_sensor.recordings or ())


def _check_recording(recording: RecordedChunks, verdict: str) -> Checked:
    """Return whether a bag begins with the chunks that a live verdict names."""
    place = find_input(recording.path, verdict)
    if place is None:
        return Checked(f'  recording {recording.path}: not at hand, so it is not checked', GOOD)
    try:
        chain = read_chain(place, max(recording.chunks, 0))
    except (OSError, ValueError) as error:
        return Checked(f'  recording {place}: cannot be read: {error}', BROKEN)
    n_chunks = count_words(recording.chunks, 'chunk')
    if (chain.chunks, chain.sha256) == (recording.chunks, recording.sha256):
        return Checked(f'  recording {place}: holds the first {n_chunks} that the live verdict '
                       'names, unchanged', GOOD)
    problem = (f'its first {n_chunks} are not those' if chain.chunks == recording.chunks else
               f'it holds {count_words(chain.chunks, "chunk")}, fewer than the {n_chunks}')
    return Checked(f'  recording {place}: does not hold: {problem} that the live verdict names. '
                   'It was changed, or it is a recovered or rewritten copy; look for the bag as '
                   'it was recorded', BROKEN)


def _find_place(path: str, verdict: str) -> str | None:
    """Return where an input lies, which may be a pattern of names; None if it is not at hand."""
    matched = is_several(path) and list_files(path)
    return find_input(path, verdict) or (path if matched else None)


def _list_log(place: str) -> list[str]:
    """Return the files of a log in the order in which they are read."""
    if os.path.isfile(place):
        return [place]
    return [*map(os.fspath, sources_of(place))] or LogReader(place).paths
