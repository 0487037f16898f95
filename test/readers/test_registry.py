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

"""Files of other programs: recognised by content, judged, imported, shown, or refused in words."""

from __future__ import annotations

import gzip
import json
import math
import sqlite3
import sys

from command_line import analyze_json, NORMS, refusal
import numpy as np
import pytest

from heading_intercompare.cli import main
from heading_intercompare.readers import nmea2000
from heading_intercompare.readers.registry import (
    find_format,
    FORMATS,
    open_log_of_streams,
    open_recording,
    refuse_unreadable,
)
from heading_intercompare.readers.stream_recording import ReaderError

S = 1_000_000_000
T0_S = 1_400_000_000
N = 900
QUIET_NORMS = (*NORMS, '--quiet')


def readings():
    """Return the seconds, the TS and the RS headings of 15 minutes at 1 Hz."""
    rng = np.random.default_rng(8)
    ship = 100.0 + 5.0 * np.sin(np.arange(N) / 40.0)
    return range(N), *(ship + sigma * rng.standard_normal(N) for sigma in (0.1, 0.02))


def utc(second):
    """Return a time as ISO text."""
    return f'{np.datetime64(T0_S + second, "s")}.000Z'


def candump(source, second, heading_deg):
    raw = round(math.radians(heading_deg) * 1e4)
    return (f'({T0_S + second}.000000) can0 {2 << 26 | nmea2000.PGN << 8 | source:08X}'
            f'#01{raw.to_bytes(2, "little").hex()}FF7FFF7FFC')


def canboat(source, second, heading_deg):
    raw = round(math.radians(heading_deg) * 1e4)
    return (f'{utc(second)},2,127250,{source},255,8,01,{raw.to_bytes(2, "little").hex(",")},'
            'ff,7f,ff,7f,fc')


def canboat_json(source, second, heading_deg):
    return json.dumps({'timestamp': utc(second), 'src': source, 'pgn': 127250, 'fields': {
        'Heading': round(heading_deg, 4), 'Reference': 'True'}})


def signalk(source, second, heading_deg):
    return json.dumps({'context': 'vessels.self', 'updates': [{
        '$source': f'n2k.{source}', 'timestamp': utc(second), 'values': [
            {'path': 'navigation.headingTrue', 'value': math.radians(heading_deg)}]}]})


def openrvdas(source, second, heading_deg):
    return json.dumps({'data_id': f's{source}', 'timestamp': T0_S + second,
                       'fields': {'HeadingTrue': round(heading_deg, 4)}})


LINES = {
    'NMEA 2000, candump': (candump, '{}'), 'NMEA 2000, canboat': (canboat, '{}'),
    'NMEA 2000, canboat JSON': (canboat_json, '{}'),
    'Signal K deltas': (signalk, 'n2k.{}/headingTrue'),
    'OpenRVDAS records': (openrvdas, 's{}/HeadingTrue'),
}


@pytest.fixture(params=[*LINES, 'csv of headings', 'Parquet'])
def files(request, tmp_path):
    """Return a format, a file of both sensors, one of each, and the names of the streams."""
    form, (seconds, ts, rs) = request.param, readings()
    paths = [tmp_path / f'{name}.dat' for name in ('both', 'ts', 'rs')]
    names = ['TsHeading', 'RsHeading']
    if form == 'csv of headings':
        rows = [f'{utc(i)},{a:.4f},{b:.4f}' for i, a, b in zip(seconds, ts, rs)]
        for path, use in zip(paths, ([0, 1, 2], [0, 1], [0, 2])):
            paths_rows = [','.join([*('time', *names)][at] for at in use)]
            paths_rows += [','.join(row.split(',')[at] for at in use) for row in rows]
            path.write_text('\n'.join(paths_rows) + '\n')
    elif form == 'Parquet':
        pyarrow = pytest.importorskip('pyarrow', reason='pyarrow is not installed')
        parquet = pytest.importorskip('pyarrow.parquet')
        columns = {'t_ns': (T0_S + np.arange(N)) * S, 'TsHeading': ts, 'RsHeading': rs}
        for path, use in zip(paths, (columns, ['t_ns', 'TsHeading'], ['t_ns', 'RsHeading'])):
            parquet.write_table(pyarrow.table({name: columns[name] for name in use}), path)
    else:
        line, name = LINES[form]
        names = [name.format(source) for source in (35, 36)]
        of = [[line(source, i, x) for i, x in zip(seconds, column)]
              for source, column in ((35, ts), (36, rs))]
        paths[0].write_text('\n'.join(one for both in zip(*of) for one in both) + '\n')
        for path, rows in zip(paths[1:], of):
            path.write_text('\n'.join(rows) + '\n')
    return form, paths, names


def test_a_file_of_both_sensors_and_two_files_give_the_same_run(files, capsys):
    form, (both, ts, rs), names = files
    assert find_format(both).name == form
    _, ts_deg, rs_deg = readings()
    of_both, _ = analyze_json(capsys, both, '--ts', names[0], '--rs', names[1])
    of_two, notes = analyze_json(capsys, ts, rs)
    run, = of_both['runs']
    assert (run['n'], of_both['outcome']) == (N, 'compliant')
    # The digits of the forms: 1e-4 rad are 0.006 degrees.
    assert run['variance_deg2'] == pytest.approx(np.var(ts_deg - rs_deg, ddof=1), rel=3e-3)
    other, = of_two['runs']
    assert {**other, 'source': run['source']} == run
    assert [one['ts_topic'] or one['rs_topic'] for one in of_two['inputs']] == names
    assert notes[0].startswith(f'note: tested sensor (TS): {ts}, {N} headings of {names[0]}')


def test_one_stream_of_several_is_chosen_by_its_name(files, capsys, tmp_path):
    _, (both, ts, rs), names = files
    problem = refusal(capsys, 'analyze', both, rs, *QUIET_NORMS)
    assert problem.startswith(f'{both}: has 2 streams: ') and '--ts-talker' in problem
    assert all(name in problem for name in names)
    of_two, _ = analyze_json(capsys, both, rs, '--ts-talker', names[0])
    assert of_two['runs'][0]['n'] == N
    problem = refusal(capsys, 'analyze', both, *QUIET_NORMS)
    assert problem.startswith(f"{both}: has no stream 'ts/heading'; it has ")
    assert main(['import-nmea', '--ts', str(both), '--ts-talker', names[0], '--rs', str(rs), '-o',
                 str(tmp_path / 'bag'), '--quiet']) == 0
    of_bag, _ = analyze_json(capsys, tmp_path / 'bag')
    assert of_bag['runs'][0]['n'] == N


@pytest.mark.parametrize('sides', [False, True])
def test_an_import_gives_the_verdict_of_its_input(files, capsys, tmp_path, sides):
    _, (both, ts, rs), names = files
    inputs = [ts, rs] if sides else [both, '--ts', names[0], '--rs', names[1]]
    assert main(['import', *map(str, inputs), '-o', str(tmp_path / 'bag'), '--quiet']) == 0
    out = capsys.readouterr().out
    assert f': {N} headings on ts/heading' in out and f': {N} headings on rs/heading' in out
    of_input, _ = analyze_json(capsys, *inputs)
    of_bag, _ = analyze_json(capsys, tmp_path / 'bag')
    assert of_bag['headline'] == of_input['headline']
    (run,), (run_of_input,) = of_bag['runs'], of_input['runs']
    assert run['n'] == run_of_input['n'] == N
    for name in ('variance_deg2', 'mean_deg', 'max_deg'):
        assert run[name] == pytest.approx(run_of_input[name], rel=1e-9, abs=1e-11), name


def test_info_shows_the_streams(files, capsys):
    form, (both, _, _), names = files
    assert main(['info', str(both)]) == 0
    out = capsys.readouterr().out
    assert out.startswith(f'format: {form}\n') and 'not taken: nothing' in out
    assert all(f'{name} ' in out for name in names) and out.count(f' {N} ') == 2
    assert f'--extract x: {both} is {form}' in refusal(capsys, 'info', both, '--extract', 'x')


def split(path, folder, after_s):
    """Write the lines of a file as two files, the later one under the earlier name."""
    head, *rows = path.read_text().splitlines(keepends=True)
    if not head.startswith('time'):
        rows, head = [head, *rows], ''
    folder.mkdir()
    later = len(rows) * after_s // N
    (folder / 'part 2.txt').write_text(head + ''.join(rows[:later]))
    (folder / 'part 1.txt').write_text(head + ''.join(rows[later:]))
    return folder


def test_a_folder_of_files_of_one_form_is_one_recording(files, capsys, tmp_path):
    """Hourly files of other programs were refused: holds no .mcap file."""
    form, (both, ts, rs), names = files
    if form == 'Parquet':
        pytest.skip('no lines')
    whole, _ = analyze_json(capsys, both, '--ts', names[0], '--rs', names[1])
    folder = split(both, tmp_path / 'hours', 400)
    (folder / 'readme').write_text('of the ship\n')
    for given in (folder, folder / 'part*.txt'):
        assert find_format(given).name == form
        found, notes = analyze_json(capsys, given, '--ts', names[0], '--rs', names[1])
        run, of_whole = found['runs'][0], whole['runs'][0]
        assert {**run, 'source': of_whole['source']} == of_whole
        assert found['inputs'][0]['sha256'] != whole['inputs'][0]['sha256']
        assert ('not taken: 1 file_of_another_form' in ''.join(notes)) is (given == folder)
    sides = [split(path, tmp_path / path.stem, 300) for path in (ts, rs)]
    of_two, _ = analyze_json(capsys, *sides)
    assert of_two['runs'][0]['variance_deg2'] == of_whole['variance_deg2']
    assert main(['import-nmea', '--ts', str(folder), '--ts-talker', names[0], '--rs', str(rs),
                 '-o', str(tmp_path / 'bag'), '--quiet']) == 0
    capsys.readouterr()
    assert main(['info', str(folder)]) == 0
    assert capsys.readouterr().out.count(f' {N} ') == 2


def test_a_folder_of_two_forms_is_refused_and_one_of_a_bag_is_a_bag(tmp_path, capsys):
    (tmp_path / 'a.txt').write_text(openrvdas(35, 0, 1.0) + '\n')
    (tmp_path / 'b.txt').write_text(candump(35, 0, 1.0) + '\n')
    said = refusal(capsys, 'analyze', tmp_path, *QUIET_NORMS)
    assert said.startswith(
        f'{tmp_path}: holds OpenRVDAS records ({tmp_path}/a.txt) and NMEA 2000, candump '
        f'({tmp_path}/b.txt): give the files of one form')
    (tmp_path / 'metadata.yaml').write_text('x: 1\n')
    assert find_format(tmp_path) is None


def test_two_recordings_of_both_sensors_are_a_campaign(tmp_path, capsys):
    seconds, ts, rs = readings()
    paths = [tmp_path / 'a.log', tmp_path / 'b.log']
    for path, late in zip(paths, (0, 10_000)):
        path.write_text(''.join(f'{candump(source, i + late, x)}\n' for i, a, b in zip(
            seconds, ts, rs) for source, x in ((35, a), (36, b))))
    verdict, _ = analyze_json(capsys, *paths, '--ts', '35', '--rs', '36')
    assert [run['source'] for run in verdict['runs']] == [str(path) for path in paths]


def test_what_is_not_taken_is_noted(tmp_path, capsys):
    seconds, ts, rs = readings()
    path = tmp_path / 'a.log'
    path.write_text(''.join(f'{candump(source, i, x)}\n' for i, a, b in zip(seconds, ts, rs)
                            for source, x in ((35, a), (36, b)))
                    + candump(35, 0, 0).replace('#010000', '#01FFFF') + '\n')
    verdict, notes = analyze_json(capsys, path, '--ts', '35', '--rs', '36')
    assert notes[0].endswith('not taken: 1 empty_heading')
    assert 'not taken: 1 empty_heading' in verdict['inputs'][0]['ledger_problems'][0]


def test_a_log_of_sentences_is_no_recording_but_can_be_shown(tmp_path, capsys):
    path = tmp_path / 'gyro.log'
    path.write_text('2014-08-01T00:00:00Z $HEHDT,12.5,T*1A\n2014-08-01T00:00:01Z $HEHDT,12.6,T\n')
    assert open_log_of_streams(path) is None
    assert main(['info', str(path)]) == 0
    assert 'format: log of one sensor' in capsys.readouterr().out
    assert 'give two logs' in refusal(capsys, 'analyze', path, *QUIET_NORMS)


def write_sqlite(path):
    """Write an SQLite file that is no bag."""
    connection = sqlite3.connect(path)
    connection.execute('CREATE TABLE runs (n INTEGER)')
    connection.commit()
    connection.close()


REFUSED = {
    'a.rbin': (b'1234', 'is a binary file of UHDAS: write it as csv'),
    'a.bag': (b'#ROSBAG V1.2\n', 'convert it with `rosbag migrate`'),
    'a.xlsx': (b'PK\x03\x04', 'is a spreadsheet: save it as csv'),
    'a.zip': (b'PK\x03\x04', 'is compressed: unpack it'),
    'a.log.gz': (gzip.compress(b'x'), 'is compressed: unpack it'),
    'a.db3.zstd': (b'\x28\xb5\x2f\xfd', 'give the folder with its metadata.yaml'),
    'a.nc': (b'\x89HDF\r\n', 'is HDF5 or netCDF: write it as csv'),
    'a.nc3': (b'CDF\x01', 'is netCDF'), 'a.mat': (b'MATLAB 5.0', 'is a file of MATLAB'),
    'a.pcap': (b'\xd4\xc3\xb2\xa1', 'is a capture of network packets'),
    'a.pcapng': (b'\x0a\x0d\x0d\x0a', 'is a capture of network packets'),
    'a.blf': (b'LOGG', 'convert it to the form of `candump -l`'),
    'a.EBL': (b'\x1b\x01', 'convert it with canboat'),
    'a.all': (b'\x10\0\0\0\x02I', 'Kongsberg SIS: write'), 'a.kmall': (b'\0\2\0\0#IIP', 'SIS'),
    'a.tar.xz': (b'\xfd7zXZ\0', 'is compressed'), 'a.bz2': (b'BZh9', 'is compressed'),
    'a.7z': (b'7z\xbc\xaf', 'is compressed'), 'a.xls': (b'\xd0\xcf', 'is a spreadsheet'),
    'a.ods': (b'PK\x03\x04', 'is a spreadsheet'),
    'b.pcap': (b'\x4d\x3c\xb2\xa1', 'is a capture of network packets'),
    'a.ubx': (b'\xb5b\x01\x07', 'is a binary log of u-blox'), 'a.sbf': (b'$@\x01', 'Septentrio'),
    'a.gps': (b'\xaa\x44\x12\x1c', 'is a binary log of NovAtel'),
    'a.gpx': (b'<?xml version="1.0"?>', 'is XML or HTML, such as GPX: write it as csv'),
    'a.pdf': (b'%PDF-1.7', 'is a PDF'), 'a.asc': (b'date Mon', 'is a CAN log of Vector'),
    'a.dat': (b'\nno recording at all\n', "it begins with 'no recording at all'. A log has"),
    'a.log': (b'{"a": 1}\n', 'it begins with \'{"a": 1}\'. A log has'),
    'a.txt': (b'x' * 200, f"it begins with '{'x' * 80}...'. A log has"),
    'a.bin': (bytes(range(1, 9)) * 9, 'it begins with the bytes 01 02 03 04 05 06 07 08 01 02'),
    'a.sqlite': (None, 'is an SQLite file without the tables of a rosbag2'),
}


@pytest.mark.parametrize('name', REFUSED)
def test_what_cannot_be_read_says_how_to_convert_it(tmp_path, capsys, name):
    path = tmp_path / name
    data, problem = REFUSED[name]
    if data is None:
        write_sqlite(path)
    else:
        path.write_bytes(data)
    for command in (['analyze', path, *QUIET_NORMS], ['info', path],
                    ['import-nmea', '--ts', path, '--rs', path, '-o', tmp_path / 'b']):
        said = refusal(capsys, *command)
        assert said.startswith(f'{path}: ') and problem in said


@pytest.mark.parametrize('name, data', [
    ('a.dat', b''), ('a.dat', bytes(9)), ('a.dat', b'\x89MCAP0\r\n'), ('a.mcap', b'no bag\n'),
    ('a.mcap.active', b'no bag\n')])
def test_bags_are_left_to_the_reader_of_bags(tmp_path, name, data):
    path = tmp_path / name
    path.write_bytes(data)
    assert find_format(path) is None
    refuse_unreadable(path)


def test_a_bag_is_no_log(tmp_path):
    path = tmp_path / 'a.bag'
    path.write_bytes(b'#ROSBAG V2.0\n')
    with pytest.raises(ReaderError, match='is a bag .ROS 1 bag., no log: give it to analyze'):
        open_log_of_streams(path)


@pytest.mark.parametrize('library, module, data', [
    ('rosbags', 'rosbag_recording', b'#ROSBAG V2.0\n'), ('pyarrow', 'parquet', b'PAR1')])
def test_a_library_that_is_not_installed_is_named_with_its_extra(
        tmp_path, capsys, monkeypatch, library, module, data):
    for name in [*sys.modules]:
        if name.partition('.')[0] == library or name.endswith(f'readers.{module}'):
            monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, library, None)
    path = tmp_path / 'a.dat'
    path.write_bytes(data)
    form = find_format(path)
    for command in (['analyze', path, *QUIET_NORMS], ['info', path]):
        assert refusal(capsys, *command) == (
            f'{path}: is {form.name}, and reading it needs {library}: install '
            f'heading_intercompare[{form.extra}]')


def test_each_format_has_a_name_of_its_own():
    assert len({form.name for form in FORMATS}) == len(FORMATS)


def test_a_directory_without_a_bag_keeps_its_error(tmp_path):
    with pytest.raises(ValueError, match='holds no .mcap file'):
        open_recording(tmp_path)
