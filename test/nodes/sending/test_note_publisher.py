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

"""A note of the operator, from one process into the bag that another one records."""

from __future__ import annotations

import os
import signal
import subprocess
import sys

from deadlines import DEADLINE_S, Stopwatch
from nodes.processes import wait_for
import pytest
from ros_domain import DOMAIN

from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.bags.rosbag2.provenance import read_notes
from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.nodes.sending.note_publisher import publish_note

pytestmark = pytest.mark.process


def test_a_note_that_nobody_hears_is_an_error():
    watch = Stopwatch()
    with pytest.raises(SettingsError, match='nobody listens to /operator/note'):
        publish_note('course change', patience_s=0.2)
    assert watch.passed_s < 4.9


def test_a_note_for_a_namespace_that_nobody_hears_says_which():
    with pytest.raises(SettingsError, match='nobody listens to /ship1/operator/note'):
        publish_note('course change', '/ship1', patience_s=0.2)
    with pytest.raises(SettingsError, match="namespace = '/1st'.*must be like /ship1"):
        publish_note('course change', '/1st')


@pytest.mark.slow
@pytest.mark.parametrize('place', [[], ['--namespace', 'ship1']])
def test_a_note_reaches_the_bag_that_is_recorded(tmp_path, place):
    (tmp_path / 'mine.yaml').write_text('/**: {ros__parameters: {variant: C}}\n'
                                        'recorder: {ros__parameters: {chunk_bytes: 4096}}\n')
    environment = {**os.environ, 'ROS_DOMAIN_ID': str(DOMAIN),
                   'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'}
    command = [sys.executable, '-m', 'heading_intercompare']
    recorder = subprocess.Popen(
        [*command, 'record', *place, '-o', 'bag', '--config', 'mine.yaml', '--note', 'MV Example',
         '--operator', 'J. Smith'],
        env=environment, cwd=tmp_path, stderr=subprocess.PIPE, text=True)
    try:
        # The command waits 5 s for a recorder, which takes longer to load on a loaded machine.
        wait_for((tmp_path / 'bag' / 'metadata.yaml').exists)
        done = subprocess.run([*command, 'note', *place, '--operator', 'Mate', 'course',
                               'change'], env=environment,
                              cwd=tmp_path, capture_output=True, text=True, timeout=DEADLINE_S)
        assert (done.returncode, done.stdout) == (
            0, 'noted: course change [by Mate]\n'), done.stderr
        recorder.send_signal(signal.SIGINT)
        said = recorder.communicate(timeout=DEADLINE_S)[1]
    finally:
        recorder.kill()
        recorder.wait()
    assert recorder.returncode == 0 and 'note: course change' in said
    bag = BagReader(tmp_path / 'bag')
    assert bag.incomplete is None
    assert [note.text for note in read_notes(bag)] == [
        'MV Example [by J. Smith]', 'course change [by Mate]']
    assert [(a.name, a.data) for a in bag.attachments()] == [
        ('mine.yaml', (tmp_path / 'mine.yaml').read_bytes())]
    assert [name for name in bag.topics if name.endswith('note')] == [
        '/ship1/operator/note' if place else '/operator/note']
    stated = bag.metadata()['heading_intercompare']
    assert stated['settings.variant'] == 'C' and stated['settings.norms.sigma_max_deg'] == 'none'
