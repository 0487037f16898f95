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

"""Many inputs at once: the same verdict as one by one, and a bad one named."""

from __future__ import annotations

from concurrent.futures import (
    BrokenExecutor,
    Executor,
    Future,
    ProcessPoolExecutor,
    ThreadPoolExecutor,
)
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack, suppress
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from types import SimpleNamespace

from command_line import analyze_json, refusal
from deadlines import DEADLINE_S
import numpy as np
import pytest
from trials import write_headings

from heading_intercompare import Headings, Settings
from heading_intercompare.app import campaign, job
from heading_intercompare.bags.parallel import decode_workers
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.settings import BagSettings
from heading_intercompare.cli import main
from heading_intercompare.core.typed_reader import make_plain
from heading_intercompare.messages.cdr import encode

S = 1_000_000_000
NORMS = ['--set', 'norms.sigma_max_deg=0.3', '--set', 'norms.sigma_ref_max_deg=0.1',
         '--set', 'risk.min_duration_s=0']


def write_bag(path, number: int, **records) -> str:
    """Write two minutes at 10 Hz, TS 0.1° sd, RS exact; and metadata records."""
    rng = np.random.default_rng(number)
    stamps = (1_400_000_000 + 1000 * number) * S + np.arange(1200) * (S // 10)
    streams = {topic: Headings.of(stamps, 100.0 + error * rng.standard_normal(1200))
               for topic, error in (('ts/heading', 0.1), ('rs/heading', 0.0))}
    return write_headings(path, streams, records=records,
                          settings=BagSettings(chunk_bytes=50_000))


@pytest.fixture
def bags(tmp_path, capsys):
    """Return three bags and a csv of pairs."""
    found = [write_bag(tmp_path / f'trial_{i}', i) for i in range(3)]
    assert main(['analyze', found[0], *NORMS, '--csv', str(tmp_path / 'pairs.csv')]) == 0
    return [*found, str(tmp_path / 'pairs.csv')]


def judged(capsys, *arguments) -> tuple[dict, str]:
    """Return the JSON of `analyze` and its other output."""
    verdict, notes = analyze_json(capsys, *arguments, norms=NORMS)
    return verdict, ''.join(f'{note}\n' for note in notes)


@pytest.fixture
def processes(monkeypatch):
    """Judge even small inputs in their own processes."""
    monkeypatch.setattr(campaign, '_WORTH_BYTES', 0)


@pytest.mark.process
def test_several_processes_judge_as_one_does(bags, capsys, monkeypatch):
    serial, _ = judged(capsys, *bags)
    monkeypatch.setattr(campaign, '_WORTH_BYTES', 0)
    parallel, said = judged(capsys, *bags, '--jobs', '2')
    assert parallel == serial and said == ''
    assert [run['source'] for run in parallel['runs']] == bags
    assert [given['path'] for given in parallel['inputs']] == bags
    assert parallel['outcome'] == 'compliant'


def test_one_large_bag_is_decoded_by_several_processes_with_the_same_verdict(
        bags, capsys, monkeypatch):
    monkeypatch.setattr('heading_intercompare.bags.mcap.mcap_file._BLOCK_BYTES', 10_000)
    monkeypatch.setattr(decode_workers, '_FEWEST', 6)
    monkeypatch.setattr(decode_workers, 'active_count', lambda: 1)
    monkeypatch.setattr(campaign, 'count_cores', lambda: 8)
    begun = []
    monkeypatch.setattr(decode_workers, '_Helper', lambda *args, begin=decode_workers._Helper: (
        begun.append(args), begin(*args))[1])
    alone, _ = judged(capsys, bags[0], '--jobs', '1')
    assert not begun
    together, said = judged(capsys, bags[0])
    assert together == alone and said == ''
    assert len(begun) == (3 if sys.platform == 'linux' else 0)


@pytest.mark.slow
@pytest.mark.parametrize('worth', [0, 10**9])
def test_a_bad_bag_is_named_and_the_campaign_is_not_compliant(
        bags, tmp_path, capsys, monkeypatch, worth):
    monkeypatch.setattr(campaign, '_WORTH_BYTES', worth)
    (tmp_path / 'bad.mcap').write_bytes(b'no bag')
    inputs = [bags[0], str(tmp_path / 'bad.mcap'), str(tmp_path / 'nowhere'), bags[1]]
    verdict, said = judged(capsys, *inputs)
    assert verdict['outcome'] == verdict['paper_outcome'] == 'indeterminate'
    assert [run['outcome'] for run in verdict['runs']] == ['compliant'] * 2
    assert [given.get('error') for given in verdict['inputs']] == [
        None, 'is not an MCAP file', 'No such file or directory', None]
    assert verdict['inputs'][1]['sha256'] is None
    assert said == (f'note: {inputs[1]}: not judged: is not an MCAP file\n'
                    f'note: {inputs[2]}: not judged: No such file or directory\n')


@pytest.mark.parametrize('kind, message, why', [
    ('std_msgs/msg/String', {'data': 'start'},
     'is std_msgs/msg/String, must be diagnostic_msgs/msg/DiagnosticArray'),
    ('diagnostic_msgs/msg/DiagnosticArray', {'status': [{'message': 'begin'}]},
     "mark = 'begin': use 'start' or 'stop'")])
def test_a_bag_with_a_wrong_mark_is_named_and_the_others_judged(
        bags, tmp_path, capsys, kind, message, why):
    marked = str(tmp_path / 'marked')
    with BagWriter(marked) as writer:
        writer.add_topic('compliance/marker', kind)
        writer.write('compliance/marker', encode(kind, message), S)
    why = f"topic '/compliance/marker': {why}; --runs ignores all marks"
    verdict, said = judged(capsys, marked, bags[0])
    assert said == f'note: {marked}: not judged: {why}\n'
    assert [run['source'] for run in verdict['runs']] == bags[:1]
    assert main(['analyze', marked, *NORMS]) == 2
    assert capsys.readouterr().err == f'heading-intercompare: error: {marked}: {why}\n'


@pytest.mark.parametrize('error, why', [(ValueError('x = 1'), 'x = 1'),
                                        (MemoryError(), 'there is not enough memory for it')])
def test_an_input_that_cannot_be_judged_does_not_stop_the_others(
        bags, capsys, monkeypatch, error, why):
    def analyze(path, *args, judge=job.judge_input, **kwargs):
        if path == bags[0]:
            raise error
        return judge(path, *args, **kwargs)

    monkeypatch.setattr(job, 'judge_input', analyze)
    verdict, said = judged(capsys, *bags[:2])
    assert said == f'note: {bags[0]}: not judged: {why}\n'
    assert [run['source'] for run in verdict['runs']] == [bags[1]]


def test_an_input_without_runs_is_named_and_the_campaign_is_not_compliant(bags, tmp_path, capsys):
    stamps = 1_400_000_000 * S + np.arange(1200) * (S // 10)
    readings = Headings.of(stamps, np.where(np.arange(1200) < 7, np.nan, 100.0))
    dead = write_headings(tmp_path / 'dead', {
        'ts/heading': readings, 'rs/heading': Headings.empty()})
    verdict, said = judged(capsys, bags[0], dead)
    assert verdict['outcome'] == verdict['paper_outcome'] == 'indeterminate'
    # The headline and the reason of the whole say so, too.
    assert verdict['headline'] == 'INDETERMINATE: not every input could be judged'
    assert verdict['campaign']['reason'] == 'an_input_not_judged'
    why = ('no pair was made; 1200 TS and 0 RS readings received, 0 paired, rejected: '
           '7 TS invalid')
    assert verdict['inputs'][1]['no_run'] == why and 'no_run' not in verdict['inputs'][0]
    assert said == f'note: {dead}: no run: {why}\n'
    assert main(['analyze', bags[0], dead, *NORMS]) == 0
    text = capsys.readouterr().out
    *_, head, first, second = text.splitlines()
    assert head.split()[:2] == ['recording', 'outcome']
    # The worst comes first.
    assert first.split()[:3] == ['dead', 'NO', 'RUN'] and first.endswith(f'  {why}')
    assert second.split()[:2] == ['trial_0', 'COMPLIANT']


def test_runs_that_are_too_short_are_said_to_be(bags, capsys):
    verdict, said = judged(capsys, bags[0], '--set', 'runs.min_duration_s=900')
    assert verdict['runs'] == []
    assert 'in a run of at least runs.min_duration_s = 900 s; 1200 TS and 1200 RS' in said


@pytest.mark.parametrize('again', ['{0}', '{0}/trial_0_0.mcap', '{copy}'])
def test_the_same_data_are_judged_once(bags, tmp_path, capsys, again):
    shutil.copytree(bags[0], tmp_path / 'copy')
    again = again.format(bags[0], copy=tmp_path / 'copy')
    once, _ = judged(capsys, *bags[:2])
    verdict, said = judged(capsys, bags[0], again, bags[1])
    assert said == f'note: {again}: not judged again: it has the data of {bags[0]}\n'
    assert verdict['inputs'][1]['same_as'] == bags[0]
    for key in ('outcome', 'campaign', 'runs'):
        assert verdict[key] == once[key]


def test_a_source_in_the_table_of_runs_may_be_written_as_another_path(bags, tmp_path, capsys,
                                                                     monkeypatch):
    table = tmp_path / 'runs.csv'
    starts = [(1_400_000_000 + 1000 * number) * S for number in range(2)]
    monkeypatch.chdir(tmp_path)
    table.write_text(''.join(['\ufeffstart,stop,source\n',
                              f'{starts[0]},{starts[0] + 50 * S},./trial_0\n',
                              f'{starts[1]},{starts[1] + 60 * S},trial_1\n',
                              f'{starts[1]},{starts[1] + 60 * S},gone\n']), 'utf-8')
    verdict, said = judged(capsys, *bags[:3], '--runs', str(table))
    assert [(run['source'], run['n']) for run in verdict['runs']] == [
        (bags[0], 500), (bags[1], 600)]
    assert 'the table of runs has no row for it' in verdict['inputs'][2]['no_run']
    assert said.endswith(f'note: {table}: source gone is not one of the INPUTs\n')


def test_a_source_that_means_several_inputs_is_refused(bags, tmp_path, capsys):
    shutil.copytree(bags[0], tmp_path / 'other' / 'trial_0')
    table = tmp_path / 'runs.csv'
    table.write_text('start,stop,source\n1,2,trial_0\n')
    assert main(['analyze', bags[0], str(tmp_path / 'other' / 'trial_0'), *NORMS, '--runs',
                 str(table)]) == 2
    assert 'write the path instead' in capsys.readouterr().err


def test_a_bad_bag_does_not_hide_that_another_is_not_compliant(bags, tmp_path, capsys):
    assert main(['analyze', *bags[:2], str(tmp_path / 'nowhere'), '--check',
                 '--set', 'norms.sigma_max_deg=0.02', '--set', 'norms.sigma_ref_max_deg=0.01',
                 '--set', 'risk.min_duration_s=0']) == 1


@pytest.mark.slow
def test_a_report_is_written_though_a_bag_is_bad(bags, tmp_path, capsys, processes):
    judged(capsys, *bags[:2], str(tmp_path / 'nowhere'), '--report',
           str(tmp_path / 'report.html'))
    text = (tmp_path / 'report.html').read_text('utf-8')
    assert 'nowhere' in text and 'trial_1' in text


def test_where_no_input_can_be_read_nothing_is_judged(tmp_path, capsys):
    err = refusal(capsys, 'analyze', tmp_path / 'a', tmp_path / 'b', *NORMS)
    assert 'none of the 2 inputs can be read' in err and 'No such file' in err


@pytest.mark.parametrize('jobs', ['0', '-1', 'x', '1.5', '²'])
def test_a_wrong_number_of_processes_is_refused(capsys, jobs):
    assert main(['analyze', 'a', 'b', *NORMS, '--jobs', jobs]) == 2
    assert 'is not a whole number above 0' in capsys.readouterr().err


def test_without_the_library_of_dask_one_line_says_what_to_install(bags, capsys, monkeypatch):
    monkeypatch.delitem(sys.modules, 'heading_intercompare.app.cluster', raising=False)
    monkeypatch.setitem(sys.modules, 'distributed', None)
    err = refusal(capsys, 'analyze', *bags, *NORMS, '--dask', 'tcp://127.0.0.1:8786')
    assert 'no module distributed: install heading_intercompare[dask]' in err


@pytest.mark.parametrize('option', ['--csv', '--ensembles', '--jobs'])
def test_what_a_cluster_does_not_do_is_refused_before_a_file_is_touched(
        bags, tmp_path, capsys, option):
    given = '2' if option == '--jobs' else str(tmp_path / 'new')
    err = refusal(capsys, 'analyze', bags[0], *NORMS, option, given, '--dask', 'tcp://127.0.0.1:1')
    assert f'{option} {given}: ' in err and '--dask' in err
    assert not (tmp_path / 'new').exists()


@pytest.mark.process
def test_a_process_that_dies_is_no_end_of_the_others():
    """Exit with code 3 instead of an answer, like a process killed when memory ran out."""
    broken = Future()
    broken.set_exception(BrokenProcessPool())
    job = SimpleNamespace(survive=os._exit, unread=lambda path, why: (path, why))
    path, why = campaign._result(job, 3, broken)
    assert path == 3 and 'died' in why
    job.survive = str
    assert campaign._result(job, 3, broken) == '3'


def entered(gate, process) -> int:
    """Return the other end of a named pipe as soon as somebody reads it."""
    while process.poll() is None:
        with suppress(OSError):
            return os.open(gate, os.O_WRONLY | os.O_NONBLOCK)
        time.sleep(0.02)
    raise AssertionError(f'ended with {process.returncode}')


@pytest.mark.process
@pytest.mark.parametrize('number, code', [
    (signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGKILL, -signal.SIGKILL)])
def test_no_process_outlives_the_command(tmp_path, number, code):
    """Two of its processes wait for ever; a third input is not started."""
    gates = [tmp_path / f'{i}.csv' for i in range(3)]
    for gate in gates:
        os.mkfifo(gate)
    command = ('import signal, sys; from heading_intercompare.cli import main; '
               'signal.signal(signal.SIGINT, signal.default_int_handler); sys.exit(main())')
    process = subprocess.Popen(
        [sys.executable, '-c', command, 'analyze', *map(str, gates), *NORMS, '--jobs', '2'],
        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, start_new_session=True,
        env={**os.environ, 'PYTHONPATH': os.pathsep.join(sys.path)})
    try:
        with ExitStack() as held:
            for gate in gates[:2]:
                held.callback(os.close, entered(gate, process))
            process.send_signal(number)
            # Who still runs holds the output open.
            process.communicate(timeout=DEADLINE_S)
        assert process.returncode == code
    finally:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.communicate()


def test_an_unfinished_bag_is_judged_and_said_to_be_unfinished(bags, capsys):
    file = f'{bags[1]}/trial_1_0.mcap'
    with open(file, 'r+b') as cut:
        cut.truncate(60_000)
    verdict, said = judged(capsys, *bags[:2])
    assert len(verdict['runs']) == 2 and 'was not closed' in said


def test_a_recovered_bag_is_said_to_be_recovered(bags, tmp_path, capsys):
    file = f'{bags[1]}/trial_1_0.mcap'
    with open(file, 'r+b') as cut:
        cut.truncate(60_000)
    assert main(['recover', bags[1], '-o', str(tmp_path / 'new')]) == 0
    _, said = judged(capsys, str(tmp_path / 'new'))
    assert 'recovered from a damaged bag' in said


def test_a_bag_whose_recorder_lost_messages_is_said_to_have_lost_them(tmp_path, capsys):
    bag = write_bag(tmp_path / 'bag', 1, recording={'not_written./ts/heading': 7})
    _, said = judged(capsys, bag)
    assert said == f'note: {bag}: 7 messages received but not written\n'


@pytest.mark.slow
def test_results_come_in_the_order_given(bags, processes):
    settings = Settings.from_mapping({'norms.sigma_max_deg': 0.3, 'norms.sigma_ref_max_deg': 0.1})
    found = campaign.judge_inputs([bags[2], bags[0], bags[1]], settings, None, jobs=3)
    assert [each.path for each in found] == [bags[2], bags[0], bags[1]]
    assert all(each.error is None and len(each.results['ts', 'rs']) == 1 for each in found)


@pytest.mark.slow
@pytest.mark.parametrize('make', [ThreadPoolExecutor, ProcessPoolExecutor])
def test_any_executor_of_the_standard_library_judges_as_one_process_does(bags, make):
    settings = Settings.from_mapping({'norms.sigma_max_deg': 0.3, 'norms.sigma_ref_max_deg': 0.1})
    alone = campaign.judge_inputs(bags, settings, sketched=True)
    said = []
    with make(2) as executor:
        found = campaign.judge_inputs(bags, settings, sketched=True, executor=executor,
                                      progress=said.append)
    assert [each.path for each in found] == bags
    assert [each.entries_of_tested for each in found] == [each.entries_of_tested for each in alone]
    assert exact([each.results for each in found]) == exact([each.results for each in alone])
    assert [each.notes for each in found] == [[]] * len(bags)
    assert [each.sketches['ts'].sketches[0].n for each in found] == [1200] * len(bags)
    n = len(bags)
    assert said[0] == f'0 of {n} done' and said[-1].startswith(f'{n} of {n} done, ')


def exact(results) -> str:
    """Return the runs of inputs as text that shows every bit."""
    return json.dumps([make_plain(each.verdict) for of_pairs in results
                       for some in of_pairs.values() for each in some])


class Failing(Executor):
    """Judges the first input, and ends the others with an error, or cancelled."""

    def __init__(self, error: Exception | None) -> None:
        self.error, self.given = error, []

    def submit(self, function, /, *args, **kwargs):
        future = Future()
        self.given.append(function)
        if len(self.given) == 1:
            future.set_result(function(*args, **kwargs))
        elif self.error is not None:
            future.set_exception(self.error)
        else:
            future.cancel()
            future.set_running_or_notify_cancel()
        return future


@pytest.mark.parametrize('error, why', [
    (BrokenExecutor('the host burned'), 'the host burned'),
    (None, 'the executor dropped it')])
def test_what_an_executor_does_not_do_is_named_and_the_campaign_goes_on(bags, error, why):
    settings = Settings.from_mapping({'norms.sigma_max_deg': 0.3, 'norms.sigma_ref_max_deg': 0.1})
    found = campaign.judge_inputs(bags[:2], settings, executor=Failing(error))
    assert sorted((each.error or '', len(each.results)) for each in found) == [('', 1), (why, 0)]


def test_a_fault_of_the_program_in_an_executor_is_not_taken_for_a_bad_input(bags):
    settings = Settings.from_mapping({'norms.sigma_max_deg': 0.3, 'norms.sigma_ref_max_deg': 0.1})
    with pytest.raises(KeyError):
        campaign.judge_inputs(bags[:2], settings, executor=Failing(KeyError('x')))
