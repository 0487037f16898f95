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

"""A campaign on a cluster: the same verdict as in one process, and one line for each mistake."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, ExitStack
import csv
import json
import logging
import os
from pathlib import Path
import pickle
import shutil
import signal
import socket
import subprocess
import sys
import time
from typing import Any, Callable, Iterator

import numpy as np
import pytest
from trials import write_headings

from heading_intercompare import analyze_bags, Headings, Settings
from heading_intercompare.app import campaign, job
from heading_intercompare.app.job import Job
from heading_intercompare.cli import main
from heading_intercompare.core.verdict.compare_verdicts import find_differences
from heading_intercompare.report.json import parse

distributed = pytest.importorskip('distributed', reason='distributed is not installed')
threadpoolctl = pytest.importorskip('threadpoolctl', reason='threadpoolctl is not installed')
from heading_intercompare.app import cluster as module  # noqa: E402

pytestmark = pytest.mark.process

S = 1_000_000_000
N = 20_000
NORMS = {'norms.sigma_max_deg': 0.3, 'norms.sigma_ref_max_deg': 0.1, 'risk.min_duration_s': 0.0}
DEADLINE_S = 20.0


def start(workers: int) -> distributed.LocalCluster:
    """Start a scheduler with workers, each a process, on ports of this machine only."""
    return distributed.LocalCluster(
        n_workers=workers, threads_per_worker=1, processes=True, host='127.0.0.1',
        dashboard_address='127.0.0.1:0', scheduler_kwargs={'dashboard': False}, silence_logs=50)


@pytest.fixture(scope='module')
def cluster():
    """Return a cluster with two workers."""
    with start(2) as started:
        yield started


@pytest.fixture
def by_hand(tmp_path):
    """Return the file and the process of a scheduler with a worker, both from the shell."""
    file = tmp_path / 'scheduler.json'
    command = [sys.executable, '-m', 'dask']
    environment = {**os.environ, 'PYTHONPATH': str(Path(module.__file__).parents[2])}
    options = ['--scheduler-file', str(file), '--dashboard-address', '127.0.0.1:0']
    with ExitStack() as ended:
        def begin(*words: str) -> subprocess.Popen:
            process = ended.enter_context(subprocess.Popen(
                [*command, *words, *options], env=environment, stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL))
            ended.callback(process.kill)
            return process

        scheduler = begin('scheduler', '--host', '127.0.0.1', '--port', '0')
        begin('worker', '--no-nanny', '--nthreads', '1', '--local-directory', str(tmp_path))
        eventually(lambda: file.exists() and file.stat().st_size)
        yield file, scheduler


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    """Return a folder with two bags and a csv of the pairs of one."""
    made = tmp_path_factory.mktemp('campaign')
    for number in range(2):
        rng = np.random.default_rng(number)
        stamps = (1_400_000_000 + 5000 * number) * S + np.arange(N) * (S // 10)
        write_headings(made / f'trial_{number}', {
            topic: Headings.of(stamps, 100.0 + error * rng.standard_normal(N))
            for topic, error in (('ts/heading', 0.1), ('rs/heading', 0.0))})
    assert main(['analyze', str(made / 'trial_1'), *norms(), '--csv', str(made / 'p.csv')]) == 0
    return made


@pytest.fixture
def gate(tmp_path):
    """Return a csv that is a named pipe: its reader waits until a test releases it."""
    path = tmp_path / 'gate.csv'
    os.mkfifo(path)
    return path


@pytest.fixture
def processes(monkeypatch):
    """Judge even small inputs in their own processes if there is no cluster."""
    monkeypatch.setattr(campaign, '_WORTH_BYTES', 0)


@pytest.fixture
def beside():
    """Return a thread for what happens while the command is at work."""
    with ThreadPoolExecutor(1) as thread:
        yield thread


def norms() -> list[str]:
    """Return the settings as options."""
    return [word for name, value in NORMS.items() for word in ('--set', f'{name}={value}')]


def analyze(capsys, *arguments: str | Path, code: int = 0) -> tuple[str, str]:
    """Return what `analyze` prints on stdout and on stderr."""
    capsys.readouterr()
    assert main(['analyze', *map(str, arguments), *norms(), '--json', '-']) == code
    return capsys.readouterr()


def refusal(capsys, *arguments: str | Path) -> str:
    """Return the one line with which `analyze` fails."""
    out, err = analyze(capsys, *arguments, code=2)
    assert out == '' and err.count('\n') == 1
    return err


def eventually(condition: Callable[[], Any]) -> Any:
    """Wait until a condition holds, and return its value."""
    deadline = time.monotonic() + DEADLINE_S
    while not (found := condition()):
        assert time.monotonic() < deadline
        time.sleep(0.02)
    return found


@contextmanager
def held(gate: Path) -> Iterator[None]:
    """Hold up the reader of a pipe once there is one; at the end it sees the end of the pipe."""
    def opened() -> int | None:
        try:
            return os.open(gate, os.O_WRONLY | os.O_NONBLOCK)
        except OSError:
            return None
    descriptor = eventually(opened)
    try:
        yield
    finally:
        os.close(descriptor)


def reader(cluster, gate: Path) -> int:
    """Return the process of the worker that reads a pipe."""
    def found() -> int | None:
        for pid in filter(None, (nanny.pid for nanny in cluster.workers.values())):
            if gate in (file.resolve() for file in Path(f'/proc/{pid}/fd').iterdir()):
                return pid
        return None
    return eventually(found)


def test_a_cluster_judges_as_one_process_does_to_the_byte(
        cluster, folder, processes, capsys, monkeypatch, tmp_path):
    monkeypatch.chdir(folder)
    inputs = ['trial_0', str(folder / 'trial_1'), './p.csv']
    report = tmp_path / 'report.html'
    alone, _ = analyze(capsys, *inputs, '--report', report)
    drawn = report.read_text('utf-8')
    shared, said = analyze(capsys, *inputs, '--report', report, '--dask',
                           cluster.scheduler_address)
    assert shared == alone and said == ''
    assert report.read_text('utf-8') == drawn
    assert [run['source'] for run in json.loads(shared)['runs']] == inputs
    assert json.loads(shared)['outcome'] == 'compliant'


@pytest.fixture(scope='module')
def fleet(tmp_path_factory):
    """Return 60 bags of ten minutes, one of them damaged and one without a run."""
    made = tmp_path_factory.mktemp('fleet')
    for number in range(60):
        rng, n = np.random.default_rng(number), 600 if number != 41 else 1
        stamps = (1_400_000_000 + 5000 * number) * S + np.arange(n) * S
        ship_deg = 100.0 + 20.0 * np.sin(np.arange(n) / 60.0)
        write_headings(made / f'trial_{number:02}', {
            topic: Headings.of(stamps, ship_deg + error_deg * rng.standard_normal(n))
            for topic, error_deg in (('ts/heading', 0.1), ('rs/heading', 0.03))})
    (made / 'trial_07' / 'trial_07_0.mcap').write_bytes(b'no bag')
    return made


def judge_fleet(capsys, fleet: Path, *options: str) -> list[str]:
    """Return JSON, table of runs, standard output and notes on all bags."""
    document, table = fleet / 'verdict.json', fleet / 'runs.csv'
    capsys.readouterr()
    assert main(['analyze', *map(str, sorted(fleet.glob('trial_*'))), *norms(), *options,
                 '--json', str(document), '--runs-csv', str(table)]) == 0
    out, said = capsys.readouterr()
    # A cluster also says which of its hosts could not read an input.
    return [text.replace(f' (on {socket.gethostname()})', '') for text in (
        document.read_text('utf-8'), table.read_text('utf-8'), out, said)]


def kill_busy(started: distributed.LocalCluster) -> int:
    """Kill a worker that is at work, and return its process."""
    pids = [worker.pid for worker in started.workers.values()]
    eventually(lambda: started.scheduler.total_occupancy > 0.0)
    os.kill(pids[0], signal.SIGKILL)
    return pids[0]


@pytest.mark.slow
def test_a_fleet_is_one_table_whatever_judges_it(fleet, capsys, beside):
    """Processes, clusters of any size, and a worker that is killed in between: to the byte."""
    alone = judge_fleet(capsys, fleet, '--jobs', '1')
    assert judge_fleet(capsys, fleet, '--jobs', '2') == alone
    with open(fleet / 'runs.csv', newline='', encoding='utf-8') as file:
        recordings = [Path(row['recording']).name for row in csv.DictReader(file)]
    assert sorted(recordings) == [f'trial_{number:02}' for number in range(60)]
    for workers in (1, 2, 4):
        with start(workers) as started:
            killed = beside.submit(kill_busy, started) if workers == 2 else None
            assert judge_fleet(capsys, fleet, '--dask', started.scheduler_address) == alone
            assert killed is None or killed.result(DEADLINE_S)


def test_a_table_of_runs_means_the_inputs_as_they_were_given(
        cluster, folder, processes, capsys, monkeypatch, tmp_path):
    table = tmp_path / 'runs.csv'
    table.write_text('start,stop,source\n'
                     f'{1_400_000_000 * S},{1_400_000_900 * S},trial_0\n'
                     f'{1_400_005_000 * S},{1_400_006_000 * S},./trial_1\n', 'utf-8')
    monkeypatch.chdir(folder)
    arguments = ['trial_0', './trial_1', '--runs', table]
    alone, _ = analyze(capsys, *arguments)
    assert analyze(capsys, *arguments, '--dask', cluster.scheduler_address) == (alone, '')
    assert len(json.loads(alone)['runs']) == 2


def test_a_bad_bag_is_named_with_the_host_that_could_not_read_it(
        cluster, folder, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'bad.mcap').write_bytes(b'no bag')
    out, said = analyze(capsys, 'bad.mcap', folder / 'trial_0', 'nowhere', '--dask',
                        cluster.scheduler_address)
    host = f'(on {socket.gethostname()})'
    assert said == (f'note: bad.mcap: not judged: is not an MCAP file {host}\n'
                    f'note: nowhere: not judged: No such file or directory {host}\n')
    verdict = json.loads(out)
    assert verdict['outcome'] == 'indeterminate'
    assert [given.get('error') for given in verdict['inputs']] == [
        f'is not an MCAP file {host}', None, f'No such file or directory {host}']


def test_an_input_that_was_judged_with_other_libraries_has_a_note(
        cluster, folder, capsys, monkeypatch):
    there = job.describe_libraries()
    monkeypatch.setattr(campaign, 'describe_libraries', lambda: 'numpy 0.9 and scipy 0.1')
    _, said = analyze(capsys, folder / 'trial_0', '--dask', cluster.scheduler_address)
    assert said == (f'note: {folder / "trial_0"}: judged with {there} on {socket.gethostname()}, '
                    'but here are numpy 0.9 and scipy 0.1: last digits may differ\n')


@pytest.mark.parametrize('inputs', [['nowhere'], ['nowhere', 'neither']])
def test_where_no_worker_can_read_anything_one_line_says_so(cluster, inputs, capsys):
    said = refusal(capsys, *inputs, '--dask', cluster.scheduler_address)
    assert f'nowhere: No such file or directory (on {socket.gethostname()})' in said
    assert ('none of the 2 inputs' in said) == (len(inputs) == 2)


def test_what_a_killed_worker_had_is_judged_by_another(
        cluster, folder, gate, processes, capsys, beside):
    def kill() -> None:
        with held(gate):
            pid = reader(cluster, gate)
            gate.unlink()
            for end in ('', '.account.json'):
                shutil.copy(folder / f'p.csv{end}', f'{gate}{end}')
            os.kill(pid, signal.SIGKILL)

    killed = beside.submit(kill)
    out, said = analyze(capsys, gate, folder / 'trial_0', '--dask', cluster.scheduler_address)
    killed.result(DEADLINE_S)
    alone, _ = analyze(capsys, folder / 'p.csv', folder / 'trial_0')
    assert out == alone.replace(str(folder / 'p.csv'), str(gate)) and said == ''


def test_an_input_that_kills_every_worker_is_named(cluster, folder, gate, capsys, beside,
                                                   monkeypatch):
    monkeypatch.setattr(cluster.scheduler, 'allowed_failures', 0)

    def kill() -> None:
        with held(gate):
            os.kill(reader(cluster, gate), signal.SIGKILL)

    killed = beside.submit(kill)
    out, said = analyze(capsys, gate, folder / 'trial_0', '--dask', cluster.scheduler_address)
    killed.result(DEADLINE_S)
    assert said == f'note: {gate}: not judged: the workers that judged it died (out of memory?)\n'
    assert [run['outcome'] for run in json.loads(out)['runs']] == ['compliant']
    assert json.loads(out)['outcome'] == 'indeterminate'


def test_an_interrupt_takes_the_inputs_off_the_cluster(cluster, gate, capsys, beside):
    def interrupt() -> None:
        with held(gate):
            os.kill(os.getpid(), signal.SIGINT)
            eventually(lambda: not cluster.scheduler.tasks)

    interrupted = beside.submit(interrupt)
    out, said = analyze(capsys, gate, '--dask', cluster.scheduler_address, code=130)
    interrupted.result(DEADLINE_S)
    assert (out, said) == ('', '\n')


def test_a_scheduler_by_its_file_and_told_in_one_line_when_it_goes_away(
        by_hand, folder, gate, processes, capsys, beside):
    file, scheduler = by_hand
    inputs = [folder / 'trial_0', folder / 'trial_1']
    alone, _ = analyze(capsys, *inputs)
    assert analyze(capsys, *inputs, '--dask', file) == (alone, '')
    alone, _ = analyze(capsys, inputs[0])
    shared, said = analyze(capsys, inputs[0], '--dask', file)
    # Alone it is judged in this process, where linear algebra may take several threads.
    assert list(find_differences(parse(alone), parse(shared))) == [] and said == ''

    def kill() -> None:
        with held(gate):
            scheduler.kill()
            scheduler.wait(DEADLINE_S)

    killed = beside.submit(kill)
    said = refusal(capsys, gate, '--dask', file)
    killed.result(DEADLINE_S)
    assert f'{gate}: the scheduler or its last worker was lost' in said


def test_a_cluster_that_loses_its_last_worker_is_told_in_one_line(
        gate, capsys, beside, monkeypatch):
    monkeypatch.setattr(module, '_LOOK_S', 0.1)
    monkeypatch.setattr(module, '_DESERTED_S', 0.3)
    with start(1) as small:
        def retire() -> None:
            with held(gate):
                small.scale(0)
                eventually(lambda: not small.scheduler.workers)

        retired = beside.submit(retire)
        said = refusal(capsys, gate, '--dask', small.scheduler_address)
        retired.result(DEADLINE_S)
    assert f'{gate}: the scheduler or its last worker was lost' in said


def test_a_cluster_without_workers_is_refused(folder, capsys, monkeypatch):
    monkeypatch.setattr(module, '_CONNECT_S', 0.5)
    with start(0) as empty:
        said = refusal(capsys, folder / 'trial_0', '--dask', empty.scheduler_address)
    assert f'--dask {empty.scheduler_address}: the scheduler has no workers' in said


@pytest.mark.parametrize('spoil, why', [
    ('version.VERSION = "0.0.9"', 'has 0.0.9'),
    ('import sys; sys.modules["heading_intercompare.app.job"] = None', 'cannot load it')])
def test_a_worker_with_other_software_is_named_before_work_starts(capsys, tmp_path, spoil, why):
    with (start(2) as spoilt,
          distributed.Client(spoilt.scheduler_address, set_as_default=False) as client):
        client.wait_for_workers(2, DEADLINE_S)
        worker = sorted(client.nthreads())[1]
        client.run(exec, f'from heading_intercompare.core import version; {spoil}',
                   workers=[worker])
        said = refusal(capsys, tmp_path / 'nowhere', '--dask', spoilt.scheduler_address)
    here = module.VERSION
    assert f'heading_intercompare is {here} here, but worker {worker} {why}' in said


@pytest.mark.parametrize('address', ['tcp://127.0.0.1:{port}', '127.0.0.1:{port}',
                                     'tcp://127.0.0.1', 'http://127.0.0.1:80', '', 'tcp://a b:1',
                                     'tcp://127.0.0.1:99999999'])
def test_where_no_scheduler_is_one_line_says_so_in_time(folder, capsys, monkeypatch, address):
    monkeypatch.setattr(module, '_CONNECT_S', 0.5)
    with socket.socket() as unused:
        unused.bind(('127.0.0.1', 0))
        address = address.format(port=unused.getsockname()[1])
        said = refusal(capsys, folder / 'trial_0', '--dask', address)
    assert f'--dask {address}: no Dask scheduler answers there' in said


def test_a_worker_is_not_taken_for_a_scheduler(cluster, folder, capsys):
    address = next(iter(cluster.scheduler.workers))
    said = refusal(capsys, folder / 'trial_0', '--dask', address)
    assert f'--dask {address}: no Dask scheduler answers there: a Worker does\n' in said


@pytest.mark.parametrize('words', [b'SSH-2.0-x\r\n', bytes(64), b'', b'\x08' + bytes(15)])
def test_another_program_is_not_taken_for_a_scheduler(
        folder, capsys, caplog, monkeypatch, beside, words):
    monkeypatch.setattr(module, '_CONNECT_S', 0.5)
    with socket.create_server(('127.0.0.1', 0)) as server, ExitStack() as open_till_the_end:
        def greet() -> None:
            open_till_the_end.enter_context(server.accept()[0]).sendall(words)

        address = f'tcp://127.0.0.1:{server.getsockname()[1]}'
        greeted = beside.submit(greet)
        said = refusal(capsys, folder / 'trial_0', '--dask', address)
        greeted.result(DEADLINE_S)
    why = 'another program does' if words else 'not within 0.5 s'
    assert f'--dask {address}: no Dask scheduler answers there: {why}\n' in said
    assert not [each for each in caplog.records if each.levelno == logging.CRITICAL]


def test_a_scheduler_of_another_version_is_refused(cluster, folder, capsys, monkeypatch):
    monkeypatch.setattr(module, 'DISTRIBUTED', '1.0')
    said = refusal(capsys, folder / 'trial_0', '--dask', cluster.scheduler_address)
    assert f'distributed is 1.0 here, but the scheduler has {distributed.__version__}' in said


@pytest.mark.parametrize('text, why', [
    (None, 'No such file'), ('{', 'must be JSON'), ('[]', 'is not the file of a Dask scheduler'),
    ('{"address": 1}', 'is not the file of a Dask scheduler'), ('\udcff', 'must be JSON')])
def test_a_wrong_file_of_a_scheduler_is_named(folder, capsys, tmp_path, text, why):
    file = tmp_path / 'scheduler.json'
    if text is not None:
        file.write_text(text, 'utf-8', 'surrogateescape')
    said = refusal(capsys, folder / 'trial_0', '--dask', file)
    assert str(file) in said and why in said


def test_what_comes_back_of_an_input_does_not_grow_with_its_pairs(folder, tmp_path):
    lines = (folder / 'p.csv').read_text('utf-8').splitlines(keepends=True)
    (tmp_path / 'some.csv').write_text(''.join(lines[:N // 4]), 'utf-8')
    job = Job(Settings.from_mapping(NORMS), None, sketched=True)
    all_of_it, some = (len(pickle.dumps(job.survive(str(path))))
                       for path in (folder / 'p.csv', tmp_path / 'some.csv'))
    # With what the figures of a protocol are drawn from.
    assert all_of_it < 700_000 and all_of_it < 1.2 * some
    plain = Job(Settings.from_mapping(NORMS), None, sketched=False)
    # With a fingerprint of the differences, by which runs that share readings are known.
    assert len(pickle.dumps(plain.survive(str(folder / 'p.csv')))) < 40_000


def test_linear_algebra_has_one_thread_until_the_last_of_several_tasks_is_done():
    def threads() -> set[int]:
        return {library['num_threads'] for library in threadpoolctl.threadpool_info()}

    before = threads()
    one = job._OneThread()
    first, second = ExitStack(), ExitStack()
    first.enter_context(one)
    second.enter_context(one)
    first.close()
    assert threads() == {1}
    second.close()
    assert threads() == before


def sleeping(cluster) -> list[str]:
    """Return the calls of `sleep` that a scheduler knows of."""
    return [str(key) for key in cluster.scheduler.tasks if 'sleep' in str(key)]


def test_the_cluster_is_an_executor_as_any_other(cluster, folder, beside):
    with module.open_cluster(cluster.scheduler_address) as executor:
        assert executor.submit(pow, 2, exp=5).result(DEADLINE_S) == 32
        assert list(executor.map(abs, [-1, 2])) == [1, 2]
        with pytest.raises(ZeroDivisionError):
            executor.submit(divmod, 1, 0).result(DEADLINE_S)
        waits = executor.submit(time.sleep, 3)
        eventually(lambda: sleeping(cluster))
        assert waits.cancel() and waits.cancelled()
        eventually(lambda: not sleeping(cluster))
        settings = Settings.from_mapping(NORMS)
        inputs = [folder / 'trial_0', folder / 'trial_1']
        assert analyze_bags(inputs, settings, executor=executor).to_dict() == analyze_bags(
            inputs, settings, jobs=2).to_dict()
