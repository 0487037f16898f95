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

"""The command ``info``: what a file is and holds, whether it is intact, and what to do next."""

from __future__ import annotations

import argparse
import os
from pathlib import Path
import shlex
from typing import Iterator, Mapping, Sequence

from heading_intercompare.bags.errors import BagError, decimal
from heading_intercompare.bags.recording.part_states import read_states, STATES
from heading_intercompare.bags.recording.recorder_losses import (
    count_missing,
    RECORDING,
    tell_missing,
)
from heading_intercompare.bags.rosbag2.bag_check import BagCheck, check_bag
from heading_intercompare.bags.rosbag2.bag_reader import Attachment, BagReader
from heading_intercompare.bags.rosbag2.provenance import (
    find_report,
    is_note,
    read_notes,
    RECORD,
)
from heading_intercompare.bags.rosbag2.readable import Readable
from heading_intercompare.bags.rosbag2.sequence_gaps import Numbering
from heading_intercompare.cli.terminal.console import say_lines, VERDICT_MARKS
from heading_intercompare.cli.terminal.printable import safe_name
from heading_intercompare.cli.terminal.progress import Progress
from heading_intercompare.core.count_words import count_words
from heading_intercompare.core.typed_reader import VerdictError
from heading_intercompare.core.utc_text import utc
from heading_intercompare.journal.journal_file import is_journal, read_journal
from heading_intercompare.messages.sentence_messages import TOPIC_TYPES
from heading_intercompare.readers.registry import (
    find_format,
    find_written,
    Format,
    has_pairs,
    open_recording,
    refuse_unreadable,
)
from heading_intercompare.readers.stream_recording import StreamOptions, StreamRecording
from heading_intercompare.readers.topic_bag import TopicBag
from heading_intercompare.readers.written_files import WrittenFile

from .log_options import add_log_arguments, drivers_for, SHARED_OPTIONS

#: Counts by topic in the record of losses, and the heads of their columns.
_LOSSES = {'received': 'received', 'lost_on_the_way': 'lost on the way',
           'not_written': 'not written'}
#: Values that are not shown: most settings of a scenario are not given.
_ABSENT = ('None', 'none', '')
_REPORT, _RUNS = 'report.json', 'runs.csv'
_DEFAULT_TOPICS = ('ts/heading', 'rs/heading')
#: Highlights on a terminal.
_MARKS = (*VERDICT_MARKS, (r'(?m)^missing: .*$', 'red'),
          (r'(?m)^(?:bag|format|journal|span|software|attachment): ', 'bold'),
          (r'(?m)^topic +type +messages\b.*$', 'bold'), (r'(?m)^complete: (yes)$', 'green'),
          (r'(?m)^complete: (no): ', 'yellow'), (r'(?m)^  every checksum is correct$', 'green'),
          (r'(?m)^  wrong: .*$', 'red'))


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument('bag', metavar='FILE', help='a bag or another file that analyze '
                        'reads, .journal of a live run, or a file that another command wrote')
    parser.add_argument('--plot', metavar='F', help='draw what was read: headings, their '
                        'difference, gaps, and what is rejected by reason: F.png, F.pdf or F.svg')
    for role, words in (('ts', 'tested'), ('rs', 'reference')):
        parser.add_argument(f'--{role}', metavar='NAME',
                            help=f'column, stream or topic of the {words} sensor, if its name '
                            'does not say that it is a heading, or for --plot')
    add_log_arguments(parser, ())
    parser.add_argument('--check', action='store_true', help='read the whole bag: verify '
                        'every checksum, and count the missing sequence numbers of the messages; '
                        'exit code 2 if something is wrong')
    parser.add_argument('--extract', metavar='DIR', help='write the attachments as files: '
                        'verdict, table of runs, parameter file or scenario')


def run(arguments: argparse.Namespace) -> int:
    """Print the contents of the file, and with --check the result of reading it through."""
    _check_plot(arguments)
    if is_journal(arguments.bag):
        return _show_journal(arguments)
    if (written := find_written(arguments.bag)) is not None:
        return _show_written(arguments, written)
    options = StreamOptions(drivers_for(arguments, ())['motion'],
                            tuple(filter(None, (arguments.ts, arguments.rs))))
    form = find_format(arguments.bag, options)
    if form is not None:
        return _show_recording(arguments, form, options)
    refuse_unreadable(arguments.bag)
    checked = None
    if arguments.check:
        with Progress(arguments.bag, arguments.quiet) as progress:
            checked = check_bag(arguments.bag, progress.show)
    reader = TopicBag(arguments.bag)
    attachments = reader.attachments()
    wrong: list[str] = []
    lines = [*_share_missing(reader), *_whole(reader), *_topics(reader, checked), *_notes(reader),
             *_states(reader), *_records(reader.metadata()), *_files(attachments, wrong),
             *_report_verdict(reader, attachments, wrong)]
    if arguments.extract is not None:
        lines += ['', *_extract(attachments, Path(arguments.extract))]
    lines += ['', *_next_steps(arguments, reader)]
    if checked is not None:
        lines += ['', *_report_check(checked)]
    say_lines(lines, _MARKS)
    _plot(arguments, reader)
    if checked is not None and checked.faults:
        wrong += checked.faults
    if wrong:
        raise BagError('; '.join(wrong), arguments.bag)
    return 0


def _show_written(arguments: argparse.Namespace, written: WrittenFile) -> int:
    """Print the contents of a file that this program writes, and what to do with it."""
    from heading_intercompare.app.written_contents import describe_contents
    path = arguments.bag
    _refuse_options(arguments, written.name, 'extract', 'plot')
    say_lines([f'format: {written.name}', *describe_contents(path, written),
               f'to use it: {written.use.format(shlex.quote(path))}'], _MARKS)
    return 0


def _refuse_options(arguments: argparse.Namespace, kind: str, *options: str) -> None:
    for option in options:
        if (value := getattr(arguments, option)) is not None:
            lacking = {'extract': 'attachments', 'plot': 'readings'}[option]
            raise ValueError(f'--{option} {value}: {arguments.bag} is {kind}, which has no '
                             f'{lacking}; leave it out')


def _show_recording(arguments: argparse.Namespace, form: Format, options: StreamOptions) -> int:
    """Print the streams of a recording of another program."""
    _refuse_options(arguments, form.name, 'extract')
    if has_pairs(arguments.bag):
        _refuse_options(arguments, f'{form.name} of pairs', 'plot')
        from heading_intercompare.app.written_contents import describe_pairs
        path = arguments.bag
        say_lines([f'format: {form.name} of pairs', *describe_pairs(path),
                   *_to_judge(arguments, [])], _MARKS)
        return 0
    reader = open_recording(arguments.bag, options=options)
    lines = [f'format: {form.name}', *_whole(reader)]
    if isinstance(reader, StreamRecording):
        lines += [*_streams(reader), '', 'not taken: ' + (', '.join(
            f'{n} {why}' for why, n in reader.not_taken.items()) or 'nothing')]
        if reader.other_columns:
            lines.append(f'other columns: {", ".join(reader.other_columns)}')
    else:
        lines += _topics(reader, None)
    if not isinstance(reader, StreamRecording) and arguments.check:
        n = sum(1 for _ in reader.messages())
        lines += ['', f'check: all {n} messages can be read; this format has no checksums of them']
    say_lines([*lines, '', *_next_steps(arguments, reader)], _MARKS)
    _plot(arguments, reader)
    return 0


def _streams(reader: StreamRecording) -> Iterator[str]:
    """Yield a row for each stream of headings, and a line for each thing told of the motion."""
    rows: list[tuple[str, ...]] = [('stream', 'type', 'headings', 'from', 'to', 'rate [1/s]')]
    for name, headings in sorted(reader.streams.items()):
        kind = reader.topics[name].type_name
        if not len(headings):
            rows.append((name, kind, '0', '-', '-', '-'))
            continue
        begin_ns, end_ns = int(headings.stamp_ns.min()), int(headings.stamp_ns.max())
        span_s = (end_ns - begin_ns) / 1e9
        rows.append((name, kind, str(len(headings)), utc(begin_ns), utc(end_ns),
                     f'{(len(headings) - 1) / span_s:.2f}' if span_s else '-'))
    yield ''
    yield from _columns(rows)
    for what, streams in reader.motion.items():
        yield f'motion: {what} of ' + ', '.join(
            f'{name} ({len(moved)})' for name, moved in streams.items())


def _choose_streams(arguments: argparse.Namespace, reader: Readable) -> list[str]:
    """Return the streams of the TS and of the RS: those given, then the first ones present."""
    if isinstance(reader, StreamRecording):
        present = [name for name, info in sorted(reader.topics.items()) if info.count]
    elif all(reader.find(topic) is not None for topic in _DEFAULT_TOPICS):
        present = [*_DEFAULT_TOPICS]
    else:
        present = [name for name, info in sorted(reader.topics.items())
                   if info.type_name in TOPIC_TYPES]
    present = [name for name in present if name not in (arguments.ts, arguments.rs)]
    names = [stated or (present.pop(0) if present else '')
             for stated in (arguments.ts, arguments.rs)]
    return [*filter(None, names)]


def _next_steps(arguments: argparse.Namespace, reader: Readable) -> Iterator[str]:
    """Yield what to type to judge a recording, and to make a bag of it."""
    names = _choose_streams(arguments, reader)
    if isinstance(reader, StreamRecording) and not names:
        return
    if isinstance(reader, StreamRecording) and len(names) == 1:
        more = ['OTHER_SENSOR']
    elif names == [*_DEFAULT_TOPICS]:
        more = []
    else:
        ts, rs = [*names, *(['TOPIC.FIELD'] * 2)][:2]
        more = ['--ts', ts, '--rs', rs]
    yield from _to_judge(arguments, more)
    if not isinstance(reader, BagReader):
        yield from _to_import(arguments, more)


def _check_plot(arguments: argparse.Namespace) -> None:
    """Reject a picture that cannot be drawn, before any work."""
    if arguments.plot is None:
        return
    from heading_intercompare.report import check_picture
    check_picture(arguments.plot)
    if os.path.realpath(arguments.plot) == os.path.realpath(arguments.bag):
        raise ValueError(f'--plot {arguments.plot}: that is the FILE; name another one')


def _plot(arguments: argparse.Namespace, reader: Readable) -> None:
    """Write the picture of what was read, if it is asked for."""
    if arguments.plot is None:
        return
    from heading_intercompare.app.read_streams import read_streams
    from heading_intercompare.report import write_readings
    names = _choose_streams(arguments, reader)
    if not names:
        raise ValueError(f'--plot {arguments.plot}: {arguments.bag} has no headings that are '
                         'known as such; name a topic or a field with --ts and --rs')
    read = read_streams(reader, names)
    write_readings(arguments.plot, read.streams, read.pairs, read.not_taken)
    say_lines([f'written: {arguments.plot}'])


def _to_judge(arguments: argparse.Namespace, more: Sequence[str]) -> Iterator[str]:
    yield _command('to judge it', 'analyze', arguments, [*more, '--config', 'NORMS.yaml'])


def _to_import(arguments: argparse.Namespace, more: Sequence[str]) -> Iterator[str]:
    yield _command('to make a bag of it', 'import', arguments, [*more, '-o', 'BAG'])


def _command(words: str, name: str, arguments: argparse.Namespace, more: Sequence[str]) -> str:
    """Return a command line for the file, with the options that were given to read it."""
    stated = [word for option in SHARED_OPTIONS
              if (value := getattr(arguments, option, None)) is not None
              for word in (f'--{option.replace("_", "-")}', str(value))]
    return f'{words}: heading-intercompare {shlex.join([name, arguments.bag, *more, *stated])}'


def _show_journal(arguments: argparse.Namespace) -> int:
    """Print the contents of a journal, which always has checksums and no attachment."""
    # Only now: what judges is not loaded to look into a bag.
    from heading_intercompare.core.sensors.pair_names import list_names, TWO
    from heading_intercompare.journal.journal_reading import (
        describe_gaps,
        JournalReader,
        read_origin,
        Unjudged,
    )
    path = Path(arguments.bag)
    _refuse_options(arguments, 'a journal', 'extract', 'plot')
    contents = read_journal(path)
    origin = read_origin(contents, path)
    reader = JournalReader(path, origin.names)
    titles = {name: name.upper() if name in TWO else name for name in list_names(origin.names)}
    judged, trial = reader.read(contents, [Unjudged() for _ in origin.names]), reader.kept
    lines = [f'journal: {path}', f'software: {RECORD} {origin.software}',
             f'begun: {utc(origin.began_ns)} UTC', f'bag: {origin.bag or "-"}',
             f'span: {utc(trial.start_ns)} to {utc(trial.newest_ns)} UTC, {trial.n_pairs} pairs',
             *(['readings after these pairs: ' + ', '.join(
                 f'{trial.n_readings[name]} {title}' for name, title in titles.items())]
               if origin.holds_readings else []),
             f'runs judged before: {judged}',
             'marks:', *(f'  {utc(ns)} UTC  {kind}'
                         for kind, ns in sorted(trial.marks, key=lambda mark: mark[1])),
             'missing:', *(f'  {gap}' for gap in describe_gaps(trial, contents.torn)),
             'settings:', *(f'  {name}: {"none" if value is None else value}'
                            for name, value in origin.settings.items()),
             '', f'to judge it: heading-intercompare analyze {shlex.quote(str(path))}']
    say_lines(lines, _MARKS)
    if arguments.check and contents.torn:
        raise BagError(f'its last {contents.torn} bytes are of a record that was cut', path)
    return 0


def _share_missing(reader: BagReader) -> Iterator[str]:
    """Yield how much of a recording is missing, as far as it says so itself."""
    recovery = reader.metadata().get('recovery', {})
    missing = (reader.missing_messages + count_missing(reader.metadata().get(RECORDING, {}))
               + (decimal(recovery.get('messages_lost', '')) or 0))
    if missing:
        whole = missing + sum(topic.count for topic in reader.topics.values())
        bound = 'at least ' if recovery.get('messages_lost_is') == 'at least' else ''
        share = f'{missing / whole:.0%}' if missing >= whole / 100 else 'under 1%'
        yield f'missing: {bound}{missing:,} of {whole:,} messages ({share})'


def _whole(reader: Readable) -> Iterator[str]:
    yield f'bag: {reader.path}'
    why = '; '.join(filter(None, (reader.incomplete, reader.recovered,
                                  tell_missing(reader.metadata().get(RECORDING, {})))))
    yield f'complete: {f"no: {why}" if why else "yes"}'
    yield from (f'note: {oddity}' for oddity in reader.oddities)
    span_s = _span_s(reader)
    if span_s is None:
        yield 'span: no message'
    else:
        yield (f'span: {utc(reader.start_ns)} to {utc(reader.end_ns)} UTC, '
               f'{span_s:.1f} s')


def _span_s(reader: Readable) -> float | None:
    if reader.start_ns is None or reader.end_ns is None:
        return None
    return (reader.end_ns - reader.start_ns) / 1e9


def _topics(reader: Readable, checked: BagCheck | None) -> Iterator[str]:
    span_s = _span_s(reader)
    rows: list[tuple[str, ...]] = [('topic', 'type', 'messages', 'rate [1/s]')]
    for name, info in sorted(reader.topics.items()):
        rate = f'{(info.count - 1) / span_s:.2f}' if span_s and info.count > 1 else '-'
        rows.append((name, info.type_name or '(without a schema)', str(info.count), rate))
    if checked is not None:
        rows = [(*row, _missing(checked.topics.get(row[0], Numbering())) if at else 'missing')
                for at, row in enumerate(rows)]
    yield ''
    yield from _columns(rows)


def _missing(numbers: Numbering) -> str:
    if not numbers.numbered:
        return '-'
    begin = [f'at {numbers.first}'] if (numbers.first or 0) > 1 else []
    if numbers.restarts:
        begin.append(f'again: {numbers.restarts}')
    return str(numbers.missing) + (f' (numbers begin {", ".join(begin)})' if begin else '')


def _columns(rows: Sequence[Sequence[str]]) -> list[str]:
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    return ['  '.join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip()
            for row in rows]


def _entry(name: str, value: str) -> Iterator[str]:
    """Yield the lines of an entry; a value of several lines goes below its name."""
    lines = value.rstrip('\n').split('\n')
    if len(lines) == 1:
        yield f'  {name}: {value}'
    else:
        yield f'  {name}:'
        yield from (f'    {line}' for line in lines)


def _records(metadata: Mapping[str, Mapping[str, str]]) -> Iterator[str]:
    """Yield the metadata records, ours first and by groups: version, sources, settings."""
    for name, entries in sorted(metadata.items(), key=lambda item: item[0] != RECORD):
        if name in ('rosbag2', STATES) or is_note(name):
            continue
        yield ''
        if name == RECORD:
            yield f'software: {RECORD} {entries.get("version", "(unknown version)")}'
            entries = {key: value for key, value in entries.items() if key != 'version'}
            groups = sorted({key.partition('.')[0] for key in entries if '.' in key})
        else:
            yield f'{name}:'
            entries = {key: value for key, value in entries.items() if value not in _ABSENT}
            groups = []
        if name == RECORDING:
            yield from _losses(entries)
            continue
        for key, value in entries.items():
            if key.partition('.')[0] not in groups:
                yield from _entry(key, value)
        for group in groups:
            yield f'{group}:'
            for key, value in entries.items():
                if key.startswith(f'{group}.'):
                    yield from _entry(key[len(group) + 1:], value)


def _losses(entries: Mapping[str, str]) -> Iterator[str]:
    """Yield the counts of a recorder: its totals, and one row per topic that it received."""
    by_topic: dict[str, dict[str, str]] = {}
    for key, value in entries.items():
        kind, _, topic = key.partition('.')
        if kind in _LOSSES and topic:
            by_topic.setdefault(topic, {})[kind] = value
        else:
            yield from _entry(key, value)
    rows = [(f'  {topic}', *(counts.get(kind, '-') for kind in _LOSSES))
            for topic, counts in by_topic.items()]
    if rows:
        yield from _columns([('  topic', *_LOSSES.values()), *rows])


def _notes(reader: BagReader) -> Iterator[str]:
    notes = read_notes(reader)
    if notes:
        yield ''
        yield "operator's notes:"
        yield from (f'  {utc(note.stamp_ns)} UTC  {note.text}' for note in notes)


def _states(reader: BagReader) -> Iterator[str]:
    """Yield what each part of the graph said of itself at last."""
    states = read_states(reader)
    if states:
        yield ''
        yield 'last state of each part:'
        yield from _columns([(f'  {name}', state) for name, state in states.items()])


def _files(attachments: Sequence[Attachment], wrong: list[str]) -> Iterator[str]:
    """Yield the attachments, with the contents of the verdict and the table of runs."""
    for attachment in attachments:
        yield ''
        yield (f'attachment: {attachment.name} ({attachment.media_type}, '
               f'{len(attachment.data)} bytes)')
        text = attachment.data.decode(errors='replace')
        if attachment.name == _RUNS:
            yield from (f'  {line}' for line in text.splitlines())
        elif attachment.name == _REPORT:
            yield from _verdict(text, f'attachment {attachment.name}', wrong)


def _report_verdict(reader: BagReader, attachments: Sequence[Attachment],
                    wrong: list[str]) -> Iterator[str]:
    """Yield the last published verdict if the recorder ended before it attached one."""
    if all(attachment.name != _REPORT for attachment in attachments):
        report = find_report(reader)
        if report is not None:
            yield ''
            yield f'last report on {report.topic}, {utc(report.log_time_ns)} UTC'
            yield from _verdict(report.text, f'last report on {report.topic}', wrong)


def _verdict(text: str, place: str, wrong: list[str]) -> Iterator[str]:
    """Yield the lines of a verdict; add to `wrong` what contradicts its own figures."""
    # Only now: it loads what judges.
    from heading_intercompare.core.verdict.consistency import ContradictionError
    from heading_intercompare.report.json import parse_any
    try:
        yield from str(parse_any(text)).splitlines()
    except ContradictionError as error:
        wrong.append(f'{place}: {error}')
        yield f'  wrong: {error}'
    except VerdictError as error:
        yield f'  not a verdict that this version can read: {error}'


def _extract(attachments: Sequence[Attachment], folder: Path) -> Iterator[str]:
    """Write the attachments, never over an existing file; yield their paths."""
    folder.mkdir(parents=True, exist_ok=True)
    names: set[str] = set()
    for number, attachment in enumerate(attachments, 1):
        name = safe_name(attachment.name, number)
        # Each file of a bag may have an attachment of this name.
        name = f'{number}_{name}' if name in names else name
        names.add(name)
        place = folder / name
        with place.open('xb') as file:
            file.write(attachment.data)
        yield f'written: {place}'
    if not attachments:
        yield 'written: nothing, the bag has no attachment'


def _report_check(checked: BagCheck) -> Iterator[str]:
    yield (f'check: {checked.messages:,} messages in {checked.chunks:,} chunks of {checked.files} '
           f'file{"s" if checked.files > 1 else ""} read')
    if checked.chunks:
        yield f'  chain: {count_words(checked.chunks, "chunk")}, SHA-256 {checked.chain.sha256}'
    if checked.unprotected:
        yield (f'  {checked.unprotected:,} chunks have no checksum: damage is found only if it '
               'makes them unreadable')
    if checked.unprotected < checked.chunks and not checked.faults:
        yield '  every checksum is correct'
    yield from (f'  {topic}: {count:,} messages lie after one with a later log time'
                for topic, count in sorted(checked.late.items()))
    yield from (f'  wrong: {fault}' for fault in checked.faults)
    if checked.faults:
        yield '  `recover` copies the intact messages into a new bag'
