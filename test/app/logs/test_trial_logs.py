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

"""Two logs are judged in one step as the bag that `import` makes of them."""

from __future__ import annotations

from functools import reduce
import gzip
import hashlib
import json

from command_line import analyze_json, NORMS, refusal
import numpy as np
import pytest

from heading_intercompare import analyze_logs, DriverSettings, Settings
from heading_intercompare.cli import main

QUIET_NORMS = (*NORMS, '--quiet')
N = 900


def lines(talker, heading_deg, begin_s=0):
    """Return a log at 1 Hz from noon or later on, with a line of another kind at its end."""
    for second, value in enumerate(heading_deg, begin_s):
        body = f'{talker}HDT,{value:.2f},T'
        checksum = reduce(lambda a, b: a ^ b, body.encode())
        yield (f'2014-08-01T12:{second // 60:02d}:{second % 60:02d}.000000Z '
               f'${body}*{checksum:02X}\n')
    yield 'the end\n'


@pytest.fixture
def logs(tmp_path, rng):
    """Return 15 minutes of a TS with 0.1° sd and of an RS with 0.02°."""
    paths = []
    for name, talker, sigma in (('gyro.log', 'HE', 0.1), ('seapath.log', 'IN', 0.02)):
        paths.append(tmp_path / name)
        heading = 100.0 + 5.0 * np.sin(np.arange(N) / 40.0) + sigma * rng.standard_normal(N)
        paths[-1].write_text(''.join(lines(talker, heading)))
    return paths


@pytest.mark.parametrize('skew', ['report', 'apply'])
def test_two_logs_give_the_verdict_of_their_bag(logs, tmp_path, capsys, skew):
    assert main(['import-nmea', '--ts', str(logs[0]), '--rs', str(logs[1]), '-o',
                 str(tmp_path / 'bag'), '--quiet']) == 0
    capsys.readouterr()
    extra = ['--set', f'alignment.skew={skew}']
    by_bag, _ = analyze_json(capsys, tmp_path / 'bag', *extra)
    by_logs, _ = analyze_json(capsys, *logs, *extra)
    assert by_logs['outcome'] == by_bag['outcome'] == 'compliant'
    ours, theirs = by_logs['runs'][0], by_bag['runs'][0]
    assert ours['n'] == theirs['n'] >= N - 5 and ours['source'] == str(logs[0])
    for name in ('variance_deg2', 'mean_deg', 'max_deg'):
        assert ours[name] == pytest.approx(theirs[name], rel=1e-9, abs=1e-11), name
    assert by_logs['ledger_complete'] and by_bag['ledger_complete']


def test_the_verdict_and_the_screen_say_which_log_is_which(logs, capsys):
    verdict, notes = analyze_json(capsys, *logs)
    ts, rs = verdict['inputs']
    digests = [hashlib.sha256(path.read_bytes()).hexdigest() for path in logs]
    assert (ts['path'], ts['sha256'], ts['ts_topic'], ts['rs_topic']) == (
        str(logs[0]), digests[0], 'HEHDT', None)
    assert (rs['path'], rs['sha256'], rs['ts_topic'], rs['rs_topic']) == (
        str(logs[1]), digests[1], None, 'INHDT')
    assert ts['not_taken'] == rs['not_taken'] == {'no_sentence': 1}
    assert notes[:2] == [
        f'note: tested sensor (TS): {logs[0]}, 900 headings of HEHDT; not taken: 1 no_sentence',
        f'note: reference sensor (RS): {logs[1]}, 900 headings of INHDT; not taken: '
        '1 no_sentence']


def test_tables_runs_and_a_logbook_take_logs(logs, tmp_path, capsys):
    table, pairs = tmp_path / 'runs.csv', tmp_path / 'pairs.csv'
    table.write_text('start,stop,source\n2014-08-01T12:00:00Z,2014-08-01T12:05:00Z,gyro.log\n')
    verdict, _ = analyze_json(capsys, *logs, '--runs', table, '--csv', pairs,
                            '--logbook', tmp_path / 'book.sqlite')
    assert [run['n'] for run in verdict['runs']] == [300]
    assert len(pairs.read_text().splitlines()) == N + 1
    assert main(['history', str(tmp_path / 'book.sqlite')]) == 0


@pytest.mark.slow
def test_report_is_analyze_with_report(logs, tmp_path, capsys):
    pytest.importorskip('jinja2')
    pytest.importorskip('matplotlib')
    pages = [tmp_path / name for name in ('a.html', 'b.html')]
    assert main(['analyze', *map(str, logs), *QUIET_NORMS, '--report', str(pages[0])]) == 0
    printed = capsys.readouterr()
    assert main(['report', *map(str, logs), *QUIET_NORMS, '-o', str(pages[1])]) == 0
    assert capsys.readouterr() == printed
    assert pages[0].read_text('utf-8') == pages[1].read_text('utf-8')
    assert 'seapath.log that gave no heading: 1 no_sentence' in pages[0].read_text('utf-8')


def test_no_run_is_said_with_both_logs(logs, capsys):
    verdict, notes = analyze_json(capsys, *logs, '--set', 'runs.min_duration_s=3600')
    assert verdict['outcome'] == 'indeterminate' and 'no_run' in verdict['inputs'][0]
    assert notes[2].startswith(f'note: {logs[0]}, {logs[1]}: no run: none of its pairs')


def test_wrong_inputs_are_refused_in_one_line(logs, tmp_path, capsys):
    use = ': give two logs, first that of the TS, then that of the RS, and nothing else'
    ts, rs = logs
    apart = ('; if it is of both, tell its sensors apart with --ts-sentence and --rs-sentence, '
             '--ts-talker and --rs-talker, or --ts-instrument and --rs-instrument')
    assert refusal(capsys, 'analyze', *QUIET_NORMS, ts) == (
        f'{ts}: is the log of one sensor{use}{apart}')
    assert refusal(capsys, 'analyze', *QUIET_NORMS, ts, rs, rs) == (
        f'{ts}: is one of 3 logs{use}; give the files of one sensor as their folder, or as a '
        'pattern in quotes')
    assert refusal(capsys, 'analyze', *QUIET_NORMS, ts, ts) == (
        f'{ts}: is given as TS and as RS{use}{apart}')
    (tmp_path / 'bag').mkdir()
    assert refusal(capsys, 'analyze', *QUIET_NORMS, tmp_path / 'bag', rs) == (
        f'{tmp_path / "bag"}: is not a log of NMEA sentences or headings, but {rs} is{use}')
    assert refusal(capsys, 'analyze', *QUIET_NORMS, ts, tmp_path / 'none.log') == (
        f'{tmp_path / "none.log"}: No such file or directory')


@pytest.mark.parametrize('option, value, words', [
    ('--ts', 'gyro', '--ts gyro: is for bags, and these INPUTs are logs'),
    ('--dask', 'tcp://h:1', '--dask tcp://h:1: is for bags, and these INPUTs are logs'),
    ('--ts-sentence', 'THS', 'gyro.log: no heading in it, read as the TS (not taken: '
     '1 no_sentence, 900 other_sentence.HDT); first refused line: '),
    ('--rs-sentence', 'XXX', "sentence = 'XXX': must be 'auto' or 'THS'")])
def test_options_that_do_not_fit_logs_are_refused(logs, capsys, option, value, words):
    assert words in refusal(capsys, 'analyze', *QUIET_NORMS, *logs, option, value)


def test_options_of_logs_are_refused_without_logs(tmp_path, capsys):
    arguments = tmp_path / 'trial.mcap', '--stamp-format', 'iso'
    assert refusal(capsys, 'analyze', *QUIET_NORMS, *arguments) == (
        '--stamp-format iso: is for logs, and no INPUT is one; leave it out')


@pytest.mark.parametrize('begin_s', [1200, 880, 600])
def test_logs_whose_clocks_lie_apart_are_named_also_without_pairs(begin_s, tmp_path, capsys, rng):
    """The stamps of the two logs overlap for 0 s, 20 s and 300 s; their motion is the same."""
    def tell(*options):
        arguments = (*paths, '--set', 'alignment.clock_range_s=1800', *options)
        if begin_s < N:
            return '\n'.join(analyze_json(capsys, *arguments)[1])
        return refusal(capsys, 'analyze', *QUIET_NORMS, *arguments)

    second = np.arange(N)
    heading = 100.0 + sum(np.sin(2.0 * np.pi * second / period) for period in (
        5.3, 6.1, 7.7, 8.4, 9.9, 11.6, 13.1))
    paths = tmp_path / 'gyro.log', tmp_path / 'seapath.log'
    for path, talker, late_s in zip(paths, ('HE', 'IN'), (begin_s, 0)):
        path.write_text(''.join(lines(talker, heading + 0.05 * rng.standard_normal(N), late_s)))
    named = (f'the clock of the RS lags by about {begin_s:.1f} s by the motion in all readings: '
             f'alignment.skew_s = {begin_s:.1f} pairs them')
    assert named in tell()
    assert 'lags' not in tell('--set', 'alignment.skew=off')
    mended, notes = analyze_json(capsys, *paths, '--set', f'alignment.skew_s={begin_s}')
    assert mended['outcome'] == 'compliant' and not any('lags' in note for note in notes)


@pytest.mark.parametrize('command', ['analyze', 'report', 'import-nmea'])
@pytest.mark.parametrize('role', ['ts', 'rs'])
def test_an_empty_side_ends_every_command_with_the_first_refused_line(
        logs, tmp_path, capsys, command, role):
    log = logs[role == 'rs']
    log.write_text(log.read_text().replace('2014-08-01T', ''))
    inputs = (['--ts', str(logs[0]), '--rs', str(logs[1])] if command == 'import-nmea' else
              [*map(str, logs)])
    output = [] if command == 'analyze' else ['-o', str(tmp_path / 'out.html')]
    err = refusal(capsys, command, *inputs, *output, *QUIET_NORMS)
    assert f'{log}: no heading in it, read as the {role.upper()}' in err
    assert "first refused line: '12:00:00.000000Z $" in err and 'set --date to' in err
    assert main([command, *inputs, *output, *QUIET_NORMS, f'--{role}-date', '2014-08-01']) == 0


def test_one_log_of_both_sensors_is_told_apart_by_talker_or_word(logs, tmp_path, capsys):
    both = tmp_path / 'both.log'
    both.write_text(''.join(line for pair in zip(logs[0].open(), logs[1].open())
                            for line in pair))
    by_two, _ = analyze_json(capsys, *logs)
    by_talker, _ = analyze_json(capsys, both, '--ts-talker', 'HE', '--rs-talker', 'IN')
    words = tmp_path / 'words.log'
    words.write_text(''.join(line.replace(' $', f' G{k} $') for pair in zip(
        logs[0].open(), logs[1].open()) for k, line in enumerate(pair)))
    by_word, _ = analyze_json(
        capsys, words, words, '--ts-instrument', 'G0', '--rs-instrument', 'G1')
    for verdict in (by_talker, by_word):
        assert verdict['runs'][0]['variance_deg2'] == by_two['runs'][0]['variance_deg2']
    text = words.read_text().replace('$IN', '$HE')
    words.write_text(''.join(f'{line.partition("*")[0]}\n' for line in text.splitlines()))
    assert 'HEHDT comes from several instruments: G0 (900 headings), G1 (900 headings); choose ' \
        'one with --ts-instrument' in refusal(
            capsys, 'analyze', *QUIET_NORMS, words, logs[1], '--checksum', 'if_present')


def test_folders_of_hourly_files_and_patterns_are_judged_as_one_log(logs, tmp_path, capsys):
    for path in logs:
        lines = path.read_text().splitlines(keepends=True)
        folder = tmp_path / path.stem
        folder.mkdir()
        for k in range(3):
            (folder / f'{path.stem}_{k + 9}.log.gz').write_bytes(
                gzip.compress(''.join(lines[300 * k:300 * (k + 1)]).encode()))
        (folder / 'empty.log').touch()
    by_two, _ = analyze_json(capsys, *logs)
    by_folder, notes = analyze_json(capsys, tmp_path / 'gyro', tmp_path / 'seapath' / '*.gz')
    assert by_folder['runs'][0]['variance_deg2'] == by_two['runs'][0]['variance_deg2']
    assert notes[0].endswith('900 headings of HEHDT; 3 files; not taken: nothing')
    assert len(by_folder['inputs'][1]['sha256']) == 64


def test_an_option_of_one_log_goes_before_that_of_both(logs, capsys):
    logs[1].write_text(logs[1].read_text().replace('2014-08-01T', '01/08/2014 '))
    assert 'set --stamp-format to dmy or mdy' in refusal(capsys, 'analyze', *QUIET_NORMS, *logs)
    verdict, _ = analyze_json(capsys, *logs, '--rs-stamp-format', 'dmy')
    assert verdict['runs'][0]['n'] >= N - 1


def test_a_text_that_is_no_log_shows_its_first_line(logs, tmp_path, capsys):
    text, empty = tmp_path / 'notes.txt', tmp_path / 'empty.log'
    text.write_text('\n2014-08-01 calm\n')
    empty.touch()
    start = ("first refused line: '2014-08-01 calm'; recognised in it: no stamp, no sentence; "
             'a line needs a sentence that begins with $ or !, or a log of a receiver with # or '
             '%; give another log')
    assert refusal(capsys, 'analyze', *QUIET_NORMS, logs[0], text) == (
        f'{text}: is not a log of NMEA sentences or headings, but {logs[0]} is: {start}')
    assert refusal(capsys, 'analyze', *QUIET_NORMS, text, text) == (
        f'{text}: is neither a bag nor a log of NMEA sentences: {start}')
    assert refusal(capsys, 'analyze', *QUIET_NORMS, empty, logs[1]) == (
        f'{empty}: is not a log of NMEA sentences or headings, but {logs[1]} is: it is empty')


def test_options_that_choose_the_same_sensor_twice_are_refused(logs, capsys):
    assert 'gives the same headings as TS and as RS' in refusal(
        capsys, 'analyze', *QUIET_NORMS, logs[0], '--ts-sentence', 'HDT')


# --- the motion of the ship ---

def moving(tmp_path, off_deg=0.0):
    """Return logs of a TS and an RS, both off by an angle, and one of courses; 15 minutes."""
    heading = 100.0 + 2.0 * np.sin(np.arange(N) / 40.0)
    paths = [tmp_path / name for name in ('gyro.log', 'seapath.log', 'gps.log')]
    for path, talker, phase in zip(paths, ('HE', 'IN'), (0.0, 1.0)):
        noise = 0.1 * np.sin(np.arange(N) * (2.1 + phase))
        path.write_text(''.join(lines(talker, np.mod(heading + noise + off_deg, 360.0))))
    paths[2].write_text(''.join(courses(heading)))
    return paths


def courses(heading):
    """Yield lines of VTG at 10 knots, 3 degrees off the heading."""
    for second, value in enumerate(heading):
        body = f'GPVTG,{value + 3.0:.1f},T,,M,10.0,N,18.5,K,A'
        checksum = reduce(lambda a, b: a ^ b, body.encode())
        yield (f'2014-08-01T12:{second // 60:02d}:{second % 60:02d}.000000Z '
               f'${body}*{checksum:02X}\n')


def of_motion(verdict):
    """Return the finding on the motion; None without one."""
    return next((f for f in verdict['runs'][0]['validity'] if f['condition'] == 'motion'), None)


@pytest.mark.parametrize('off, effect', [(0.0, 'holds'), (180.0, 'void'), (90.0, 'void')])
def test_a_log_of_courses_shows_both_sensors_off_together(tmp_path, capsys, off, effect):
    ts, rs, gps = moving(tmp_path, off)
    alone, notes = analyze_json(capsys, ts, rs)
    assert of_motion(alone) is None and 'motion' not in alone['runs'][0]
    assert not any('motion' in note for note in notes)
    beside, notes = analyze_json(capsys, ts, rs, '--motion', gps)
    assert of_motion(beside)['effect'] == effect
    assert f'note: motion of the ship: course and speed of GPVTG in {gps} (900)' in notes
    assert (beside['outcome'] == alone['outcome']) == (effect == 'holds')


@pytest.mark.parametrize('off', [0.0, 180.0])
def test_the_bag_of_logs_with_motion_gives_their_verdict(tmp_path, capsys, off):
    ts, rs, gps = moving(tmp_path, off)
    assert main(['import-nmea', '--ts', str(ts), '--rs', str(rs), '--motion', str(gps), '-o',
                 str(tmp_path / 'bag'), '--quiet']) == 0
    assert f'course and speed of GPVTG in {gps} (900)' in capsys.readouterr().out
    by_bag, _ = analyze_json(capsys, tmp_path / 'bag')
    by_logs, _ = analyze_json(capsys, ts, rs, '--motion', gps)
    assert by_bag['headline'] == by_logs['headline']
    ours, theirs = by_logs['runs'][0]['motion'], by_bag['runs'][0]['motion']
    assert ours['legs'].pop('ts_deg') == pytest.approx(theirs['legs'].pop('ts_deg'), abs=1e-9)
    assert ours['legs'].pop('rs_deg') == pytest.approx(theirs['legs'].pop('rs_deg'), abs=1e-9)
    assert ours['legs'] == theirs['legs'] and ours['kind'] == theirs['kind']


def test_the_motion_of_the_log_of_the_rs_is_found_without_an_option(tmp_path, capsys):
    ts, rs, gps = moving(tmp_path, 180.0)
    both = sorted(rs.read_text().splitlines()[:-1] + gps.read_text().splitlines())
    rs.write_text('\n'.join(both) + '\n')
    verdict, notes = analyze_json(capsys, ts, rs)
    assert of_motion(verdict)['effect'] == 'void' and verdict['runs'][0]['reason'] == 'void.motion'
    assert any(note.endswith(f'course and speed of GPVTG in {rs} (900)') for note in notes)
    off, notes = analyze_json(capsys, ts, rs, '--set', 'motion.compare=false')
    assert of_motion(off) is None and not any('motion of the ship' in note for note in notes)


def test_a_motion_log_without_motion_is_refused_in_one_line(tmp_path, capsys):
    ts, rs, _ = moving(tmp_path)
    assert refusal(capsys, 'analyze', *QUIET_NORMS, ts, rs, '--motion', ts).startswith(
        f'{ts}: has no motion of the ship: no VTG, RMC, GNS, GGA, GLL or ROT with a stamp')


def test_a_motion_log_is_for_logs_only(tmp_path, capsys):
    assert refusal(capsys, 'analyze', *QUIET_NORMS, tmp_path / 'bag', '--motion', 'gps.log') == (
        '--motion gps.log: is for logs, and no INPUT is one; leave it out')


@pytest.mark.parametrize('ts, rs, more, minutes, ts_deg, rs_deg, bound_deg', [
    ('nbp1406/NBP1406_gyr1-2014-08-01', 'nbp1406/NBP1406_s330-2014-08-01', [],
     10.0, -1.4, -1.4, 29.3),
    ('nbp1406/NBP1406_seap-2014-08-01', 'nbp1406/NBP1406_s330-2014-08-01', [],
     10.0, -0.6, -1.4, 29.3),
    ('nbp1406/NBP1406_gyr1-2014-08-01', 'nbp1406/NBP1406_adcp-2014-08-01',
     ['--checksum', 'if_present', '--motion', 'nbp1406/NBP1406_gp02-2014-08-01'],
     16.6, -1.6, -0.7, 29.4),
    ('nbp1700_replay/NBP1700_seap-2017-11-04', 'nbp1700_replay/NBP1700_s330-2017-11-04',
     ['--time', 'validity'], 20.68, 6.0, 5.2, 26.5),
    ('lmg1903/LMG1903_lgyr.d085', 'lmg1903/LMG1903_lsep.d085', [], 16.6, -1.5, -0.8, 24.3)])
def test_sound_sensors_of_real_ships_raise_nothing(shared_data, capsys, ts, rs, more, minutes,
                                                   ts_deg, rs_deg, bound_deg):
    """The figures of docs/howto/check_against_motion.md."""
    more = [str(shared_data / one) if '/' in one else one for one in more]
    verdict, _ = analyze_json(capsys, shared_data / ts, shared_data / rs, *more)
    found = verdict['runs'][0]['motion']
    assert of_motion(verdict)['effect'] == 'holds' and found['kind'] == 'agrees'
    assert (found['n_legs'], found['legs_s'] / 60.0) == (1, pytest.approx(minutes, abs=0.05))
    assert found['least_bound_deg'] == pytest.approx(bound_deg, abs=0.05)
    assert found['ts']['off_deg'] == pytest.approx(ts_deg, abs=0.05)
    assert found['rs']['off_deg'] == pytest.approx(rs_deg, abs=0.05)


SETTINGS = Settings.of(sigma_max_deg=0.3, sigma_ref_max_deg=0.1)


def test_two_logs_in_python_give_the_verdict_of_the_command(logs, capsys):
    by_command, notes = analyze_json(capsys, *logs)
    with pytest.warns(UserWarning) as warned:
        verdict = analyze_logs(*logs, SETTINGS)
    document = json.loads(json.dumps(verdict.to_dict()))
    assert document['runs'] == by_command['runs'] and document['inputs'] == by_command['inputs']
    assert [f'note: {warning.message}' for warning in warned] == notes
    assert warned[0].filename == __file__
    assert '\n' not in repr(verdict) and repr(verdict.runs[0]).startswith('<RunVerdict on run 1: ')


def test_one_log_of_both_sensors_needs_drivers_that_differ(logs, tmp_path):
    both = tmp_path / 'both.log'
    both.write_text(logs[0].read_text() + logs[1].read_text())
    with pytest.raises(ValueError, match='apart with ts_driver.sentence and rs_driver.sentence'):
        analyze_logs(both, both, SETTINGS)
    with pytest.warns(UserWarning):
        verdict = analyze_logs(both, both, SETTINGS, ts_driver=DriverSettings(talker='HE'),
                               rs_driver=DriverSettings(talker='IN'))
    assert verdict.runs[0].n > 800


@pytest.mark.parametrize('paths', [('pairs.csv', 'pairs.csv'), ('a.mcap', 'b.mcap')])
def test_what_is_no_log_is_refused_in_words_of_python(tmp_path, paths):
    for name in paths:
        (tmp_path / name).write_text('stamp_s,ts_deg,rs_deg\n1400000000,1,1\n')
    with pytest.raises(ValueError) as refused:
        analyze_logs(*(tmp_path / name for name in paths), SETTINGS)
    assert '--' not in str(refused.value) and str(refused.value).startswith(str(tmp_path))
