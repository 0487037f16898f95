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

"""The benchmark of the risks runs, and compares and simulates the right rules and errors."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
import importlib
from pathlib import Path
import re
import sys

from deadlines import DEADLINE_S
import numpy as np
import pytest

from heading_intercompare.core.alarms.comparison_watch import COMPARISON_RULES
from heading_intercompare.core.statistics.cells import Cells
from heading_intercompare.core.statistics.variance_uncertainty import (
    between_runs,
    estimate_spread,
    lower_bound,
    pool,
    scatter_of_runs,
    upper_bound,
)

BENCHMARKS = Path(__file__).resolve().parent.parent / 'benchmarks'
sys.path.insert(0, str(BENCHMARKS))

import alarms  # noqa: E402
import decision_risk  # noqa: E402
import error_processes as processes  # noqa: E402
import history  # noqa: E402
import live  # noqa: E402
import norm_tests  # noqa: E402
import plain_rule  # noqa: E402
from risk_campaigns import _decide_wrongly, CAMPAIGNS, ENDS  # noqa: E402
from risk_rows import ROWS  # noqa: E402
import same_source  # noqa: E402
import sound_pairs  # noqa: E402
import sound_ships  # noqa: E402
import sources  # noqa: E402

QUICK = {'A': '^AR.1., 20$', 'cells': '^AR.1., 20$', 'drift': '^AR.1., 20; (order 3|auto)',
         'gaps': '^AR.1., 20; five', 'short': 'white, n = 128$', 'rates': '^10 Hz, n = 512: sea',
         'E': '0.5 slow, 1, n = 600', 'runs': '^AR.1., 50$', 'means': '^1, 2 runs',
         'looks': '^white; 4', 'open': '^white$', 'B': '^AR', 'stated': '^AR.1., 20$',
         'stated_lengths': '^AR',
         'longer': '^R from 0', 'month': '^AR.1., 3 h, 1 h$',
         'stated_runs': '^AR.1.; 5 of 20$'}

ERRORS = {'white': processes.white, 'AR(1)': processes.ar1(25.0),
          'Laplace': processes.as_laplace(processes.ar1(10.0)),
          'slow': processes.mixed(0.5, processes.white, processes.ar1(1000.0)),
          'equal': lambda rng, runs, n: np.full((runs, n), 3.0)}


@pytest.mark.parametrize('table', [*ROWS, *CAMPAIGNS])
def test_a_table_is_printed(table, capsys):
    """With 3 runs per row its result is random, so only that it runs is tested."""
    done = decision_risk.main(['--table', table, '--rows', QUICK[table], '--replications', '3'])
    lines = capsys.readouterr().out.strip().splitlines()
    assert done in (0, 1)
    assert len(lines) >= 3
    assert len({line.count('|') for line in lines}) == 1


def test_figures_that_are_kept_are_shown_as_a_trend(tmp_path):
    kept = tmp_path / 'history.jsonl'
    for ratio in (1.0, 2.0, 1.5):
        history.keep('recover', {'mcap / ours': ratio, 'peak MB': 80.0}, kept)
    history.keep('other', {'share': 0.5}, kept)
    history.keep('nothing', {}, kept)
    runs = history.read_runs(kept)
    assert [run['benchmark'] for run in runs] == ['recover', 'recover', 'recover', 'other']
    assert [line.split() for line in history.describe_trend(runs, 'recover')] == [
        ['mcap', '/', 'ours', '3', '1', '1.5', '▁█▅'], ['peak', 'MB', '3', '80', '80', '▁▁▁']]


def test_a_damaged_history_is_refused_with_its_line(tmp_path):
    kept = tmp_path / 'history.jsonl'
    kept.write_text('{"benchmark": "x", "figures": {"a": 1}}\n{"benchmark": "x"}\n', 'utf-8')
    with pytest.raises(ValueError, match='history.jsonl, line 2: is not a run of a benchmark'):
        history.read_runs(kept)


def test_false_alarms_are_counted_by_kind_and_bounded(capsys):
    """Two voyages of 10 min each; 1 / 3 h and 3.0 / (2 / 3 h), per 1000 h."""
    assert alarms.main(['--hours', '0.2', '--kind', '1 Hz', '1 Hz, alongside', '--seed', '3']) == 0
    _, _, *rows = capsys.readouterr().out.splitlines()
    cells = [[cell.strip() for cell in row.strip('|').split('|')] for row in rows]
    assert [row[:2] for row in cells] == [['1 Hz', '0.3'], ['1 Hz, alongside', '0.3'],
                                          ['all', '0.7']]
    assert [(row[2], row[4], row[5]) for row in cells] == [
        ('none', '0', '8987'), ('none', '0', '8987'), ('none', '0', '4494')]
    assert all(float(row[3]) > 0.0 for row in cells)


def test_an_alarm_that_is_raised_is_named_in_the_row_of_its_kind(monkeypatch):
    """A TS that lags by five seconds in turns of 3 °/s is not sound."""
    monkeypatch.setitem(alarms.KINDS, 'swell', {'motion': 'turning', 'late_s': 5.0})
    found = alarms.count_alarms('swell', 0.1, 1)
    assert found.raised and set(found.raised) <= {rule.name for rule in COMPARISON_RULES}
    assert str(found.raised.most_common(1)[0][0]) in alarms.describe('swell', found)
    assert (found + found).raised.total() == 2 * found.raised.total()


@pytest.mark.parametrize('n, upper', [(0, 2.9957), (1, 4.7439), (5, 10.5130)])
def test_the_upper_limit_of_a_rate_is_that_of_a_poisson_count(n, upper):
    """Printed tables of exact limits, one-sided 95 %: 3.00, 4.74, 10.51."""
    assert alarms.most_per_1000_h(n, 1000.0) == pytest.approx(upper, abs=1e-4)


@pytest.mark.parametrize('words, said', [
    (['--hours', '-1'], '-1 must be a number of hours above 0'),
    (['--hours', 'x'], 'x must be a number of hours above 0'),
    (['--seed', '-1'], '-1 must be a whole number, at least 0'),
    (['--kind', 'airship'], "invalid choice: 'airship'")])
def test_a_mistake_in_the_options_of_the_alarms_is_told_in_a_line(words, said, capsys):
    with pytest.raises(SystemExit) as ended:
        alarms.main(words)
    assert ended.value.code == 2 and said in capsys.readouterr().err.splitlines()[-1]


def test_the_peer_of_the_graph_is_a_package_and_not_a_folder_of_its_name(tmp_path, monkeypatch):
    """A checkout of message_filters beside the user is a folder of that name."""
    monkeypatch.setattr(sys, 'path', [str(tmp_path)])
    package = tmp_path / 'message_filters'
    package.mkdir()
    assert not live.has_message_filters()
    (package / '__init__.py').touch()
    importlib.invalidate_caches()
    assert live.has_message_filters()


def test_a_process_of_a_benchmark_finds_a_peer_on_a_relative_path(tmp_path, monkeypatch):
    """It runs in another folder, where the relative path leads nowhere."""
    (tmp_path / 'elsewhere').mkdir()
    (tmp_path / 'peers').mkdir()
    (tmp_path / 'peers' / 'only_there.py').touch()
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv('PYTHONPATH', 'peers')
    process = live.Process(['-c', 'import only_there; print(only_there.__name__)'],
                           tmp_path / 'elsewhere', 1)
    assert process.process.communicate(timeout=DEADLINE_S)[0] == 'only_there\n'


def test_a_process_that_is_gone_ends_the_benchmark_with_a_line(tmp_path):
    """One that was killed or refused had no line of its memory: IndexError."""
    process = live.Process(['-c', 'import sys; sys.exit("no such sensor")'], tmp_path, 1)
    line = ('the process -c import sys; sys.exit("no such sensor") ended with exit code 1 before '
            'it was measured: no such sensor')
    for ask in (process.say, process.memory_mb, process.cpu_s):
        with pytest.raises(SystemExit, match=re.escape(line)):
            ask()
    process.process.communicate()


def test_ratios_to_a_peer_are_those_of_the_median_round():
    peer = [{'cpu': {'plain': 0.1}, 'p50_s': 1.0, 'p99_s': late_s} for late_s in (2.0, 2.0, 90.0)]
    graph = [{'cpu': {'a': 0.1, 'b': b_cpu}, 'p50_s': p50_s, 'p99_s': 4.0}
             for p50_s, b_cpu in ((5.0, 0.15), (6.0, 0.2), (9.0, 0.4))]
    assert live.describe_ratios('graph', 'plain', {'plain': peer, 'graph': graph}) == (
        'graph / plain: CPU 3.00 (2.50 to 5.00), p50 6.0, p99 2.0')


@pytest.mark.parametrize('row, kinds', [
    ('copy, white', {'common'}), ('glitches, copy', {'common', 'suspected'}),
    ('independent, perfect TS', {'independent', 'not_testable'}),
    ('independent, two perfect, rounded', {'suspected', 'not_testable'})])
def test_a_row_of_one_source_holds_what_it_is_called(row, kinds):
    kind, how = same_source.ROWS[row]
    found = [kind(same_source.draw_run(seed, **how)).kind for seed in (1, 2, 3)]
    assert found[0] in kinds and set(found) <= {*kinds, 'not_testable', 'suspected'}


def test_a_sound_pair_is_decided_by_its_number_and_the_seed():
    for number in (3, 77):
        pair, again, other = (sound_ships.draw_pair(number, seed) for seed in (1, 1, 2))
        assert (pair.words, pair.ts, pair.rs) == (again.words, again.ts, again.rs)
        assert pair.ts != other.ts


def test_an_error_of_a_norm_is_counted_by_its_test(capsys):
    assert norm_tests.main(['--tests', 'rms_of_ten', 'settling_time', '--trials', '1',
                            '--jobs', '1']) == 0
    rows = capsys.readouterr().out.splitlines()[2:]
    assert rows == ['| `rms_of_ten` | 0.00417 | 0.00 | 0.00 | 1.00 | 1.00 | 0 |',
                    '| `settling_time` | 0.0125 | 0.00 | 0.00 | 1.00 | 1.00 | 0 |']
    assert norm_tests.is_too_often(9, 100, 0.01) and not norm_tests.is_too_often(2, 100, 0.01)


def test_sound_pairs_are_of_every_ship_and_bear_every_burden():
    """A number of pairs as in the benchmark has each ship with each burden."""
    n = len(sound_ships.SHIPS) * len(sound_ships.BURDENS)
    words = {tuple(sound_ships.draw_pair(k, 1).words.split(', ')[:2]) for k in range(n)}
    assert words == {(ship, burden) for ship in sound_ships.SHIPS
                     for burden in sound_ships.BURDENS}


def test_a_sound_sensor_has_the_errors_that_its_words_tell(rng):
    """Steps of 0.2 deg alone scatter by 0.058 deg; within six standard errors."""
    sensor = sound_ships._Sensor(10.0, 'white', 0.14, 0.2, 0.0)
    t_s = np.arange(0.0, 2000.0, 0.1)
    course = sound_ships.swing(rng, 2.0, 8.0)
    heading = sensor.report(rng, t_s, course).heading_deg
    error = (heading - course(t_s) + 180.0) % 360.0 - 180.0
    assert abs(error.std() / 0.14 - 1.0) < 6.0 / np.sqrt(2.0 * t_s.size)
    assert np.abs(heading / 0.2 - np.rint(heading / 0.2)).max() < 1e-6


def test_what_is_held_against_a_pair_is_told_in_a_line_each():
    """A TS at three times its norm is rejected, and one sensor twice is void."""
    found = sound_pairs.judge_number(0, 1, 3.0)
    assert found.outcomes == ('non_compliant',)
    assert sound_pairs.describe(found)[-1].startswith('pair 0: REJECTED lower_bound_above')
    pair = sound_ships.draw_pair(0, 1)
    twice = replace(pair, ts=pair.rs)
    kinds = dict(sound_pairs.find_against(sound_pairs.judge(twice)))
    assert kinds['void'].startswith('same_source: ')


def test_sound_pairs_are_counted_and_decide_the_exit_code(capsys):
    assert sound_pairs.main(['--pairs', '2', '--norm-pairs', '1', '--jobs', '1']) == 0
    said = capsys.readouterr().out
    assert '2 sound pairs: 0 void, 0 doubtful' in said and ' at the norm: 0 certified' in said
    judged = [sound_pairs.Judged(4, 'a pair', ('compliant',), (('doubtful', 'clocks: late'),))]
    assert sound_pairs.print_sound(judged)['doubtful'] == 1
    assert capsys.readouterr().out.splitlines()[0] == 'pair 4: DOUBTFUL clocks: late [a pair]'


@pytest.mark.parametrize('burden', ['nothing', 'marks'])
def test_the_legs_of_a_pair_are_its_runs_by_marks_and_by_a_table(burden):
    pair = next(pair for pair in (sound_ships.draw_pair(k, 5) for k in range(
        2, 240, 10)) if f'legs, {burden}' in pair.words)
    found = [sound_pairs.judge(replace(pair, table=table)) for table in (False, True)]
    assert [[(run.start_ns, run.n) for run in one.runs] for one in found[:1]] * 2 == [
        [(run.start_ns, run.n) for run in one.runs] for one in found]
    assert len(found[0].runs) == len(pair.legs) == 3


def test_a_wrong_look_counts_from_its_time_on_and_a_wrong_end_alone():
    looks, ends = np.zeros((3, len(ENDS)), bool), np.zeros((3, len(ENDS)), bool)
    looks[0, 8], looks[1, 9] = True, True  # At four times the least length, and at no look.
    ends[2, 3] = True
    wrong = _decide_wrongly(looks, ends)
    assert wrong[0].tolist() == [at >= 8 for at in range(len(ENDS))]
    assert not wrong[1].any() and np.flatnonzero(wrong[2]).tolist() == [3]


def test_names_of_rows_are_unique_for_they_are_seeds():
    for table in (*ROWS, *CAMPAIGNS):
        names = [row.name for row in decision_risk.rows_of(table)]
        assert len(names) == len(set(names))


@pytest.mark.process
def test_a_row_does_not_depend_on_other_rows_or_processes(capsys):
    outputs = []
    for more in (['--rows', '^AR.1., [23]0$', '--jobs', '2'], ['--rows', '^AR.1., 30$']):
        decision_risk.main(['--replications', '20', *more])
        outputs.append(capsys.readouterr().out.strip().splitlines()[-1])
    assert outputs[0] == outputs[1]
    assert outputs[0].startswith('| AR(1), 30 | 900 | 20 |')


@pytest.mark.parametrize('rates, text', [
    ([1] * 49 + [0] * 951, '0.0490 ± 0.0068'), ([1] * 61 + [0] * 939, '0.0610 ± 0.0076 **fails**'),
    ([1] * 570 + [0] * 9430, '0.0570 ± 0.0023 **fails**'), ([0] * 9, '0.0000 ± 0.0000')])
def test_a_rate_fails_above_006_or_two_standard_errors_above_005(rates, text):
    from risk_measures import rate
    assert rate(np.array(rates), 0.05) == text


@pytest.mark.slow
@pytest.mark.parametrize('sampling', [None, 'one_missing', 'five_gaps', 'half_missing',
                                      'one_in_four', 'jittered', 'seconds_on_and_off'])
@pytest.mark.parametrize('errors', ERRORS)
def test_the_rule_is_that_of_the_plain_loop(errors, sampling, rng):
    for n, order in ((128, 0), (700, 1), (1023, 0), (1024, 2), (12_001, 3)):
        x, stamps = ERRORS[errors](rng, 1, n)[0], None
        if sampling:
            at = getattr(processes, sampling)(rng, n)
            x, stamps = x[at], at * 100_000_000
        found = estimate_spread(Cells.of(x, stamps), order)
        plain = plain_rule.spread(x, order, stamps)
        if plain is None:
            assert found is None
            continue
        for name in ('d_deg2', 's_deg2', 'nu', 'f', 'corner_j', 'r_slow', 'slow_variance_deg2',
                     'slow_allowance_deg2', 'mean_variance_deg2'):
            assert getattr(found, name) == pytest.approx(getattr(plain, name), rel=1e-9,
                                                         abs=1e-12), name
        for alpha in (0.05, 0.004):
            assert upper_bound(found, alpha) == pytest.approx(
                plain_rule.upper_bound(plain, alpha), rel=1e-10)
            assert lower_bound(found, alpha) == pytest.approx(
                plain_rule.lower_bound(plain, alpha), rel=1e-10)
            for times in (20.0, 70.0, 500.0):
                stated = estimate_spread(Cells.of(x, stamps), order, times)
                assert upper_bound(stated, alpha) == pytest.approx(
                    plain_rule.stated_bound(plain, times, alpha), rel=1e-10)
                assert lower_bound(stated, alpha) == lower_bound(found, alpha)


def test_several_runs_are_judged_as_by_the_plain_loop(rng):
    runs = [ERRORS['slow'](rng, 1, n)[0] for n in (600, 1500, 3000, 600)]
    means = np.array([x.mean() for x in runs])
    found, plain = [estimate_spread(Cells.of(x)) for x in runs], [plain_rule.spread(x)
                                                                  for x in runs]
    for bound in ('upper_bound', 'lower_bound'):
        assert globals()[bound](pool(found), 0.05) == pytest.approx(
            getattr(plain_rule, bound)(plain_rule.pool(plain), 0.05), rel=1e-10)
    for bound, as_plain in ((between_runs, plain_rule.between_runs),
                            (scatter_of_runs, plain_rule.scatter_of_runs)):
        assert bound(found, means, 0.05) == pytest.approx(as_plain(plain, means, 0.05), rel=1e-10)


@pytest.mark.parametrize('order', [0, 1, 3])
def test_several_runs_with_a_statement_are_judged_as_by_the_plain_loop(order, rng):
    lengths = (600, 1500, 3000, 600, 900)
    runs, times = [ERRORS['slow'](rng, 1, n)[0] for n in lengths], [n / 30.0 for n in lengths]
    found = [estimate_spread(Cells.of(x), order, t) for x, t in zip(runs, times)]
    plain = [plain_rule.spread(x, order) for x in runs]
    assert upper_bound(pool(found, by_statement=True), 0.05) == pytest.approx(
        plain_rule.stated_bound_of_runs(plain, times, 0.05), rel=1e-10)
    assert upper_bound(pool(found), 0.05) == pytest.approx(
        plain_rule.upper_bound(plain_rule.pool(plain), 0.05), rel=1e-10)


@pytest.mark.parametrize('errors', [
    processes.white, processes.ar1(30.0), processes.blue, processes.narrow_band(60.0, 12.0),
    processes.mixed(0.3, processes.white, processes.ar1(30.0)),
    processes.as_laplace(processes.ar1(20.0)), processes.as_student5(processes.ar1(20.0)),
    processes.as_uniform(processes.ar1(20.0)), processes.quantised(2.0, processes.white),
    processes.calm_then_rough(processes.white), processes.ramp(processes.white),
    processes.sea_state(0.7, 60.0, processes.white), processes.ar1(1e4)])
def test_a_process_has_variance_1(errors, rng):
    """Within six standard errors."""
    squares = np.mean(errors(rng, 4000, 60) ** 2, axis=1)
    assert abs(squares.mean() - 1.0) < 6.0 * squares.std() / np.sqrt(squares.size)


@pytest.mark.parametrize('errors', [
    processes.ar1(30.0), processes.blue, processes.narrow_band(60.0, 12.0),
    processes.sea_state(0.7, 60.0, processes.white)])
def test_a_process_begins_in_its_stationary_state(errors, rng):
    first = errors(rng, 20_000, 2)[:, 0] ** 2
    assert abs(first.mean() - 1.0) < 6.0 * first.std() / np.sqrt(first.size)


@pytest.fixture
def damaged_bags():
    for peer in ('pybag', 'rosbags'):
        pytest.importorskip(peer, reason=f'{peer} is not installed')
    return importlib.import_module('damaged_bags')


@pytest.mark.slow
def test_of_damaged_bags_more_is_recovered_than_others_read(damaged_bags, tmp_path):
    """A few of the bags of the benchmark: nothing foreign, and nothing under another topic."""
    scores = damaged_bags.measure(tmp_path, 18, 200)
    total = damaged_bags.add_up(scores)
    ours = total.pop('recover')
    assert ours.total > 5000 and not ours.crashes and not ours.misplaced
    assert ours.share > 0.7 > max(score.share for score in total.values())
    assert not any(row['recover'].foreign for name, row in scores.items()
                   if damaged_bags.LAYOUTS[name].protected)


def test_a_score_counts_what_is_kept_foreign_and_misplaced(damaged_bags):
    score = damaged_bags.Score()
    whole = Counter({('/a', 1): 1, ('/a', 2): 1, ('/b', 3): 2})
    score.take(whole, Counter({('/a', 1): 2, ('/b', 2): 1, ('/b', 3): 1, ('/b', 9): 1}), 'X')
    assert (score.total, score.kept, score.foreign, score.misplaced) == (4, 2, 3, 1)
    assert score.share == 0.5 and score.crashes == {'X': 1}


def test_damages_of_a_seed_are_always_the_same(damaged_bags):
    data = bytes(range(1, 256)) * 10
    for kind in damaged_bags.DAMAGES:
        one, other = ([damaged_bags.damage(data, kind, np.random.default_rng(seed))
                       for seed in range(5)] for _ in range(2))
        assert one == other and any(each != data for each in one)
        assert all(len(each) <= len(data) for each in one)


def test_the_sources_are_measured(tmp_path):
    (tmp_path / 'a.py').write_text(
        '"""A module."""\nimport os\n\n\ndef pick(given, n):\n    """Return it."""\n'
        '    # Why.\n    found = [one for one in given if one or n]\n    return found\n')
    figures = sources.measure(tmp_path)
    assert (figures.files, figures.code_lines) == (1, 3)
    assert figures.names == {'given': 1, 'found': 1, 'one': 1}
    assert (figures.above_10, figures.above_20) == (0, 0)


def test_few_names_say_nothing():
    """Fewer than five in 1000 code lines."""
    figures = sources.measure(BENCHMARKS.parent / 'heading_intercompare')
    assert figures.names_per_1000 < 5.0
