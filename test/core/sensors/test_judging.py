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

"""The verdict on several sensors: the wrong one is named, whichever it is, and no sound one."""

from __future__ import annotations

import json

import pytest
from ship_of_sensors import make_sensor

from heading_intercompare import analyze_sensors
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.sensors.comparison import SensorsComparison
from heading_intercompare.core.sensors.judging import judge_sensors
from heading_intercompare.core.sensors.sensors_verdict import SensorsVerdict
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.typed_reader import VerdictError

NAMES = ('gyro1', 'gyro2', 'ins', 'gnss')
SOUND = {'gyro1': 0.15, 'gyro2': 0.15, 'ins': 0.05, 'gnss': 0.05}
NORMS = {'gyro1': 0.3, 'gyro2': 0.3, 'ins': 0.1, 'gnss': 0.1}


def judge(reference='gnss', seed=0, settings=None, **errors):
    """Judge sound sensors, with other errors for some: a standard deviation or arguments."""
    headings = {}
    for at, name in enumerate(NAMES):
        given = errors.get(name, SOUND[name])
        given = given if isinstance(given, dict) else {'sigma_deg': given}
        headings[name] = make_sensor(10 * seed + at, **{
            'sigma_deg': SOUND[name], 'phase_s': 0.05 * at, **given})
    rows = [f'{name} sigma_max_deg={NORMS[name]}{" rs" if name == reference else ""}'
            for name in NAMES]
    return analyze_sensors(headings, Settings.of(
        sensors='\n'.join(rows), slowest_error_s=60.0, **(settings or {})))


@pytest.fixture(scope='module')
def sound():
    """Return the verdict on sound sensors as JSON has it."""
    return judge().to_dict()


def outcomes(verdict):
    return {one.name: one.outcome and one.outcome.value for one in verdict.sensors}


def test_sound_sensors_comply_and_none_is_named():
    verdict = judge()
    assert outcomes(verdict) == {'gyro1': 'compliant', 'gyro2': 'compliant', 'ins': 'compliant',
                                 'gnss': None}
    assert verdict.outcome is Outcome.COMPLIANT
    assert verdict.vote.wrong == verdict.vote.suspected == ()
    for one in verdict.sensors:
        low, high = one.variance.interval_deg2
        assert low <= SOUND[one.name] ** 2 <= high


@pytest.mark.parametrize('reference', ['gnss', None])
@pytest.mark.parametrize('name', ['gyro1', 'ins'])
def test_a_tested_sensor_beyond_its_norm_is_named(name, reference):
    verdict = judge(reference, **{name: 3.0 * NORMS[name]})
    if name == 'ins':
        # The gyros have norms so wide that the INS is still within what both explain.
        assert verdict.vote.suspected == (name,)
    else:
        assert verdict.vote.wrong == (name,)
    assert outcomes(verdict)[name] != 'compliant'
    sound = [other for other in NAMES if other not in (name, reference)]
    assert all(outcomes(verdict)[other] != 'non_compliant' for other in sound)


def test_a_wrong_reference_makes_every_verdict_against_it_void():
    """Each comparison with it alone blames the sound sensor: that is what two cannot tell."""
    verdict = judge(gnss=1.2)
    assert {one.outcome for one in verdict.verdicts.values()} == {Outcome.NON_COMPLIANT}
    assert verdict.vote.wrong == ('gnss',)
    assert verdict.outcome is Outcome.INDETERMINATE and verdict.validity_effect == 'void'
    for one in verdict.sensors[:3]:
        assert one.headline.startswith('INDETERMINATE, VOID: the reference gnss is wrong')
    assert verdict.sensors[3].headline.startswith('reference, WRONG')


def test_without_a_reference_sensors_certify_each_other_only_within_their_own_norm():
    verdict = judge(None, gnss=0.03)
    assert verdict.verdicts == {}
    assert outcomes(verdict) == dict.fromkeys(NAMES, 'compliant')
    # A sensor at its norm is never certified: its partner adds to its variance.
    assert outcomes(judge(None, gyro1=0.3))['gyro1'] == 'indeterminate'


@pytest.mark.parametrize('error', [
    {'offset_deg': 90.0}, {'offset_deg': 180.0}, {'offset_deg': 40.0}])
def test_a_gross_error_that_no_variance_shows_is_named(error):
    verdict = judge(None, gyro2=error)
    assert verdict.vote.wrong == ('gyro2',)
    assert outcomes(verdict)['gyro2'] == 'non_compliant'
    assert all(pair.gross for pair in verdict.pairs if 'gyro2' in pair.names)


def test_a_sensor_whose_clock_lags_is_named_with_its_age():
    verdict = judge(gyro1={'age_s': 1.0, 'sigma_deg': 0.05})
    assert verdict.vote.wrong == ('gyro1',)
    ages = [sign * pair.skew_s for other in NAMES[1:]
            for pair, sign in [verdict.find_pair('gyro1', other)]]
    assert ages == pytest.approx([1.0] * 3, abs=0.1)


def test_two_headings_of_one_sensor_have_one_voice():
    """The copy of a wrong gyro would outvote the sound sensor, two to one."""
    wrong, sound = make_sensor(1, 1.0), make_sensor(2, 0.1, phase_s=0.05)
    verdict = analyze_sensors(
        {'a': wrong, 'b': wrong, 'c': sound},
        Settings.of(sensors='a sigma_max_deg=0.3; b sigma_max_deg=0.3; c sigma_max_deg=0.3'))
    assert verdict.vote.wrong == verdict.vote.suspected == ()
    assert verdict.vote.one_source == (('a', 'b'),)
    assert Outcome.COMPLIANT not in outcomes(verdict).values()


def test_sound_sensors_are_not_named_and_sensors_at_their_norm_not_certified():
    """Both risks are stated; over these trials both are kept."""
    named = certified = 0
    for seed in range(6):
        verdict = judge(None, seed=seed, **NORMS)
        named += bool(verdict.vote.wrong)
        certified += 'compliant' in outcomes(verdict).values()
    assert (named, certified) == (0, 0)


def test_a_pair_whose_beginning_is_missing_says_so():
    """The node that compares the other pairs was started again 12 min into the trial."""
    headings = {name: make_sensor(at, SOUND[name], phase_s=0.05 * at)
                for at, name in enumerate(NAMES)}
    rows = [f'{name} sigma_max_deg={NORMS[name]}{" rs" if name == "gnss" else ""}'
            for name in NAMES]
    settings = Settings.of(sensors='\n'.join(rows), slowest_error_s=60.0)
    whole, late = SensorsComparison(settings), SensorsComparison(settings)
    whole.update(headings)
    late.update({name: readings[len(readings) * 720 // 1800:]
                 for name, readings in headings.items()})
    for one in (whole, late):
        one.finish()
    verdicts = {name: one.verdict() for name, one in whole.tested.items()}
    for comparison, missing in ((whole, 0), (late, 3)):
        verdict = judge_sensors(settings, verdicts, {
            names: one.results() for names, one in comparison.others.items()})
        said = [pair for pair in verdict.pairs
                if any('first 12 min are missing' in words for words in pair.findings)]
        assert len(said) == missing
        assert all(pair.validity_effect == 'doubtful' for pair in said)


def test_what_a_pair_missed_is_among_its_findings_and_decides_nothing():
    headings = {name: make_sensor(at, SOUND[name]) for at, name in enumerate(NAMES)}
    settings = Settings.of(sensors='; '.join(f'{name} sigma_max_deg=0.3' for name in NAMES))
    comparison = SensorsComparison(settings)
    comparison.update(headings)
    comparison.finish()
    results = {names: one.results() for names, one in comparison.others.items()}
    whole = judge_sensors(settings, {}, results)
    told = judge_sensors(settings, {}, results, problems={('gyro1', 'ins'): ['3 are missing']})
    assert [pair.names for pair in told.pairs if pair.findings != whole.find_pair(
        *pair.names)[0].findings] == [('gyro1', 'ins')]
    assert told.find_pair('gyro1', 'ins')[0].findings[-1] == '3 are missing'
    assert told.headline == whole.headline and told.validity_effect == whole.validity_effect


def test_installation_angles_are_removed():
    rows = 'a sigma_max_deg=0.3 installation_offset_deg=30; b sigma_max_deg=0.3'
    headings = {'a': make_sensor(1, 0.1, offset_deg=30.2), 'b': make_sensor(2, 0.1)}
    pair, = analyze_sensors(headings, Settings.of(sensors=rows)).pairs
    assert pair.mean_deg == pytest.approx(0.2, abs=0.05) and not pair.differs


@pytest.mark.parametrize('reference', ['gnss', None])
def test_json_is_read_back_as_it_was(reference):
    verdict = judge(reference, gyro2=0.9)
    plain = json.loads(json.dumps(verdict.to_dict()))
    again = SensorsVerdict.from_dict(plain)
    assert again.to_dict() == plain
    assert str(again) == str(verdict)


@pytest.mark.parametrize('change, said', [
    ({'schema': 'heading_intercompare/sensors/2'}, 'heading_intercompare/sensors/2'),
    ({'outcome': 'fine'}, "outcome = 'fine': must be"),
    ({'pairs': [{}]}, 'pairs[0].first is missing'),
    ({'verdicts': 3}, 'verdicts = 3: must be an object'),
    ({'settings_sha256': 'x'}, "settings_sha256 = 'x': the settings have"),
])
def test_json_that_is_wrong_says_where(change, said, sound):
    with pytest.raises(VerdictError) as error:
        SensorsVerdict.from_dict({**sound, **change})
    assert said in str(error.value)


def test_the_text_has_outcomes_matrices_and_the_vote():
    text = str(judge(gyro2=0.9))
    assert text.startswith('VERDICT on 4 sensors: gyro1 COMPLIANT; gyro2 NON-COMPLIANT')
    assert 'who is wrong: gyro2 differs from gyro1, ins and gnss' in text
    rows = [line.split() for line in text.splitlines()]
    assert ['gyro1', 'gyro2', 'ins', 'gnss'] in rows
    assert all(len(line) <= 300 for line in text.splitlines())
