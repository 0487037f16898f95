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

"""Why a log gave no heading: its first refused line, what was recognised in it, what to set."""

from __future__ import annotations

import dataclasses
import os
import re
from typing import Mapping

from .csv_log import CsvDecoder, is_csv_file, open_csv
from .framing import split
from .log_lines.days import Days
from .log_lines.line_stamps import LineStamps
from .log_lines.log_files import head_of
from .log_lines.log_order import open_log
from .nmea import NmeaDecoder
from .sentence_choice import choose_naming
from .sentences import Rejected
from .settings import DriverSettings, SENTENCES

ROLE_SETTINGS = ('sentence', 'own_sentence', 'talker', 'instrument')
"""Settings that choose the lines of one sensor; each sensor has options of its own for them."""

_LONGEST_SHOWN = 160
_OTHERS = ('other_talker', 'other_sentence', 'other_instrument')
#: Reasons that a wrong number of a field gives.
_OF_FIELDS = ('bad_field', 'empty_heading', 'invalid_quality', 'out_of_range', 'too_few_fields')
_LEAST = ('not_heading', 'no_sentence')

#: Reason -> what to set, with the names of settings between backticks.
_ADVICE = {
    'no_stamp': 'if the sentences tell the time (ZDA, RMC, GGA, PASHR, GPS weeks), set `time` to '
                'validity; if the stamp has another form, describe it with `stamp_pattern`',
    'bad_stamp': 'if the zone of the stamps is named, state it with `stamp_zone`; if day or month '
                 'come first, set `stamp_format` to dmy or mdy; otherwise describe the stamp with '
                 '`stamp_pattern`',
    'ambiguous_date': 'no date of the log says whether the day or the month comes first: set '
                      '`stamp_format` to dmy or mdy',
    'no_date': 'the stamps have no date: set `date` to that of the first line, YYYY-MM-DD',
    'burst': 'one stamp stands for many lines: set `bursts` to accept to take it for all of them, '
             'or `time` to validity if the sentences tell the time',
    'no_checksum': 'set `checksum` to if_present to take sentences without one',
    'bad_checksum': 'the lines are damaged; look at the line and the converter that wrote it',
    'no_validity_time': 'no ZDA, RMC or GGA with a date tells the time before the sentence: set '
                        '`time` to receipt if the lines have stamps, or `date` for times without '
                        'one',
    'bad_time': 'the time in ZDA, RMC or GGA is unreadable: set `time` to receipt if the lines '
                'have stamps, or `date` for times without one',
    'no_variation': 'the heading is magnetic: state the variation with `variation_deg`, positive '
                    'to the east, or choose another sentence with `sentence`',
    'other_talker': 'choose another talker with `talker`',
    'other_sentence': 'choose another kind of sentence with `sentence`',
    'other_instrument': 'choose another word of the line with `instrument`',
    'not_heading': f'a heading sentence is one of {", ".join(SENTENCES)}; describe another one '
                   'with `own_sentence`, or give another log',
    'no_sentence': 'a line needs a sentence that begins with $ or !, or a log of a receiver with '
                   '# or %; give another log',
}
_OTHER_ADVICE = 'the sensor sends no valid heading; choose another sentence with `sentence`'


def advise(reason: str) -> str:
    """Return what to set for a reason to refuse lines; settings stand between backticks."""
    return _ADVICE.get(reason.partition('.')[0], _OTHER_ADVICE)


def name_options(text: str, role: str | None) -> str:
    """Replace names of settings between backticks by the options of the command line."""
    def option(match: re.Match[str]) -> str:
        prefix = f'{role or "ts"}-' if match[1] in ROLE_SETTINGS else ''
        return f'--{prefix}{match[1].replace("_", "-")}'
    return re.sub('`([a-z_]+)`', option, text)


def explain_no_heading(path: str, settings: DriverSettings, counts: Mapping[str, int]) -> str:
    """
    Return why a log gave no heading, in one line.

    Parameters
    ----------
    path
        The log: a file, a folder, a pattern.
    settings
        How it was read.
    counts
        Lines that gave no heading, by reason.

    Returns
    -------
    str
        The first line refused for the chief reason, what was recognised in it, and what to set;
        names of settings stand between backticks.

    """
    reason = _chief_reason(counts)
    if reason is None:
        return 'it has no line'
    line, of_csv = _first_line(path, settings, reason)
    shown = _show(line)
    advice = advise(reason)
    if settings.own_sentence is not None and reason in _OF_FIELDS:
        advice = ('correct the numbers of fields in `own_sentence`: the field up to the first '
                  'comma has number 0')
    if of_csv:
        advice = 'correct the file, or choose another source with `talker`'
    recognised = 'a row of a csv of headings' if of_csv else _recognise(line, settings)
    return (f'first refused line: {shown!r}; recognised in it: {recognised}; '
            f'refused as {reason}; {advice}')


def describe_start(path: str) -> str:
    """Return in words how a file that holds no sentence begins; empty for what is no text."""
    if not os.path.isfile(path):
        return ''
    head = head_of(path)
    if not head:
        return 'it is empty'
    if b'\0' in head:
        return ''
    line = head.lstrip().partition(b'\n')[0]
    return (f'first refused line: {_show(line)!r}; recognised in it: '
            f'{_recognise(line, DriverSettings())}; {_ADVICE["no_sentence"]}')


def _show(line: bytes) -> str:
    """Return a line as one can print it, shortened."""
    shown = line.decode('ascii', 'replace').strip()
    if len(shown) > _LONGEST_SHOWN:
        shown = shown[:_LONGEST_SHOWN] + '...'
    return ''.join(c if c.isprintable() else '?' for c in shown)


def _chief_reason(counts: Mapping[str, int]) -> str | None:
    """Return the commonest reason, first of the reasons that concern the sentences to read."""
    def rank(reason: str) -> tuple[bool, bool, int]:
        first = reason.partition('.')[0]
        return first in _LEAST, first in _OTHERS, -counts[reason]
    reasons = sorted((reason for reason in counts if counts[reason]), key=rank)
    return reasons[0] if reasons else None


def _first_line(path: str, settings: DriverSettings, reason: str) -> tuple[bytes, bool]:
    """Return the first line that was counted for a reason, and whether it is of a csv."""
    files = open_csv(path, settings) or open_log(path, settings)
    csv = CsvDecoder(files.paths[0], settings) if is_csv_file(files.paths[0]) else None
    decoder = csv or NmeaDecoder(dataclasses.replace(settings, source=f'file:{path}'), files)
    line = b''
    for begins, line in files.lines():
        if csv is not None and begins not in (None, files.paths[0]):
            csv.begin_file(begins)
        decoder.feed(line, None)
        if decoder.counts.get(reason):
            break
    return line, csv is not None


def _recognise(line: bytes, settings: DriverSettings) -> str:
    """Return the stamp and the sentence that a line holds, in words."""
    prefix, text, suffix = split(line) or (line, b'', b'')
    tried = dataclasses.replace(settings, stamp_format='auto', stamp_pattern=None)
    stamps = LineStamps(tried, Days(settings.date))
    try:
        stamp = ('a stamp of the form ' + stamps.form
                 if stamps.own_ns(prefix, suffix) is not None else 'no stamp')
    except Rejected as rejected:
        stamp = {'ambiguous_date': 'a date with day or month first',
                 'no_date': 'a time of day without a date'}.get(
                     rejected.reason, 'a stamp that no instant has, or whose zone is unknown')
    if not text:
        return f'{stamp}, no sentence'
    name = choose_naming(settings)(text)
    kind = text.split(b',')[0].decode('ascii', 'replace')[:20]
    return f'{stamp}, the sentence {kind}' + ('' if name else ', which gives no heading')
