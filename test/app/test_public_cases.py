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

"""Inputs in the forms that people reported, with their right answers."""

from __future__ import annotations

import json

import pytest

from heading_intercompare.cli.program import main

NORMS = ('--set', 'norms.sigma_max_deg=0.2', '--set', 'norms.sigma_ref_max_deg=0.1')
TWO_LOGS = ('gyro.log', 'ref.log')
NORMS_MET = ('compliant', 660, 0.308, 0.116)
#: Arguments of analyze; outcome, pairs, mean and standard deviation of the differences [deg].
ANSWERS = {
    'rad_csv': (('d.csv', '--ts', 'gyro_heading_rad', '--rs', 'gps_heading_rad'),
                ('non_compliant', 660, 3.42, 5.24)),
    'rad_canboatjs': (('d.json', '--ts', '35', '--rs', '36'), ('non_compliant', 660, 3.42, 5.24)),
    'gaps_rough_sea': (TWO_LOGS, ('compliant', 853, 0.30, 0.117)),
    'gaps_mild': (TWO_LOGS, ('compliant', 551, 0.30, 0.117)),
    'held_rs_5hz': (('gyro.log.gz', 'ref.log.gz'), ('compliant', 660, 0.30, 0.117)),
    'scs_elg': (('d.csv', '--ts', 'GYRO-HEADING', '--rs', 'POSMV-HEADING'), NORMS_MET),
    'slashes': (('d.csv', '--ts', 'gyro_heading', '--rs', 'gps_heading'), NORMS_MET),
    'name_gyro': (('d.csv', '--ts', 'GYRO', '--rs', 'POSMV'), NORMS_MET),
    'ydwg_raw': (('d.log', '--ts', '35', '--rs', '36', '--date', '2024-05-28'), NORMS_MET),
    'signalk_raw_A': (('d.log', '--ts', '35', '--rs', '36'), NORMS_MET),
    'gpsd_att': (('d.log', '--ts', '/dev/gyro', '--rs', '/dev/gps'), NORMS_MET),
    'ptnl_avr': (TWO_LOGS, NORMS_MET),
    'psat_hpr': (TWO_LOGS, NORMS_MET),
    'uniheadinga': (TWO_LOGS, NORMS_MET),
    'talker_blocks': ((*TWO_LOGS, '--rs-talker', 'GN,GP'), NORMS_MET),
    'n2kd_talker': (('nav.log', '--ts-talker', '23', '--rs-talker', '24'), NORMS_MET),
    'zda_two_digits': ((*TWO_LOGS, '--time', 'validity'), NORMS_MET),
    'sentence_mcap': (('bag', '--ts', '/gyro', '--rs', '/gps'), NORMS_MET),
}

@pytest.mark.parametrize('case', ANSWERS)
def test_a_reported_form_is_read(shared_data, case, tmp_path, monkeypatch):
    arguments, (outcome, n, mean_deg, std_deg) = ANSWERS[case]
    monkeypatch.chdir(shared_data / 'public_cases' / case)
    assert main(['analyze', *arguments, *NORMS, '--quiet', '--json',
                 str(tmp_path / 'verdict.json')]) == 0
    verdict = json.loads((tmp_path / 'verdict.json').read_text('utf-8'))
    run, = verdict['runs']
    assert (verdict['outcome'], run['n']) == (outcome, n)
    assert run['mean_deg'] == pytest.approx(mean_deg, abs=0.03)
    assert run['std_deg'] == pytest.approx(std_deg, rel=0.03)


def test_streams_that_do_not_meet_name_both_spans_and_a_zone(shared_data, monkeypatch, capsys):
    monkeypatch.chdir(shared_data / 'public_cases' / 'local_time')
    assert main(['analyze', *TWO_LOGS, *NORMS, '--quiet']) == 2
    refusal = capsys.readouterr().err
    assert 'TS from 2024-05-28 20:00:00 to 20:10:59 UTC' in refusal
    assert 'RS begins 2 h after TS: a time zone?' in refusal
