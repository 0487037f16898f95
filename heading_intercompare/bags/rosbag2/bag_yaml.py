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

"""The YAML texts of a rosbag2 bag: metadata.yaml and the QoS of its topics, version 9."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache
import json
from pathlib import Path
import re
from typing import Any, Iterator, Mapping, Sequence

from heading_intercompare.bags.errors import BagError
from heading_intercompare.yaml_file import load_yaml, YamlError

_VERSION = 9
_DISTRIBUTION = 'jazzy'
#: The starting time that rosbag2 writes for a bag without messages.
_NEVER = 2**63 - 1
_FOREVER = {'sec': 9223372036, 'nsec': 854775807}
_DEPTH = 1000
#: Upper bounds of the queue depth and of the bytes in a file name.
_DEPTHS, _NAME_BYTES = 10**9, 255
#: A metadata.yaml that is longer without its topics is rejected, and longer QoS profiles of a
#: topic are ignored. A hundred thousand files or a thousand publishers need less.
_MOST_BYTES, _MOST_QOS_BYTES = 2**24, 2**18
#: The same with its topics: some ninety thousand of them.
_MOST_WITH_TOPICS = 2**26
_TOPICS = re.compile(rb'^  topics_with_message_count:\n', re.MULTILINE)
_NEXT_ENTRY = re.compile(rb'^ {0,2}[^ \n-]', re.MULTILINE)
_PLAIN = re.compile(r'[A-Za-z/][\w./-]*')
_WHOLE = 'rosbag2_bagfile_information'
_WORDS = ('true', 'false', 'yes', 'no', 'on', 'off', 'null', 'y', 'n')


#: Metadata up to version 8 uses the numbers of rmw instead of words.
_NUMBERED = {
    'history': {'0': 'system_default', '1': 'keep_last', '2': 'keep_all', '3': 'unknown'},
    'reliability': {'0': 'system_default', '1': 'reliable', '2': 'best_effort', '3': 'unknown'},
    'durability': {'0': 'system_default', '1': 'transient_local', '2': 'volatile',
                   '3': 'unknown'},
}


@dataclass(frozen=True, slots=True)
class Qos:
    """
    Quality of service that a publisher offers, in the words of rosbag2.

    Attributes
    ----------
    history
        'keep_last', 'keep_all', 'system_default' or 'unknown'.
    depth
        Messages kept.
    reliability
        'reliable', 'best_effort', 'system_default' or 'unknown'.
    durability
        'volatile', 'transient_local', 'system_default' or 'unknown'.

    """

    history: str = 'keep_last'
    depth: int = _DEPTH
    reliability: str = 'reliable'
    durability: str = 'volatile'

    @classmethod
    def of_yaml(cls, text: str) -> 'Qos':
        """Return the first profile in the metadata of a channel; defaults for missing values."""
        return _read_qos(text) if len(text) <= _MOST_QOS_BYTES else cls()

    def rows(self) -> list[dict[str, Any]]:
        """Return a list with this profile, in the form of rosbag2."""
        return [{
            'history': self.history, 'depth': self.depth, 'reliability': self.reliability,
            'durability': self.durability, 'deadline': _FOREVER, 'lifespan': _FOREVER,
            'liveliness': 'automatic', 'liveliness_lease_duration': _FOREVER,
            'avoid_ros_namespace_conventions': False}]

    def to_yaml(self) -> str:
        """Return the value of `offered_qos_profiles` in the metadata of an MCAP channel."""
        return '\n'.join(_lines(self.rows(), ''))


@lru_cache(maxsize=64)
def _read_qos(text: str) -> Qos:
    """Return the first profile of a text; cached, as most topics of a bag share a profile."""
    try:
        profiles = load_yaml(text, _MOST_QOS_BYTES)
    except YamlError:
        return Qos()
    first = profiles[0] if isinstance(profiles, list) and profiles else {}
    policies: dict[str, Any] = {}
    for name, words in _NUMBERED.items() if isinstance(first, Mapping) else ():
        word = str(first.get(name))
        if type(first.get(name)) in (str, int) and re.fullmatch(r'\w+', word):
            policies[name] = words.get(word, word)
    depth = first.get('depth') if isinstance(first, Mapping) else None
    if type(depth) is int and 0 <= depth < _DEPTHS:
        policies['depth'] = depth
    return Qos(**policies)


@dataclass(slots=True)
class TopicRow:
    """One topic of metadata.yaml."""

    name: str
    type_name: str
    type_hash: str
    qos: Qos
    count: int = 0
    encoding: str = 'cdr'


@dataclass(slots=True)
class PartInfo:
    """The entry of metadata.yaml for one file of the bag; times in nanoseconds."""

    path: str
    start_ns: int | None = None
    end_ns: int | None = None
    count: int = 0
    topics: list[TopicRow] = field(default_factory=list)


def _scalar(value: Any) -> str:
    if value is None:
        return '~'
    if isinstance(value, bool):
        return 'true' if value else 'false'
    if isinstance(value, int):
        return str(value)
    text: str = value
    if _PLAIN.fullmatch(text) and text.lower() not in _WORDS:
        return text
    # Escape characters that parsers treat as the end of a line, or reject.
    return ''.join(letter if letter.isprintable() else f'\\u{ord(letter):04x}'
                   for letter in json.dumps(text, ensure_ascii=False))


def _lines(value: Any, indent: str) -> Iterator[str]:
    """Yield mappings and lists as YAML in block style; empty ones in flow style."""
    if isinstance(value, Mapping):
        for name, inner in value.items():
            if isinstance(inner, (Mapping, list)) and inner:
                yield f'{indent}{_scalar(name)}:'
                yield from _lines(inner, indent + '  ')
            else:
                empty = '[]' if isinstance(inner, list) else '{}'
                text = empty if isinstance(inner, (Mapping, list)) else _scalar(inner)
                yield f'{indent}{_scalar(name)}: {text}'
    else:
        for inner in value:
            if isinstance(inner, Mapping):
                first, *others = _lines(inner, indent + '  ')
                yield f'{indent}- {first.lstrip()}'
                yield from others
            else:
                yield f'{indent}- {_scalar(inner)}'


def _span(parts: Sequence[PartInfo]) -> dict[str, Any]:
    """Return the entries for starting time, duration and number of messages."""
    starts = [part.start_ns for part in parts if part.start_ns is not None]
    start_ns = min(starts, default=_NEVER)
    ends = [part.end_ns for part in parts if part.end_ns is not None]
    end_ns = max(ends, default=start_ns)
    return {'duration': {'nanoseconds': end_ns - start_ns},
            'starting_time': {'nanoseconds_since_epoch': start_ns},
            'message_count': sum(part.count for part in parts)}


def bag_metadata(parts: Sequence[PartInfo], custom_data: Mapping[str, str]) -> str:
    """
    Return the description of a bag in the form of the MCAP metadata record `rosbag2`.

    Parameters
    ----------
    parts
        The files and their topics, in order.
    custom_data
        Free entries.

    """
    counts: dict[str, int] = {}
    topics: dict[str, TopicRow] = {}
    for part in parts:
        for row in part.topics:
            topics[row.name] = row
            counts[row.name] = counts.get(row.name, 0) + row.count
    rows = {'version': _VERSION, 'storage_identifier': 'mcap', **_span(parts),
            'topics_with_message_count': [{'topic_metadata': {
                'name': name, 'type': row.type_name, 'serialization_format': row.encoding,
                'offered_qos_profiles': row.qos.rows(), 'type_description_hash': row.type_hash},
                'message_count': counts[name]} for name, row in topics.items()],
            'compression_format': '', 'compression_mode': '',
            'relative_file_paths': [part.path for part in parts],
            'files': [{'path': part.path, **_span([part])} for part in parts],
            'custom_data': dict(custom_data) or None, 'ros_distro': _DISTRIBUTION}
    return '\n'.join(_lines(rows, '')) + '\n'


def metadata_file(parts: Sequence[PartInfo], custom_data: Mapping[str, str]) -> str:
    """Return the text of metadata.yaml; see `bag_metadata`."""
    inner = bag_metadata(parts, custom_data).splitlines()
    return '\n'.join([f'{_WHOLE}:', *(f'  {line}' for line in inner)]) + '\n'


def _is_file_name(name: str) -> bool:
    """Tell whether a file can have this name."""
    return name not in ('', '..') and '\0' not in name and len(name.encode()) <= _NAME_BYTES


def list_parts(path: Path) -> list[str]:
    """
    Return the file names that a metadata.yaml lists, without folders.

    Parameters
    ----------
    path
        The metadata.yaml; if there is no such file, the list is empty.

    Raises
    ------
    BagError
        If it is not metadata of rosbag2; the message has the line and the remedy.

    """
    if not path.is_file():
        return []
    with path.open('rb') as file:
        data = file.read(_MOST_WITH_TOPICS + 1)
    try:
        if len(data) > _MOST_WITH_TOPICS:
            raise YamlError(f'longer than {_MOST_WITH_TOPICS} bytes')
        if len(data) > _MOST_BYTES:
            data = _leave_out_topics(data)
        if len(data) > _MOST_BYTES:
            raise YamlError(f'longer than {_MOST_BYTES} bytes without its topics')
        parts = _parts_in(load_yaml(data.decode(), _MOST_BYTES))
    except UnicodeDecodeError as error:
        line = data.count(b'\n', 0, error.start) + 1
        raise _make_error(path, YamlError('not UTF-8', line)) from error
    except YamlError as error:
        raise _make_error(path, error) from error
    return list(filter(_is_file_name, (Path(part).name for part in parts)))


def _leave_out_topics(data: bytes) -> bytes:
    """Return metadata without the topics, whose lines stay empty: they are not read from there."""
    begin = _TOPICS.search(data)
    if begin is None:
        return data
    after = _NEXT_ENTRY.search(data, begin.end())
    end = len(data) if after is None else after.start()
    return data[:begin.start()] + b'\n' * data.count(b'\n', begin.start(), end) + data[end:]


def _parts_in(metadata: Any) -> list[str]:
    """Return the files that metadata list; YamlError if the metadata are not of rosbag2."""
    whole = metadata.get(_WHOLE) if isinstance(metadata, Mapping) else None
    if not isinstance(whole, Mapping):
        raise YamlError(f'{_WHOLE} is missing')
    parts = whole.get('relative_file_paths')
    parts = [] if parts is None else parts
    if not isinstance(parts, list) or not all(isinstance(part, str) for part in parts):
        raise YamlError('relative_file_paths must be a list of names')
    return parts


def _make_error(path: Path, fault: YamlError) -> BagError:
    """Return the error for a faulty metadata.yaml, with the line."""
    line = '' if fault.line is None else f'line {fault.line}: '
    return BagError(f'{line}{fault}; `recover` reads the bag without this file, and so do all '
                    'other commands once it is removed', path)
