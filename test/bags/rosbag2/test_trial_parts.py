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

"""Bags of one trial are found and judged together."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest

from heading_intercompare.app.analysis import judge_bags
from heading_intercompare.bags.mcap.chunk_writer import Rows
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.rosbag2.provenance import describe_origin, RECORD
from heading_intercompare.bags.rosbag2.publisher_starts import PublisherRecords, PublisherStart
from heading_intercompare.bags.rosbag2.trial_parts import find_parts, find_place
from heading_intercompare.core.pipeline import Intercomparison
from heading_intercompare.core.records import Headings
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.verdict.compare_verdicts import find_differences
from heading_intercompare.messages.heading_messages import encode_imu, IMU

S = 1_000_000_000
T0 = 20_000 * 86400 * S
SETTINGS = Settings.from_mapping({
    'norms.sigma_max_deg': 0.3, 'norms.sigma_ref_max_deg': 0.1, 'risk.min_duration_s': 0.0,
    'pairing.method': 'interpolate', 'runs.gap_s': 120.0})


def parts_of(rng, folder):
    """Write a trial of 30 min in three bags, with 20 s missing between them."""
    paths, readings = [], []
    for number, lo_s in enumerate((0, 600, 1200)):
        stamp = T0 + np.arange(lo_s, lo_s + 580) * S
        ts = Headings.of(stamp, 90.0 + rng.normal(0.0, 0.1, 580))
        rs = Headings.of(stamp + S // 4, np.full(580, 90.0))
        paths.append(str(folder / f'trial_{number}'))
        readings.append((ts, rs))
        with BagWriter(paths[-1]) as bag:
            bag.metadata(RECORD, describe_origin({}, None, f'trial_{number - 1}' if number
                                                 else None))
            for topic, chunk in zip(('/ts/heading', '/rs/heading'), (ts, rs)):
                bag.add_topic(topic, IMU)
                bag.write_rows([Rows(topic, encode_imu(chunk, 'f'), chunk.stamp_ns)])
    return paths, readings


def test_in_any_order_the_first_bag_leads_the_others(tmp_path, rng):
    paths, _ = parts_of(rng, tmp_path)
    for given in itertools.permutations(paths):
        assert find_parts(given) == {paths[0]: paths[1:]}
    assert find_parts(paths[1:]) == {paths[1]: paths[2:]}
    assert find_parts([paths[0], paths[2]]) == find_parts(paths[:1]) == {}
    assert find_parts([*paths, str(tmp_path / 'none'), 'pairs.csv']) == {paths[0]: paths[1:]}


@pytest.mark.parametrize('jobs', [None, 2])
def test_they_are_one_run_and_each_reading_is_accounted_for(tmp_path, rng, jobs):
    paths, readings = parts_of(rng, tmp_path)
    comparison = Intercomparison(SETTINGS)
    for number, (ts, rs) in enumerate(readings):
        if number:
            comparison.begin_again()
        comparison.update(ts, rs)
    comparison.finish()
    expected, = comparison.verdict().runs
    judged = judge_bags(paths, SETTINGS, jobs=jobs)
    run, = judged.verdict.runs
    # Each bag pairs on its own: the first and last TS readings have too few of the RS around.
    assert (run.n, run.mean_deg, run.std_deg) == (3 * 575, expected.mean_deg, expected.std_deg)
    assert run.pairing == expected.pairing
    assert (run.pairing.ts_received, run.pairing.rs_received) == (3 * 580, 3 * 580)
    assert [one.continues for one in judged.verdict.inputs] == [None, paths[0], paths[0]]
    assert len(judged.verdict.ledger_problems) == 2
    alone = judge_bags([paths[0]], SETTINGS).verdict.runs[0]
    assert alone.n == 575


def write_part(path, readings, rows, numbers, publishers, before=None):
    """Write some rows of both sensors, with the numbers and the publishers of their messages."""
    with BagWriter(path) as bag:
        bag.metadata(RECORD, describe_origin({}, None, before))
        records = PublisherRecords(bag.metadata)
        for topic, chunk in zip(('/ts/heading', '/rs/heading'), readings):
            bag.add_topic(topic, IMU)
            part, sequence = chunk[rows], numbers[rows]
            records.add(topic, [PublisherStart(f'{topic}.{publisher}', int(sequence[at]),
                                               int(part.stamp_ns[at]))
                                for publisher, at in publishers.items()])
            bag.write_rows([Rows(topic, encode_imu(part, 'f'), part.stamp_ns,
                                 sequence=sequence)])
    return str(path)


def count_lost(verdict):
    """Return what is lost of the TS and the RS in each run."""
    return [(run.pairing.lost.ts, run.pairing.lost.rs) for run in verdict.runs]


@pytest.mark.parametrize('missing', [0, 7])
def test_parts_of_which_only_the_recorder_was_away_are_one_whole(tmp_path, rng, missing):
    """The publishers go on, and restart later; 7 at the seam were no longer held."""
    stamp, n = T0 + np.arange(1800) * S, 1800
    readings = (Headings.of(stamp, 90.0 + rng.normal(0.0, 0.1, n)),
                Headings.of(stamp + S // 4, np.full(n, 90.0)))
    numbers = np.concatenate((np.arange(5, 1205), np.arange(12, 612)))
    rows = np.r_[0:800, 800 + missing:n]
    whole = write_part(tmp_path / 'whole', readings, rows, numbers,
                       {'a': 0, 'b': 1200 - missing})
    first = write_part(tmp_path / 'trial', readings, np.arange(800), numbers, {'a': 0})
    second = write_part(tmp_path / 'trial_2', readings, np.arange(800 + missing, n), numbers,
                        {'a': 0, 'b': 400 - missing}, 'trial')
    judged = judge_bags([first, second], SETTINGS)
    expected = judge_bags([whole], SETTINGS).verdict
    assert list(find_differences(judged.verdict, expected)) == []
    lost = {'before_start': 4, 'on_the_way': 11 + missing}
    assert count_lost(expected) == [(lost, lost)]
    assert judged.verdict.ledger_problems == () and judged.verdict.ledger_complete


def test_parts_with_other_publishers_are_paired_on_their_own(tmp_path, rng):
    """As when the whole graph was started again: what came in between nobody knows."""
    stamp = T0 + np.arange(1200) * S
    readings = (Headings.of(stamp, 90.0 + rng.normal(0.0, 0.1, 1200)),
                Headings.of(stamp + S // 4, np.full(1200, 90.0)))
    numbers = np.concatenate((np.arange(1, 601), np.arange(1, 601)))
    first = write_part(tmp_path / 'trial', readings, np.arange(600), numbers, {'a': 0})
    second = write_part(tmp_path / 'trial_2', readings, np.arange(600, 1200), numbers, {'b': 0},
                        'trial')
    judged = judge_bags([first, second], SETTINGS).verdict
    assert ['goes on with this trial' in problem for problem in judged.ledger_problems] == [True]
    assert count_lost(judged) == [({}, {})]


def test_other_bags_beside_them_stay_runs_of_their_own(tmp_path, rng):
    paths, _ = parts_of(rng, tmp_path)
    (tmp_path / 'other').mkdir()
    others, _ = parts_of(rng, tmp_path / 'other')
    judged = judge_bags([others[0], *paths], SETTINGS)
    assert sorted(run.n for run in judged.verdict.runs) in ([575, 3 * 575], [575, 575, 2 * 575])


def test_a_bag_goes_on_with_the_newest_one_if_that_was_cut_off(tmp_path, rng):
    """The names are taken in order; a bag that was closed is not continued."""
    wanted = str(tmp_path / 'trial')
    assert find_place(wanted) == (wanted, None)
    (tmp_path / 'made').mkdir()
    paths, _ = parts_of(rng, tmp_path / 'made')
    for path, name in zip(paths, ('trial', 'trial_2', 'trial_3')):
        assert find_place(wanted + '/')[0].rstrip('/') == str(tmp_path / name)
        Path(path).rename(tmp_path / name)
    assert find_place(wanted) == (f'{wanted}_4', None)
    recording, = (tmp_path / 'trial_3').glob('*.mcap')
    recording.write_bytes(recording.read_bytes()[:-100])
    (tmp_path / 'trial_3' / 'metadata.yaml').unlink()
    assert find_place(wanted) == (f'{wanted}_4', 'trial_3')


def test_something_else_of_that_name_is_left_alone(tmp_path):
    (tmp_path / 'trial').write_text('no bag')
    assert find_place(str(tmp_path / 'trial')) == (str(tmp_path / 'trial_2'), None)
