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
NMEA 0183 bytes to headings, with a count of everything that gave none.

Bytes of a stream wait in the kernel, unstamped, while the program does not read. Then several
readings come at once, and the time at which they are read is not the time at which they came.
"""

from __future__ import annotations

from collections import Counter, deque
from functools import partial
from statistics import median
from typing import Mapping

from heading_intercompare.core.records import Headings, Quality

from .framing import Frame, Framer
from .line_numbers import LineNumbers, SenderTurns
from .log_lines.days import Days
from .log_lines.line_stamps import LineStamps, STAMP_REASONS
from .log_lines.line_words import WordCounts
from .log_lines.log_clocks import choose_time_sentences, start_stamps
from .log_lines.log_files import LogFiles
from .log_lines.log_order import open_log
from .log_lines.stream_times import StreamTimes, TIME_SENTENCES
from .log_lines.times import DATED_CLOCKS, day_time_ns, receiver_log_ns
from .sentence_choice import (
    accepts,
    choose_instrument,
    choose_naming,
    find_sentence,
    Heard,
    Listening,
    TalkerTurns,
)
from .sentence_quality import QualityListener, says_quality
from .sentences import (
    field_of,
    find_time,
    heading_of,
    may_lack_checksum,
    Name,
    Rejected,
    split_fields,
)
from .settings import DriverError, DriverSettings

#: Steps and latencies remembered, and how many of them are needed.
_REMEMBERED, _NEEDED = 31, 3
#: A stamp may be late by this many usual steps.
_LATE_STEPS = 2.0


class BurstFinder:
    """
    Tells which readings of a stream have no stamp of their own.

    A reading has none if another one of its kind and talker began in the same read, or if its
    bytes may have waited for more than two usual steps of its kind.
    """

    def __init__(self) -> None:
        self._last_ns: dict[Name, int] = {}
        self._steps_ns: dict[Name, deque[int]] = {}
        self._latencies_ns: dict[Name, deque[int]] = {}

    def find(self, name: Name, received_ns: int, in_read: int, late_s: float) -> bool:
        """
        Tell whether a reading belongs to a burst.

        Parameters
        ----------
        name
            Kind and talker of the reading.
        received_ns
            Time of the read in which its first byte came, nanoseconds.
        in_read
            Readings of this name that began in that read, itself among them.
        late_s
            Longest time for which its bytes may have waited to be read, seconds.

        """
        last_ns = self._last_ns.get(name)
        self._last_ns[name] = received_ns
        if in_read > 1 or received_ns == last_ns:
            return True
        steps_ns = self._steps_ns.setdefault(name, deque(maxlen=_REMEMBERED))
        enough_steps = len(steps_ns) >= _NEEDED
        if enough_steps and late_s * 1e9 > _LATE_STEPS * median(steps_ns):
            return True
        if last_ns is not None and received_ns > last_ns:
            steps_ns.append(received_ns - last_ns)
        return False

    def learn_latency(self, name: Name, received_ns: int, valid_ns: int) -> None:
        """Note how long after its time of validity a reading with a stamp of its own came."""
        latencies_ns = self._latencies_ns.setdefault(name, deque(maxlen=_REMEMBERED))
        latencies_ns.append(received_ns - valid_ns)

    def receipt_ns(self, name: Name, valid_ns: int) -> int | None:
        """Return when a reading valid at some time usually comes; None while that is unknown."""
        latencies_ns = self._latencies_ns.get(name, ())
        return valid_ns + int(median(latencies_ns)) if len(latencies_ns) >= _NEEDED else None


#: Talkers counted each by itself; a flood may have thousands.
_MOST_OTHERS = 32
#: Readings held until a sentence is chosen; a flood does not wait for the end of `learn_s`.
_MOST_TALKERS = 64
_MOST_HELD = 100_000


_TIME_MARKS = frozenset(kind[1:].encode() + b',' for kind in TIME_SENTENCES)


class NmeaDecoder:
    r"""
    Turns the bytes of a source into headings of one sensor.

    Parameters
    ----------
    settings
        The scheme of `source` matters: udp delivers complete datagrams; the lines of a file carry
        their own stamps. Without a source the bytes are a live stream.

    Attributes
    ----------
    lines
        Sentences, and lines without one, seen so far: the headings returned, those held while
        listening, and the sum of `counts`.
    numbers : LineNumbers
        The numbers of the lines.
    senders : SenderTurns
        Who sent the headings of the chosen sentence.

    Notes
    -----
    *Which sentence.* One kind and one talker (`sentence_choice`). A file is searched beforehand.
    On a live line with sentence 'auto', the decoder listens for `learn_s` of receipt time after
    the first heading sentence. It holds all readings until then, and returns those of the best
    kind. On a line that has fallen silent, `feed(b'', now_ns)` makes that time pass.

    *Stamps of receipt.* On a live line, the time of receipt of the first byte of the sentence. In
    a file, the stamp of its line or of its burst (`LineStamps`); also on a live line if
    `stamp_format` names its form.

    *Bursts.* Bytes of a TCP or serial line wait unstamped while the program does not read. Of
    several readings in one read, or in a read that may be more than two steps late, none has a
    time of receipt: it is counted as `burst`. If the stream carries times of validity, it gets its
    time of validity plus the usual latency instead.

    *Stamps of validity.* A heading takes the time of the ZDA before it if it is the first
    sentence of its kind and talker after that ZDA: one ZDA opens one burst. A heading before any
    ZDA, a second one in a burst, and one after an unreadable ZDA have no time of validity. Without
    ZDA, RMC tells the time; without both, GGA, whose day comes from the time of receipt or from
    `Days`. A sentence with its own time, such as PASHR, takes that, on the day that puts it
    nearest to the last ZDA or, without one, to the time of receipt. A log of a receiver has week
    and second of GPS.

    *Order.* The headings keep the order of the bytes. The pairing deals with stamps that do not
    increase.

    Examples
    --------
    >>> decoder = NmeaDecoder(DriverSettings(sentence='HDT'))
    >>> decoder.feed(b'$HEHDT,218.53,T*12\r\n', 1_000).heading_deg.tolist()
    [218.53]

    """

    def __init__(self, settings: DriverSettings, files: LogFiles | None = None) -> None:
        self._settings = settings
        address = settings.address if settings.source is not None else None
        scheme = address.scheme if address else ''
        if address is not None and scheme == 'file' and files is None:
            files = open_log(address.path, settings)
        self._framer = Framer(datagrams=scheme == 'udp', with_lines=files is not None)
        self._counts = self._framer.counts
        self._lenient = settings.checksum == 'if_present'
        self._validity = settings.time == 'validity'
        self._stamp_format = settings.stamp_format
        if scheme != 'file' and settings.stamp_format == 'auto':
            self._stamp_format = 'none'
        #: Only bytes of a stream that are stamped as they are read can wait unstamped.
        self._bursts = (BurstFinder() if scheme in ('tcp', 'serial') and not self._validity
                        and self._stamp_format == 'none' and settings.bursts == 'reject'
                        else None)
        #: By the time of a read, how long its bytes may have waited: of the last two reads.
        self._late_s: dict[int, float] = {}
        self._in_read: Counter[tuple[Name | None, int | None]] = Counter()
        self._from_file = files is not None
        self._listening = Listening(
            settings.kinds, settings.learn_s, _MOST_HELD if settings.kind == 'auto' else 0,
            None if files is None else find_sentence(files.bare_blocks(), settings))
        self._instrument, self._compass = choose_instrument(settings), settings.compass
        self._own_sentence = settings.described_sentence
        self._identify = choose_naming(settings)
        self._days, self._stamps = start_stamps(settings, files)
        self._times = StreamTimes(self._days, self._time_sentences(files))
        self._words = WordCounts()
        self._burst_ns: int | None = None
        self._stamped: set[Name] = set()
        self._psxn_quality = b''
        # Nobody takes that of the sentences in messages, so it would grow for months.
        self._hears_quality = settings.source is not None
        self._listeners: dict[Name, QualityListener] = {}
        #: The newest sentences that say something of headings, by talker: one may come earlier.
        self._quality_sentences: dict[bytes, bytes] = {}
        if self._listening.chosen is not None:
            self._listen(self._listening.chosen)
        self._n_headings = self._n_others = self._n_chosen = 0
        self._turns = TalkerTurns()
        self.numbers, self.senders = LineNumbers(), SenderTurns()
        self._sender = ''
        #: By kind: stamp, heading and reason of old lines, which a restart lets count.
        self._old: dict[tuple[str, bytes], list[tuple[int, float, str]]] = {}
        self._read = (self._read_valid if self._validity else self._read_receipt
                      if self._bursts is None else self._read_stream)

    def _time_sentences(self, files: LogFiles | None) -> tuple[str, ...]:
        """Return the sentences whose time is used: in a log, the best of those that it has."""
        if self._bursts is not None:
            return TIME_SENTENCES[:1]
        if not self._validity:
            return TIME_SENTENCES[:2]
        return choose_time_sentences(files, self._settings)

    @property
    def counts(self) -> dict[str, int]:
        """
        Everything so far that gave no heading, by reason.

        In addition to the reasons of `Framer`: `no_checksum`; `not_heading`: intact sentences of
        other kinds; `other_sentence.KIND`, `other_talker.XX`: headings that were not chosen;
        `other_instrument`; `too_few_fields`, `empty_heading`, `bad_field`, `out_of_range`,
        `not_true`, `invalid_mode.X` (THS), `no_variation` (HDG, VHW, HDM), `invalid_quality` (a
        sentence of a maker, or the PSXN,20 before a PSXN,23, says so); `repeated`, `old_number`
        (the number of the line, see `LineNumbers`); `no_stamp`, `bad_stamp`,
        `no_date` (a time of day), `ambiguous_date` (day or month first), `burst` (readings of a
        stream or of a log without a stamp of their own), `no_validity_time`, `bad_time` (a ZDA,
        RMC or GGA).
        """
        return dict(sorted(self._counts.items()))

    def count(self, reason: str) -> int:
        """Return how many sentences or lines gave no heading for one reason."""
        return self._counts[reason]

    @property
    def stamps(self) -> LineStamps:
        """Return the stamps of the lines."""
        return self._stamps

    @property
    def days(self) -> Days:
        """Return the days of times of day."""
        return self._days

    @property
    def undone(self) -> str:
        """Return in words which rollovers of GPS were undone; '' if none were."""
        return self._times.rollovers.words

    def refuse_several_instruments(self, path: str) -> None:
        """Raise DriverError if the words of the lines of a log name several instruments."""
        if instruments := self.find_instruments():
            several = ', '.join(f'{name} ({n} headings)' for name, n in instruments)
            raise DriverError(f'{path}: {self.chosen} comes from several instruments: {several}; '
                              f'choose one with `instrument`, such as {instruments[0][0]}, or '
                              "'any' to take all")

    def find_instruments(self) -> list[tuple[str, int]]:
        """Return the instruments of the headings taken, if the words of the lines name several."""
        return [] if self._settings.instrument is not None else self._words.instruments()

    @property
    def turns(self) -> list[str]:
        """Return the talkers of GNSS that take turns with the chosen one; see `TalkerTurns`."""
        return self._turns.find(self._n_chosen)

    @property
    def lines(self) -> int:
        """Sentences, and lines without one, seen so far."""
        return (sum(self._counts.values()) + self._n_headings + self._listening.n_held
                + sum(map(len, self._old.values())))

    @property
    def chosen(self) -> Name | None:
        """Kind and talker whose headings are returned; None while listening."""
        return self._listening.chosen

    def feed(self, data: bytes, received_ns: int | None, late_s: float = 0.0,
             file: str | None = None, sender: str = '') -> Headings:
        """
        Take bytes and return the headings that they complete.

        Parameters
        ----------
        data
            A datagram, or a piece of the stream, split anywhere; may be empty.
        received_ns
            Time of receipt, nanoseconds UTC; not used if the lines carry stamps.
        late_s
            Longest time for which the bytes may have waited to be read, seconds.
        file
            The file of a log that begins with these bytes.
        sender
            Address of the host that sent a datagram.

        Returns
        -------
        Headings
            In the order of the bytes; none while it still listens.

        """
        if file is not None:
            self._stamps.begin_file(file)
            self.numbers.begin_file()
        self._sender = sender
        frames = self._framer.feed(data, received_ns)
        if self._bursts is not None and received_ns is not None:
            self._late_s = {received_ns: late_s, **dict(list(self._late_s.items())[:1])}
            self._in_read = Counter((self._identify(text), came_ns)
                                    for came_ns, _, text, _, _ in frames)
        for frame in frames:
            self._take(frame)
        if self._listening.held:
            self._count_choice(self._listening.learn(received_ns))
        return self._drain()

    def flush(self) -> Headings:
        """Return the last headings at the end of the stream."""
        for frame in self._framer.flush():
            self._take(frame)
        self._count_choice(self._listening.choose())
        for kind in [*self._old]:
            self._decide(kind, restarted=False)
        return self._drain()

    def _count_choice(self, held: Mapping[Name, Heard]) -> None:
        """Count the sentences that gave no heading, of those held until the choice."""
        for name, heard in held.items():
            if name == self.chosen:
                self._counts.update(heard.counts)
            else:
                self._counts[self._reason_not_chosen(name)] += heard.n
                self._listeners.pop(name, None)

    def _listen(self, name: Name) -> QualityListener:
        """Return what gathers the quality of the headings in a sentence."""
        if name not in self._listeners:
            listener = self._listeners[name] = QualityListener(name, self._own_sentence)
            for text in self._quality_sentences.values():
                listener.note(text)
        return self._listeners[name]

    def drain_quality(self, *, end: bool = False) -> Quality:
        """
        Return what the sensor said of its headings since the last call; nothing while listening.

        Rows come where it says something else, if it says anything; `end` adds the last reading.
        Without a source nothing is kept.
        """
        if not self._hears_quality or self.chosen is None:
            return Quality.empty()
        return self._listen(self.chosen).drain(end=end)

    def _drain(self) -> Headings:
        chunk = Headings(*self._listening.rows.drain())
        self._n_headings += len(chunk)
        return chunk

    def _reason_not_chosen(self, name: Name) -> str:
        """Return the reason under which to count a heading sentence that was not chosen."""
        kind = self.chosen.kind if self.chosen else self._settings.kind
        reason = (f'other_talker.{name.talker}' if name.kind == kind or kind == 'auto'
                  else f'other_sentence.{name.kind}')
        if reason not in self._counts:
            if self._n_others >= _MOST_OTHERS:
                return 'other_talker.others'
            self._n_others += 1
        return reason

    def _take(self, frame: Frame) -> None:
        """Turn one sentence into a reading or a count."""
        received_ns, prefix, text, checked, suffix = frame
        if not text or (self._from_file and text[:6] == b'UNIXD,'):
            self._open_burst(prefix, text)
            return
        if not checked and self._from_file and not prefix.strip():
            text, suffix = self._stamps.cut(text)
        name = self._identify(text)
        if not (checked or self._lenient or may_lack_checksum(name, self._own_sentence)):
            self._counts['no_checksum'] += 1
            return
        refused = self.numbers.refuse(prefix, text, received_ns)
        if name is None and refused:
            self._counts['not_heading'] += 1
            return
        if name is None:
            self._counts[self._note(text, prefix, suffix, received_ns)] += 1
            return
        if self._instrument is not None and not self._instrument.accepts(prefix, suffix):
            self._stamps.pass_by(prefix, suffix)
            self._counts['other_instrument'] += 1
            return
        listening = self._listening
        counts, rows = self._counts, listening.rows
        if name != listening.chosen:
            if listening.chosen is not None or not accepts(name, self._settings):
                self._stamps.pass_by(prefix, suffix)
                counts[self._reason_not_chosen(name)] += 1
                self._turns.hear(name, listening.chosen, self._n_chosen)
                return
            heard = listening.hear(name)
            counts, rows = heard.counts, heard.rows
        self._n_chosen += 1
        try:
            if refused:
                self._hold(refused, name, text, prefix, suffix, received_ns)
                return
            stamp_ns, heading_deg = self._read(name, text, prefix, suffix, received_ns)
        except Rejected as rejected:
            if rejected.reason not in STAMP_REASONS:
                self._stamps.pass_by(prefix, suffix, name)
            counts[rejected.reason] += 1
            return
        if self.numbers.kind in self._old:
            self._decide(self.numbers.kind, self.numbers.restarted)
        self.senders.hear(f'{self._sender} {self.numbers.source}'.strip())
        rows.stamp_ns.append(stamp_ns)
        rows.values[0].append(heading_deg)
        if self._hears_quality and (listener := self._listen(name)).listens:
            listener.hear(text, stamp_ns)

    def _hold(self, reason: str, name: Name, text: bytes, prefix: bytes, suffix: bytes,
              received_ns: int | None) -> None:
        """Hold an old line until its numbers go on; raises Rejected if it has no stamp."""
        kind, stamp_ns = self.numbers.kind, received_ns
        if self._stamp_format != 'none':
            stamp_ns = self._near_ns(prefix, suffix)
        if (name != self.chosen or kind is None or stamp_ns is None or self._validity
                or self._bursts is not None):
            raise Rejected(reason)
        self._old.setdefault(kind, []).append((stamp_ns, self._heading(name, text), reason))
        self._stamps.pass_by(prefix, suffix, name)

    def _decide(self, kind: tuple[str, bytes], restarted: bool) -> None:
        """Return the lines that were held if the numbers began elsewhere; otherwise count them."""
        rows = self._listening.rows
        for stamp_ns, heading_deg, reason in self._old.pop(kind):
            if restarted:
                rows.stamp_ns.append(stamp_ns)
                rows.values[0].append(heading_deg)
            else:
                self._counts[reason] += 1

    def _open_burst(self, prefix: bytes, text: bytes) -> None:
        """Take a line without a sentence, which may be a stamp, or the line UNIXD of UHDAS."""
        if text:
            self._counts['not_heading'] += 1
            self._stamps.open_burst(text.split(b',')[1])
        elif not prefix.lstrip().startswith(b'#'):
            self._stamps.pass_by(prefix, b'')
        if self._instrument is not None:
            self._instrument.accepts(prefix, b'')

    def _note(self, text: bytes, prefix: bytes, suffix: bytes, received_ns: int | None) -> str:
        """Keep what another sentence says about later headings; return the reason to count it."""
        if self._from_file and (prefix or suffix):
            self._stamps.pass_by(prefix, suffix)
        for listener in self._listeners.values():
            listener.note(text)
        if self._hears_quality and says_quality(text):
            heard = self._quality_sentences
            if text[:6] in heard or len(heard) < _MOST_TALKERS:
                heard[text[:6]] = text
        if text[:8] == b'PSXN,20,':
            self._psxn_quality = (text.split(b',') + [b''] * 3)[4].strip()
        elif text[3:6] in _TIME_MARKS and (
                self._validity or self._bursts is not None or self._stamps.by_clock
        ) and self._times.tells(text):
            self._stamped.clear()
            try:
                if self._from_file and self._validity:
                    received_ns = self._near_ns(prefix, suffix)
                self._burst_ns = self._times.read(text, received_ns)
            except ValueError:
                self._burst_ns = None
                return 'bad_time' if self._validity else 'not_heading'
        return 'not_heading'

    def _near_ns(self, prefix: bytes, suffix: bytes) -> int | None:
        """Return the stamp of a line's own, which says the day of a time in it."""
        try:
            return self._stamps.own_ns(prefix, suffix) if self._stamp_format != 'none' else None
        except Rejected:
            return None

    def _heading(self, name: Name, text: bytes) -> float:
        if name.kind == 'PSXN,23' and self._psxn_quality == b'2':
            raise Rejected('invalid_quality')
        return heading_of(text, self._compass, self._own_sentence)

    def _read_valid(self, name: Name, text: bytes, prefix: bytes, suffix: bytes,
                    received_ns: int | None) -> tuple[int, float]:
        """Return time of validity and heading of a sentence; raises Rejected."""
        burst_ns = None if name in self._stamped else self._burst_ns
        self._stamped.add(name)
        heading_deg = self._heading(name, text)
        own_ns = self._own_time_ns(name, text, prefix, suffix, received_ns)
        valid_ns = burst_ns if own_ns is None else own_ns
        if valid_ns is None:
            raise Rejected('no_validity_time')
        return valid_ns, heading_deg

    def _read_stream(self, name: Name, text: bytes, prefix: bytes, suffix: bytes,
                     received_ns: int | None) -> tuple[int, float]:
        """
        Return time of receipt and heading of a sentence from a stream; raises Rejected.

        One of a burst was received at its time of validity plus the usual latency, if both are
        known.
        """
        bursts = self._bursts
        if bursts is None or received_ns is None:
            return self._read_receipt(name, text, prefix, suffix, received_ns)
        burst = bursts.find(name, received_ns, self._in_read[name, received_ns],
                            self._late_s.get(received_ns, 0.0))
        heading_deg = self._heading(name, text)
        try:
            valid_ns, _ = self._read_valid(name, text, b'', b'', received_ns)
        except Rejected:
            valid_ns = None
        if not burst:
            if valid_ns is not None:
                bursts.learn_latency(name, received_ns, valid_ns)
            return received_ns, heading_deg
        stamp_ns = None if valid_ns is None else bursts.receipt_ns(name, valid_ns)
        if stamp_ns is None:
            raise Rejected('burst')
        return stamp_ns, heading_deg

    def _read_receipt(self, name: Name, text: bytes, prefix: bytes, suffix: bytes,
                      received_ns: int | None) -> tuple[int, float]:
        """Return the stamp of a line, its burst or its receipt, and the heading; may reject."""
        heading_deg = self._heading(name, text)
        if self._stamp_format != 'none':
            stamp_ns = self._stamps.take(name, prefix, suffix)
            if self._from_file and self._stamps.words:
                self._words.add(self._stamps.words)
            return stamp_ns, heading_deg
        if self._from_file or received_ns is None:
            raise Rejected('no_stamp')
        return received_ns, heading_deg

    def _own_time_ns(self, name: Name, text: bytes, prefix: bytes, suffix: bytes,
                     received_ns: int | None) -> int | None:
        """Return the time that a heading sentence tells itself, if any; raises Rejected."""
        at, clock = find_time(name, text, self._own_sentence)
        if clock != 'week' and not at:
            return None
        if self._stamp_format != 'none':
            received_ns = self._near_ns(prefix, suffix)
        elif self._from_file:
            received_ns = None
        undo = partial(self._times.rollovers.undo, logger_ns=received_ns)
        try:
            fields = split_fields(text)
            if clock == 'week':
                return receiver_log_ns(fields, at, undo)
            if clock in DATED_CLOCKS:
                return undo(DATED_CLOCKS[clock](field_of(fields, at)))
            return self._times.place(day_time_ns(field_of(fields, at)), received_ns)
        except (ValueError, IndexError):
            raise Rejected('no_validity_time') from None
