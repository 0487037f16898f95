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

"""The commands for several sensors: what they print, write and refuse."""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path

from checksums import with_checksum
from command_line import refusal
import pytest
from ship_of_sensors import (
    course_deg,
    make_three,
    START_NS,
    TABLE,
    write_bag,
    write_log,
)

from heading_intercompare import analyze_sensors, Settings
from heading_intercompare.app.analysis import judge_bags
from heading_intercompare.cli import main
from heading_intercompare.core.records import Headings
from heading_intercompare.core.sensors.pair_settings import settings_of_tested
from heading_intercompare.core.sensors.sensors_verdict import SensorsVerdict
from heading_intercompare.core.verdict.compare_verdicts import find_differences
from heading_intercompare.report.json import CONFIRMED


@pytest.fixture(scope='module')
def trial(tmp_path_factory):
    """Return a bag with a wrong gyro2, and a parameter file with its sensors."""
    folder = tmp_path_factory.mktemp('trial')
    write_bag(folder / 'bag', make_three(gyro2=0.9))
    rows = TABLE.strip().replace('\n', '\n      ')
    (folder / 'ship.yaml').write_text(
        '/**:\n  ros__parameters:\n    risk:\n      slowest_error_s: 60.0\n'
        f'    sensors: |\n      {rows}\n')
    return folder


def test_analyze_prints_all_sensors_and_the_wrong_one(trial, capsys):
    given = ['analyze', str(trial / 'bag'), '--config', str(trial / 'ship.yaml')]
    assert main(given) == 0
    out = capsys.readouterr().out
    assert out.startswith('VERDICT on 3 sensors: gyro1 COMPLIANT; gyro2 NON-COMPLIANT; gyro2 '
                          'differs from gyro1 and gnss, which do not differ from each other')
    assert main([*given, '--check']) == 1
    assert main([*given, '--json', '-']) == 0
    out = capsys.readouterr().out
    plain = json.loads(out[out.index('{\n'):])
    assert plain['vote']['wrong'] == ['gyro2'] and [*plain['verdicts']] == ['gyro1', 'gyro2']


def test_two_of_the_sensors_alone_by_name(trial, capsys):
    given = ['analyze', str(trial / 'bag'), '--config', str(trial / 'ship.yaml'), '--json', '-']
    assert main([*given, '--ts', 'gyro1', '--rs', 'gnss']) == 0
    alone = json.loads(capsys.readouterr().out)
    assert main(given) == 0
    several = json.loads(capsys.readouterr().out)['verdicts']['gyro1']
    assert alone['runs'] == several['runs'] and alone['headline'] == several['headline']
    assert main([*given, '--ts', 'gyro1', '--rs', 'gnss', '--csv',
                 str(trial / 'pairs.csv')]) == 0
    assert '--ts gyro1: with the setting sensors give --ts and --rs' in refusal(
        capsys, *given, '--ts', 'gyro1')


def test_logs_by_name(trial, tmp_path, capsys):
    logs = [f'{name}={write_log(tmp_path / name, readings, "HE")}'
            for name, readings in make_three(gyro2=0.9).items()]
    assert main(['analyze', *logs, '--config', str(trial / 'ship.yaml')]) == 0
    out, err = capsys.readouterr()
    assert 'gyro2 NON-COMPLIANT' in out
    assert [line.split(':')[1].strip() for line in err.splitlines()[:3]] == [
        'gyro1', 'gyro2', 'gnss']
    assert 'gnss: has no log' in refusal(
        capsys, 'analyze', *logs[:2], '--config', trial / 'ship.yaml')


def test_the_logbook_has_a_row_per_sensor_and_run(trial, tmp_path, capsys):
    book = tmp_path / 'book.sqlite'
    assert main(['analyze', str(trial / 'bag'), '--config', str(trial / 'ship.yaml'),
                 '--logbook', str(book), '--ship', 'Palmer']) == 0
    assert main(['history', str(book)]) == 0
    out = capsys.readouterr().out
    assert 'Palmer/gyro1' in out and 'Palmer/gyro2' in out and 'Palmer/gnss' not in out


@pytest.mark.parametrize('option', ['csv', 'ensembles', 'runs-csv'])
def test_tables_are_refused_without_a_reference_with_what_to_do(trial, option, capsys, tmp_path):
    rows = '; '.join(TABLE.strip().replace('  rs', '').splitlines())
    assert 'no sensor is the reference, and it is for two sensors; choose them with --ts' in (
        refusal(capsys, 'analyze', trial / 'bag', '--set', f'sensors={rows}', f'--{option}',
                tmp_path / 'x.csv'))
    assert not (tmp_path / 'x.csv').exists()


def test_a_csv_of_each_sensor_has_the_verdict_on_it(trial, capsys, tmp_path):
    """The account beside each csv makes it as good as the bag."""
    given = ['analyze', str(trial / 'bag'), '--config', str(trial / 'ship.yaml')]
    assert main([*given, '--csv', str(tmp_path / 'pairs.csv'), '--json',
                 str(tmp_path / 'all.json')]) == 0
    assert {path.name for path in tmp_path.glob('*.csv')} == {'pairs-gyro1.csv', 'pairs-gyro2.csv'}
    whole = SensorsVerdict.from_dict(json.loads((tmp_path / 'all.json').read_text()))
    for name, verdict in whole.verdicts.items():
        path = tmp_path / f'pairs-{name}.csv'
        alone = judge_bags([path], settings_of_tested(whole.settings, name)).verdict
        assert [*find_differences(verdict, alone)] == []


def test_a_csv_of_logs_has_the_verdict_on_them(trial, capsys, tmp_path):
    logs = [f'{name}={write_log(tmp_path / f"{name}.log", readings, "HE")}'
            for name, readings in make_three().items()]
    assert main(['analyze', *logs, '--config', str(trial / 'ship.yaml'), '--csv',
                 str(tmp_path / 'pairs.csv'), '--json', str(tmp_path / 'all.json')]) == 0
    whole = SensorsVerdict.from_dict(json.loads((tmp_path / 'all.json').read_text()))
    alone = judge_bags([tmp_path / 'pairs-gyro1.csv'],
                       settings_of_tested(whole.settings, 'gyro1')).verdict
    assert [*find_differences(whole.verdicts['gyro1'], alone)] == []


def test_ensembles_and_runs_of_each_sensor(trial, capsys, tmp_path):
    given = ['analyze', str(trial / 'bag'), '--config', str(trial / 'ship.yaml')]
    assert main([*given, '--ensembles', str(tmp_path / 'e.csv'), '--runs-csv',
                 str(tmp_path / 'runs.csv'), '--json', str(tmp_path / 'all.json')]) == 0
    for name in ('gyro1', 'gyro2'):
        assert main([*given, '--ts', name, '--rs', 'gnss', '--ensembles',
                     str(tmp_path / 'two.csv')]) == 0
        assert (tmp_path / f'e-{name}.csv').read_text() == (tmp_path / 'two.csv').read_text()
    with open(tmp_path / 'runs.csv', newline='') as file:
        rows = [*csv.DictReader(file)]
    assert [(row['sensor'], row['outcome']) for row in rows] == [
        ('gyro1', 'compliant'), ('gyro2', 'non_compliant')]
    capsys.readouterr()
    assert main(['report', str(tmp_path / 'all.json'), '-o', str(tmp_path / 'all.html'),
                 '--runs-csv', str(tmp_path / 'again.csv')]) == 0
    assert (tmp_path / 'again.csv').read_text() == (tmp_path / 'runs.csv').read_text()


def test_a_csv_is_of_one_input(trial, capsys, tmp_path):
    assert 'takes the pairs of one INPUT, but 2 are given' in refusal(
        capsys, 'analyze', trial / 'bag', trial / 'bag', '--config', trial / 'ship.yaml', '--csv',
        tmp_path / 'x.csv')
    (tmp_path / 'x-gyro1.csv').mkdir()
    assert 'x-gyro1.csv: is a folder; name a file' in refusal(
        capsys, 'analyze', trial / 'bag', '--config', trial / 'ship.yaml', '--csv',
        tmp_path / 'x.csv')


def test_what_is_for_two_sensors_or_for_logs_is_refused_with_what_to_do(trial, capsys):
    given = ['analyze', trial / 'bag', '--config', trial / 'ship.yaml']
    assert '--rs-antennas fore.log aft.log: is for two sensors; choose them with --ts NAME' in (
        refusal(capsys, *given, '--rs-antennas', 'fore.log', 'aft.log'))
    assert '--motion gps.log: is for logs' in refusal(capsys, *given, '--motion', 'gps.log')


@pytest.fixture
def ship(trial, tmp_path):
    """Return logs of sensors that agree and lie 180 deg off the course, and a log of that."""
    logs = []
    for name, readings in make_three().items():
        turned = Headings.of(readings.stamp_ns, (readings.heading_deg + 180.0) % 360.0)
        logs.append(f'{name}={write_log(tmp_path / f"{name}.log", turned, "HE")}')
    lines = []
    for at in range(1800):
        body = f'GPVTG,{steady_deg(at) % 360.0:.1f},T,,M,12.0,N,22.2,K,A'
        lines.append(f'{START_NS / 1e9 + at:.3f} {with_checksum(body)}')
    (tmp_path / 'gps.log').write_text('\n'.join(lines) + '\n')
    return [*logs, '--motion', str(tmp_path / 'gps.log'), '--config', str(trial / 'ship.yaml')]


def steady_deg(t_s):
    """Return the course, which does not yaw."""
    return course_deg(t_s) - 3.0 * math.sin(2.0 * math.pi * t_s / 9.0)


def test_the_course_contradicts_sensors_that_agree_with_each_other(ship, capsys):
    """No pair of them shows it: all are turned round."""
    assert main(['analyze', *ship, '--json', '-']) == 0
    plain = json.loads(capsys.readouterr().out)
    assert plain['vote']['wrong'] == [] and plain['validity_effect'] == 'void'
    for verdict in plain['verdicts'].values():
        assert verdict['runs'][0]['reason'] == 'void.motion'


def test_logs_become_one_bag_with_the_same_verdict(ship, tmp_path, capsys):
    bag, config = str(tmp_path / 'bag'), ship[ship.index('--config'):]
    assert main(['import-nmea', *ship, '-o', bag]) == 0
    out = capsys.readouterr().out
    assert 'gyro1 ' in out and '9000 headings on /g1/imu' in out
    assert 'course and speed of GPVTG' in out
    found = []
    for inputs in ([bag, *config], ship):
        assert main(['analyze', *inputs, '--json', '-']) == 0
        found.append(json.loads(capsys.readouterr().out))
    of_bag, of_logs = found
    assert of_bag['headline'] == of_logs['headline']
    assert [pair['n'] for pair in of_bag['pairs']] == [pair['n'] for pair in of_logs['pairs']]


def test_a_bag_of_logs_takes_two_logs_or_one_per_sensor(ship, tmp_path, capsys):
    given = ['-o', tmp_path / 'bag']
    assert '--ts: is missing; give the INPUTs of analyze, or --ts FILE and --rs FILE' in refusal(
        capsys, 'import-nmea', *given)
    assert '--ts a: with the setting sensors give --ts and --rs' in refusal(
        capsys, 'import-nmea', *ship, '--ts', 'a', *given)
    assert 'x=y: No such file' in refusal(
        capsys, 'import-nmea', 'x=y', *given)


def test_the_unit_of_a_row_holds_where_logs_become_a_bag(tmp_path, capsys):
    """Radians near 1.6 could be degrees: only the row says which."""
    logs = []
    for name, heading in (('gyro', 1.6), ('gnss', 91.673)):
        path = tmp_path / f'{name}.csv'
        path.write_text('stamp_s,heading\n' + ''.join(
            f'{1_770_000_000 + at}.0,{heading + 0.001 * (at % 7)}\n' for at in range(300)))
        logs.append(f'{name}={path}')
    rows = 'sensors=gyro unit=rad sigma_max_deg=0.3; gnss unit=deg sigma_max_deg=0.1 rs'
    bag = str(tmp_path / 'bag')
    assert main(['import-nmea', *logs, '--set', rows, '-o', bag]) == 0
    means = []
    for inputs in ([bag], logs):
        assert main(['analyze', *inputs, '--set', rows, '--json', str(tmp_path / 'v.json')]) == 0
        verdict = json.loads((tmp_path / 'v.json').read_text())
        means.append(verdict['pairs'][0]['mean_deg'])
    assert means[0] == pytest.approx(means[1], abs=1e-6) and abs(means[1]) < 1.0
    capsys.readouterr()


def test_logs_without_names_and_names_without_a_setting_are_one_line(trial, tmp_path, capsys):
    log = tmp_path / 'gyro.log'
    log.write_text('2014-08-01T00:00:00Z $HEHDT,100.00,T*17\n')
    config = ('--config', trial / 'ship.yaml')
    assert f'NAME={log} with one of gyro1, gyro2, gnss' in refusal(
        capsys, 'analyze', log, log, *config)
    norms = ('--set', 'norms.sigma_max_deg=0.3', '--set', 'norms.sigma_ref_max_deg=0.1')
    for command in (['analyze'], ['report', '-o', tmp_path / 'x.html']):
        assert f'a={log}: NAME=LOG is for several sensors, and the setting sensors has no a' in (
            refusal(capsys, *command, f'a={log}', f'b={log}', f'c={log}', *norms))


def test_wrong_sensors_are_one_line(trial, capsys):
    assert 'sensors, has one sensor' in refusal(
        capsys, 'analyze', trial / 'bag', '--set', 'sensors=gyro1 sigma_max_deg=1')
    assert 'give sigma_max_deg in the rows of both' in refusal(
        capsys, 'analyze', trial / 'bag', '--set', 'sensors=gyro1; gyro2')
    assert 'the rows of the setting sensors choose' in refusal(
        capsys, 'analyze', 'gyro1=a', 'gyro2=b', 'gnss=c', '--config', trial / 'ship.yaml',
        '--ts-talker', 'HE')
    assert 'no INPUT is NAME=LOG' in refusal(
        capsys, 'analyze', trial / 'bag', '--config', trial / 'ship.yaml', '--time', 'validity')


@pytest.mark.slow
def test_the_report_is_an_overview_and_a_protocol_of_each_sensor(trial, tmp_path, capsys):
    pytest.importorskip('matplotlib')
    page, kept = tmp_path / 'ship.html', tmp_path / 'ship.json'
    given = ['--config', str(trial / 'ship.yaml')]
    assert main(['analyze', str(trial / 'bag'), *given, '--report', str(page), '--json',
                 str(kept)]) == 0
    names = {file.name for file in tmp_path.iterdir()}
    assert names == {'ship.html', 'ship-gyro1.html', 'ship-gyro2.html', 'ship.json'}
    assert '<svg' in (tmp_path / 'ship-gyro1.html').read_text('utf-8')
    # From the verdict alone the same overview, and protocols without figures.
    again = tmp_path / 'again' / 'ship.html'
    again.parent.mkdir()
    assert main(['report', str(kept), '-o', str(again)]) == 0
    label, = [line for line in again.read_text('utf-8').splitlines(True) if 'provenance' in line]
    assert CONFIRMED in label
    assert again.read_text('utf-8').replace(label, '') == page.read_text('utf-8')
    # No output overwrites an input.
    (tmp_path / 'ship-gyro1.html').unlink()
    assert main(['report', str(trial / 'bag'), *given, '-o', str(page)]) == 0
    assert (tmp_path / 'ship-gyro1.html').exists()


@pytest.mark.parametrize('kept, words', [
    ('report', 'attachment: report.json'), ('published', 'last report on sensors/report, ')])
def test_info_shows_the_verdict_on_several_sensors(tmp_path, capsys, kept, words):
    """It was "not a verdict that this version can read", and a published one was not found."""
    headings = make_three(gyro2=0.9)
    verdict = analyze_sensors(headings, Settings.of(sensors=TABLE, slowest_error_s=60.0))
    bag = write_bag(tmp_path / 'bag', headings, **{kept: json.dumps(verdict.to_dict())})
    assert main(['info', str(bag)]) == 0
    said = capsys.readouterr().out
    assert words in said and str(verdict).splitlines()[0] in said
    assert 'gyro2 NON-COMPLIANT' in said.partition(words)[2]


def test_the_example_of_four_sensors_judges_the_scenario_of_four_sensors(tmp_path, capsys):
    """Both were in `config`, and gyro1 and gnss of the one were not in the bag of the other."""
    config = Path(__file__).resolve().parents[3] / 'config'
    scenario = (config / 'scenarios' / 'four_sensors.yaml').read_text()
    (tmp_path / 'short.yaml').write_text(scenario.replace('duration_s: 3600', 'duration_s: 900'))
    file, bag = str(config / 'four_sensors.yaml'), str(tmp_path / 'four')
    assert main(['simulate', '--scenario', str(tmp_path / 'short.yaml'), '--config', file,
                 '-o', bag]) == 0
    assert 'TS 9000 headings on gyro1/heading' in capsys.readouterr().out
    assert main(['analyze', bag, '--config', file]) == 0
    assert capsys.readouterr().out.startswith('VERDICT on 4 sensors: ')
