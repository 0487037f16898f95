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

"""The stamps of the lines of one log: their form, their zone, their day, and their bursts."""

from __future__ import annotations

from collections import deque
from datetime import datetime, timedelta, timezone, tzinfo
from functools import lru_cache
import re
from typing import Callable, Iterable, NamedTuple
from zoneinfo import ZoneInfo

from heading_intercompare.core.utc_text import DAY_NS
from heading_intercompare.drivers.framing import KEPT_PREFIX
from heading_intercompare.drivers.sentences import Name, Rejected
from heading_intercompare.drivers.settings import DriverSettings

from .days import Days
from .line_formats import (
    compile_form,
    FORMATS,
    half_day_ns,
    LineFormat,
    NUMERIC_DATES,
    read_own,
    read_zone,
)
from .tag_blocks import tag_blocks
from .times import fraction_ns, SECOND_NS

_TAGS = re.compile(rb'(?:\\[^\\]*\\\s*)+\Z|\\[a-z]:[^\\]*\Z')
_NUMERIC_DATE = re.compile(rb'(?<![0-9A-Za-z.+-])(\d{1,2})[/.-](\d{1,2})[/.-]\d{4}(?!\d)')
_OFFSET = re.compile(r'([+-])(\d\d):?(\d\d)\Z')
_DIGIT = re.compile(rb'\d').search
_BY_NAME = {form.name: form for form in FORMATS}
_EPOCH = compile_form(_BY_NAME['epoch'].pattern, 'alone')
_EARLIEST = datetime(1970, 1, 1)

#: Reasons to reject a heading for its stamp.
STAMP_REASONS = ('ambiguous_date', 'bad_stamp', 'burst', 'no_date', 'no_stamp')

#: Lines passed by that are remembered to find the stamp of a burst.
_REMEMBERED = 256
#: Seconds of stamps remembered; the lines of one second share it.
_SECONDS = 1024


class Found(NamedTuple):
    """A stamp in a text: its form, nanoseconds UTC, and the text around it."""

    form: str
    ns: int
    words: bytes


def read_offset(zone: str) -> tzinfo:
    """Return the zone that `+02:00`, 'UTC' or a name such as 'Europe/Oslo' states; ValueError."""
    match = _OFFSET.match(zone)
    if match:
        shift = timedelta(hours=int(match[2]), minutes=int(match[3]))
        return timezone(shift if match[1] == '+' else -shift)
    return timezone.utc if zone == 'UTC' else ZoneInfo(zone)


def find_date_order(blocks: Iterable[bytes]) -> str | None:
    """
    Return whether the numeric dates of a log put the day or the month first.

    Returns
    -------
    {'mdy', 'dmy'} or None
        By the first date with a number above 12. None if no date has one.

    """
    tail = b''
    for block in blocks:
        text = tail + block
        for match in _NUMERIC_DATE.finditer(text):
            if order := _order_of(match):
                return order
        tail = text[-24:]
    return None


def _order_of(match: re.Match[bytes]) -> str | None:
    first, second = int(match[1]), int(match[2])
    if first > 12 or b'.' in match[0]:
        return 'dmy'
    return 'mdy' if second > 12 else None


class LineStamps:
    r"""
    Reads the stamps of the lines of one log.

    Parameters
    ----------
    settings
        Form, zone and pattern of the stamps.
    days
        The day of a time of day.
    order
        Returns the order of numeric dates in the whole log, see `find_date_order`.
    of_log
        A line without a stamp takes the stamp of the burst that it belongs to.

    Attributes
    ----------
    borrowed : int
        Headings that took the stamp of a line before theirs.
    form : str
        Form of the last stamp; empty if there was none.
    words : bytes
        The text around the last stamp.

    Notes
    -----
    The stamp nearest to the sentence counts, first of those that end the text before it. If there
    is none before the sentence, one after it counts. The form of the first stamp is looked for
    first in all other lines. Another form counts there only if nothing stands between it and the
    sentence. A time of day never does: it may be the rest of a damaged stamp.

    *Bursts.* A stamp opens a burst. The lines without a stamp after it belong to it. Of each kind
    and talker the first sentence takes the stamp of the burst; a second one came at another time,
    which nobody knows: it is counted as `burst`.

    """

    def __init__(self, settings: DriverSettings, days: Days,
                 order: Callable[[], str | None] = lambda: None, of_log: bool = False) -> None:
        self._days, self._find_order, self._of_log = days, order, of_log
        self._accept_bursts = settings.bursts == 'accept'
        self._zone = None if settings.stamp_zone is None else read_offset(settings.stamp_zone)
        self._own_pattern = (None if settings.stamp_pattern is None else
                             re.compile(settings.stamp_pattern.encode()))
        named = settings.stamp_format
        self._tags = named in ('auto', 'tag') and self._own_pattern is None
        self._forms = [form for form in FORMATS if form.name == named
                       or named == 'auto' and form.automatic and form.name != 'dmy']
        self._auto = named == 'auto'
        self._order: str | None = None if self._auto else named
        self._locked: tuple[LineFormat, tuple[re.Pattern[bytes], ...]] | None = None
        #: The quick way for lines that begin with a stamp of the form found, in UTC.
        self._quick: Callable[[bytes], re.Match[bytes] | None] | None = None
        self._form_found = ''
        self._seconds: dict[bytes, int] = {}
        self._burst_ns: int | None = None
        self._owner: Name | None = None
        self._borrowers: set[Name] = set()
        self._passed: deque[tuple[bytes, bytes, Name | None]] = deque(maxlen=_REMEMBERED)
        self._utc = lru_cache(maxsize=1024)(self._local_to_utc)
        self.borrowed = 0
        self.form = ''
        self.words = b''

    @property
    def by_clock(self) -> bool:
        """Whether the last stamp was a time of day."""
        return self.form in ('clock', 'hhmmss')

    def begin_file(self, path: str) -> None:
        """Take note that the next line is from another file: no burst goes on."""
        self._days.begin_file(path)
        self._burst_ns = None
        self._passed.clear()

    def find(self, text: bytes) -> Found | None:
        """
        Return the stamp in a text before or after a sentence, or None.

        Raises
        ------
        ValueError
            If it has the form of a stamp but no such instant exists: month 13, hour 24.
        Rejected
            If nothing says its date, or whether day or month is first.

        """
        if b'\\' not in text:
            return self._find(text)
        stamp = self._find(_TAGS.sub(b'', text))
        return self._find_tag(text) if stamp is None and self._tags else stamp

    def own_ns(self, prefix: bytes, suffix: bytes) -> int | None:
        """Return the stamp of a line's own, before or after its sentence; raises Rejected."""
        if self._quick is not None and (match := self._quick(prefix)):
            text, digits, zone = match.groups()
            if not zone or zone == b'Z':
                ns = self._seconds.get(text)
                if ns is None:
                    ns = self._read_second(text)
                self.form, self.words = self._form_found, b''
                return ns + (fraction_ns(digits) if digits else 0)
        try:
            stamp = self.find(prefix[-KEPT_PREFIX:]) if prefix else None
            if stamp is None and suffix:
                stamp = self.find(suffix[:KEPT_PREFIX])
        except ValueError:
            raise Rejected('bad_stamp') from None
        if stamp is None:
            return None
        self.form, self.words = stamp.form, stamp.words
        return stamp.ns

    def cut(self, text: bytes) -> tuple[bytes, bytes]:
        """Return a sentence without checksum and the stamp that follows it, if any."""
        for form in self._forms if self._own_pattern is None else ():
            match = compile_form(form.pattern, 'last').match(text)
            if match and match.start(1) > text.find(b','):
                return text[:match.start(1)].rstrip(b' \t,;'), text[match.start(1):]
        return text, b''

    def take(self, name: Name, prefix: bytes, suffix: bytes) -> int:
        """Return the stamp of a heading, nanoseconds UTC; raises Rejected."""
        try:
            ns = self.own_ns(prefix, suffix)
        except Rejected:
            self._open(None)
            raise
        if ns is not None:
            if self._passed:
                self._passed.clear()
            self._burst_ns, self._owner = ns, name
            return ns
        if not self._of_log:
            raise Rejected('no_stamp')
        return self._borrow(name, bare=not prefix.strip())

    def pass_by(self, prefix: bytes, suffix: bytes, name: Name | None = None) -> None:
        """Take note of a line whose stamp is not needed; it may open a burst."""
        if self._of_log and (name is not None or prefix or suffix):
            self._passed.append((prefix, suffix, name))

    def open_burst(self, dday: bytes) -> None:
        """Take the line of UHDAS before a sentence: days since the start of the year."""
        year_ns = self._days.year_start()
        self._passed.clear()
        self.form = 'unixd'
        try:
            whole, _, decimals = dday.partition(b'.')
            day_ns = int(decimals[:12].ljust(12, b'0')) * DAY_NS // 10 ** 12
            self._open(None if year_ns is None else year_ns + int(whole) * DAY_NS + day_ns)
        except ValueError:
            self._open(None)

    def _open(self, ns: int | None) -> None:
        self._burst_ns, self._owner, self._borrowers = ns, None, set()
        self._passed.clear()

    def _borrow(self, name: Name, *, bare: bool) -> int:
        """Return the stamp of the burst for a line without one; raises Rejected."""
        if self._owner is not None:
            self._borrowers, self._owner = {self._owner}, None
        passed = set()
        while self._passed:
            prefix, suffix, passed_name = self._passed.pop()
            passed.add(passed_name)
            try:
                ns = self.own_ns(prefix, suffix)
            except Rejected:
                self._open(None)
                break
            if ns is not None:
                self._open(ns)
                break
        self._borrowers.update(passed_name for passed_name in passed if passed_name is not None)
        if self._burst_ns is None:
            raise Rejected('no_stamp')
        if name in self._borrowers and not self._accept_bursts:
            raise Rejected('burst' if bare else 'no_stamp')
        self._borrowers.add(name)
        self.borrowed += 1
        return self._burst_ns

    def _find(self, text: bytes) -> Found | None:
        if self._own_pattern is not None:
            return self._find_own(text)
        if self._locked is not None:
            form, patterns = self._locked
            for pattern in patterns:
                match = pattern.match(text)
                if match:
                    return self._read(match, form)
        if not _DIGIT(text):
            return None
        forms = (self._forms if self._locked is None or self._locked[0].kind == 'clock' else
                 [form for form in self._forms if form.kind != 'clock'])
        for places in (('alone', 'last'), ('anywhere',))[:1 if self._locked else 2]:
            for form in forms:
                for place in places:
                    match = compile_form(form.pattern, place).match(text)
                    if match is None:
                        continue
                    if self._auto and form.name in NUMERIC_DATES:
                        form = self._choose_order(match)
                    stamp = self._read(match, form)
                    if self._locked is None:
                        self._lock(form)
                    return stamp
        return None

    def _choose_order(self, match: re.Match[bytes]) -> LineFormat:
        """Return the form of a numeric date, by the dates of the whole log."""
        if self._order is None:
            date = _NUMERIC_DATE.match(match[1])
            self._order = (date and _order_of(date)) or self._find_order()
        if self._order is None:
            raise Rejected('ambiguous_date')
        return _BY_NAME[self._order]

    def _read(self, match: re.Match[bytes], form: LineFormat) -> Found:
        text, digits, zone = match.group(1, 2, 3)
        ns = form.read(text)
        if form.kind == 'instant':
            if digits:
                ns += fraction_ns(digits) // 10 ** (len(text) - 10)
        elif digits:
            ns += fraction_ns(digits)
        if form.kind != 'instant':
            ns = self._to_utc(form.kind, ns, zone)
        if not 0 <= ns < 2 ** 63 - SECOND_NS:
            raise ValueError('year')
        return Found(form.name, ns, match.string[:match.start(1)] + match.string[match.end():])

    def _read_second(self, text: bytes) -> int:
        """Return and remember a second of the form found; raises Rejected."""
        assert self._locked is not None
        try:
            ns = self._locked[0].read(text)
        except ValueError:
            raise Rejected('bad_stamp') from None
        if len(self._seconds) >= _SECONDS:
            self._seconds.clear()
        self._seconds[text] = ns
        return ns

    def _lock(self, form: LineFormat) -> None:
        """Look for this form first from now on."""
        # Of one form, the last stamp anywhere is the one that ends the text, if one does.
        self._locked = form, tuple(compile_form(form.pattern, place)
                                   for place in ('alone', 'anywhere'))
        if self._zone is None and form.kind == 'date':
            self._quick, self._form_found = self._locked[1][0].match, form.name

    def _to_utc(self, kind: str, ns: int, zone: bytes | None) -> int:
        if zone and zone[:1] in b'AaPp' and zone[1:2] in b'.Mm':
            ns, zone = half_day_ns(ns, zone), None
        if kind == 'clock':
            placed_ns = self._days.place(ns)
            if placed_ns is None:
                raise Rejected('no_date')
            ns = placed_ns
        if zone and (self._zone is None or not zone[:1].isalpha()
                     or zone in (b'Z', b'UTC', b'GMT')):
            return read_zone(ns, zone)
        if self._zone is None:
            return ns
        seconds, rest_ns = divmod(ns, SECOND_NS)
        return self._utc(seconds) + rest_ns

    def _local_to_utc(self, seconds: int) -> int:
        """Return UTC for a local clock, nanoseconds; ValueError if that hour is not one hour."""
        local = _EARLIEST + timedelta(seconds=seconds)
        offsets = {local.replace(tzinfo=self._zone, fold=fold).utcoffset() for fold in (0, 1)}
        if len(offsets) != 1:
            raise ValueError('hour that the change of the clocks repeats or leaves out')
        (offset,) = offsets
        assert offset is not None
        return (seconds - int(offset.total_seconds())) * SECOND_NS

    def _find_own(self, text: bytes) -> Found | None:
        assert self._own_pattern is not None
        match = self._own_pattern.search(text)
        if match is None:
            return None
        kind, ns, zone = read_own(match)
        if kind != 'instant':
            ns = self._to_utc(kind, ns, zone)
        if not 0 <= ns < 2 ** 63:
            raise ValueError('year')
        return Found('clock' if kind == 'clock' else 'pattern', ns,
                     text[:match.start()] + text[match.end():])

    def _find_tag(self, prefix: bytes) -> Found | None:
        """Return the time `c:` of the last TAG block that has one and a correct checksum."""
        for fields in tag_blocks(prefix):
            for field in fields:
                if field.startswith(b'c:'):
                    match = _EPOCH.match(field[2:])
                    words = b','.join(part for part in fields if part.startswith(b's:'))
                    return match and Found('tag', self._read(match, _BY_NAME['epoch']).ns, words)
        return None
