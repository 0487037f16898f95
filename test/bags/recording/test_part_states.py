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

"""The last state of each part, and which messages of /diagnostics a recording keeps."""

from __future__ import annotations

from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.recording.part_states import PartStates, read_states, STATES
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.messages.status_messages import (
    encode_statuses,
    ERROR,
    OK,
    Status,
    STATUS_TYPE,
    WARN,
)

S = 1_000_000_000
T0_NS = 1_700_000_000 * S


def message(level=OK, words='recording', name='recorder: bag', **values):
    """Return a message with one status."""
    return encode_statuses(T0_NS, [Status(name, level, words, values)])


def test_what_says_nothing_new_is_kept_once_in_a_period():
    states = PartStates(10.0)
    kept = [n for n in range(35) if states.take(message(messages=n), T0_NS + n * S)]
    assert kept == [0, 10, 20, 30]


def test_what_is_new_is_kept_at_once():
    states = PartStates(10.0)
    said = [(OK, 'recording'), (OK, 'recording'), (ERROR, 'disk full'), (ERROR, 'disk full'),
            (ERROR, 'disk gone'), (OK, 'recording')]
    kept = [n for n, one in enumerate(said) if states.take(message(*one), T0_NS + n * S)]
    assert kept == [0, 2, 4, 5]
    assert states.take(message(name='another: part'), T0_NS + 6 * S)


def test_what_cannot_be_read_is_kept():
    assert PartStates(10.0).take(b'\0\3\0\0', T0_NS)


def test_the_last_state_of_each_part_is_told_in_words():
    states = PartStates(10.0)
    for n, level in enumerate((OK, WARN)):
        states.take(message(level, f'line {n}\nbroken'), T0_NS + n * S)
    states.take(message(name='a: node'), T0_NS)
    assert states.record() == {
        'a: node': '2023-11-14 22:13:20.000 UTC  OK     recording',
        'recorder: bag': '2023-11-14 22:13:21.000 UTC  WARN   line 1 broken'}


def test_a_bag_whose_recorder_was_killed_has_the_states_of_its_last_minute(tmp_path):
    with BagWriter(tmp_path / 'bag') as bag:
        bag.add_topic('/diagnostics', STATUS_TYPE)
        for n, name in ((0, 'gone: long ago'), (100, 'ts_driver: source'), (120, 'node: x')):
            bag.write('/diagnostics', message(name=name), T0_NS + n * S)
    assert list(read_states(BagReader(tmp_path / 'bag'))) == ['node: x', 'ts_driver: source']


def test_a_bag_that_was_closed_has_them_in_a_record(tmp_path):
    with BagWriter(tmp_path / 'bag') as bag:
        bag.metadata(STATES, {'x: y': 'well'})
    assert read_states(BagReader(tmp_path / 'bag')) == {'x: y': 'well'}
