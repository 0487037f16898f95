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

"""The command ``analyze``, in short ``report``: the verdict on recorded runs, the protocol."""

from __future__ import annotations

import argparse
from concurrent.futures import Executor
from contextlib import ExitStack, nullcontext
from dataclasses import replace
import os
import sys
from typing import ContextManager, Mapping, Sequence

from heading_intercompare.app.analysis import judge_bags, Judgement
from heading_intercompare.app.config import choose_pair, Config, settings_for
from heading_intercompare.app.inputs import load_config_or_journal, options_of
from heading_intercompare.app.logs.trial_logs import find_logs, judge_logs, name_logs, ROLES
from heading_intercompare.app.outputs import check_outputs, open_tables, Outputs
from heading_intercompare.app.recorded_looks import find_looks
from heading_intercompare.app.rejudge import confirm_verdict
from heading_intercompare.app.run_table import read_exclusion_table
from heading_intercompare.app.signatures.ssh_signature import find_key, find_signers, sign_file
from heading_intercompare.app.signatures.verification import with_signature
from heading_intercompare.cli.terminal.campaign_table import campaign_lines, is_campaign
from heading_intercompare.cli.terminal.console import (
    find_width,
    say,
    say_lines,
    tell,
    VERDICT_MARKS,
)
from heading_intercompare.cli.terminal.progress import Progress
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.sensor_table import read_sensors
from heading_intercompare.core.sensors.compared_sensors import pair_with_reference
from heading_intercompare.core.sensors.pair_settings import check_norms, settings_of_pair
from heading_intercompare.core.sensors.sensors_verdict import SensorsVerdict
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.validity.condition import is_doubtful
from heading_intercompare.core.verdict.verdict_document import Verdict
from heading_intercompare.core.verdict.verdict_table import verdict_text
from heading_intercompare.drivers.settings import DriverSettings
from heading_intercompare.logbook.logbook_file import Logbook
from heading_intercompare.logbook.run_row import make_rows
from heading_intercompare.readers.registry import has_one_sensor, has_streams, is_verdict
from heading_intercompare.report import check_form, is_protocol, json, SeriesSketch
from heading_intercompare.report.correction_card import check_card, write_card
from heading_intercompare.report.json import NOT_JUDGED
from heading_intercompare.report.runs_csv import write_runs
from heading_intercompare.report.sensors_report import sensor_path, write_protocols

from .log_options import (
    add_log_arguments,
    add_unit_arguments,
    drivers_for,
    LOG_OPTIONS,
    OF_TABLES,
)
from .verify import add_signers_argument

_CHECK_CODES = {Outcome.COMPLIANT: 0, Outcome.NON_COMPLIANT: 1, Outcome.INDETERMINATE: 3}
_DOUBTFUL_CODE = 4
_OF_PAIRS = 'csv', 'ensembles', 'corrections'
_OF_TESTED = *_OF_PAIRS, 'runs_csv', 'card'
_OF_TWO = 'is for two sensors; choose them with --ts NAME --rs NAME'
#: Options of a verdict in JSON as the INPUT; the others need readings, which it lacks.
_OF_VERDICT = ('command', 'inputs', 'reports', 'annexes_apart', 'json', 'check', 'verbose',
               'quiet', 'runs_csv', 'card', 'ensemble_s', 'running_s', 'signers')


def add_settings_arguments(parser: argparse._ActionsContainer) -> None:
    """Add the options that give settings to any command."""
    parser.add_argument('--config', metavar='F', help='ROS parameter file with the settings')
    parser.add_argument('--set', metavar='name=value', action='append', default=[],
                        help='one setting, e.g. norms.sigma_max_deg=0.2; may be repeated')


def add_motion_argument(parser: argparse._ActionsContainer) -> None:
    """Add the option that names the log of the motion of the ship."""
    parser.add_argument('--motion', metavar='LOG', help='log with the motion of the ship (VTG, '
                        'RMC, GNS, GGA, GLL, ROT), to check the headings against (default: that '
                        'of the reference sensor, or of the tested one, if it has any)')


def add_antenna_arguments(parser: argparse._ActionsContainer) -> None:
    """Add the options of an RS that is two antennas; those of its settings are not shown."""
    parser.add_argument('--rs-antennas', metavar=('FORE', 'AFT'), nargs=2,
                        help='logs with the positions of two antennas, whose baseline is the '
                        'reference sensor, in place of its log; the settings '
                        'antennas.baseline_m and antennas.baseline_angle_deg say how they lie')
    for option in ('--baseline-m', '--baseline-angle'):
        parser.add_argument(option, type=float, help=argparse.SUPPRESS)


def add_verdict_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of every command that ends with a verdict; see `conclude`."""
    _add_annexes_argument(parser)
    parser.add_argument('--json', metavar='F', help="write the verdict as JSON; '-' for stdout")
    parser.add_argument('--check', action='store_true',
                        help='exit code 1 if non-compliant, 3 if indeterminate, 4 if the '
                        'outcome is doubtful')
    _add_verbose_argument(parser)


def _add_annexes_argument(parser: argparse._ActionsContainer) -> None:
    parser.add_argument('--annexes-apart', action='store_true',
                        help='a protocol of at most 8 pages, and its annexes in a second file '
                        'F-annexes.html or F-annexes.pdf')


def _add_verbose_argument(parser: argparse._ActionsContainer) -> None:
    parser.add_argument('--verbose', action='store_true',
                        help='show the criteria of Granovskii & Kudryavtsev and the abbreviations '
                        'too, also where no setting asks for them')


def _add_reports_argument(parser: argparse._ActionsContainer) -> None:
    parser.add_argument('-o', '--output', '--report', dest='reports', metavar='F',
                        action='append', default=[],
                        help='write the protocol, with plots: F.html, or F.pdf with the extra '
                        'pdf; F.json: the verdict; F.xml: a Digital Calibration '
                        'Certificate of the PTB; may be repeated; the short name report needs '
                        'it')


def _add_signing_arguments(parser: argparse._ActionsContainer) -> None:
    parser.add_argument('--sign', metavar='KEY', help='sign the verdict, F.json, and the '
                        'protocols with an ssh key; page one says by whom')
    add_signers_argument(parser)


def _add_runs_csv_argument(parser: argparse._ActionsContainer) -> None:
    parser.add_argument('--runs-csv', metavar='F', help='write one row per run: recording, start, '
                        'end, n, mean, sd, bounds, outcome, validity')


def add_delivery_arguments(group: argparse._ActionsContainer) -> None:
    """Add the options of a command that may end with a verdict; see `deliver`."""
    _add_reports_argument(group)
    _add_annexes_argument(group)
    _add_runs_csv_argument(group)
    _add_verbose_argument(group)
    _add_signing_arguments(group)


def check_delivery(arguments: argparse.Namespace, inputs: Sequence[str],
                   settings: Settings | None = None) -> None:
    """Reject files that `deliver` cannot write or sign; `inputs` must not be overwritten."""
    _check_forms(arguments, settings)
    check_outputs(Outputs(reports=tuple(arguments.reports), json=arguments.json,
                          runs_csv=arguments.runs_csv, card=arguments.card,
                          annexes_apart=arguments.annexes_apart), inputs)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command: first those that most trials need."""
    parser.usage = '%(prog)s [OPTION ...] INPUT [INPUT ...]'
    parser.add_argument('inputs', nargs='+', metavar='INPUT',
                        help='.mcap file, rosbag2 directory, .csv of pairs, or .journal of a live '
                        'run, which brings its settings; or two logs of NMEA sentences, first '
                        'that of the tested, then that of the reference sensor: files, folders, '
                        'or patterns in quotes; with the setting sensors recordings, or NAME=LOG '
                        'for each sensor; or one verdict in JSON, which is checked')
    add_settings_arguments(parser)
    _add_reports_argument(parser)
    parser.add_argument('--ts', metavar='TOPIC', help='topic of the tested sensor, or its name '
                        'in the setting sensors')
    parser.add_argument('--rs', metavar='TOPIC', help='topic of the reference sensor, or its name')
    add_motion_argument(parser)
    parser.add_argument('--exclude', metavar='F.csv', help='table of stretches to take out: '
                        'start,end,reason; the verdict with nothing taken out stands beside')
    add_verdict_arguments(parser)
    _add_signing_arguments(parser)
    logs = parser.add_argument_group('how logs and tables are read')
    add_unit_arguments(logs)
    add_log_arguments(logs)
    add_antenna_arguments(logs)
    _add_run_arguments(parser.add_argument_group('several runs and recordings'))
    _add_table_arguments(parser.add_argument_group('tables to write'))


def _add_run_arguments(group: argparse._ActionsContainer) -> None:
    """Add the options of several runs, recordings and computers."""
    group.add_argument('--runs', metavar='F.csv', help='table of runs: start,stop[,source]')
    group.add_argument('--jobs', metavar='N', type=parse_count,
                       help='number of processes to judge several large INPUTs, or to read one '
                       '(default: one per core)')
    group.add_argument('--dask', metavar='ADDRESS', help='judge the INPUTs on the workers of a '
                       'Dask scheduler, tcp://HOST:8786 or its .json file; the workers must see '
                       'the same paths')
    group.add_argument('--logbook', metavar='F', help='write a row per run into a logbook '
                       '(SQLite); see the command history')
    group.add_argument('--ship', metavar='NAME', help='name of the ship or station in the '
                       'logbook (default: that of the section compliance of --config)')


def _add_table_arguments(group: argparse._ActionsContainer) -> None:
    """Add the options of the tables of pairs and runs."""
    _add_runs_csv_argument(group)
    group.add_argument('--card', metavar='F', help='write the correction card for the bridge: '
                       'what to add to the tested sensor on eight headings; F.html, F.pdf or '
                       'F.csv')
    group.add_argument('--csv', metavar='F', help='write one row per pair')
    group.add_argument('--ensembles', metavar='F', help='write one row per ensemble, with '
                       'the columns of UHDAS: dday,mean_hdg,last_hdg,mean_dh,std_dh,num,badflag; '
                       'dh is TS - RS')
    group.add_argument('--ensemble-s', metavar='S', type=float, default=120.0,
                       help='length of an ensemble in seconds (default: 120)')
    group.add_argument('--corrections', metavar='F', help='write the correction C - O of each '
                       'ensemble, with a flag, and the running correction with its interval')
    group.add_argument('--running-s', metavar='S', type=float, default=1800.0,
                       help='window of the running correction in seconds (default: 1800)')


def run(arguments: argparse.Namespace) -> int:
    """Judge the inputs, or read the verdict; print and write it."""
    if arguments.command == 'report' and not arguments.reports:
        raise ValueError('report: -o is missing, the protocol to write, such as -o protocol.html')
    if len(arguments.inputs) == 1 and is_verdict(arguments.inputs[0]):
        return _show_again(arguments)
    config = load_config_or_journal(arguments.config, arguments.inputs)
    settings = settings_for(
        config, arguments.set, find_looks(config, arguments.set, arguments.inputs),
        ts_topic=arguments.ts, rs_topic=arguments.rs,
        ts_unit=arguments.ts_unit, rs_unit=arguments.rs_unit,
        exclusions=read_exclusion_table(arguments.exclude) if arguments.exclude else None,
        **{'antennas.baseline_m': arguments.baseline_m,
           'antennas.baseline_angle_deg': arguments.baseline_angle})
    settings = choose_pair(settings, arguments.ts, arguments.rs)
    check_norms(settings)
    drivers = drivers_for(arguments)
    logs = choose_logs(arguments, settings, drivers)
    _check_options(arguments, settings, logs is not None, drivers['ts'])
    check_signing(arguments)
    inputs = arguments.inputs if logs is None else [*logs.values()]
    outputs = _plan_outputs(arguments, settings)
    for sensor_outputs in outputs.values():
        check_outputs(sensor_outputs, [*inputs, *(arguments.rs_antennas or ())],
                      config=arguments.config, runs=arguments.runs)
    book = _open_logbook(arguments.logbook)
    with (ExitStack() as files, Progress(_label(arguments), arguments.quiet) as progress,
          _cluster(arguments.dask) as executor):
        tables = {sensor.name: [files.enter_context(table) for table in open_tables(
            outputs[sensor.name], settings_of_pair(settings, sensor, reference))]
            for sensor, reference in pair_with_reference(settings)}
        takers = {name: [table.write for table in writers]
                  for name, writers in tables.items() if writers}
        if logs is not None:
            judged = judge_logs(
                logs, settings, drivers, runs=arguments.runs or None,
                motion=arguments.motion, aft=(arguments.rs_antennas or (None, None))[1],
                takers=takers, sketched=bool(arguments.reports), progress=progress.show)
        else:
            judged = judge_bags(arguments.inputs, settings, runs=arguments.runs or None,
                                takers=takers, sketched=bool(arguments.reports),
                                jobs=arguments.jobs, executor=executor, driver=drivers['ts'],
                                progress=progress.show)
        for name, writers in tables.items():
            for table in writers:
                table.add_account(judged.accounts.get(name))
    for note in judged.notes:
        tell(note)
    if book is not None:
        _write_rows(book, judged, _find_ship(arguments.ship, config))
    return deliver(judged.verdict, arguments, judged.sketches)


def _show_again(arguments: argparse.Namespace) -> int:
    """Print the verdict that is the INPUT, and write its protocol, if its inputs confirm it."""
    path, = arguments.inputs
    verdict = with_signature(json.read_any(path), path, find_signers(arguments.signers))
    for option, value in vars(arguments).items():
        if option not in _OF_VERDICT and value:
            shown = value[0] if isinstance(value, list) else value
            raise ValueError(f'{path}: is a verdict, which is judged by its own settings; leave '
                             f'out --{option.replace("_", "-")} {shown}')
    check_delivery(arguments, arguments.inputs, verdict.settings)
    with Progress(path, arguments.quiet) as progress:
        progress.show('judging the inputs of the verdict, where they are at hand')
        verdict, why = confirm_verdict(path, verdict)
    if why:
        tell(f'{path}: {NOT_JUDGED}: {why}')
    return deliver(verdict, arguments)


def choose_logs(arguments: argparse.Namespace, settings: Settings,
               drivers: Mapping[str, DriverSettings]) -> dict[str, str] | None:
    """Return the log of each sensor by its name; None if the inputs are no logs."""
    if settings.sensors is None:
        fore = arguments.rs_antennas[:1] if arguments.rs_antennas else []
        pair = find_logs([*arguments.inputs, *fore], drivers,
                         recordings=bool(arguments.ts and arguments.rs))
        return None if pair is None else dict(zip(ROLES, pair))
    logs = name_logs(arguments.inputs, settings)
    if logs is None:
        names = ', '.join(sensor.name for sensor in read_sensors(settings.sensors))
        for path in arguments.inputs:
            if os.path.exists(path) and has_one_sensor(path):
                raise ValueError(f'{path}: is the log of one sensor; say of which, NAME={path} '
                                 f'with one of {names}, or take the setting sensors out')
    elif drivers['ts'] != drivers['rs']:
        raise ValueError('--ts-... and --rs-...: with several sensors the rows of the setting '
                         'sensors choose sentence, talker and instrument')
    return logs


def _plan_outputs(arguments: argparse.Namespace, settings: Settings) -> dict[str, Outputs]:
    """Return the files of the tested sensor, or those of each beside those of all."""
    whole = Outputs(arguments.csv, arguments.ensembles, tuple(arguments.reports), arguments.json,
                    arguments.ensemble_s, arguments.runs_csv,
                    annexes_apart=arguments.annexes_apart, card=arguments.card,
                    corrections=arguments.corrections, running_s=arguments.running_s)
    if settings.sensors is None:
        return {'ts': whole}

    def of(path: str | None, name: str) -> str | None:
        return os.fspath(sensor_path(path, name)) if path and path != '-' else path
    return {'': replace(whole, csv=None, ensembles=None, corrections=None, card=None,
                        annexes_apart=False), **{
        sensor.name: replace(whole, csv=of(whole.csv, sensor.name),
                             ensembles=of(whole.ensembles, sensor.name),
                             corrections=of(whole.corrections, sensor.name),
                             card=of(whole.card, sensor.name),
                             reports=tuple(os.fspath(sensor_path(path, sensor.name))
                                           for path in whole.reports))
        for sensor, _ in pair_with_reference(settings)}}


def _write_rows(book: Logbook, judged: Judgement, ship: str) -> None:
    """Write the runs of each tested sensor; among several its name follows that of the ship."""
    for name, verdict in judged.verdicts.items():
        several = judged.sensors is not None
        book.write(make_rows(
            verdict, ship='/'.join(filter(None, (ship, name))) if several else ship,
            earlier=judged.earlier[name], find_bag=os.path.abspath))
    if not judged.verdicts:
        tell('--logbook: no row, because no sensor is the reference')


def _find_ship(ship: str | None, config: Config) -> str:
    """Return the name of the ship from the command line or the parameter file."""
    return str(ship or config.sections.get('compliance', {}).get('ship') or '')


def _open_logbook(path: str | None) -> Logbook | None:
    """Return the logbook, after a check that it can be written."""
    if path is None:
        return None
    book = Logbook(path)
    book.check()
    return book


def deliver(verdict: Verdict | SensorsVerdict, arguments: argparse.Namespace,
            sketches: Mapping[str, Sequence[SeriesSketch]] | None = None) -> int:
    """Print and write the verdict, write the protocols if asked for; return the exit code."""
    code = conclude(verdict, arguments)
    if arguments.sign and arguments.json:
        verdict = _sign([arguments.json], verdict, arguments)
    if arguments.runs_csv:
        if isinstance(verdict, SensorsVerdict) and not verdict.verdicts:
            raise ValueError(f'--runs-csv {arguments.runs_csv}: no sensor is the reference, so '
                             'the verdict has no run of a sensor; leave it out')
        write_runs(verdict, arguments.runs_csv)
    if arguments.card:
        _write_cards(verdict, arguments.card)
    for path in sorted(arguments.reports, key=lambda path: not _is_json(path)):
        with Progress(path, arguments.quiet) as progress:
            progress.show('drawing the protocol')
            files = write_protocols(verdict, path, sketches, progress.show,
                                    arguments.verbose, arguments.annexes_apart)
        if arguments.sign:
            verdict = _sign([*map(str, files)], verdict, arguments)
        if isinstance(verdict, SensorsVerdict) and arguments.json != '-':
            say_lines(['protocols: ' + ', '.join(map(str, files))])
    return code


def _write_cards(verdict: Verdict | SensorsVerdict, path: str) -> None:
    """Write the correction card, or that of each tested sensor beside that name."""
    if isinstance(verdict, Verdict):
        write_card(verdict, path)
        return
    if not verdict.verdicts:
        raise ValueError(f'--card {path}: no sensor is the reference, so no sensor has a '
                         'correction; leave it out')
    for name, of_sensor in verdict.verdicts.items():
        write_card(of_sensor, sensor_path(path, name))


def _sign(files: Sequence[str], verdict: Verdict | SensorsVerdict,
          arguments: argparse.Namespace) -> Verdict | SensorsVerdict:
    """Sign files; return the verdict, which knows who signed it if the first one is its JSON."""
    key = find_key(arguments.sign, '--sign')
    for path in files:
        sign_file(path, key)
    if files[0] != arguments.json and not _is_json(files[0]):
        return verdict
    return with_signature(verdict, files[0], find_signers(arguments.signers))


def check_signing(arguments: argparse.Namespace) -> None:
    """Reject, before any work, a signature that cannot be made."""
    find_signers(arguments.signers)
    if arguments.sign is None:
        if arguments.signers is not None:
            raise ValueError(f'--signers {arguments.signers}: names the signer of a verdict; give '
                             'one in JSON as the INPUT, or add --sign KEY')
        return
    find_key(arguments.sign, '--sign')
    if arguments.json in (None, '-') and not any(map(_is_json, arguments.reports)):
        raise ValueError(f'--sign {arguments.sign}: signs the verdict in JSON and the protocols '
                         'made from it; add -o F.json')


def _is_json(path: str) -> bool:
    return path.lower().endswith('.json')


def parse_count(text: str) -> int:
    """Return a number of processes from the command line."""
    if not text.isascii() or not text.isdigit() or not int(text):
        raise argparse.ArgumentTypeError(f'{text!r} is not a whole number above 0')
    return int(text)


def _label(arguments: argparse.Namespace) -> str:
    """Return the label of the progress: the name of the input, or the number of inputs."""
    alone = len(arguments.inputs) == 1 and arguments.dask is None
    return arguments.inputs[0] if alone else f'{len(arguments.inputs)} inputs'


def _cluster(address: str | None) -> ContextManager[Executor | None]:
    """Return the workers of a Dask cluster; ValueError if Dask is not installed."""
    if address is None:
        return nullcontext()
    try:
        from heading_intercompare.app.cluster import open_cluster
    except ModuleNotFoundError as error:
        raise ValueError(f'--dask {address}: no module {error.name}: install '
                         'heading_intercompare[dask]') from error
    return open_cluster(address)


def _check_options(arguments: argparse.Namespace, settings: Settings, of_logs: bool,
                   driver: DriverSettings) -> None:
    """Reject options that do not go together, or not with these inputs."""
    check_input_options(arguments, settings, of_logs, driver)
    if arguments.dask is not None and arguments.jobs is not None:
        raise ValueError(f'--jobs {arguments.jobs}: with --dask the scheduler decides; '
                         'leave out one of them')
    _check_forms(arguments, settings)
    for option in _OF_TESTED:
        path = getattr(arguments, option)
        if path is None:
            continue
        named = f'--{option.replace("_", "-")} {path}'
        if not pair_with_reference(settings):
            raise ValueError(f'{named}: no sensor is the reference, and it {_OF_TWO}')
        if option not in _OF_PAIRS:
            continue
        if len(arguments.inputs) > 1 and not of_logs:
            raise ValueError(f'{named}: takes the pairs of one INPUT, but '
                             f'{len(arguments.inputs)} are given')
        if arguments.dask is not None:
            raise ValueError(f'{named}: the pairs stay on the workers; leave out --dask')


def check_input_options(arguments: argparse.Namespace, settings: Settings, of_logs: bool,
                         driver: DriverSettings) -> None:
    """Reject options of logs without logs, and options of bags with logs."""
    several = settings.sensors is not None
    form = 'NAME=LOG' if several else 'one'
    wrong = dict.fromkeys(LOG_OPTIONS, f'is for logs, and no INPUT is {form}; leave it out')
    of_tables = [option for option in OF_TABLES if getattr(arguments, option) is not None]
    if of_tables and not of_logs and any(has_streams(path, options_of(settings, driver))
                                         for path in arguments.inputs):
        wrong = {option: why for option, why in wrong.items() if option not in of_tables}
    if of_logs:
        wrong = dict.fromkeys(('ts', 'rs', 'dask'),
                              'is for bags, and these INPUTs are logs; leave it out')
    if several:
        wrong['rs_antennas'] = _OF_TWO
    for option, why in wrong.items():
        if (value := getattr(arguments, option, None)) is not None:
            shown = ' '.join(value) if isinstance(value, list) else value
            raise ValueError(f'--{option.replace("_", "-")} {shown}: {why}')


def _check_forms(arguments: argparse.Namespace, settings: Settings | None) -> None:
    """Reject a protocol in an unknown form, or one whose libraries are not installed."""
    if arguments.annexes_apart and not any(map(is_protocol, arguments.reports)):
        raise ValueError('--annexes-apart: no protocol is asked for; give -o F.pdf, or leave it '
                         'out')
    for path in arguments.reports:
        check_form(path, settings)
    if arguments.card:
        check_card(arguments.card)


def conclude(verdict: Verdict | SensorsVerdict, arguments: argparse.Namespace) -> int:
    """
    Print the verdict, write it as JSON if asked for, and return the exit code.

    Parameters
    ----------
    verdict
        On one sensor or on several.
    arguments
        With `json`, `check` and `verbose`.

    """
    if arguments.json == '-':
        sys.stdout.write(json.render(verdict))
    else:
        _show(verdict, arguments.verbose)
        if arguments.json:
            json.write(verdict, arguments.json)
    return code_of(verdict.outcome, verdict.validity_effect) if arguments.check else 0


def code_of(outcome: Outcome, validity_effect: str) -> int:
    """Return the exit code of ``--check``."""
    if is_doubtful(outcome, validity_effect):
        return _DOUBTFUL_CODE
    return _CHECK_CODES[outcome]


def _show(verdict: Verdict | SensorsVerdict, verbose: bool) -> None:
    """Print a verdict: the figures of each run, or of a campaign a line per recording."""
    if isinstance(verdict, Verdict) and is_campaign(verdict):
        say('\n'.join(campaign_lines(verdict, find_width(sys.stdout), verbose)), VERDICT_MARKS)
    else:
        text = verdict_text(verdict, verbose) if isinstance(verdict, Verdict) else str(verdict)
        say(text, VERDICT_MARKS)
