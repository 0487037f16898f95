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

"""The motion of the ship from live streams: the choice of sentence, stamps, any cut of bytes."""

from __future__ import annotations

from drivers.motion.test_motion_log import RMC, S, sentence, START_NS, VTG, write
import numpy as np
import pytest

from heading_intercompare.core.records import Motion
from heading_intercompare.drivers.motion.motion_decoder import MotionDecoder
from heading_intercompare.drivers.motion.motion_log import read_log_motion
from heading_intercompare.drivers.settings import DriverSettings

UDP = DriverSettings(source='udp://127.0.0.1:60001')


def datagram(body, second=0):
    return f'{sentence(body.format(second))}\r\n'.encode()


def live(decoder, bodies, seconds):
    """Feed sentences once a second; return all rows."""
    found = [decoder.feed(datagram(body, second), START_NS + second * S)
             for second in range(seconds) for body in bodies]
    return Motion.concatenate([*found, decoder.flush()])


def columns(motion):
    return {name: getattr(motion.in_order(), name) for name in Motion.__slots__}


def assert_same(one, other):
    for name, column in columns(one).items():
        np.testing.assert_array_equal(column, columns(other)[name], name)


def test_a_live_line_gives_the_best_sentence_of_the_talker_heard_first():
    decoder = MotionDecoder(UDP)
    found = live(decoder, [f'GP{RMC}', f'GP{VTG}', f'IN{VTG}', 'HEROT,6.0,A'], 6)
    assert {what: str(name) for what, name in decoder.chosen.items()} == {
        'fix': 'GPRMC', 'velocity': 'GPVTG', 'rate': 'HEROT'}
    assert found.velocities().stamp_ns.tolist() == [START_NS + k * S for k in range(6)]
    assert found.velocities().course_deg == pytest.approx([90.0] * 6)
    assert found.rates().rate_deg_s.tolist() == [0.1] * 6
    # The course of RMC, and all of the second talker.
    assert decoder.counts == {'other': 12}


def test_rows_are_held_while_it_listens_and_none_is_lost():
    decoder = MotionDecoder(DriverSettings(learn_s=3.0))
    taken = [len(decoder.feed(datagram(f'GP{VTG}'), START_NS + k * S)) for k in range(6)]
    assert taken == [0, 0, 0, 4, 1, 1]


def test_time_passes_on_a_silent_line():
    decoder = MotionDecoder(UDP)
    assert not len(decoder.feed(datagram(f'GP{VTG}'), START_NS))
    assert len(decoder.feed(b'', START_NS + 2 * S)) == 1


def test_what_begins_later_is_chosen_by_itself():
    decoder = MotionDecoder(UDP)
    live(decoder, [f'GP{VTG}'], 5)
    later = Motion.concatenate([decoder.feed(datagram('HEROT,6.0,A'), START_NS + (9 + k) * S)
                                for k in range(4)])
    assert len(later.rates()) == 4 and str(decoder.chosen['rate']) == 'HEROT'


def test_bytes_cut_anywhere_give_the_same(rng):
    text = b''.join(datagram(body, second) for second in range(20)
                    for body in (f'GP{RMC}', f'GP{VTG}', 'HEROT,6.0,A'))
    stream = DriverSettings(source='tcp://127.0.0.1:60001', time='validity')
    whole, cut = MotionDecoder(stream), MotionDecoder(stream)
    edges = [0, *np.sort(rng.integers(0, len(text), 40)).tolist(), len(text)]
    pieces = [cut.feed(text[lo:hi], START_NS) for lo, hi in zip(edges[:-1], edges[1:])]
    assert_same(Motion.concatenate([*pieces, cut.flush()]),
                Motion.concatenate([whole.feed(text, START_NS), whole.flush()]))


def test_live_datagrams_with_tags_give_the_rows_of_their_log(tmp_path):
    """The stamps of TAG blocks are those of the lines of the log."""
    bodies = [f'GP{RMC}', f'GP{VTG}', 'HEROT,6.0,A']
    log = write(tmp_path / 'a.log', [bodies] * 20)
    decoder = MotionDecoder(DriverSettings(source=UDP.source, stamp_format='tag'))
    found = []
    for second in range(20):
        for body in bodies:
            tag = f'c:{(START_NS + second * S + S // 2) // 10 ** 6}'
            block = sentence(tag)[1:].encode()
            found.append(decoder.feed(b'UdPbC\0\\' + block + b'\\' + datagram(body, second),
                                      START_NS + second * S))
    assert_same(Motion.concatenate([*found, decoder.flush()]),
                Motion.concatenate([*read_log_motion(log).rows.values()]))


@pytest.mark.parametrize('time', ['receipt', 'validity'])
def test_a_log_that_is_played_gives_the_rows_of_the_whole_log(tmp_path, time):
    """The better sentence comes late, which the choice of the log knows."""
    log = write(tmp_path / 'a.log', [[f'GP{RMC}']] * 30 + [[f'GP{RMC}', f'GP{VTG}']] * 20)
    rule = DriverSettings(source=f'file:{log}', time=time)
    decoder = MotionDecoder(rule)
    with open(log, 'rb') as file:
        found = [decoder.feed(line, None, 0.0, log if not at else None)
                 for at, line in enumerate(file)]
    assert_same(Motion.concatenate([*found, decoder.flush()]),
                Motion.concatenate([*read_log_motion(log, rule).rows.values()]))
    assert str(decoder.chosen['velocity']) == 'GPVTG'


def test_damaged_sentences_are_counted_by_reason():
    decoder = MotionDecoder(UDP)
    decoder.feed(datagram('GPVTG,,T,,M,10.0,N,18.5,K,A'), START_NS)
    decoder.feed(f'$GP{VTG}\r\n'.encode(), START_NS)
    assert decoder.counts == {'GPVTG.empty': 1, 'no_checksum': 1}
