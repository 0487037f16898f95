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

"""The deviation of a compass: what a table gives to magnetic headings, and what is refused."""

from __future__ import annotations

from checksums import with_checksum
import pytest

from heading_intercompare.cli.program import main
from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.drivers.nmea import NmeaDecoder
from heading_intercompare.drivers.own_sentence import read_own_sentence
from heading_intercompare.drivers.sentences import heading_of, Rejected
from heading_intercompare.drivers.settings import DriverSettings

TABLE = '0 1; 90 -2; 180 -1; 270 2E'


@pytest.mark.parametrize('text, heading_deg', [
    ('HCHDM,0.0,M', 1.0), ('HCHDM,90.0,M', 88.0), ('HCHDM,270.0,M', 272.0),
    # Halfway between two rows; also from the last to the first.
    ('HCHDM,45.0,M', 44.5), ('HCHDM,315.0,M', 316.5), ('HCHDM,359.9,M', 0.9 + 0.1 / 90.0),
    ('VDVHW,,T,90.0,M,5.2,N,9.6,K', 88.0), ('VDVHW,90.0,T,91.0,M,5.2,N,9.6,K', 90.0),
    # An HDG that has its own deviation keeps it, be it 0.
    ('HCHDG,90.0,,,,', 88.0), ('HCHDG,90.0,3.0,E,,', 93.0), ('HCHDG,90.0,0.0,E,,', 90.0),
    ('HEHDT,90.0,T', 90.0)])
def test_a_table_turns_a_compass_heading_into_a_magnetic_one(text, heading_deg):
    """E is added: magnetic = compass + deviation. Between rows the deviation is a line."""
    compass = DriverSettings(variation_deg=0.0, deviation_table=TABLE).compass
    assert heading_of(text.encode(), compass) == pytest.approx(heading_deg, abs=1e-9)


def test_deviation_and_variation_add_up():
    compass = DriverSettings(variation_deg=-2.5, deviation_table=TABLE).compass
    assert heading_of(b'HCHDM,90.0,M', compass) == 85.5
    assert heading_of(b'HCHDG,90.0,,,1.0,E', compass) == 89.0
    own = read_own_sentence('PXYZ heading=1 north=magnetic')
    assert heading_of(b'PXYZ,90.0', compass, own) == 85.5


def test_a_table_without_a_variation_makes_no_heading_true():
    compass = DriverSettings(deviation_table=TABLE).compass
    with pytest.raises(Rejected, match='no_variation'):
        heading_of(b'HCHDM,90.0,M', compass)


@pytest.mark.parametrize('text', [
    'heading_deg,deviation_deg\n0,1\n90,-2\n180,-1\n270,2\n',
    '# swung in May\r\n0 1E\r\n\r\n90 2W  # again\r\n180 1w\r\n270 2\r\n',
    '\ufeffHeading, Deviation\n270,2\n180,-1\n90,-2\n0,1\n360,1\n'])
def test_a_file_gives_the_same_rows(text, tmp_path):
    path = tmp_path / 'card.csv'
    path.write_text(text, encoding='utf-8')
    settings = DriverSettings(variation_deg=0.0, deviation_table=f'file:{path}')
    assert settings.compass == DriverSettings(variation_deg=0.0, deviation_table=TABLE).compass
    # What is kept of the settings has the rows, whatever becomes of the file.
    assert '90' in str(settings.deviation_table) and 'file' not in str(settings.deviation_table)


@pytest.mark.parametrize('text, says', [
    ('heading,deviation\n0,1\n90,x\n', 'line 3 (90,x): must be a heading'),
    ('# card\n\n0 1\n90 -2W\n', 'line 4 (90 -2W): give a sign'), ('# card\n', 'no row'),
    ('deviation,heading\n0,1\n', 'line 1 (deviation,heading): must be')])
def test_a_mistake_in_a_file_is_named_by_its_line(text, says, tmp_path):
    (tmp_path / 'card.csv').write_text(text)
    with pytest.raises(SettingsError, match='card.csv') as caught:
        DriverSettings(deviation_table=f'file:{tmp_path}/card.csv')
    assert says in str(caught.value)


@pytest.mark.parametrize('text, says', [
    ('', 'no row'), ('0', 'row 1 (0): must be a heading and its deviation'),
    ('0 1; 90', 'row 2 (90)'), ('0 1 2; 90 1', 'row 1'), ('0 x', 'row 1'),
    ('361 1', '0 to 360'), ('0 91', '-90 to 90'), ('0 -2W', 'a sign, or E or W'),
    ('0 1; 0 2', 'another deviation'), ('0 1; 360 2', 'another deviation'),
    ('0 1', 'no row from 0 to 0'), ('0 1; 90 1; 180 1', 'no row from 180 to 0'),
    ('10 1; 110 1; 200 1; 290 1', 'no row from 10 to 110'), ('file:/no/such', 'No such file')])
def test_a_table_that_is_wrong_or_half_is_refused(text, says):
    with pytest.raises(SettingsError, match='deviation_table = ') as caught:
        DriverSettings(deviation_table=text)
    assert says in str(caught.value) and '\n' not in str(caught.value)


def test_a_live_line_and_an_import_take_the_table(tmp_path, capsys):
    settings = DriverSettings(variation_deg=1.0, deviation_table=TABLE, learn_s=0.0)
    sentence = with_checksum('HCHDM,90.0,M')
    assert NmeaDecoder(settings).feed(f'{sentence}\n'.encode(), 1).heading_deg.tolist() == [89.0]
    log = tmp_path / 'a.log'
    log.write_text(''.join(f'2026-03-01T12:00:{k:02d}Z {sentence}\n' for k in range(20)))
    command = ['import-nmea', '--ts', str(log), '--rs', str(log), '--variation-deg', '1']
    assert main([*command, '-o', str(tmp_path / 'bag'), '--deviation-table', TABLE]) == 0
    assert main([*command, '-o', str(tmp_path / 'b2'), '--deviation-table', '0 1']) == 2
    assert "deviation_table = '0 1': no row from 0 to 0" in capsys.readouterr().err
