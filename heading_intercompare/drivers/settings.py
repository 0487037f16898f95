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

"""Settings of a driver, and the addresses of heading sources."""

from __future__ import annotations

from dataclasses import dataclass
import ipaddress
import re
from urllib.parse import parse_qsl, urlsplit
from zoneinfo import ZoneInfo

from heading_intercompare.core.declared_settings import Checked, setting, SettingsError

from .deviation_table import read_deviations, write_deviations
from .own_sentence import read_own_sentence
from .sentences import Compass, OwnSentence, PARSERS, UNSTATED

#: Kinds of heading sentence; 'auto' uses the first of those present.
SENTENCES = (*PARSERS,)

#: Forms of stamp, by their names in the table of `log_lines/line_formats`.
STAMP_FORMATS = ('auto', 'iso', 'doy', 'compact', 'named', 'month', 'asctime', 'mdy', 'dmy',
                 'fields', 'epoch', 'clock', 'hhmmss', 'tag', 'none')

_FORMS = ('must be file:PATH, udp://HOST:PORT[?interface=IP&from=IP], tcp://HOST:PORT '
          'or serial:DEVICE[?baud=4800]')


class DriverError(ValueError):
    """A log or a source cannot be used: what, where, what is allowed."""


@dataclass(frozen=True, slots=True)
class Address:
    """
    Where headings come from.

    Attributes
    ----------
    scheme : {'file', 'udp', 'tcp', 'serial'}
        The transport.
    path
        Path of a log, or name of a serial device.
    host, port : str, int
        Address and port; for udp the multicast group to join or the local address to listen on,
        empty for all of them.
    interface
        Address of the local interface that joins the multicast group; empty for the system's.
    sender
        Address of the only host whose datagrams are taken; empty for every host.
    baud
        Speed of the serial line.

    """

    scheme: str
    path: str = ''
    host: str = ''
    port: int = 0
    interface: str = ''
    sender: str = ''
    baud: int = 4800

    @property
    def multicast(self) -> bool:
        """Whether the host is a multicast group."""
        try:
            return ipaddress.ip_address(self.host).is_multicast
        except ValueError:
            return False


def parse_address(source: str) -> Address:
    """
    Return the address that a source URL names.

    Parameters
    ----------
    source
        `file:PATH` (everything after the colon is the path, unchanged),
        `udp://HOST:PORT` (a multicast group is joined; `udp://:PORT` listens on all addresses),
        `tcp://HOST:PORT`, or `serial:DEVICE?baud=4800`.

    Raises
    ------
    SettingsError
        If the URL is none of these; it says what is wrong and what is allowed.

    Examples
    --------
    >>> parse_address('udp://239.192.0.3:60003').multicast
    True
    >>> parse_address('serial:/dev/ttyUSB0?baud=38400').baud
    38400

    """
    scheme, colon, rest = source.partition(':')
    scheme = scheme.lower()
    if not colon or scheme not in ('file', 'udp', 'tcp', 'serial'):
        raise SettingsError(f'source = {source!r}: {_FORMS}')
    if scheme == 'file':
        if not rest:
            raise SettingsError(f'source = {source!r}: the path is missing; {_FORMS}')
        return Address('file', path=rest)
    if scheme == 'serial':
        device, _, query = rest.partition('?')
        options = _options(source, query, ('baud',))
        if not device:
            raise SettingsError(f'source = {source!r}: the device is missing; {_FORMS}')
        baud = _parse_whole(source, 'baud', options.get('baud', '4800'), 50, 4_000_000)
        return Address('serial', path=device, baud=baud)
    return _parse_network(source, scheme)


def _parse_network(source: str, scheme: str) -> Address:
    try:
        url = urlsplit(source)
        host, digits = url.hostname or '', url.netloc.rpartition(']')[2].rpartition(':')[2]
    except ValueError as error:
        raise SettingsError(f'source = {source!r}: {error}; {_FORMS}') from None
    if not url.netloc or url.path not in ('', '/') or '@' in url.netloc:
        raise SettingsError(f'source = {source!r}: {_FORMS}')
    port = _parse_whole(source, 'port', digits, 1, 65535)
    options = _options(source, url.query, ('interface', 'from') if scheme == 'udp' else ())
    if scheme == 'tcp' and not host:
        raise SettingsError(f'source = {source!r}: the host is missing; {_FORMS}')
    interface, sender = options.get('interface', ''), options.get('from', '')
    if scheme == 'udp' and ':' in host:
        raise SettingsError(f'source = {source!r}: host must be an IPv4 address or a name')
    if interface and not _is_ipv4(interface):
        raise SettingsError(f'source = {source!r}: interface must be the IPv4 address of a '
                            'network interface of this machine')
    if sender and not _is_ipv4(sender):
        raise SettingsError(f'source = {source!r}: from must be the IPv4 address of the sender')
    return Address(scheme, host=host, port=port, interface=interface, sender=sender)


def _is_ipv4(text: str) -> bool:
    try:
        ipaddress.IPv4Address(text)
    except ValueError:
        return False
    return True


def _options(source: str, query: str, allowed: tuple[str, ...]) -> dict[str, str]:
    options = dict(parse_qsl(query, keep_blank_values=True))
    for name in options:
        if name not in allowed:
            raise SettingsError(f'source = {source!r}: unknown option {name!r}; {_FORMS}')
    return options


def _parse_whole(source: str, name: str, text: str, lo: int, hi: int) -> int:
    if not (text.isascii() and text.isdigit() and lo <= int(text) <= hi):
        raise SettingsError(f'source = {source!r}: {name} must be a whole number from {lo} to '
                            f'{hi}; {_FORMS}')
    return int(text)


def _check_pattern(pattern: str) -> None:
    """Raise SettingsError for a pattern that cannot be read as a stamp."""
    start = f'stamp_pattern = {pattern!r}: '
    try:
        groups = set(re.compile(pattern.encode()).groupindex)
    except re.error as error:
        raise SettingsError(f'{start}{error}; must be a regular expression of Python') from None
    clock, parts = {'hour', 'minute', 'second'}, groups - {'fraction', 'zone'}
    if parts not in ({'epoch'}, clock, clock | {'year', 'month', 'day'}, clock | {'year', 'yday'}):
        raise SettingsError(
            f'{start}has the groups {", ".join(sorted(groups)) or "none"}; must have (?P<epoch>), '
            'or hour, minute and second, with year, month and day or year and yday, or without a '
            'date; fraction and zone may be added')


def _check_zone(zone: str) -> None:
    """Raise SettingsError for a zone that is unknown."""
    if zone == 'UTC' or re.match(r'[+-](?:0\d|1[0-4]):?[0-5]\d\Z', zone):
        return
    try:
        ZoneInfo(zone)
    except (ValueError, OSError, KeyError):
        raise SettingsError(f'stamp_zone = {zone!r}: must be an offset such as +02:00, or a name '
                            'of the tz database such as Europe/Oslo') from None


@dataclass(frozen=True, slots=True)
class DriverSettings(Checked):
    """Where headings come from, which sentences are used and how they are stamped."""

    source: str | None = setting(
        None, 'where sentences come from: file:PATH, udp://HOST:PORT (a multicast group is '
        'joined; ?from=IP takes one sender only), tcp://HOST:PORT or serial:DEVICE?baud=4800')
    topic: str = setting('ts/heading', 'topic on which the headings are published')
    sentence: str = setting(
        'auto', "kind of sentence to use; 'auto': the first of those present, in this order",
        choices=('auto', *SENTENCES))
    own_sentence: str | None = setting(
        None, 'sentence that is not among these, in one line: its identifier, heading=NUMBER of '
        'its field, and unit, scale, sign, north, quality, valid, time, clock, checksum where '
        'needed; it is the sentence to use')
    talker: str | None = setting(
        None, "talker whose sentences are used (HE, GP, IN; source number of a csv); several with "
        "commas between, or 'any', are read as one; none: the first heard")
    variation_deg: float | None = setting(
        None, 'magnetic variation, positive to the east, for HDG without one, HDM and the '
        'magnetic heading of VHW [deg]; none: unknown', -180.0, 180.0)
    deviation_table: str | None = setting(
        None, 'deviation of that compass, for HDG without one, HDM and the magnetic heading of '
        'VHW: heading of the compass and deviation, positive to the east, in degrees, rows '
        'separated by ;, or file:PATH; none: it has none')
    time: str = setting(
        'receipt', "stamps: time of 'receipt' (in a log: the stamp of the line), or of "
        "'validity' (ZDA, RMC or GGA of the same stream, own time of PASHR, HEADINGA and others)",
        choices=('receipt', 'validity'))
    stamp_format: str = setting(
        'auto', "form of the stamp of a line of a log; 'auto': any of them in a file, none on a "
        "live line; 'mdy' and 'dmy': a numeric date with month or day first; 'tag': c: of a "
        'TAG block', choices=STAMP_FORMATS)
    stamp_pattern: str | None = setting(
        None, 'regular expression for stamps of another form, with the named groups epoch; or '
        'hour, minute, second, and year, month, day or year, yday; and fraction, zone')
    stamp_zone: str | None = setting(
        None, "zone of stamps that name none: an offset such as '+02:00' or a name such as "
        "'Europe/Oslo'; none: UTC")
    date: str | None = setting(
        None, 'date of the first line, YYYY-MM-DD, for stamps and sentences with a time of day '
        'only; none: by ZDA or RMC of the same stream, or by the name of the file',
        is_date=True)
    time_column: str | None = setting(
        None, 'name of the column of times of a csv or Parquet table; of several columns, such as '
        'Date,Time, the names in the order in which they are read; none: by their names')
    instrument: str | None = setting(
        None, 'word before or after the sentences of the instrument to read, if a log has several '
        "of the same talker; 'any': all of them; none: refuse such a log")
    checksum: str = setting(
        'required', "'required' (except for PUHAW,UVH, which has none); 'if_present': sentences "
        'without a checksum are used too', choices=('required', 'if_present'))
    speed: float = setting(
        1.0, 'speed at which a file is played, relative to log time; 0: as fast as possible', 0.0)
    bursts: str = setting(
        'reject', "readings of a TCP or serial line, or of a log with one stamp for many lines, "
        "without a time of their own: 'reject', or 'accept' them with that of the read or of the "
        'stamp, as from a converter that packs sentences',
        choices=('reject', 'accept'))
    learn_s: float = setting(
        2.0, "time to listen on a live line before sentence 'auto' chooses [s]", 0.0, 600.0)
    reconnect_s: float = setting(
        2.0, 'time between attempts to reconnect to a TCP server or serial device [s]', 0.1,
        3600.0)

    def __post_init__(self) -> None:
        """Check every setting, and the form of the source."""
        Checked.__post_init__(self)
        if self.source is not None:
            parse_address(self.source)
        if self.stamp_pattern is not None:
            _check_pattern(self.stamp_pattern)
        if self.stamp_zone is not None:
            _check_zone(self.stamp_zone)
        if self.own_sentence is not None:
            self._check_own_sentence()
        if self.deviation_table is not None:
            self._load_deviations()

    def _load_deviations(self) -> None:
        """Check the table, and keep its rows in place of the name of a file."""
        try:
            rows = write_deviations(read_deviations(str(self.deviation_table)))
        except (OSError, ValueError) as error:
            reason = error.strerror if isinstance(error, OSError) else error
            raise SettingsError(f'deviation_table = {self.deviation_table!r}: {reason}') from None
        object.__setattr__(self, 'deviation_table', rows)

    def _check_own_sentence(self) -> None:
        try:
            read_own_sentence(self.own_sentence)
        except ValueError as error:
            raise SettingsError(f'own_sentence = {self.own_sentence!r}: {error}') from None
        if self.sentence != 'auto':
            raise SettingsError(f'sentence = {self.sentence!r} and own_sentence = '
                                f'{self.own_sentence!r}: state only one of them')

    @property
    def compass(self) -> Compass:
        """Return what is stated of a magnetic compass."""
        if self.variation_deg is None and self.deviation_table is None:
            return UNSTATED
        return Compass(self.variation_deg, read_deviations(self.deviation_table)
                       if self.deviation_table else ())

    @property
    def takes_several(self) -> bool:
        """Whether the readings of several talkers or instruments are taken as those of one."""
        talker = self.talker or ''
        return 'any' in (talker, self.instrument) or ',' in talker

    @property
    def described_sentence(self) -> OwnSentence | None:
        """Return the sentence that the user describes."""
        return read_own_sentence(self.own_sentence)

    @property
    def kind(self) -> str:
        """Return the kind of sentence to use: 'auto', or one of `kinds`."""
        return self.described_sentence.kind if self.described_sentence else self.sentence

    @property
    def kinds(self) -> tuple[str, ...]:
        """Return all kinds of heading sentences, the best first."""
        return (self.described_sentence.kind, *SENTENCES) if self.described_sentence else SENTENCES

    @property
    def address(self) -> Address:
        """Return the parsed source; SettingsError if no source is set."""
        if self.source is None:
            raise SettingsError(f'source is required: {_FORMS}')
        return parse_address(self.source)


DEFAULT_DRIVER = DriverSettings()
"""The settings of a driver of which nothing is stated."""
