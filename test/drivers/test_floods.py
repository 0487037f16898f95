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

"""What a hostile sender can make a program keep is bounded, and what is dropped is counted."""

from __future__ import annotations

from functools import reduce
import itertools
import socket
import string

import numpy as np
import pytest

from heading_intercompare.bags.recording.part_states import PartStates
from heading_intercompare.bags.rosbag2.provenance import Notes
from heading_intercompare.core.pairing.incarnations import Incarnations
from heading_intercompare.core.pairing.ledger import Ledger, LedgerKey
from heading_intercompare.core.pairing.pairer import Pairer
from heading_intercompare.core.records import Headings, Losses
from heading_intercompare.core.settings import Settings
from heading_intercompare.drivers.nmea import NmeaDecoder
from heading_intercompare.drivers.settings import DriverSettings
from heading_intercompare.drivers.sources import UdpSource
from heading_intercompare.messages.errors import MessageError
from heading_intercompare.messages.status_messages import decode_statuses, encode_statuses, Status


def sentence(text):
    """Return a sentence with its checksum."""
    return f'${text}*{reduce(lambda a, b: a ^ b, text.encode()):02X}\r\n'.encode()


def test_a_flood_of_talkers_gives_few_counts_and_loses_none():
    decoder = NmeaDecoder(DriverSettings(sentence='HDT', talker='HE'))
    letters = string.ascii_uppercase + string.digits
    talkers = [''.join(two) for two in itertools.product(letters, repeat=2)]
    talkers = [one for one in talkers if one != 'HE' and one[0] != 'P']
    for one in talkers:
        decoder.feed(sentence(f'{one}HDT,10.0,T'), 1_000)
    assert len(decoder.counts) <= 33
    assert sum(decoder.counts.values()) == len(talkers)
    assert decoder.counts['other_talker.others'] == len(talkers) - 32


def test_a_flood_before_the_choice_of_a_sentence_is_not_held_without_end():
    decoder = NmeaDecoder(DriverSettings(learn_s=600.0))
    line, n = sentence('HEHDT,10.0,T') * 1000, 0
    for _ in range(150):
        n += len(decoder.feed(line, 1_000))
        assert decoder._listening.n_held <= 101_000
    assert n == 150_000 and str(decoder.chosen) == 'HEHDT'


@pytest.fixture
def udp():
    """Return a source and a function that sends it a datagram."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        sender.bind(('127.0.0.1', 0))
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
            free.bind(('127.0.0.1', 0))
            port = free.getsockname()[1]
        source = UdpSource(DriverSettings(source=f'udp://127.0.0.1:{port}'))
        yield source, lambda data: sender.sendto(data, ('127.0.0.1', port))
        source.close()


def test_an_oversized_datagram_is_counted_and_the_next_one_is_taken(udp):
    source, send = udp
    for data in (bytes(20_000), b'x' * 16_384, b'next'):
        send(data)
    taken = []
    while len(taken) < 2:
        taken += source.read(1.0)
    assert [one.data for one in taken] == [b'x' * 16_384, b'next']
    assert source.counts['oversized'] == 1


def test_forged_senders_are_not_remembered_without_end(udp):
    source, send = udp
    source._senders.update(f'10.0.{at >> 8}.{at & 255}' for at in range(1000))
    send(b'x')
    assert len(source.read(1.0)) == 1
    assert source.status.endswith('and 998 more') and source._senders['others'] == 1


def test_a_status_array_of_a_million_entries_is_refused_before_it_is_decoded():
    head = encode_statuses(0, [])[:-4]
    hostile = head + (10 ** 6).to_bytes(4, 'little') + bytes(24 * 10 ** 6)
    with pytest.raises(MessageError, match='must have at most 2097152'):
        decode_statuses(hostile)
    with pytest.raises(MessageError, match='ends early'):
        decode_statuses(head + b'\xff\xff\xff\xff' + bytes(1000))


def test_names_and_words_of_parts_are_kept_short():
    states = PartStates(10.0)
    huge = encode_statuses(0, [Status('n' * 10 ** 6, 0, 'w' * 10 ** 5)])
    assert states.take(huge, 1) and not states.take(huge, 2)
    (name, said), = states.record().items()
    assert len(name) == 500 and len(said) < 600


def test_parts_that_were_cut_are_counted_once_each():
    states = PartStates(10.0)
    for at in range(3):
        states.take(encode_statuses(0, [Status('n' * 501, 0, ''), Status('a', 0, 'w' * 501),
                                        Status('b' * 500, 0, 'w' * 500)]), at)
    assert states.cut == 2
    for at in range(3000):
        states.take(encode_statuses(0, [Status(f'{at}' + 'n' * 501, 0, '')]), at)
    assert states.cut == 999


def test_a_huge_note_is_kept_in_part_and_counted():
    written = []
    notes = Notes(lambda name, values: written.append(values))
    note, _ = notes.add('x' * 10 ** 6 + '\n' + 'y' * 10_000, 0)
    assert len(note.text) == 10_000 == len(written[0]['text'])
    assert (notes.cut, notes.left_out) == (1, 0)
    notes.add('calm sea\n' * 1500, 0)
    assert len(written) == 1000 and (notes.cut, notes.left_out) == (1, 503)


def test_ledgers_of_made_up_starts_are_refused_and_said():
    starts = Incarnations()
    for at in range(2000):
        starts.take(Ledger(), False, at)
    assert len(starts._last) == 1000
    assert next(starts.problems()).startswith('1000 ledgers of further starts')


def test_losses_told_for_the_far_future_are_counted_and_not_kept_one_by_one():
    pairer = Pairer(Settings())
    for at in range(25_000):
        pairer.lose(LedgerKey('ts_lost.at_source'),
                    Losses.of([4 * 10 ** 18 + at], [4 * 10 ** 18 + at - 1], [2]))
    assert sum(map(len, pairer.ledger._gaps.values())) <= 10_000
    assert pairer.ledger.total.counts['ts_lost.at_source'] == 50_000


def test_readings_that_crawl_in_the_future_are_not_held_without_end():
    """Their stamps go on from each other by a nanosecond, so they never last five seconds."""
    pairer = Pairer(Settings())
    good = 10 ** 18 + np.arange(100) * 10 ** 9
    pairer.update(ts=Headings.of(good, np.full(100, 10.0)), now_s=0.0)
    n = 50_000
    crawl = 2 * 10 ** 18 + np.arange(n)
    for lo in range(0, n, 5000):
        pairer.update(ts=Headings.of(crawl[lo:lo + 5000], np.full(5000, 10.0)), now_s=0.0)
        assert len(pairer._ts._jumps) <= 20_001
    total = pairer.ledger.total
    assert total.received('ts') == n + 100
    assert total.rejected('ts')['jump'] >= 20_000
