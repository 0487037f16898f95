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

"""The files that this program writes or asks for: how each begins, and what to do with it."""

from __future__ import annotations

from dataclasses import dataclass
import re
from typing import Callable

_NAMES = re.compile(rb'[a-z_]+')
_SQLITE_APPLICATION = slice(68, 72)
_PAGE = re.compile(rb'<title>(?:Intercomparison of (?:\d+ )?heading sensors|'
                   rb'Heading sensors over time)|content="heading-intercompare')


@dataclass(frozen=True, slots=True)
class WrittenFile:
    """
    A kind of file that holds no recording.

    Attributes
    ----------
    name
        What it is, in words.
    recognise
        Tells from the name of the file, in lower case, and its first 64 KiB whether it is one.
    use
        What to do with it; ``{}`` stands for its path.
    contents : {'', 'verdict', 'table', 'pairs', 'logbook', 'parameters'}
        What can be shown of it.

    """

    name: str
    recognise: Callable[[str, bytes], bool]
    use: str
    contents: str = ''


def _of_schema(*kinds: str) -> Callable[[str, bytes], bool]:
    form = re.compile(rb'\s*\{\s*"schema":\s*"heading_intercompare/(?:%s)/'
                      % '|'.join(kinds).encode())
    return lambda name, head: form.match(head) is not None


def _begins(*starts: str) -> Callable[[str, bytes], bool]:
    """Tell whether the text of a file begins so, with or without a byte order mark."""
    bytes_of = tuple(start.encode() for start in starts)
    return lambda name, head: head.removeprefix(b'\xef\xbb\xbf').startswith(bytes_of)


def _has_header(*headers: str) -> Callable[[str, bytes], bool]:
    """Tell whether the first line of a file is one of some, with or without blanks."""
    return lambda name, head: b''.join(
        head.removeprefix(b'\xef\xbb\xbf').partition(b'\n')[0].split()).decode(
            errors='replace') in headers


def _of_yaml(*words: bytes) -> Callable[[str, bytes], bool]:
    """Tell whether a file of YAML has a line that begins with each of some words."""
    forms = [re.compile(rb'^\s*' + word, re.MULTILINE) for word in words]
    return lambda name, head: (name.endswith(('.yaml', '.yml'))
                               and all(form.search(head) for form in forms))


def _is_page(name: str, head: bytes) -> bool:
    return head.startswith(b'<!DOCTYPE html>') and bool(_PAGE.search(head))


def is_of_pairs(head: bytes) -> bool:
    """Tell whether a csv that begins so has a column of the TS and one of the RS."""
    return {b'ts_deg', b'rs_deg'} <= {*_NAMES.findall(head[:1 << 12].replace(b'\0', b''))}


_ANALYZE = 'heading-intercompare analyze'

WRITTEN_FILES = (
    WrittenFile('a verdict', _of_schema('verdict', 'sensors'),
                'heading-intercompare report {} -o protocol.html', 'verdict'),
    WrittenFile('the account of a csv of pairs', _of_schema('pairs_account'),
                f'{_ANALYZE} reads it with the csv beside it'),
    WrittenFile('the result of observe', _of_schema('observations'),
                'it is for other programs; heading-intercompare observe judges again'),
    WrittenFile('the result of rejudge', _of_schema('rejudge'),
                'it is for other programs; heading-intercompare rejudge judges again'),
    WrittenFile('the result of history', _of_schema('history'),
                'it is for other programs; heading-intercompare history reads the logbooks'),
    WrittenFile('the result of plan', _begins('{\n  "levels": '),
                'it is for other programs; heading-intercompare plan makes it again'),
    WrittenFile('the JSON Schema of verdicts',
                lambda name, head: b'"urn:heading_intercompare:verdict' in head,
                'a validator of JSON Schema checks verdicts by it'),
    WrittenFile('a table of the runs of a verdict',
                _begins('recording,run,start_utc', 'sensor,recording,run,start_utc'),
                f'it is for spreadsheets; {_ANALYZE} judges the recordings that it names',
                'table'),
    WrittenFile('a table of the runs of logbooks', _begins('ship,start_ns,end_ns'),
                'it is for spreadsheets; heading-intercompare history reads the logbooks',
                'table'),
    WrittenFile('a table of corrections of the heading', _begins('ship,settings_sha256,start_utc'),
                'it is for survey programs; heading-intercompare history reads the logbooks',
                'table'),
    WrittenFile('a correction card', _begins('heading_deg,c_minus_o_deg'),
                f'it is for the bridge; {_ANALYZE} judges the recordings that it names', 'table'),
    WrittenFile('a table of ensembles, as ens_hcorr.asc of UHDAS has them',
                _has_header('dday,mean_hdg,last_hdg,mean_dh,std_dh,num,badflag'),
                'it is for the processing of current profilers; its days have no year, so give '
                f'the recording that it was made of to {_ANALYZE}', 'table'),
    WrittenFile('a table of corrections of ensembles', _begins('dday,utc,mean_hdg,correction'),
                'it is for current profilers and survey programs; give the recording that it was '
                f'made of to {_ANALYZE}', 'table'),
    WrittenFile('a csv of pairs', lambda name, head: (not head.startswith(b'{')
                                                      and is_of_pairs(head.splitlines()[0])),
                f'{_ANALYZE} {{}} --config NORMS.yaml', 'pairs'),
    WrittenFile('a table of runs', _has_header('start,stop', 'start,stop,source'),
                f'{_ANALYZE} RECORDING --runs {{}}', 'table'),
    WrittenFile('a table of stretches to take out', _has_header('start,end,reason'),
                f'{_ANALYZE} RECORDING --exclude {{}}', 'table'),
    WrittenFile('a parameter file', _of_yaml(b'ros__parameters:'),
                f'{_ANALYZE} RECORDING --config {{}}', 'parameters'),
    WrittenFile('a scenario', _of_yaml(b'duration_s:'),
                'heading-intercompare simulate --scenario {} -o BAG'),
    WrittenFile('the list of the files of a bag', _of_yaml(b'rosbag2_bagfile_information:'),
                'give the folder that it is in'),
    WrittenFile('a logbook', lambda name, head: (head.startswith(b'SQLite format 3\0')
                                                 and head[_SQLITE_APPLICATION] == b'HILB'),
                'heading-intercompare history {}', 'logbook'),
    WrittenFile('a journal of a live run', _begins('heading_intercompare journal '),
                f'{_ANALYZE} {{}}'),
    WrittenFile('a Digital Calibration Certificate',
                lambda name, head: b'<dcc:digitalCalibrationCertificate' in head,
                'it is for other programs, such as PyDCC; the verdict in JSON has all figures'),
    WrittenFile('a signature', _begins('-----BEGIN SSH SIGNATURE-----'),
                'heading-intercompare verify, with the name of the file without .sig, checks it'),
    WrittenFile('a page of this program', _is_page,
        'open it in a browser; for the figures, give the verdict in JSON'),
)
"""The files that this program writes; the first that recognises a file names it."""


def find_written_file(name: str, head: bytes) -> WrittenFile | None:
    """Return what a file that this program writes is, by its name and how it begins."""
    return next((written for written in WRITTEN_FILES if head
                 and written.recognise(name.lower(), head)), None)
