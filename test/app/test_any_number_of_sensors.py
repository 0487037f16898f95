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

"""Whatever an input has, the verdict on each of 2, 3 or 4 sensors is that of the two alone."""

from __future__ import annotations

from dataclasses import replace
import json
import shutil

import numpy as np
import pytest
from ship_of_sensors import make_sensor, START_NS, write_log

from heading_intercompare import (
    analyze,
    analyze_sensors,
    judge_bags,
    judge_logs,
    Motion,
    Settings,
)
from heading_intercompare.app.config import choose_pair
from heading_intercompare.bags.mcap.chunk_writer import Rows
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.rosbag2.provenance import describe_origin, RECORD
from heading_intercompare.cli import main
from heading_intercompare.core.motion.tangent_plane import radii_m
from heading_intercompare.messages.heading_messages import encode_imu, IMU
from heading_intercompare.messages.motion.motion_messages import encode_motion, FIX
from heading_intercompare.messages.status_messages import encode_mark, MARKER_TOPIC, STATUS_TYPE

S, SPAN_S = 10 ** 9, 1200
NAMES = ('gyro1', 'gyro2', 'ins', 'gnss')
SIGMA_DEG = {'gyro1': 0.15, 'gyro2': 0.9, 'ins': 0.1, 'gnss': 0.04}
AGE_S = {'gyro1': 0.4}
NOTHING = {'slowest_error_s': 30.0}


def settings_of(n, **changes):
    """Return settings with n sensors; gnss is the reference."""
    rows = [f'{name} sigma_max_deg=0.3' for name in NAMES[:n - 1]]
    return Settings.of(sensors='\n'.join([*rows, 'gnss sigma_max_deg=0.1 rs']),
                       **{**NOTHING, **changes})


def readings_of(n, seed=0):
    """Return the readings of n sensors."""
    return {name: make_sensor(10 * seed + at, SIGMA_DEG[name], rate_hz=2.0, span_s=SPAN_S,
                              phase_s=0.05 * at, age_s=AGE_S.get(name, 0.0))
            for at, name in enumerate((*NAMES[:n - 1], 'gnss'))}


def write_bag(path, headings, *, stored=None, marks=(), antennas=False):
    """Write a bag with the readings, marks at some seconds, and two antennas instead of gnss."""
    with BagWriter(path) as writer:
        if stored is not None:
            writer.metadata(RECORD, stored)
        if marks:
            writer.add_topic(MARKER_TOPIC, STATUS_TYPE)
            for kind, second in marks:
                stamp_ns = START_NS + second * S
                writer.write(MARKER_TOPIC, encode_mark(kind, stamp_ns), stamp_ns)
        rows = []
        for name, readings in headings.items():
            if name == 'gnss' and antennas:
                continue
            topic = f'{name}/heading'
            writer.add_topic(topic, IMU)
            rows.append(Rows(topic, encode_imu(readings, name), readings.stamp_ns))
        if antennas:
            rows += write_antennas(writer, headings['gnss'])
        writer.write_rows(rows)
    return str(path)


def write_antennas(writer, readings, length_m=20.0):
    """Return the positions of two antennas along the headings of a sensor."""
    meridian_m, normal_m = radii_m(54.0)
    course = np.radians(readings.heading_deg)
    rows = []
    for topic, ahead_m in (('gps/fore', length_m), ('gps/aft', 0.0)):
        writer.add_topic(topic, FIX)
        north, east = ahead_m * np.cos(course), ahead_m * np.sin(course)
        latitude = 54.0 + np.degrees(north / meridian_m)
        longitude = 10.0 + np.degrees(east / normal_m / np.cos(np.radians(54.0)))
        fixes = Motion.of_positions(readings.stamp_ns, latitude, longitude)
        rows.append(Rows(topic, encode_motion(fixes, 'fix', 'gps'), readings.stamp_ns))
    return rows


def between(readings, lo_s, hi_s):
    """Return the readings of all sensors between two seconds."""
    return {name: h[(h.stamp_ns >= START_NS + lo_s * S) & (h.stamp_ns < START_NS + hi_s * S)]
            for name, h in readings.items()}


def later(readings, by_s):
    """Return the readings with later stamps."""
    return {name: replace(h, stamp_ns=h.stamp_ns + by_s * S) for name, h in readings.items()}


def one_bag(folder, n):
    return [write_bag(folder / 'bag', readings_of(n))]


def two_days(folder, n):
    return [write_bag(folder / 'day1', readings_of(n)),
            write_bag(folder / 'day2', later(readings_of(n, 1), 86_400))]


def twice(folder, n):
    shutil.copytree(write_bag(folder / 'bag', readings_of(n)), folder / 'copy')
    return [str(folder / 'bag'), str(folder / 'copy')]


def parts(folder, n):
    headings = readings_of(n)
    return [write_bag(folder / 'part_0', between(headings, 0, 590),
                      stored=describe_origin({}, None, None)),
            write_bag(folder / 'part_1', between(headings, 600, SPAN_S),
                      stored=describe_origin({}, None, 'part_0'))]


def marked(folder, n):
    return [write_bag(folder / 'bag', readings_of(n), marks=[
        ('start', 100), ('stop', 600), ('start', 700)])]


def with_antennas(folder, n):
    return [write_bag(folder / 'bag', readings_of(n), antennas=True)]


def unreadable(folder, n):
    return [*one_bag(folder, n), str(folder / 'nothing')]


TABLE = [(START_NS + 60 * S, START_NS + 500 * S, ''),
         (START_NS + 600 * S, START_NS + 1100 * S, '')]
DOCK = (f'{START_NS + 100 * S}, {START_NS + 200 * S}, dock; '
        f'{START_NS + 9000 * S}, {START_NS + 9100 * S}, never')
FEATURES = {
    'a bag': (one_bag, {}, {}), 'two days': (two_days, {}, {}),
    'on all cores': (two_days, {}, {'jobs': 2}), 'twice the same': (twice, {}, {}),
    'parts of a trial': (parts, {}, {}), 'marks': (marked, {}, {}),
    'a table of runs': (one_bag, {}, {'runs': TABLE}),
    'exclusions': (one_bag, {'exclusions': DOCK}, {}),
    'a skew applied': (one_bag, {'alignment': {'skew': 'apply'}}, {}),
    'two antennas': (with_antennas, {'antennas': {'fore_topic': 'gps/fore',
                                                  'aft_topic': 'gps/aft'}}, {}),
    'stabilisation': (one_bag, {'runs': {'stabilization_s': 120.0}}, {}),
    'a campaign of one sensor': (two_days, {'campaign': {'rule': 'sensor'}}, {}),
    'an input that cannot be read': (unreadable, {}, {})}


def notes_of(judged, name):
    """Return what is said of the inputs, without the names of a pair."""
    return [note.replace(f'{name} and gnss: ', '') for note in judged.notes
            if ' and ' not in note or f'{name} and gnss: ' in note]


@pytest.mark.slow
@pytest.mark.parametrize('feature, n', [
    ('a bag', 2), ('a bag', 4), ('two days', 2), *((feature, 3) for feature in FEATURES)])
def test_each_sensor_has_the_verdict_of_the_two_alone(feature, n, tmp_path):
    make, changes, options = FEATURES[feature]
    paths, settings = make(tmp_path, n), settings_of(n, **changes)
    together = judge_bags(paths, settings, **options)
    assert [*together.verdicts] == [*NAMES[:n - 1]] and together.sensors.verdicts
    for name, verdict in together.verdicts.items():
        alone = judge_bags(paths, choose_pair(settings, name, 'gnss'), **options)
        assert json.dumps(verdict.to_dict()) == json.dumps(alone.verdict.to_dict())
        assert notes_of(together, name) == [*alone.notes]
        assert together.earlier[name] == alone.earlier['ts']
        assert len(together.accounts) == (n - 1 if 'ts' in alone.accounts else 0)
    inputs = [(entry.path, entry.sha256, entry.continues, entry.same_as, entry.error)
              for entry in together.sensors.inputs]
    assert inputs == [(entry.path, entry.sha256, entry.continues, entry.same_as, entry.error)
                      for entry in together.verdicts['gyro1'].inputs]


@pytest.mark.slow
@pytest.mark.parametrize('n', [2, 3, 4])
def test_logs_and_arrays_give_each_sensor_the_verdict_of_the_two_alone(n, tmp_path):
    headings, settings = readings_of(n), settings_of(n)
    logs = {name: str(write_log(tmp_path / f'{name}.log', readings, 'HE'))
            for name, readings in headings.items()}
    together, arrays = judge_logs(logs, settings), analyze_sensors(headings, settings)
    for name, verdict in together.verdicts.items():
        own = choose_pair(settings, name, 'gnss')
        alone = judge_logs({'ts': logs[name], 'rs': logs['gnss']}, own).verdict
        # The runs are named after the first log.
        runs = [replace(run, source=logs['gyro1']) for run in alone.runs]
        assert verdict.to_dict() == replace(alone, runs=runs).to_dict()
        assert arrays.verdicts[name].to_dict() == analyze(
            headings[name], headings['gnss'], own).to_dict()


@pytest.mark.slow
@pytest.mark.parametrize('n', [2, 3, 4])
def test_the_command_line_writes_the_same_tables_of_each_sensor(n, tmp_path, capsys):
    bag, settings = one_bag(tmp_path, n)[0], settings_of(n)
    given = ['analyze', bag, '--set', f'sensors={settings.sensors}', '--set',
             'risk.slowest_error_s=30', '--quiet']
    assert main([*given, '--csv', str(tmp_path / 'p.csv'), '--ensembles', str(tmp_path / 'e.csv'),
                 '--json', str(tmp_path / 'all.json')]) == 0
    whole = json.loads((tmp_path / 'all.json').read_text())
    for name in NAMES[:n - 1]:
        assert main([*given, '--ts', name, '--rs', 'gnss', '--csv', str(tmp_path / 'own.csv'),
                     '--ensembles', str(tmp_path / 'own_e.csv'),
                     '--json', str(tmp_path / 'own.json')]) == 0
        assert json.loads((tmp_path / 'own.json').read_text()) == whole['verdicts'][name]
        for table, own in (('p', 'own'), ('e', 'own_e')):
            assert (tmp_path / f'{table}-{name}.csv').read_text() == (
                tmp_path / f'{own}.csv').read_text()
        # The csv with its account is as good as the bag.
        assert main([*given[:1], str(tmp_path / f'p-{name}.csv'), *given[2:], '--ts', name,
                     '--rs', 'gnss', '--json', str(tmp_path / 'again.json')]) == 0
        again = json.loads((tmp_path / 'again.json').read_text())
        assert again['headline'] == whole['verdicts'][name]['headline']
    capsys.readouterr()


@pytest.mark.parametrize('kind', ['csv', 'journal'])
def test_pairs_of_two_sensors_are_refused_for_several_with_what_to_do(kind, tmp_path, capsys):
    path = tmp_path / f'pairs.{kind}'
    path.write_text('stamp_ns,ts_deg,rs_deg\n1,2.0,3.0\n')
    if kind == 'journal':
        path.write_bytes(b'')
    assert main(['analyze', str(path), '--set', f'sensors={settings_of(3).sensors}']) == 2
    said = capsys.readouterr().err
    assert said.count('\n') == 1 and str(path) in said
    if kind == 'csv':
        assert 'choose them with --ts NAME --rs NAME' in said


def test_two_antennas_need_a_reference_and_their_topics(tmp_path, capsys):
    bag = one_bag(tmp_path, 3)[0]
    antennas = ['--set', 'antennas.fore_topic=ship/nowhere', '--set', 'antennas.aft_topic=gps/aft']
    rows = settings_of(3).sensors
    for table, words in ((rows, "has no topic 'ship/nowhere'"),
                         (rows.replace(' rs', ''), 'no row of sensors has the word rs')):
        assert main(['analyze', bag, '--set', f'sensors={table}', *antennas]) == 2
        assert words in capsys.readouterr().err


def test_one_log_that_gives_two_sensors_the_same_headings_is_refused(tmp_path):
    log = str(write_log(tmp_path / 'ship.log', readings_of(2)['gyro1'], 'HE'))
    other = str(write_log(tmp_path / 'gnss.log', readings_of(2)['gnss'], 'GP'))
    with pytest.raises(ValueError, match='the same headings as gyro1 and as gyro2: tell them'):
        judge_logs({'gyro1': log, 'gyro2': log, 'gnss': other}, settings_of(3))
