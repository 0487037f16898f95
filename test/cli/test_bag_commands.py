# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The commands `info` and `recover`."""

from __future__ import annotations

import json

import numpy as np
import pytest

from heading_intercompare import analyze, Headings, Settings
from heading_intercompare.bags.cdr import encode
from heading_intercompare.bags.heading_messages import encode_imu
from heading_intercompare.bags.reader import BagReader
from heading_intercompare.bags.settings import BagSettings
from heading_intercompare.bags.writer import BagWriter, Rows
from heading_intercompare.cli import main

S = 1_000_000_000
T0 = 1_400_000_000 * S


@pytest.fixture
def bag(tmp_path, rng):
    """Return a bag of 2 minutes at 10 Hz, with settings, sources, verdict and table of runs."""
    path = tmp_path / 'trial'
    settings = Settings.from_mapping({'norms.sigma_max_deg': 0.3, 'norms.sigma_ref_max_deg': 0.1})
    stamps = T0 + np.arange(1200) * (S // 10)
    rs = Headings.of(stamps, np.full(1200, 90.0))
    ts = Headings.of(stamps, 90.0 + 0.1 * rng.standard_normal(1200))
    report = json.dumps(analyze(ts, rs, settings).to_dict())
    with BagWriter(path, BagSettings(chunk_bytes=20_000)) as writer:
        writer.metadata('heading_intercompare', {
            'version': '1.2.3', 'source.ts.path': 'gyro.log', 'operator_note': 'calm sea',
            **{f'settings.{k}': v for k, v in settings.to_mapping().items()}})
        for topic, readings in (('/ts/heading', ts), ('/rs/heading', rs)):
            writer.add_topic(topic, 'sensor_msgs/msg/Imu')
            writer.write_rows([Rows(topic, encode_imu(readings, 'x'), stamps)])
        writer.add_topic('/remark', 'std_msgs/msg/String')
        writer.write('/remark', encode('std_msgs/msg/String', {'data': 'x'}), T0)
        writer.attachment('report.json', 'application/json', report.encode())
        writer.attachment('runs.csv', 'text/csv', b'run,start,stop\n1,2,3\n')
    return path


def printed(capsys, *arguments) -> str:
    assert main([str(a) for a in arguments]) == 0
    out, _ = capsys.readouterr()
    return out


def test_info_says_what_a_bag_holds(bag, capsys):
    text = printed(capsys, 'info', bag)
    rows = [line.split() for line in text.splitlines()]
    assert ['complete:', 'yes'] in rows
    assert 'span: 2014-05-13 16:53:20.000 to 2014-05-13 16:55:19.900 UTC, 119.9 s' in text
    assert ['/ts/heading', 'sensor_msgs/msg/Imu', '1200', '10.00'] in rows
    assert ['/remark', 'std_msgs/msg/String', '1', '-'] in rows
    assert ['software:', 'heading_intercompare', '1.2.3'] in rows
    assert ['norms.sigma_max_deg:', '0.3'] in rows and ['model:', 'NN'] in rows
    assert ['ts.path:', 'gyro.log'] in rows and ['operator_note:', 'calm', 'sea'] in rows
    assert '\nVERDICT: ' in text and 'run 1' in text
    assert ['run,start,stop'] in rows and ['1,2,3'] in rows


def test_info_of_an_unfinished_bag_says_so(bag, capsys):
    file = bag / 'trial_0.mcap'
    file.write_bytes(file.read_bytes()[:-3000])
    text = printed(capsys, 'info', bag)
    assert 'complete: no: trial_0.mcap was not closed' in text
    assert '/ts/heading' in text


def test_info_of_a_bag_without_messages(tmp_path, capsys):
    with BagWriter(tmp_path / 'empty'):
        pass
    assert 'span: no message' in printed(capsys, 'info', tmp_path / 'empty')


@pytest.mark.parametrize('report', [b'[]', b'{}', b'nonsense', b'{"outcome": 3}', b'\xff'])
def test_info_survives_a_report_that_is_no_verdict(tmp_path, capsys, report):
    with BagWriter(tmp_path / 'bag') as writer:
        writer.attachment('report.json', 'application/json', report)
    assert 'not a verdict that this version reads' in printed(capsys, 'info', tmp_path / 'bag')


def test_recover_prints_what_was_kept_and_lost(bag, tmp_path, capsys):
    file = bag / 'trial_0.mcap'
    content = bytearray(file.read_bytes())
    content[len(content) // 4] ^= 0x10
    file.write_bytes(content)
    assert main(['recover', str(bag), '-o', str(tmp_path / 'new')]) == 0
    out, err = capsys.readouterr()
    kept = sum(t.count for t in BagReader(tmp_path / 'new').topics.values())
    assert 2200 < kept < 2401
    assert f'kept: {kept} messages' in out
    assert f'lost: {2401 - kept} messages; 1 chunks damaged or cut' in out
    assert f'bag: {tmp_path / "new"}\n' in out
    assert err.startswith('note: trial_0.mcap: bytes ') and err.count('\n') == 1
    text = printed(capsys, 'info', tmp_path / 'new')
    assert 'complete: no: recovered from a damaged bag' in text


def test_recover_of_a_whole_bag_loses_nothing(bag, tmp_path, capsys):
    text = printed(capsys, 'recover', bag, '-o', tmp_path / 'new')
    assert 'lost: nothing\n' in text
    assert 'complete: yes' in printed(capsys, 'info', tmp_path / 'new')


@pytest.mark.parametrize('content', [b'', b'no bag', bytes(100)])
def test_recover_of_what_is_not_readable_is_one_line(tmp_path, capsys, content):
    (tmp_path / 'x.mcap').write_bytes(content)
    assert main(['recover', str(tmp_path / 'x.mcap'), '-o', str(tmp_path / 'new')]) == 2
    out, err = capsys.readouterr()
    assert out == '' and err.count('\n') == 1 and 'nothing in it is readable' in err
    assert not (tmp_path / 'new').exists()


def test_recover_of_what_is_not_there_is_one_line(tmp_path, capsys):
    assert main(['recover', str(tmp_path / 'nowhere'), '-o', str(tmp_path / 'new')]) == 2
    assert 'nowhere: No such file' in capsys.readouterr().err
