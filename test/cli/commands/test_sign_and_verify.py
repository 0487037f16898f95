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

"""The commands `sign` and `verify`, and who signed a verdict on page one of its protocol."""

from __future__ import annotations

import json
import os
import shutil
import subprocess

from bags.chained_bags import CHANGES, write as write_bag
from command_line import NORMS, refusal
import numpy as np
import pytest

from heading_intercompare.bags.rosbag2.bag_chain import read_chain
from heading_intercompare.cli import main

pytestmark = [pytest.mark.process, pytest.mark.skipif(
    shutil.which('ssh-keygen') is None, reason='OpenSSH is not installed')]


@pytest.fixture
def place(tmp_path, monkeypatch, rng):
    """Return a folder with a csv of pairs, its verdict, a key, and a list with its owner."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv('HOME', str(tmp_path))
    subprocess.run(['ssh-keygen', '-q', '-t', 'ed25519', '-N', '', '-f', 'key'], check=True)
    (tmp_path / 'signers').write_text(f'mate@ship {(tmp_path / "key.pub").read_text()}')
    rows = [f'{1_400_000_000 + i},{100.0 + x:.6f},100.0'
            for i, x in enumerate(0.1 * rng.standard_normal(600))]
    (tmp_path / 'pairs.csv').write_text('\n'.join(['stamp_s,ts_deg,rs_deg', *rows]) + '\n')
    assert main(['analyze', 'pairs.csv', *NORMS, '--json', 'v.json', '--quiet']) == 0
    return tmp_path


def said(capsys, *arguments):
    """Return the exit code of a command and what it prints."""
    capsys.readouterr()
    code = main([*arguments])
    return code, capsys.readouterr().out


def signature_on(page):
    """Return what page one says of the signature."""
    _, _, rest = page.read_text('utf-8').partition('electronic signature</th><td>')
    return rest.partition('</td>')[0]


def test_sign_and_verify_say_who_signed_and_whether_the_inputs_are_those_judged(place, capsys):
    assert said(capsys, 'verify', 'v.json') == (
        3, 'v.json: not signed, for there is no v.json.sig\n'
        '  input pairs.csv: holds the data that were judged\n')
    assert said(capsys, 'sign', 'v.json', '--key', 'key') == (0, 'signature: v.json.sig\n')
    code, out = said(capsys, 'verify', 'v.json')
    assert code == 3 and out.startswith('v.json: signed with an unknown key SHA256:')
    code, out = said(capsys, 'verify', 'v.json', 'v.json.sig', '--signers', 'signers')
    assert code == 0 and out.startswith('v.json: signed by mate@ship (SHA256:')
    assert out.endswith('\n  input pairs.csv: holds the data that were judged\n')
    (place / '.ssh').mkdir()
    shutil.copy(place / 'signers', place / '.ssh' / 'allowed_signers')
    assert said(capsys, 'verify', 'v.json') == (0, out)


@pytest.mark.parametrize('change, code, line', [
    (lambda place: (place / 'pairs.csv').write_text(
        (place / 'pairs.csv').read_text().replace('100.0\n', '100.1\n', 1)), 1,
     '  input pairs.csv: holds other data than those that were judged (SHA-256 '),
    (lambda place: (place / 'pairs.csv').unlink(), 0,
     '  input pairs.csv: not at hand, so it is not checked'),
    (lambda place: (place / 'v.json').write_text(
        (place / 'v.json').read_text().replace('"n": 600', '"n": 601')), 1,
     'v.json: changed, or not the file that v.json.sig signs: ')])
def test_each_change_of_a_signed_verdict_or_its_input_is_said(place, capsys, change, code, line):
    assert main(['sign', 'v.json', '--key', 'key']) == 0
    change(place)
    ended, out = said(capsys, 'verify', 'v.json', '--signers', 'signers')
    assert ended == code and any(text.startswith(line) for text in out.splitlines())


def test_a_signed_verdict_of_an_older_rule_is_verified_as_it_stands(place, capsys):
    verdict = json.loads((place / 'v.json').read_text())
    verdict['software']['version'], verdict['campaign']['reason'] = '0.0.9', 'older words'
    (place / 'v.json').write_text(json.dumps(verdict))
    assert 'made by version 0.0.9' in refusal(capsys, 'verify', 'v.json')
    assert main(['sign', 'v.json', '--key', 'key']) == 0
    code, out = said(capsys, 'verify', 'v.json', '--signers', 'signers')
    assert code == 0 and out.endswith('input pairs.csv: holds the data that were judged\n')


@pytest.mark.parametrize('endless', ['/dev/zero', 'pipe'])
def test_a_stated_input_that_has_no_end_is_not_read(place, capsys, endless):
    pytest.importorskip('matplotlib')
    os.mkfifo('pipe')
    verdict = json.loads((place / 'v.json').read_text())
    verdict['inputs'][0]['path'] = endless
    (place / 'v.json').write_text(json.dumps(verdict))
    code, out = said(capsys, 'verify', 'v.json')
    assert code == 3 and f'input {endless}: not at hand, so it is not checked' in out
    assert main(['report', 'v.json', '-o', 'p.html', '--quiet']) == 0
    assert f'its input {endless} is neither there nor beside' in capsys.readouterr().err


def leave_files(path, n):
    """Remove all but the first `n` files."""
    for file in sorted(path.glob('*.mcap'))[n:]:
        file.unlink()


@pytest.mark.parametrize('change, code, line', [
    (lambda path: None, 3, 'holds the first 9 chunks that the live verdict names, unchanged'),
    (lambda path: leave_files(path, 2), 3, 'holds the first 9 chunks that the live verdict '
     'names, unchanged'),
    *((change, 1, 'does not hold: its first 9 chunks are not those that the live verdict names. ')
      for change in CHANGES),
    (lambda path: (path / 'bag_1.mcap').unlink(), 1,
     'does not hold: its first 9 chunks are not those that the live verdict names. '),
    (lambda path: leave_files(path, 1), 1,
     'does not hold: it holds 5 chunks, fewer than the 9 chunks that the live verdict names. '),
    (lambda path: leave_files(path, 0), 1, 'cannot be read: bag: holds no .mcap file '),
    (shutil.rmtree, 3, 'not at hand, so it is not checked')])
def test_verify_says_whether_a_bag_begins_with_the_chunks_of_a_live_verdict(
        place, capsys, change, code, line):
    path, _ = write_bag(place / 'bag')
    chain = read_chain(path, 9)
    verdict = json.loads((place / 'v.json').read_text())
    verdict['operator_actions'] = [{'stamp_ns': 1, 'text': 'compliance: start'}]
    verdict['recordings'] = [{'path': 'bag', 'chunks': chain.chunks, 'sha256': chain.sha256}]
    (place / 'live.json').write_text(json.dumps(verdict))
    change(path)
    ended, out = said(capsys, 'verify', 'live.json')
    assert ended == code and out.splitlines()[2].startswith(f'  recording bag: {line}')


def test_page_one_says_who_signed_the_verdict_and_refuses_a_changed_one(place, capsys):
    pytest.importorskip('matplotlib')
    page = place / 'p.html'
    assert main(['report', 'v.json', '-o', 'p.html', '--quiet']) == 0
    assert signature_on(page) == 'not signed'
    assert main(['sign', 'v.json', '--key', 'key']) == 0
    assert main(['report', 'v.json', '-o', 'p.html', '--quiet']) == 0
    assert signature_on(page).startswith('the verdict is signed with an unknown key SHA256:')
    assert main(['report', 'v.json', '-o', 'p.html', '--signers', 'signers', '--quiet']) == 0
    words = signature_on(page)
    assert words.startswith('the verdict is signed by mate@ship (SHA256:')
    assert words.endswith('), unchanged')
    verdict = json.loads((place / 'v.json').read_text())
    (place / 'v.json').write_text(json.dumps(verdict, indent=2))
    page.unlink()
    assert refusal(capsys, 'report', 'v.json', '-o', 'p.html').startswith(
        'v.json: changed, or not the file that v.json.sig signs: ')
    assert not page.exists()


@pytest.mark.slow
@pytest.mark.parametrize('verdict', [('-o', 'w.json'), ('--json', 'w.json')])
def test_analyze_signs_what_it_writes_and_says_so_on_page_one(place, capsys, verdict):
    pytest.importorskip('matplotlib')
    assert main(['analyze', 'pairs.csv', *NORMS, '-o', 'p.html', *verdict, '--sign', 'key',
                 '--signers', 'signers', '--quiet']) == 0
    assert signature_on(place / 'p.html').startswith('the verdict is signed by mate@ship (SHA256:')
    assert said(capsys, 'verify', 'w.json', 'p.html', '--signers', 'signers')[0] == 0


@pytest.mark.slow
def test_the_overview_of_several_sensors_says_who_signed_it(place):
    pytest.importorskip('matplotlib')
    stamps = 1_400_000_000 + np.arange(600)
    for name, sd_deg in (('gyro', 0.1), ('aux', 0.1), ('gnss', 0.05)):
        noise = sd_deg * np.random.default_rng(len(name)).standard_normal(600)
        (place / f'{name}.csv').write_text('stamp_s,heading_deg\n' + ''.join(
            f'{stamp},{100.0 + 5.0 * np.sin(at / 30.0) + noise[at]:.4f}\n'
            for at, stamp in enumerate(stamps)))
    sensors = 'gyro sigma_max_deg=0.3; aux sigma_max_deg=0.3; gnss sigma_max_deg=0.1 rs'
    assert main(['analyze', 'gyro=gyro.csv', 'aux=aux.csv', 'gnss=gnss.csv', '--set',
                 f'sensors={sensors}', '-o', 's.json', '-o', 's.html', '--sign', 'key',
                 '--signers', 'signers', '--quiet']) == 0
    assert 'Electronic signature: the verdict is signed by mate@ship' in (
        place / 's.html').read_text('utf-8')
    assert signature_on(place / 's-gyro.html').startswith('the verdict is signed by mate@ship')


@pytest.mark.parametrize('arguments, line', [
    (['analyze', 'pairs.csv', *NORMS, '--sign', 'key'],
     '--sign key: signs the verdict in JSON and the protocols made from it; add -o F.json'),
    (['analyze', 'pairs.csv', *NORMS, '--sign', 'none', '--json', 'w.json'],
     '--sign none: no such file; name the file of an ssh key, or make one with ssh-keygen -t '
     'ed25519'),
    (['analyze', 'pairs.csv', *NORMS, '--signers', 'signers'],
     '--signers signers: names the signer of a verdict; give one in JSON as the INPUT, or add '
     '--sign KEY'),
    (['report', 'v.json', '-o', 'w.json', '--sign', 'key'],
     'v.json: is a verdict, which is judged by its own settings; leave out --sign key'),
    (['report', 'v.json', '-o', 'w.xml'],
     'w.xml: a certificate names its laboratory, customer, person and item; set '
     'trial.laboratory, trial.customer, trial.operator, trial.ts_serial'),
    (['verify', 'v.json', '--signers', 'none'], 'none: No such file or directory'),
    (['verify', 'none'], 'none: No such file or directory'),
    (['sign', 'none', '--key', 'key'], 'none: No such file or directory'),
    (['sign', 'v.json.sig', '--key', 'key'],
     'v.json.sig: is a signature; give the file that it signs')])
def test_what_cannot_be_signed_or_verified_is_refused_in_one_line(place, capsys, arguments, line):
    assert refusal(capsys, *arguments) == line
    assert not (place / 'w.json').exists()
