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

"""The files of a bag: those that its metadata.yaml lists, or all if there is no such list."""

from __future__ import annotations

from pathlib import Path
import re
from typing import NamedTuple

from heading_intercompare.bags.mcap.mcap_file import mcap_files
from heading_intercompare.bags.packed_files import plain_name

from .bag_yaml import list_parts

__all__ = ['BagFiles', 'find_files', 'METADATA']

METADATA = 'metadata.yaml'
"""The file of a rosbag2 that lists the others."""

#: Names in a message.
_MOST_NAMED = 5
_NUMBERED = re.compile(r'(.*_)(?:0|[1-9]\d*)\.mcap(\.zstd)?')


class BagFiles(NamedTuple):
    """
    The files of a bag.

    Attributes
    ----------
    paths : list of Path
        The files to read, in natural order of their names.
    absent : list of str
        Names of files that do not exist: listed ones, and links that lead nowhere.
    unlisted : list of str
        Names of files that are left out, because the list names others.

    """

    paths: list[Path]
    absent: list[str]
    unlisted: list[str]

    @property
    def missing(self) -> list[str]:
        """Which files are missing, in words; of many only the first are named."""
        more = len(self.absent) - _MOST_NAMED
        return [f'{name} is missing' for name in self.absent[:_MOST_NAMED]] + (
            [f'{more} more files are missing'] if more > 0 else [])

    @property
    def oddities(self) -> list[str]:
        """Return what a user should know about the files that are left out, in words."""
        if not self.unlisted:
            return []
        more = len(self.unlisted) - _MOST_NAMED
        return [f'left out, because {METADATA} does not list it: '
                + ', '.join(self.unlisted[:_MOST_NAMED]) + (f' and {more} more' if more > 0
                                                            else '')]


def find_files(path: Path, listed: list[str] | None = None) -> BagFiles:
    """
    Return the files of a bag.

    A copy of a file in the folder of a bag would double its readings. So files are left out that
    metadata.yaml does not list. Two kinds are read all the same: those with the name of the
    listed ones and another number, because a recorder may be killed before it lists its newest
    file; and all files if none of those listed is there.

    Parameters
    ----------
    path : Path
        A rosbag2 directory; or a file of any name, which is then the only one.
    listed : list of str, optional
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
    there, wanted = ({plain_name(name) for name in names}
                     for names in ([each.name for each in everything], listed))
    absent = [name for name in listed if not (path / name).is_file()
              and plain_name(name) not in there]
    # A link that leads nowhere, or to itself.
    absent += sorted({each.name for each in path.glob('*.mcap*') if each.is_symlink()
                      and not each.exists()} - {*absent})
    known = {each for each in everything if plain_name(each.name) in wanted}
    if not known:
        return BagFiles(everything, absent, [])
    stems = {_stem(name) for name in listed} - {None}
    paths = [each for each in everything if each in known or _stem(each.name) in stems]
    kept = set(paths)
    return BagFiles(paths, absent, [each.name for each in everything if each not in kept])


def _stem(name: str) -> str | None:
    """Return what rosbag2 puts before the number of a file; None for other names."""
    found = _NUMBERED.fullmatch(name)
    return None if found is None else found[1]
