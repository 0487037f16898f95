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

"""Recordings are judged by the looks by which they were judged live."""

from __future__ import annotations

import json
import os
from pathlib import Path

from journals import some_pairs, write_journal
import numpy as np
import pytest

from heading_intercompare.app.config import Config, LIVE, settings_for
from heading_intercompare.app.recorded_looks import find_looks
from heading_intercompare.bags.recording.bag_writer import BagWriter, Rows
from heading_intercompare.bags.rosbag2.provenance import describe_origin, RECORD
from heading_intercompare.cli import main
from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.core.records import Headings
from heading_intercompare.core.settings import Settings
from heading_intercompare.messages.heading_messages import encode_imu

PLAN, LOOKS = 'sequential.plan_s', 'sequential.looks'
NORMS = {'norms.sigma_max_deg': 0.3, 'norms.sigma_ref_max_deg': 0.1}
OPEN = {PLAN: 'open', LOOKS: 5}


@pytest.fixture
def make_bag(tmp_path):
    """Return a function that makes a bag, given the settings that it holds."""
    def make(name='bag', n=0, **stored):
        stamps = (np.arange(n) + 1_700_000_000) * 10 ** 9
        rs = 100.0 + 50.0 * np.sin(np.arange(n) / 40.0)
        ts = rs + 0.1 * np.random.default_rng(3).standard_normal(n)
        with BagWriter(tmp_path / name) as writer:
            if stored:
                writer.metadata(RECORD, describe_origin(
                    Settings.from_mapping({**NORMS, **stored}).to_mapping()))
            for topic, headings in (('ts/heading', ts), ('rs/heading', rs)):
                writer.add_topic(topic, 'sensor_msgs/msg/Imu')
                if n:
                    writer.write_rows([Rows(topic, encode_imu(
                        Headings.of(stamps, headings), 'x'), stamps)])
        return str(tmp_path / name)
    return make


@pytest.mark.parametrize('stated, assignments, plan_s', [
    ({}, [], 'open'), ({PLAN: 'none'}, [], None), ({PLAN: None}, [], None),
    ({PLAN: 7200.0}, [], 7200.0), ({}, [f'{PLAN}=none'], None), ({}, [f'{PLAN}=900'], 900.0),
    ({PLAN: 'none'}, [f'{PLAN}=open'], 'open'), ({LOOKS: 3}, [], 'open')])
def test_a_live_graph_takes_open_looks_unless_the_user_states_a_plan(stated, assignments, plan_s):
    config = Config('my.yaml', {**NORMS, **stated})
    assert settings_for(config, assignments, LIVE).sequential.plan_s == plan_s
    assert settings_for(Config('my.yaml', NORMS)).sequential.plan_s is None


@pytest.mark.parametrize('stored, looks', [
    (OPEN, OPEN), ({PLAN: 3600.0}, {PLAN: 3600.0, LOOKS: 7}), ({PLAN: None, LOOKS: 5}, {}),
    ({}, {})])
def test_a_bag_is_judged_by_the_looks_that_it_holds(make_bag, stored, looks):
    assert find_looks(Config(), (), [make_bag(**stored)]) == looks


def test_a_bag_that_was_renamed_keeps_its_looks(make_bag, tmp_path):
    file, = Path(make_bag(**OPEN)).glob('*.mcap')
    assert find_looks(Config(), (), [str(file.rename(tmp_path / 'trial.bag'))]) == OPEN


def test_a_pipe_is_left_for_the_judging(tmp_path):
    """Nobody writes into it: whoever opened it here would wait for ever."""
    os.mkfifo(tmp_path / 'pipe.csv')
    assert find_looks(Config(), (), [str(tmp_path / 'pipe.csv')]) == {}


@pytest.mark.parametrize('stated, assignments, looks', [
    ({PLAN: 'none'}, [], {}), ({}, [f'{PLAN}=none'], {}), ({}, [f'{PLAN}=900'], {}),
    ({LOOKS: 3}, [], {PLAN: 'open'}), ({}, [f'{LOOKS}=3'], {PLAN: 'open'})])
def test_what_the_user_states_wins_over_a_bag(make_bag, stated, assignments, looks):
    assert find_looks(Config('my.yaml', stated), assignments, [make_bag(**OPEN)]) == looks


def test_a_journal_is_judged_by_its_looks_also_with_a_parameter_file(tmp_path):
    path = tmp_path / 'trial.journal'
    write_journal(path, some_pairs(200), **OPEN)
    assert find_looks(Config('my.yaml', NORMS), (), [str(path)]) == OPEN


def test_an_input_without_looks_or_that_cannot_be_read_says_nothing(make_bag, tmp_path):
    log = tmp_path / 'log.mcap'
    log.write_text('$HEHDT,1.0,T\n')
    inputs = [make_bag('plain', **{LOOKS: 5}), str(log), str(tmp_path / 'absent.mcap'), 'ts=log',
              make_bag('looked_at', **OPEN)]
    assert find_looks(Config(), (), inputs[:-1]) == {}
    assert find_looks(Config(), (), inputs) == OPEN


def test_bags_with_other_looks_are_refused_until_the_user_chooses(make_bag):
    bags = [make_bag('a', **OPEN), make_bag('b', **{PLAN: 3600.0})]
    with pytest.raises(SettingsError) as refused:
        find_looks(Config(), (), bags)
    assert str(refused.value) == (
        f'{bags[1]}: was judged live with other looks than {bags[0]}: sequential.plan_s = 3600.0, '
        'sequential.looks = 7, not open, 5; choose those for all with '
        '--set sequential.plan_s=...')
    assert find_looks(Config(), [f'{PLAN}=none'], bags) == {}


@pytest.mark.parametrize('stored, plan_s, n_looks', [(OPEN, 'open', 2), ({LOOKS: 5}, None, 0)])
def test_analyze_judges_a_bag_as_it_was_judged_live(make_bag, tmp_path, stored, plan_s, n_looks):
    bag, verdict = make_bag(n=300, **stored), tmp_path / 'verdict.json'
    rule = {**NORMS, 'risk.min_duration_s': 100}
    assert main(['analyze', bag, '--quiet', '--json', str(verdict),
                 *(word for name, value in rule.items()
                   for word in ('--set', f'{name}={value}'))]) == 0
    document = json.loads(verdict.read_text())
    assert document['settings'][PLAN] == plan_s
    assert len(document['runs'][0]['looks']) == n_looks
