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

"""What the covariances of a bag claim beside the verdict on its headings."""

from __future__ import annotations

from command_line import analyze_json
import numpy as np
import pytest

from heading_intercompare import Headings
from heading_intercompare.bags.mcap.chunk_writer import Rows
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.cli import main
from heading_intercompare.messages.heading_messages import encode_imu, IMU

N = 3000
STAMPS = 1_800_000_000 * 10 ** 9 + np.arange(N) * 10 ** 9
CONSTANT_DEG = float(np.degrees(0.1))
"""The claim of drivers that fill the covariance with 0.01 rad², whatever their sensor is."""


@pytest.fixture
def write(tmp_path, rng):
    """Return a function that writes a bag of two sensors: errors and claims, degrees."""
    def write_bag(*, ts_deg=(0.1, 0.0), rs_deg=(0.02, 0.0)):
        ship = 220.0 + 10.0 * np.sin(np.arange(N) / 40.0)
        with BagWriter(tmp_path / 'bag') as bag:
            for topic, (sigma_deg, claim_deg) in {
                    '/ts/heading': ts_deg, '/rs/heading': rs_deg}.items():
                bag.add_topic(topic, IMU)
                headings = Headings.of(STAMPS, ship + sigma_deg * rng.standard_normal(N))
                bag.write_rows([Rows(topic, encode_imu(headings, 'x', sigma_deg=claim_deg),
                                     STAMPS)])
        return tmp_path / 'bag'
    return write_bag


def findings_of(run):
    return {finding['condition']: finding for finding in run['validity']}


def test_a_bag_without_claims_says_nothing(write, capsys):
    run = analyze_json(capsys, write())[0]['runs'][0]
    assert 'quality' not in run and 'reduced_quality' not in findings_of(run)


def test_constant_covariances_leave_a_compliant_verdict_as_it_is(write, capsys):
    """A claim that is larger than the data show and than the norms is no reason for doubt."""
    verdict, _ = analyze_json(capsys, write(ts_deg=(0.1, CONSTANT_DEG),
                                            rs_deg=(0.02, CONSTANT_DEG)))
    run = verdict['runs'][0]
    assert run['outcome'] == 'compliant' and not run['warnings']
    assert {finding['effect'] for finding in run['validity']} <= {'holds', 'not_testable'}
    assert run['quality']['ts_claim'] == 'too_large'
    assert [run['quality'][sensor]['stated_largest_deg'] for sensor in ('ts', 'rs')] == [5.73] * 2
    assert run['quality']['rs']['n'] == run['n'] and not run['quality']['rs']['n_reduced']


def test_a_rejection_is_doubtful_if_the_reference_claims_more_than_its_norm(write, capsys):
    verdict, _ = analyze_json(capsys, write(ts_deg=(0.6, 0.0), rs_deg=(0.02, CONSTANT_DEG)))
    run = verdict['runs'][0]
    finding = findings_of(run)['reference']
    assert run['outcome'] == 'non_compliant' and finding['effect'] == 'doubtful'
    assert 'it claims 5.73 deg' in finding['words'] and finding['words'] in verdict['headline']


def test_a_sensor_that_claims_too_little_is_named(write, capsys):
    run = analyze_json(capsys, write(ts_deg=(0.1, 0.01)))[0]['runs'][0]
    assert run['outcome'] == 'compliant'
    assert any(warning.startswith('claim_of_ts: the TS claims 0.01 deg')
               for warning in run['warnings'])


def test_claims_of_a_field_and_of_its_topic_are_the_same(write, capsys):
    bag = write(rs_deg=(0.02, 0.05))
    whole, field = (analyze_json(capsys, bag, '--set', f'rs_topic={topic}')[0]['runs'][0]
                    for topic in ('rs/heading', 'rs/heading.orientation'))
    assert whole['quality'] == field['quality'] and field['quality']['rs']['n'] == N


def test_a_bag_made_of_a_bag_keeps_its_claims_once(write, capsys, tmp_path):
    bag, copy = write(rs_deg=(0.02, np.where(np.arange(N) < 900, 0.05, 0.08))), tmp_path / 'copy'
    assert main(['import', str(bag), '-o', str(copy), '--quiet']) == 0
    by_bag, by_copy = (analyze_json(capsys, path)[0]['runs'][0]['quality']
                       for path in (bag, copy))
    assert by_bag == by_copy and by_bag['rs']['stated_largest_deg'] == 0.08
