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

"""File names in place of paths: a protocol says nothing about the computer that wrote it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import PurePath
import re
from typing import Any, Iterator, Mapping, Sequence

from heading_intercompare.core.verdict.verdict_document import Input, Verdict

#: A topic is no path, whatever it looks like.
_TOPICS = ('ts_topic', 'rs_topic')


def name_files(inputs: Sequence[Input], sources: Sequence[str] = ()) -> dict[str, str]:
    """
    Return the names of all files that a verdict mentions, by their paths.

    Parameters
    ----------
    inputs
        The inputs of the verdict, with the files that they mention.
    sources
        The sources of its runs.

    Examples
    --------
    >>> name_files([Input('day1/trial'), Input('/data/day2/trial')])
    {'day1/trial': 'trial', '/data/day2/trial': 'trial (2)'}

    """
    names: dict[str, str] = {}
    for path in dict.fromkeys([*_list_paths(inputs), *sources]):
        name = _name(path)
        n_before = sum(_name(earlier) == name for earlier in names)
        names[path] = f'{name} ({n_before + 1})' if n_before else name
    return names


def _name(path: str) -> str:
    # Two logs that are judged together stand in one path, as a source or as two antennas.
    return ''.join(PurePath(part).name or part for part in re.split('( and |, )', path))


def _list_paths(inputs: Sequence[Input]) -> Iterator[str]:
    for recording in inputs:
        yield from filter(None, (recording.path, recording.same_as, recording.continues))
        yield from recording.made_from or ()


def replace_paths(thing: Any, names: Mapping[str, str]) -> Any:
    """Return text, or the texts of nested mappings and lists, with names in place of paths."""
    if isinstance(thing, str):
        # A path may begin with another one.
        for path in sorted(names, key=len, reverse=True):
            thing = thing.replace(path, names[path])
        return thing
    if isinstance(thing, Mapping):
        return {replace_paths(key, names): inner if key in _TOPICS else replace_paths(inner, names)
                for key, inner in thing.items()}
    if isinstance(thing, (list, tuple)):
        return [replace_paths(inner, names) for inner in thing]
    return thing


def hide_paths(verdict: Verdict, names: Mapping[str, str]) -> Verdict:
    """Return the verdict with names in place of paths in all its texts, but for its settings."""
    changed = {path: name for path, name in names.items() if path != name}
    if not changed:
        return verdict
    mapping = verdict.to_dict()
    shown = Verdict.from_dict({**replace_paths(mapping, changed), 'settings': mapping['settings'],
                               'settings_sha256': mapping['settings_sha256']})
    return replace(shown, provenance=verdict.provenance)
