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

"""
The files of a bag: those that its metadata.yaml lists, or all if there is no such list.

A file that equals another byte by byte is a copy, whatever its name, and is left out.
"""

from __future__ import annotations

from collections import Counter
from contextlib import suppress
from pathlib import Path
import re
from typing import NamedTuple, Sequence

from heading_intercompare.bags.mcap.mcap_file import mcap_files
from heading_intercompare.bags.packed_files import plain_name

from .bag_yaml import list_parts

METADATA = 'metadata.yaml'
"""The file of a rosbag2 that lists the others."""

#: Names in a message.
_MOST_NAMED = 5
#: The index at the end of a file tells most files of one size apart.
_END_BYTES, _PIECE_BYTES = 2**12, 2**20
_NUMBER = r'(?:0|[1-9]\d*)'
#: Number, name and local time of its beginning since rosbag2 #2265, name and number before.
_NUMBERED = (
    re.compile(rf'(?P<number>{_NUMBER})(?P<stem>_.+_)\d{{4}}_\d\d_\d\d-\d\d_\d\d_\d\d\.mcap'
               r'(?:\.zstd)?'),
    re.compile(rf'(?P<stem>.*_)(?P<number>{_NUMBER})\.mcap(?:\.zstd)?'))
#: Longer gaps in the numbers come from names with dates.
_MOST_GAP = 1000


class BagFiles(NamedTuple):
    """
    The files of a bag.

    Attributes
    ----------
    paths
        The files to read, in natural order of their names.
    absent
        Names of files that do not exist: listed ones, links that lead nowhere, and those whose
        numbers are missing between others.
    unlisted
        Names of files that are left out, because the list names others.
    copies
        Names of files that are left out, because they equal another file, and of that file.

    """

    paths: list[Path]
    absent: list[str]
    unlisted: list[str]
    copies: list[tuple[str, str]] = []

    @property
    def missing(self) -> list[str]:
        """Which files are missing, in words; of many only the first are named."""
        more = len(self.absent) - _MOST_NAMED
        return [f'{name} is missing' for name in self.absent[:_MOST_NAMED]] + (
            [f'{more} more files are missing'] if more > 0 else [])

    @property
    def oddities(self) -> list[str]:
        """Return what a user should know about the files that are left out, in words."""
        return [f'left out, because {why}: {", ".join(names[:_MOST_NAMED])}'
                + (f' and {len(names) - _MOST_NAMED} more' if len(names) > _MOST_NAMED else '')
                for why, names in (
                    (f'{METADATA} does not list it', self.unlisted),
                    ('it is a copy', [f'{copy} (of {name})' for copy, name in self.copies]))
                if names]


def find_files(path: Path, listed: list[str] | None = None) -> BagFiles:
    """
    Return the files of a bag.

    A copy of a file in the folder of a bag would double its readings. So files are left out that
    metadata.yaml does not list. Two kinds are read all the same: those with the name of the
    listed ones and another number and time, because a recorder may be killed before it lists its
    newest file; and all files if none of those listed is there. Of files with the same bytes only
    one is read, the first that is listed.

    Parameters
    ----------
    path
        A rosbag2 directory; or a file of any name, which is then the only one.
    listed
        The names in metadata.yaml; read from it by default.

    Raises
    ------
    OSError
        If metadata.yaml cannot be read.
    BagError
        If it is damaged, or if a directory holds no MCAP file.

    """
    everything = mcap_files(path)
    if not path.is_dir():
        return BagFiles(everything, [], [])
    listed = list_parts(path / METADATA) if listed is None else listed
    present, listed_names = ({plain_name(name) for name in names}
                             for names in ([file.name for file in everything], listed))
    absent = [name for name in listed if not (path / name).is_file()
              and plain_name(name) not in present]
    # A link that leads nowhere, or to itself.
    absent += sorted({file.name for file in path.glob('*.mcap*') if file.is_symlink()
                      and not file.exists()} - {*absent})
    absent += _find_gaps(present, listed_names)
    listed_files = {file for file in everything if plain_name(file.name) in listed_names}
    paths = everything
    if listed_files:
        stems = {_split_name(name)[0] for name in listed} - {''}
        paths = [file for file in everything
                 if file in listed_files or _split_name(file.name)[0] in stems]
    selection = set(paths)
    copies = _find_copies([file for file in paths if file in listed_files]
                          + [file for file in paths if file not in listed_files])
    return BagFiles([file for file in paths if file not in copies], absent,
                    [file.name for file in everything if file not in selection],
                    [(copy.name, of.name) for copy, of in copies.items()])


def _find_copies(paths: Sequence[Path]) -> dict[Path, Path]:
    """Return the files that equal an earlier file byte by byte, and that file."""
    copies: dict[Path, Path] = {}
    seen: dict[tuple[int, bytes], list[Path]] = {}
    sizes = Counter(path.stat().st_size for path in paths)
    for path in paths:
        size = path.stat().st_size
        if not size or sizes[size] < 2:
            continue
        with suppress(OSError):
            with path.open('rb') as file:
                file.seek(max(size - _END_BYTES, 0))
                alike = seen.setdefault((size, file.read(_END_BYTES)), [])
            of = next((candidate for candidate in alike if _are_equal(path, candidate)), None)
            if of is None:
                alike.append(path)
            else:
                copies[path] = of
    return copies


def _are_equal(path: Path, candidate: Path) -> bool:
    """Tell whether two files of one size have the same bytes."""
    if path.samefile(candidate):
        return True
    with path.open('rb') as file, candidate.open('rb') as candidate_file:
        while piece := file.read(_PIECE_BYTES):
            if piece != candidate_file.read(_PIECE_BYTES):
                return False
    return True


def _split_name(name: str) -> tuple[str, int]:
    """Return what the files of a bag of rosbag2 have in common, and the number; '' for others."""
    match = next(filter(None, (form.fullmatch(name) for form in _NUMBERED)), None)
    return ('', 0) if match is None else (match['stem'], int(match['number']))


def _find_gaps(present: set[str], listed: set[str]) -> list[str]:
    """
    Return the names of the files whose numbers are missing between others, as `bag_1.mcap`.

    rosbag2 begins with 0 and leaves no number out. Up to its last number metadata.yaml knows all.
    """
    numbers: dict[str, set[int]] = {}
    for stem, number in map(_split_name, present | listed):
        if stem:
            numbers.setdefault(stem, set()).add(number)
    gaps = []
    for stem, known in sorted(numbers.items()):
        last_listed = max((number for listed_stem, number in map(_split_name, listed)
                           if listed_stem == stem), default=0)
        ordered = sorted(number for number in known if number >= last_listed) if 0 in known else []
        for before, after in zip(ordered, ordered[1:]):
            if after - before <= _MOST_GAP:
                gaps += [f'{number}{stem}*.mcap' if stem.startswith('_') else
                         f'{stem}{number}.mcap' for number in range(before + 1, after)]
    return gaps
