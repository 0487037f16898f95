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

"""The commands and their options; each command has a module of its own."""

from __future__ import annotations

import argparse
from contextlib import contextmanager
from importlib import import_module
import os
import signal
import sys
from typing import Any, Iterator, NoReturn, Sequence

from heading_intercompare.cli.terminal.printable import escape
from heading_intercompare.cli.terminal.standard_streams import safe_stderr, safe_stdout
from heading_intercompare.core.version import VERSION
from heading_intercompare.missing_module import explain_missing

PROGRAM = 'heading-intercompare'

_CRASHED = 70

#: How long an exception for a signal may be on its way, seconds.
_DROPPED_S = 0.5
#: Linear algebra here is short: several threads would mostly wait for each other.
_ONE_THREAD = ('OPENBLAS_NUM_THREADS', 'OMP_NUM_THREADS', 'MKL_NUM_THREADS')

# name: (module, help, example)
COMMANDS = {
    'demo': ('graph.demo', 'run the live graph on simulated sensors, record it, replay it, '
             'analyze the bag, and say whether the three verdicts agree', 'demo --out demo_out'),
    'live': ('graph.live', 'run the graph in one process, from drivers or topics, and record it',
             'live --config heading_intercompare.yaml'),
    'analyze': ('analyze', 'judge recorded runs, and write the protocol, with plots',
                'analyze trial_bag -o protocol.html --set norms.sigma_max_deg=0.2 '
                '--set norms.sigma_ref_max_deg=0.1'),
    'observe': ('observe', 'judge the systematic error of a sensor by observations: a quay, a '
                'survey, a leading line, the sun', 'observe gyro.log quay.csv --bearing 73.42 '
                '--common-u-deg 0.05 --set norms.systematic_max_deg=0.75'),
    'rejudge': ('rejudge', 'judge old recordings again, and list the outcomes that changed',
                'rejudge trial_*'),
    'history': ('history', 'list the runs of a logbook, say since when a sensor differs, or judge '
                'the last runs together',
                'history logbook.sqlite --since 2026-03-01'),
    'import': ('import_inputs', 'convert logs, tables and recordings of other programs to a bag',
               'import gyro.log seapath.log -o trial_bag'),
    'simulate': ('simulate', 'simulate a trial at full speed, and write it to a bag',
                 'simulate --scenario sea_trial_12h -o trial_bag'),
    'record': ('graph.record', 'record topics to a bag', 'record -o trial_bag'),
    'note': ('note', "add an operator's note to the bag that is being recorded",
             "note 'course change to 270'"),
    'plan': ('plan', 'say before a trial how long to measure, with the chances of a '
             'decision', 'plan --set norms.sigma_max_deg=0.2 --set norms.sigma_ref_max_deg=0.1 '
             '--set risk.sensor_class=gnss_compass'),
    'norms': ('norms', 'list the norm presets with their sources', 'norms'),
    'info': ('info', 'show what a file is and holds, such as topics, rates, settings, verdict, '
             'and what to type next', 'info trial_bag'),
    'recover': ('recover', 'copy everything readable of a cut or damaged bag to a new one',
                'recover trial_bag -o recovered_bag'),
    'sign': ('sign', 'sign verdicts, protocols and bags with an ssh key', 'sign verdict.json'),
    'verify': ('verify', 'say who signed files, and whether they and the inputs are unchanged',
               'verify verdict.json --signers allowed_signers'),
    'replay': ('graph.replay', 'publish the topics of a bag, under the same or other names',
               'replay trial_bag --rate 20 --remap ts/heading:=gyro/heading'),
}

#: Second names, by the name in `COMMANDS`.
_ALIASES = {'analyze': ('report',), 'import': ('import-nmea',)}
_NAMES = {name: command for command, aliases in _ALIASES.items() for name in aliases}


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        raise UsageError(f'{message} (see {self.prog} --help)')


class UsageError(ValueError):
    """The command line is wrong."""


def _build_parser(argv: Sequence[str]) -> argparse.ArgumentParser:
    """Return a parser; only the commands that appear in `argv` have their arguments."""
    parser = _Parser(prog=PROGRAM, description='Decide whether a heading sensor meets its '
                     'accuracy norm, by comparison with a reference sensor.')
    parser.add_argument('--version', action='version', version=f'{PROGRAM} {VERSION}')
    commands = parser.add_subparsers(dest='command', metavar='COMMAND', parser_class=_Parser)
    for name, (module, summary, example) in COMMANDS.items():
        command = commands.add_parser(
            name, aliases=_ALIASES.get(name, ()), help=summary,
            description=summary[0].upper() + summary[1:] + '.',
            epilog=f'example: {PROGRAM} {example}')
        command.add_argument('--quiet', action='store_true', help='no progress, results only')
        if not {name, *_ALIASES.get(name, ())}.isdisjoint(argv):
            import_module(f'heading_intercompare.cli.commands.{module}').add_arguments(command)
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """
    Run a command.

    Parameters
    ----------
    argv
        Arguments; those of the process by default.

    Returns
    -------
    int
        The exit code: 0 for done, 2 for wrong usage, configuration, input or output, 130 for
        Ctrl-C, 143 for SIGTERM and 129 for SIGHUP. With ``--check`` a verdict also gives 1 for
        non-compliant, 3 for indeterminate and 4 for a doubtful outcome. The code does not depend
        on whether anyone reads the output. A fault of the program ends the process with 70.

    """
    if argv is not None:
        return _run_safely(argv)
    sys.excepthook = _crash
    # Before numpy is loaded; what the user has set stays.
    for name in _ONE_THREAD:
        os.environ.setdefault(name, '1')
    with ended_by_signals():
        return _run_safely(sys.argv[1:])


def _run_safely(argv: Sequence[str]) -> int:
    with safe_stderr():
        try:
            with safe_stdout():
                return _run(argv)
        except (ValueError, OSError, ModuleNotFoundError, MemoryError) as error:
            return _refuse(error)
        except KeyboardInterrupt:
            sys.stderr.write('\n')
            return 130


def _run(argv: Sequence[str]) -> int:
    if '_ARGCOMPLETE' in os.environ:
        # A shell asks for completions; only then is their module loaded.
        from heading_intercompare.cli.completion import complete

        complete(_build_parser(os.environ.get('COMP_LINE', '').split()))
    parser = _build_parser(argv)
    arguments = parser.parse_args(argv)
    if arguments.command is None:
        parser.print_help()
        return 2
    command = _NAMES.get(arguments.command, arguments.command)
    module = import_module(f'heading_intercompare.cli.commands.{COMMANDS[command][0]}')
    code: int = module.run(arguments)
    return code


def _refuse(error: Exception) -> int:
    if isinstance(error, ModuleNotFoundError):
        explained = explain_missing(error)
        if explained is None:
            raise error
        text = explained
    elif isinstance(error, MemoryError):
        text = 'there is not enough memory for this: end other programs, or give less data at once'
    elif isinstance(error, OSError) and error.strerror:
        where = f'{error.filename}: ' if error.filename is not None else ''
        text = f'{where}{error.strerror}'
    else:
        text = str(error)
    sys.stderr.write(f'{PROGRAM}: error: {escape(" ".join(text.split()))}\n')
    return 2


@contextmanager
def ended_by_signals() -> Iterator[None]:
    """
    Let SIGTERM and SIGHUP end the process as Ctrl-C does: drafts and unpacked files are removed.

    SIGHUP stays ignored if it was, for instance by `nohup`.
    """
    for number in (signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) != signal.SIG_IGN:
            signal.signal(number, _end)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)


def _end(number: int, *_: object) -> NoReturn:
    """
    Leave by an exception, with the exit code that a shell gives for the signal.

    Code in C that is interrupted may drop the exception, as does the loading of some modules. So
    it is raised once more if nothing handles it a moment later.
    """
    signal.signal(number, signal.SIG_IGN)
    ending = SystemExit(128 + number)

    def raise_if_dropped(*_: object) -> None:
        if not _is_handled(ending):
            raise ending

    signal.signal(signal.SIGALRM, raise_if_dropped)
    signal.setitimer(signal.ITIMER_REAL, _DROPPED_S, _DROPPED_S)
    raise ending


def _is_handled(error: BaseException) -> bool:
    """Tell whether a clean-up runs because of an exception, or of one that followed from it."""
    handled = sys.exc_info()[1]
    while handled is not None and handled is not error:
        handled = handled.__context__
    return handled is error


def _crash(*error: Any) -> NoReturn:
    """End with a traceback, but not with Python's exit code 1, which --check uses."""
    sys.__excepthook__(*error)
    sys.exit(_CRASHED)

