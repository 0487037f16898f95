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

"""The manifest of a folder: a line of SHA-256 for each file, in the form of ``sha256sum``."""

from __future__ import annotations

import os
from pathlib import Path
import re

from heading_intercompare.app.sources.file_hash import hash_files
from heading_intercompare.replaced_file import replace_file

_LINE = re.compile(rb'(\\?)([0-9a-f]{64}) [ *](.+)')
_ESCAPES = {b'\\': b'\\\\', b'\n': b'\\n', b'\r': b'\\r'}


def manifest_path(folder: str | os.PathLike[str]) -> Path:
    """Return where the manifest of a folder lies, beside it; its names begin with the folder."""
    place = Path(folder)
    if place.name in ('', '..'):
        place = Path(os.path.abspath(folder))
    return place.with_name(f'{place.name}.sha256')


def hash_folder(folder: str | os.PathLike[str]) -> dict[bytes, str]:
    """
    Return the SHA-256 of each file in and below a folder, by its name in the manifest.

    Raises
    ------
    OSError
        If a file cannot be read.
    ValueError
        If it has something that is no file, or no file at all.

    """
    root = os.fsencode(os.path.abspath(folder))
    above = os.path.dirname(root)
    digests: dict[bytes, str] = {}
    for place, folders, names in os.walk(root, onerror=_raise):
        for name in (*names, *(name for name in folders
                               if os.path.islink(os.path.join(place, name)))):
            path = os.path.join(place, name)
            if not os.path.isfile(path):
                raise ValueError(f'{os.fsdecode(path)}: is no file, so nobody can sign it; '
                                 'take it out of the folder')
            digests[os.path.relpath(path, above)] = hash_files([os.fsdecode(path)])
    if not digests:
        raise ValueError(f'{os.fspath(folder)}: has no file to sign')
    return digests


def write_manifest(folder: str | os.PathLike[str]) -> Path:
    """Write the manifest of a folder, and return where it lies; errors as `hash_folder`."""
    place = manifest_path(folder)
    replace_file(place, b''.join(_compose_line(name, digest)
                               for name, digest in sorted(hash_folder(folder).items())))
    return place


def compare_with_manifest(folder: str | os.PathLike[str]) -> list[str]:
    """
    Return how a folder differs from its manifest: a line for each file; errors as `hash_folder`.

    A line that is none of ``sha256sum`` counts as a difference, too.
    """
    place = manifest_path(folder)
    stated: dict[bytes, str] = {}
    differences = []
    for number, line in enumerate(place.read_bytes().split(b'\n')[:-1], 1):
        if (match := _LINE.fullmatch(line)) is None:
            differences.append(f'{place}: line {number} is none of sha256sum')
        else:
            stated[_unescape(match[3]) if match[1] else match[3]] = match[2].decode()
    digests = hash_folder(folder)
    for name in sorted({*stated, *digests}):
        if stated.get(name) != digests.get(name):
            fault = ('missing' if name not in digests else 'added after the signature'
                     if name not in stated else 'changed')
            differences.append(f'{os.fsdecode(name)}: {fault}')
    return differences


def _compose_line(name: bytes, digest: str) -> bytes:
    escaped = b''.join(_ESCAPES.get(bytes([code]), bytes([code])) for code in name)
    mark = b'\\' if escaped != name else b''
    return b'%s%s  %s\n' % (mark, digest.encode(), escaped)


def _unescape(name: bytes) -> bytes:
    return re.sub(rb'\\([\\nr])', lambda match: {
        b'\\': b'\\', b'n': b'\n', b'r': b'\r'}[match[1]], name)


def _raise(error: OSError) -> None:
    raise error
