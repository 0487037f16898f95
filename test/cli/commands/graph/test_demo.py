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

"""The demo and the live graph in one process: live, replayed and offline verdicts agree."""

from __future__ import annotations

import gc
from pathlib import Path
import re
import shlex
import sys

from checksums import with_checksum
import pytest

from heading_intercompare.app.config import LIVE
from heading_intercompare.cli import main
from heading_intercompare.core.verdict.compare_verdicts import find_differences
from heading_intercompare.report.json import parse, read

pytest.importorskip('rclpy')
pytest.importorskip('jinja2')
pytest.importorskip('matplotlib')

from heading_intercompare.report import html  # noqa: E402

TUTORIALS = Path(__file__).resolve().parents[4] / 'docs' / 'tutorials'
NORMS = 'norms: {sigma_max_deg: 0.2, sigma_ref_max_deg: 0.1, m_low: 0.9}'


@pytest.mark.slow
def test_live_replayed_and_offline_agree_on_simulated_sensors(tmp_path, capfd):
    out = tmp_path / 'out'
    for _ in range(2):
        assert main(['demo', '--out', str(out), '--duration', '120', '--speed', '60']) == 0
        text = capfd.readouterr().out
        assert 'verdicts agree: 1199 pairs' in text and 'VERDICT: ' in text
        *lines, page, protocol = text.splitlines()
        assert len(lines) < 20
        assert page.startswith('live page: heading-intercompare demo --web --speed 10; ')
        assert protocol == f'protocol: open {(out / "report.html").as_uri()} in a browser'
    (report,) = (out / 'live').glob('verdict_*.json')
    assert read(report).runs[0].n == 1199
    # What a node has reported becomes a protocol.
    page = tmp_path / 'live.html'
    assert main(['report', str(report), '-o', str(page)]) == 0
    assert capfd.readouterr().out == f'{read(report)}\n'
    assert page.read_text('utf-8') == html.render(read(report))


@pytest.mark.slow
@pytest.mark.endurance
def test_the_demo_of_four_sensors_ends_with_the_protocol_and_the_page(tmp_path, capfd):
    out = tmp_path / 'out'
    assert main(['demo', '--sensors', '--out', str(out), '--duration', '200', '--speed',
                 '60']) == 0
    text = capfd.readouterr().out
    assert 'VERDICT on 4 sensors: ' in text and 'replayed and offline verdicts agree: ' in text
    assert 'who is wrong: ' in text
    *_, page, protocol = text.splitlines()
    assert protocol == f'protocol: open {(out / "report.html").as_uri()} in a browser'
    assert 'heading-intercompare demo --sensors --web' in page
    assert {path.name for path in out.glob('report*')} == {
        'report.html', 'report-gyro1.html', 'report-gyro2.html', 'report-ins.html'}


@pytest.mark.slow
def test_the_demo_without_the_libraries_of_the_protocol_leaves_it_out(tmp_path, capfd,
                                                                      monkeypatch):
    monkeypatch.delitem(sys.modules, 'heading_intercompare.report.html')
    monkeypatch.delattr('heading_intercompare.report.html')
    monkeypatch.setitem(sys.modules, 'jinja2', None)
    out = tmp_path / 'out'
    assert main(['demo', '--out', str(out), '--duration', '120', '--speed', '60']) == 0
    said = [line for line in capfd.readouterr().out.splitlines() if line.startswith('protocol: ')]
    assert len(said) == 1 and said[0].startswith('protocol: left out: ')
    assert "pip install 'heading_intercompare[report]'" in said[0]
    assert (out / 'offline.json').is_file() and not (out / 'report.html').exists()


@pytest.mark.parametrize('speed', ['inf', '-1', '50'])
def test_the_demo_removes_only_what_a_demo_made(tmp_path, capfd, speed):
    (tmp_path / 'bag').mkdir()
    (tmp_path / 'bag' / 'mine').write_text('precious')
    assert main(['demo', '--out', str(tmp_path), '--speed', speed]) == 2
    error = capfd.readouterr().err
    assert error.count('\n') == 1
    assert ('--speed' if speed != '50' else 'bag exists and was not made by a demo') in error
    assert (tmp_path / 'bag' / 'mine').read_text() == 'precious'


@pytest.mark.slow
@pytest.mark.parametrize('ts, rs, n', [
    ('nbp1406/NBP1406_gyr1-2014-08-01', 'nbp1406/NBP1406_s330-2014-08-01', 625),
    pytest.param('lmg1903/LMG1903_lgyr.d085', 'lmg1903/LMG1903_lsep.d085', 999,
                 marks=pytest.mark.endurance)], ids=['nbp', 'lmg'])
def test_real_logs_played_live_give_the_verdict_of_their_import(ts, rs, n, shared_data, tmp_path,
                                                                capfd):
    config = tmp_path / 'config.yaml'
    config.write_text('\n'.join([
        '/**:', '  ros__parameters:', f'    {NORMS}',
        *(f'{role}_driver:\n  ros__parameters:\n    source: file:{shared_data / log}\n'
          '    speed: 60' for role, log in (('ts', ts), ('rs', rs)))]) + '\n')
    live, bag, imported = (str(tmp_path / name) for name in ('live.json', 'bag', 'imported'))
    assert main(['live', '--config', str(config), '-o', bag, '--json', live]) == 0
    assert main(['import-nmea', '--ts', str(shared_data / ts), '--rs', str(shared_data / rs),
                 '-o', imported]) == 0
    capfd.readouterr()
    verdicts = [read(live)]
    looks = ['--set', *(f'{name}={value}' for name, value in LIVE.items())]
    for path, judged_as in ((bag, []), (imported, looks)):
        assert main(['analyze', path, '--config', str(config), *judged_as, '--json', '-']) == 0
        verdicts.append(parse(capfd.readouterr().out))
    assert sum(run.n for run in verdicts[0].runs) == n
    assert [run.motion.kind for run in verdicts[0].runs] == ['agrees']
    for other in verdicts[1:]:
        assert list(find_differences(verdicts[0], other)) == []


def log(path, first_s):
    """Write a log of 300 HDT sentences, 5 per second; return its source."""
    lines = []
    for i in range(300):
        body = f'HEHDT,{90.0 + 0.02 * (i * 7 % 11):.2f},T'
        minutes, seconds = divmod(first_s + i / 5, 60)
        lines.append(f'2014-08-01T00:{minutes:02.0f}:{seconds:09.6f}Z {with_checksum(body)}\n')
    path.write_text(''.join(lines))
    return f'file:{path}'


@pytest.mark.slow
@pytest.mark.parametrize('page', ['live_graph', 'bridge'])
def test_the_tutorials_of_the_live_graph_run_as_printed(page, tmp_path, capfd, monkeypatch):
    """With logs in place of the sensors of a ship."""
    if page == 'bridge':
        pytest.importorskip('nicegui')
    monkeypatch.chdir(tmp_path)
    text = (TUTORIALS / 'live_graph.md').read_text('utf-8')
    settings, = re.findall(r'^```yaml\n# my\.yaml\n(.*?)^```', text, re.MULTILINE | re.DOTALL)
    settings, n = re.subn(r"'(?:udp|serial):.*?'", lambda match: repr(log(
        tmp_path / ('ts.log' if 'udp' in match[0] else 'rs.log'),
        0.0 if 'udp' in match[0] else 0.05)) + ', speed: 50', settings)
    assert n == 2
    (tmp_path / 'my.yaml').write_text(settings + 'dashboard: {ros__parameters: {port: 0}}\n')
    command, = re.findall(r'^heading-intercompare (live --config .*)$',
                          (TUTORIALS / f'{page}.md').read_text('utf-8'), re.MULTILINE)
    assert main(shlex.split(command)) == 0
    heard = capfd.readouterr()
    assert 'INDETERMINATE' in heard.out and ('http://127.0.0.1:' in heard.err + heard.out) == (
        page == 'bridge')
    assert main(['info', 'trial_1']) == 0 and 'complete: yes' in capfd.readouterr().out


@pytest.mark.parametrize('text, words', [
    ('ts_driver: {ros__parameters: {topic: gyro}}', "section 'ts_driver': source is missing"),
    ('motion_driver: {ros__parameters: {speed: 1.0}}',
     "section 'motion_driver': source is missing"),
    ('ts_driver: {ros__parameters: {source: "ftp://x"}}\n'
     'rs_driver: {ros__parameters: {source: "udp://:1"}}', 'must be file:PATH'),
    ('ts_driver: {ros__parameters: {source: "file:nowhere.log"}}\n'
     'rs_driver: {ros__parameters: {source: "file:nowhere.log"}}', 'nowhere.log: No such file'),
    ('ts_driver: {ros__parameters: {source: "udp://:1", spead: 3}}\n'
     'rs_driver: {ros__parameters: {source: "udp://:1"}}', "did you mean 'speed'"),
    ('ts_driver: {ros__parameters: {source: "udp://:1"}}\n'
     'rs_driver: {ros__parameters: {source: "udp://:1"}}\n'
     'synchronizer: {ros__parameters: {end_weight_s: 1}}', "did you mean 'end_wait_s'")])
def test_a_wrong_source_is_named(text, words, tmp_path, capfd):
    config = tmp_path / 'config.yaml'
    config.write_text(f'/**: {{ros__parameters: {{{NORMS}}}}}\n' + text.replace('{}', ''))
    assert main(['live', '--config', str(config), '-o', str(tmp_path / 'bag')]) == 2
    # A file that is left open is an error.
    gc.collect()
    *notes, error = capfd.readouterr().err.splitlines()
    assert error.startswith('heading-intercompare: error: ') and words in error
    assert all('a run must last 10 min to comply' in note for note in notes)


def test_live_needs_norms_and_nothing_else(capfd, tmp_path, monkeypatch):
    """Without drivers it listens to topics, and says to which, until it is interrupted."""
    assert main(['live']) == 2
    assert 'norms.sigma_max_deg is missing' in capfd.readouterr().err
    asked = []
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr('heading_intercompare.nodes.graph.intercompare',
                        lambda sources, settings, **kwargs: asked.append((sources, settings)))
    monkeypatch.setattr('heading_intercompare.cli.commands.graph.live.conclude', lambda *_: 0)
    assert main(['live', '--ts', '/gyro/imu', '--set', 'norms.sigma_max_deg=0.2',
                 '--set', 'norms.sigma_ref_max_deg=0.1']) == 0
    (sources, settings), = asked
    assert sources == [] and settings['ts_topic'] == '/gyro/imu'
    assert 'listening to /gyro/imu and rs/heading; Ctrl-C' in capfd.readouterr().err


def test_a_bag_that_is_not_there_cannot_be_replayed(capfd):
    assert main(['replay', 'nowhere']) == 2
    error = capfd.readouterr().err
    assert 'nowhere' in error and error.count('\n') == 1
