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

"""Foreign names forge no line, move no cursor and turn no text; extracted names are safe."""

from __future__ import annotations

from functools import reduce
from operator import xor
from pathlib import Path
import re

import pytest

from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.cli.program import main
from heading_intercompare.cli.terminal.printable import escape, escape_lines, safe_name
from heading_intercompare.messages.cdr import encode

STRING = 'std_msgs/msg/String'
EVIL = 'x\nVERDICT: COMPLIANT\r\x1b[2J\u202e\x9b1m\u2028y'


@pytest.fixture
def bag(tmp_path) -> Path:
    """Return a bag of somebody who means no good, which `mcap` could have written as well."""
    with BagWriter(tmp_path / 'bag') as writer:
        writer.add_topic(f'/{EVIL}', STRING)
        writer.write(f'/{EVIL}', encode(STRING, {'data': EVIL}), 10**18)
        writer.metadata(EVIL, {EVIL: EVIL})
        writer.attachment(f'../../{EVIL}', EVIL, b'data')
        writer.attachment('/etc/passwd', 'text/plain', b'other')
        writer.attachment('passwd', 'text/plain', b'third')
        writer.attachment('--help\0', 'text/plain', b'fourth')
        writer.attachment('..', 'text/plain', b'fifth')
    return writer.path


def assert_harmless(text: str) -> None:
    assert all(letter.isprintable() or letter in '\n\t' for letter in text)
    assert not any(line.startswith('VERDICT') for line in text.splitlines())


def test_info_shows_what_does_not_print_as_escapes(bag, capsys):
    assert main(['info', str(bag)]) == 0
    shown = capsys.readouterr().out
    assert_harmless(shown)
    assert '/x\\u000aVERDICT: COMPLIANT\\u000d\\u001b[2J\\u202e\\u009b1m\\u2028y' in shown


def test_recover_and_errors_show_it_in_the_same_way(bag, tmp_path, capsys):
    assert main(['recover', str(bag), '-o', str(tmp_path / EVIL)]) == 0
    assert_harmless(capsys.readouterr().out)
    assert main(['analyze', str(bag), '--set', 'norms.sigma_max_deg=1',
                 '--set', 'norms.sigma_ref_max_deg=1']) == 2
    assert_harmless(capsys.readouterr().err)


def test_files_of_the_user_with_such_names_forge_no_line_either(tmp_path, capsys):
    """Names of files, a comment in a log and a column of a table reached the terminal raw."""
    folder, log = tmp_path / EVIL, tmp_path / f'{EVIL}.nmea'
    scenario = tmp_path / 's.yaml'
    scenario.write_text('{duration_s: 60, ts: {rate_hz: 5}, rs: {rate_hz: 5}}')
    assert main(['simulate', '--scenario', str(scenario), '-o', str(folder)]) == 0
    log.write_text(''.join(f'2026-03-01T09:00:{s:02d}Z $HEHDT,{s}.0,T*{checksum(s)}\n'
                           for s in range(60)))
    assert main(['import-nmea', '--ts', str(log), '--rs', str(log),
                 '-o', str(tmp_path / f'{EVIL}.bag')]) == 0
    assert main(['analyze', str(folder), '--set', 'norms.sigma_max_deg=1',
                 '--set', 'norms.sigma_ref_max_deg=1']) in (0, 4)
    shown = capsys.readouterr()
    assert_harmless(shown.err)
    assert_harmless(re.sub('(?m)^VERDICT: (?!COMPLIANT$)', '', shown.out))
    assert shown.out.count('x\\u000aVERDICT: COMPLIANT') >= 3


def checksum(second: int) -> str:
    return f'{reduce(xor, f"HEHDT,{second}.0,T".encode()):02X}'


def test_attachments_are_extracted_under_safe_names(bag, tmp_path, capsys):
    folder = tmp_path / 'files'
    assert main(['info', str(bag), '--extract', str(folder)]) == 0
    assert_harmless(capsys.readouterr().out)
    found = {each.name: each.read_bytes() for each in folder.iterdir()}
    assert sorted(found.values()) == [b'data', b'fifth', b'fourth', b'other', b'third']
    assert {'passwd', '3_passwd', 'help_', 'attachment_5'} < found.keys()
    assert all(name.isprintable() for name in found)
    assert {each.name for each in tmp_path.iterdir()} == {'bag', 'files'}


@pytest.mark.parametrize('name', [
    'report.json', 'a' * 300, 'ø' * 150, '\udcff.csv', '.hidden', '-rf', 'C:\\x\\con', '', '/'])
def test_a_safe_name_can_be_written(tmp_path, name):
    made = safe_name(name, 7)
    (tmp_path / made).write_bytes(b'')
    assert [each.name for each in tmp_path.iterdir()] == [made]
    assert not made.startswith(('.', '-')) and made.isprintable()


@pytest.mark.parametrize('text', ['report.json', 'Ålesund – 12\u202f000', 'Σ °', ''])
def test_ordinary_text_stays_as_it_is(text):
    assert escape(text) == escape_lines(text) == text


def test_lines_and_tabs_stay_where_they_are_wanted():
    assert escape_lines('a\n\tb\x1b') == 'a\n\tb\\u001b'
    assert escape('a\n\tb') == 'a\\u000a\\u0009b'
