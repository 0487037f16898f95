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
The copy of everything readable in a damaged bag into a new one, and the count of losses.

Each file is read once. If only its end tells what its beginning meant, it is read once more.
"""

from __future__ import annotations

from contextlib import ExitStack
import os
from pathlib import Path
from typing import Callable, Sequence

from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.mcap.chunk_writer import COMPRESSIONS
from heading_intercompare.bags.packed_files import PlainFile
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.rosbag2.bag_files import BagFiles, find_files, METADATA
from heading_intercompare.bags.rosbag2.bag_yaml import list_parts
from heading_intercompare.bags.settings import BagSettings

from .file_salvage import FileSalvage, Plan
from .recovered import Recovered
from .scanner import Salvage, Sound
from .unreadable_sectors import open_with_holes

#: The compressions in the settings, by MCAP's names.
_NAMES = {written: name for name, written in COMPRESSIONS.items()}


def _find_files(source: Path) -> tuple[BagFiles, str]:
    """Return the files of a bag, and why its metadata cannot be read: then all count."""
    try:
        list_parts(source / METADATA)
    except BagError as error:
        return find_files(source, []), error.problem.partition(';')[0]
    except OSError as error:
        return find_files(source, []), error.strerror or str(error)
    return find_files(source), ''


def recover(source: str | os.PathLike[str], target: str | os.PathLike[str],
            settings: BagSettings | None = None,
            progress: Callable[[str], None] = lambda text: None, *,
            unproven: bool = False) -> Recovered:
    """
    Write everything readable of a bag into a new one.

    Parameters
    ----------
    source
        An MCAP file or a rosbag2 directory, cut, damaged or complete; metadata.yaml may be
        missing. It is never changed.
    target
        The rosbag2 directory to write; it must not exist. It gets a metadata record `recovery`
        with the counts.
    settings
        Settings of the new bag. Without them, chunks keep their compression; with them, chunks
        with another compression are compressed again. Intact chunks keep their size.
    progress
        Called with the progress in words.
    unproven
        Also keep the messages of chunks whose checksum is wrong, as far as their lengths and log
        times are possible. The new bag says how many there are.

    Returns
    -------
    Recovered
        What was kept and what was lost.

    Raises
    ------
    OSError
        If the source cannot be read or the target cannot be written.
    BagError
        If nothing in the source is readable, the source changes while it is read, or the target
        exists or lies inside the source.

    Notes
    -----
    If the recovery stops for any reason, there is no target.

    """
    source, target = Path(source), Path(target)
    if target.exists():
        raise BagError('already exists; a bag is never overwritten', target)
    listed, problem = _find_files(source)
    if Path(os.path.realpath(source)) in Path(os.path.realpath(target)).parents:
        raise BagError(f'lies inside the bag to recover; write it next to {source}', target)
    holes, others = _sort_out(listed.paths)
    cut = [(file.source, file.problem) for file in holes if file.problem]
    plan: Plan | None = Plan(_guess_compression(holes))
    while plan is not None:
        new = settings or BagSettings(compression=_NAMES[plan.compression])
        with ExitStack() as undo:
            bag = BagWriter(target, new, whole=True)
            undo.callback(bag.abandon)
            salvage = FileSalvage(
                bag, plan, compression=None if settings is None else COMPRESSIONS[new.compression],
                unproven=unproven)
            for file in holes:
                salvage.copy(file, holes[file], progress)
            plan = salvage.next_plan()
            if plan is None:
                total = salvage.total
                _note_files(total, source, listed, problem, cut + others)
                if not total.messages and (total.messages_lost or not salvage.worthwhile):
                    raise BagError('nothing in it is readable: ' + (
                        '; '.join(total.notes[:3]) or 'it holds no message'), source)
                bag.metadata('recovery', total.describe(source, salvage.earlier))
                bag.close()
                undo.pop_all()
    return total


def _sort_out(paths: Sequence[Path]
              ) -> tuple[dict[PlainFile, list[int]], list[tuple[Path, str]]]:
    """Return the files that can be opened, and why others cannot; OSError if none can."""
    holes: dict[PlainFile, list[int]] = {}
    others: list[tuple[Path, str]] = []
    for path in paths:
        try:
            file = PlainFile(path)
            open_with_holes(file.place, []).close()
            holes[file] = []
        except OSError as error:
            if len(others) + 1 == len(paths):
                raise
            others.append((path, error.strerror or str(error)))
    return holes, others


def _guess_compression(holes: dict[PlainFile, list[int]]) -> str:
    """Return MCAP's name of the compression of the first intact chunk."""
    for file in holes:
        with open_with_holes(file.place, holes[file]) as opened:
            for item in Salvage(opened).scan():
                if isinstance(item, Sound) and item.run is not None:
                    return item.run.chunks[0].compression
    return COMPRESSIONS[BagSettings().compression]


def _note_files(total: Recovered, source: Path, listed: BagFiles, problem: str,
                unread: list[tuple[Path, str]]) -> None:
    """Note what is wrong with the files of a bag, apart from their content."""
    for path, why in unread:
        total.note(path, why)
    if problem:
        total.note(source / METADATA, problem)
    for oddity in listed.oddities:
        total.note(source, oddity)
    for name in listed.absent:
        total.note(source / name, 'is missing')
    total.messages_known = total.messages_known and not (unread or listed.absent)
