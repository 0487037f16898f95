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

"""Settings of what sends the alerts to the bridge."""

from __future__ import annotations

from dataclasses import dataclass
import re
from urllib.parse import urlsplit

from heading_intercompare.core.declared_settings import Checked, setting, SettingsError
from heading_intercompare.drivers.settings import Address, parse_address

_FORMS = ('must be udp://HOST:PORT[?interface=IP], tcp://HOST:PORT or '
          'serial:DEVICE[?baud=38400]')
_COMMANDS = 'must be udp://HOST:PORT[?interface=IP&from=IP]'


@dataclass(frozen=True, slots=True)
class AlertSettings(Checked):
    """Where alerts go, in which form, and how often they are repeated."""

    destination: str | None = setting(
        None, 'where the sentences of alerts go: udp://HOST:PORT, tcp://HOST:PORT or '
        'serial:DEVICE?baud=38400; required without push_url')
    commands: str | None = setting(
        None, 'where commands come from if the sentences go out by UDP: udp://HOST:PORT; none: no '
        'commands are taken. A TCP or serial line has both directions')
    form: str = setting(
        'plain', "form of the datagrams: the 'plain' sentence, or '61162-450' with UdPbC and TAG "
        'blocks', choices=('plain', '61162-450'))
    system: str = setting(
        'II0001', 'name of this equipment in the TAG block s:, two letters and four digits')
    talker: str = setting('II', 'talker of the sentences, two letters')
    manufacturer: str | None = setting(
        None, 'mnemonic code that NMEA has assigned to the manufacturer, three letters; none: the '
        'field is empty')
    list_period_s: float = setting(
        30.0, 'time from one list of the active alerts (ALC) to the next [s]', 1.0, 3600.0)
    heartbeat_s: float = setting(
        30.0, 'time from one heartbeat (HBT) to the next [s]', 1.0, 999.0)
    repeat_s: float = setting(
        300.0, 'an unacknowledged warning is repeated after this time, as MSC.302 asks for within '
        '5 min [s]', 1.0, 3600.0)

    push_url: str | None = setting(
        None, 'address to which each change of an alarm is posted as JSON, http://... or '
        'https://...; none: nothing is posted')

    def __post_init__(self) -> None:
        """Check every setting, and the form of those that are texts."""
        Checked.__post_init__(self)
        for name, text, form, words in (
                ('system', self.system, '[A-Z]{2}[0-9]{4}', 'two letters and four digits'),
                ('talker', self.talker, '[A-Z]{2}', 'two capital letters'),
                ('manufacturer', self.manufacturer or 'XXX', '[A-Z]{3}', 'three capital letters')):
            if not re.fullmatch(form, text):
                raise SettingsError(f'{name} = {text!r}: must be {words}')
        if self.destination is not None:
            _parse('destination', self.destination, ('udp', 'tcp', 'serial'), _FORMS)
        if self.commands is not None:
            _parse('commands', self.commands, ('udp',), _COMMANDS)

        if self.push_url is not None:
            _check_url(self.push_url)

    @property
    def address(self) -> Address:
        """Return the parsed destination; SettingsError if none is set."""
        if self.destination is None:
            raise SettingsError(f'destination is required, or push_url: destination {_FORMS}')
        return parse_address(self.destination)


def _check_url(text: str) -> None:
    """Raise SettingsError for what is no address of HTTP; it may hold a secret."""
    try:
        url = urlsplit(text)
        is_right = url.scheme in ('http', 'https') and bool(url.hostname) and url.port != 0
    except ValueError:
        is_right = False
    if not is_right:
        raise SettingsError('push_url: must be http://HOST[:PORT]/... or https://HOST[:PORT]/...')


def _parse(name: str, text: str, schemes: tuple[str, ...], forms: str) -> None:
    """Raise SettingsError for a text that is no address of one of these kinds."""
    try:
        address = parse_address(text)
    except SettingsError:
        raise SettingsError(f'{name} = {text!r}: {forms}') from None
    if address.scheme not in schemes or (name == 'destination' and address.scheme == 'udp'
                                         and (not address.host or address.sender)):
        raise SettingsError(f'{name} = {text!r}: {forms}')
