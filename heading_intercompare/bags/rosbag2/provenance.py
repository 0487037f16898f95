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
What a bag says about its own origin: software, settings, sources, and the operator's notes.

Each note is written at once as its own metadata record. So a recorder that is killed leaves its
notes in the bag, and no record grows.
"""

from __future__ import annotations

from datetime import datetime, timezone
import re
from typing import Callable, Mapping, NamedTuple, TYPE_CHECKING

from heading_intercompare.bags.errors import BagError
from heading_intercompare.core.version import VERSION
from heading_intercompare.messages.errors import MessageError
from heading_intercompare.messages.status_messages import decode_text, TEXT_TYPE

if TYPE_CHECKING:
    from .readable import Readable


CONTINUES = 'continues'
"""The key in that record that names the bag before this one."""

NAMESPACE = 'namespace'
"""The key in that record that names the namespace of the graph."""

RECORD = 'heading_intercompare'
"""The metadata record with version, settings and sources."""

NOTE_TOPIC = 'operator/note'
ACTION_TOPIC = 'operator/action'
"""Topic of what operators did, such as a change of a setting, each as a note."""
REPORT_TOPIC = 'compliance/report'
SENSORS_REPORT_TOPIC = 'sensors/report'
TRUTH_TOPIC = 'truth/heading'
"""Topic of the true heading, which only a simulator knows."""

_NOTE, _SETTINGS = 'note.', 'settings.'
#: More than this are no notes but a program gone wrong; their messages are still recorded.
_MOST = 1000
#: Letters of a note that are kept.
_LONGEST = 10_000
_SECOND_NS = 1_000_000_000
_TIMED = re.compile(r'(\d{4}-\d\d-\d\dT\d\d:\d\d(?::\d\d)?)(?:\.(\d{1,9}))?Z\s+(.+)')


def describe_origin(settings: Mapping[str, object],
                    sources: Mapping[str, Mapping[str, object]] | None = None,
                    continues: str | None = None, namespace: str = '/') -> dict[str, object]:
    """
    Return the record `RECORD`.

    Parameters
    ----------
    settings
        Settings of the analysis, by dotted name.
    sources
        Where the headings come from: names and values of each source; None and '' are skipped.
    continues
        Name of the bag of the same trial that came before this one.
    namespace
        Namespace of the graph; that of the root is not kept.

    """
    return {'version': VERSION, **({CONTINUES: continues} if continues else {}),
            **({NAMESPACE: namespace} if namespace != '/' else {}),
            **{f'{_SETTINGS}{name}': 'none' if value is None else value
               for name, value in settings.items()},
            **{f'source.{source}.{name}': value for source, values in (sources or {}).items()
               for name, value in values.items() if value not in (None, '')}}


class PublishedReport(NamedTuple):
    """A report as it was published: its topic, the time of receipt, and its text, JSON."""

    topic: str
    log_time_ns: int
    text: str


class Note(NamedTuple):
    """What the operator noted, and when: UTC nanoseconds."""

    stamp_ns: int
    text: str


def _parse_note(line: str, now_ns: int) -> Note:
    """Return a note; the line may begin with its time, 2026-03-01T09:00:00Z."""
    match = _TIMED.fullmatch(line)
    if match is None:
        return Note(now_ns, line)
    whole, fraction, text = match.groups()
    try:
        moment = datetime.fromisoformat(whole).replace(tzinfo=timezone.utc)
    except ValueError:
        return Note(now_ns, line)
    if moment.year < 1970:
        return Note(now_ns, line)
    ns = int((fraction or '').ljust(9, '0'))
    return Note(int(moment.timestamp()) * _SECOND_NS + ns, text)


def time_text(stamp_ns: int) -> str:
    """Return UTC nanoseconds as the time with which a note may begin."""
    seconds, ns = divmod(stamp_ns, _SECOND_NS)
    return f'{datetime.fromtimestamp(seconds, timezone.utc):%Y-%m-%dT%H:%M:%S}.{ns:09d}Z'


def note_lines(text: str) -> list[str]:
    """Return the notes in a text, one per line, without empty lines and unprintable characters."""
    lines = (' '.join(''.join(c if c.isprintable() else ' ' for c in line).split())
             for line in text.splitlines())
    return [line for line in lines if line]


class Notes:
    """
    Writes the operator's notes into a bag.

    Parameters
    ----------
    metadata
        Writes a metadata record, given its name and a mapping.

    Attributes
    ----------
    cut : int
        Notes of which only the first 10 000 letters were written.
    left_out : int
        Notes that were not written at all, because there were a thousand already.

    """

    def __init__(self, metadata: Callable[[str, Mapping[str, object]], object]) -> None:
        self._metadata = metadata
        self._count = self.cut = self.left_out = 0

    def add(self, text: str, now_ns: int) -> list[Note]:
        """
        Write the notes in a text, and return them.

        Parameters
        ----------
        text
            Each line is a note. A line that begins with a time such as 2026-03-01T09:00:00Z gets
            that time. Empty lines are skipped.
        now_ns
            Time of the other notes, UTC nanoseconds.

        Returns
        -------
        list of Note
            The notes written; a bag takes at most a thousand.

        """
        written = []
        for line in note_lines(text):
            if self._count == _MOST:
                self.left_out += 1
                continue
            self._count += 1
            note = _parse_note(line[:_LONGEST], now_ns)
            if self._count == _MOST:
                # This word takes the place of the note.
                self.left_out += 1
                note = Note(now_ns, f'too many notes: later ones are only in '
                            f'{NOTE_TOPIC} and {ACTION_TOPIC}')
            elif len(line) > _LONGEST:
                self.cut += 1
            self._metadata(f'{_NOTE}{self._count}', {'time': time_text(note.stamp_ns),
                                                     'text': note.text})
            written.append(note)
        return written


def is_note(name: str) -> bool:
    """Tell from its name whether a metadata record is a note."""
    return name.startswith(_NOTE) and name[len(_NOTE):].isdigit()


def read_continues(bag: Readable) -> str | None:
    """Return the name of the bag before this one; None if there is none."""
    return bag.metadata().get(RECORD, {}).get(CONTINUES)


def read_settings(bag: Readable) -> dict[str, str]:
    """Return the settings that a bag holds, as text by dotted name; none of a foreign bag."""
    return {name.removeprefix(_SETTINGS): value
            for name, value in bag.metadata().get(RECORD, {}).items()
            if name.startswith(_SETTINGS)}


def read_texts(bag: Readable, topic: str) -> list[tuple[int, str]]:
    """
    Return the texts of a topic, each with its time of receipt; [] if there is no such text topic.

    Raises
    ------
    OSError, BagError
        If the bag cannot be read.

    """
    name = bag.find(topic)
    if name is None or bag.topics[name].type_name != TEXT_TYPE or not bag.topics[name].count:
        return []
    try:
        return [(message.log_time_ns, decode_text(message.data))
                for message in bag.messages([name])]
    except MessageError as error:
        raise BagError(error.problem) from None


def find_report(bag: Readable) -> PublishedReport | None:
    """
    Return the last report that was published, that on all sensors first; None if there is none.

    Raises
    ------
    OSError, BagError
        If the bag cannot be read.

    """
    for topic in (SENSORS_REPORT_TOPIC, REPORT_TOPIC):
        texts = read_texts(bag, topic)
        if texts:
            return PublishedReport(topic, *texts[-1])
    return None


def read_notes(bag: Readable) -> list[Note]:
    """
    Return the operator's notes in a bag, in the order of their times.

    They are in metadata records, which are quick to read. A bag that another program recorded may
    have them only as messages; then the whole bag is read.

    Raises
    ------
    OSError, BagError
        If the bag cannot be read.

    """
    notes = []
    for name, entries in bag.metadata().items():
        match = is_note(name) and _TIMED.fullmatch(
            f'{entries.get("time", "")} {entries.get("text", "")}')
        if match:
            notes.append(_parse_note(match.group(), 0))
    if not notes:
        written = Notes(lambda name, mapping: None)
        notes = [note for topic in (NOTE_TOPIC, ACTION_TOPIC)
                 for ns, text in read_texts(bag, topic) for note in written.add(text, ns)]
    return sorted(notes, key=lambda note: note.stamp_ns)
