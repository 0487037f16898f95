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

"""Source addresses and driver settings: what is accepted, and the errors for the rest."""

from __future__ import annotations

import pytest

from heading_intercompare.core.declared_settings import from_mapping, SettingsError, to_mapping
from heading_intercompare.drivers.sentence_choice import choose_sentence
from heading_intercompare.drivers.sentences import Name, PARSERS
from heading_intercompare.drivers.settings import Address, DriverSettings, parse_address, SENTENCES


@pytest.mark.parametrize('source, address', [
    ('file:logs/gyro 1%20?.log', Address('file', path='logs/gyro 1%20?.log')),
    ('udp://0.0.0.0:10110', Address('udp', host='0.0.0.0', port=10110)),
    ('udp://:10110', Address('udp', port=10110)),
    ('udp://239.192.0.3:60003?interface=10.0.0.5',
     Address('udp', host='239.192.0.3', port=60003, interface='10.0.0.5')),
    ('tcp://moxa-1:4001', Address('tcp', host='moxa-1', port=4001)),
    ('tcp://[fe80::1]:4001', Address('tcp', host='fe80::1', port=4001)),
    ('serial:/dev/ttyUSB0', Address('serial', path='/dev/ttyUSB0', baud=4800)),
    ('serial:COM3?baud=38400', Address('serial', path='COM3', baud=38400)),
])
def test_a_source_is_read(source, address):
    assert parse_address(source) == address


@pytest.mark.parametrize('source, says', [
    ('', 'must be file:PATH'),
    ('/var/log/gyro', 'must be file:PATH'),
    ('http://host:80', 'must be file:PATH'),
    ('file:', 'path is missing'),
    ('udp://239.192.0.3', 'port must be a whole number from 1 to 65535'),
    ('udp://host:0', 'port must be'),
    ('udp://host:65536', 'port must be'),
    ('udp://host:1e3', 'port must be'),
    ('udp://host:123/path', 'must be file:PATH'),
    ('udp://host:123?group=5', "unknown option 'group'"),
    ('udp://[ff02::1]:10110', 'host must be an IPv4 address'),
    ('udp://239.192.0.3:123?interface=eth0', 'interface must be the IPv4 address'),
    ('tcp://:4001', 'host is missing'),
    ('tcp://[::1:4001', 'must be file:PATH'),
    ('tcp://h:4001?interface=1', "unknown option 'interface'"),
    ('serial:', 'device is missing'),
    ('serial:/dev/ttyS0?baud=fast', 'baud must be'),
    ('serial:/dev/ttyS0?parity=E', "unknown option 'parity'"),
])
def test_a_wrong_source_is_refused_in_one_line_that_names_it(source, says):
    with pytest.raises(SettingsError, match='source = ') as caught:
        DriverSettings(source=source)
    message = str(caught.value)
    assert says in message and repr(source) in message and '\n' not in message


@pytest.mark.parametrize('host, multicast', [
    ('239.192.0.3', True), ('224.0.0.1', True), ('10.0.0.5', False), ('gyro', False),
    ('', False)])
def test_a_multicast_group_is_known_by_its_address(host, multicast):
    assert Address('udp', host=host).multicast is multicast


@pytest.mark.parametrize('name, value', [
    ('stamp_zone', 'CEST2'), ('stamp_zone', '+25:00'), ('stamp_zone', '../x'),
    ('date', '28.05.2024'), ('date', '2024-02-30'), ('date', '1969-01-01'), ('stamp_pattern', '('),
    ('stamp_pattern', '(?P<hour>.)'), ('stamp_pattern', '(?P<epoch>.)(?P<hour>.)'),
    ('sentence', 'ROT'), ('variation_deg', 181.0), ('time', 'gps'), ('stamp_format', 'unix'),
    ('speed', -1.0), ('learn_s', -1.0), ('checksum', 'no'), ('speed', float('nan'))])
def test_a_value_outside_its_range_is_refused(name, value):
    with pytest.raises(SettingsError, match=name):
        from_mapping(DriverSettings, {name: value})


def test_settings_survive_a_mapping():
    settings = DriverSettings(source='tcp://gyro:4001', sentence='PSXN,23', time='validity')
    assert from_mapping(DriverSettings, to_mapping(settings)) == settings


def test_a_driver_without_a_source_says_that_one_is_required():
    with pytest.raises(SettingsError, match='source is required'):
        _ = DriverSettings().address


def test_every_kind_of_sentence_that_can_be_set_has_a_parser_and_its_order():
    assert tuple(PARSERS) == SENTENCES
    assert SENTENCES[:6] == ('THS', 'HDT', 'PASHR', 'PSXN,23', 'PUHAW,UVH', 'HDG')
    names = [Name(kind, 'HE') for kind in reversed(SENTENCES)]
    assert choose_sentence(names).kind == 'THS'
    assert choose_sentence([Name('HDT', 'GP'), Name('HDT', 'HE')]) == Name('HDT', 'GP')
