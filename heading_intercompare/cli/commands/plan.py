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

"""The command ``plan``: how long to measure, with the chances of a decision."""

from __future__ import annotations

import argparse
from dataclasses import asdict
import json
import math
import sys
from typing import Any, Iterator, Sequence, TypeAlias

import numpy as np

from heading_intercompare.app.config import load_config, settings_for
from heading_intercompare.app.outputs import check_outputs, Outputs
from heading_intercompare.app.scenarios import read_scenario
from heading_intercompare.app.simulation.scenario_plan import (
    lengthen,
    plan_scenario,
    ScenarioPlan,
)
from heading_intercompare.app.simulation.voyage import read_voyage
from heading_intercompare.cli.terminal.console import say
from heading_intercompare.cli.terminal.progress import Progress
from heading_intercompare.core.decision.coverage import least_duration_words, span_words
from heading_intercompare.core.decision.trial_plan import (
    LEVELS,
    OUTCOMES,
    plan_trial,
    REMEDY_LEVEL,
    TrialPlan,
)
from heading_intercompare.core.norm_tests.judged_test import STATES
from heading_intercompare.core.norm_tests.planned_tests import plan_tests, PlannedTest
from heading_intercompare.core.settings import Settings
from heading_intercompare.replaced_file import replace_file
from heading_intercompare.report import check_picture, write_chances, write_trial_page
from heading_intercompare.report.figures.chances import draw_chances, list_lines
from heading_intercompare.report.figures.drawing import Drawing

from .analyze import add_settings_arguments, parse_count
from .simulate import check_page, name_trial

_MARKS = ((r'(?m)^(to certify|what shortens) .*$', 'bold'),)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    add_settings_arguments(parser)
    parser.add_argument('--scenario', metavar='F', help='plan for the sensors, the legs and the '
                        'sea of this YAML file of the simulator, or of the one of this name in '
                        'the package, such as sea_trial_12h')
    parser.add_argument('--hours', metavar='H', type=float,
                        help='with --scenario: the longest run to try; the legs are sailed again '
                        '(default: the length of the scenario)')
    parser.add_argument('--jobs', metavar='N', type=parse_count,
                        help='with --scenario: number of processes (default: one per core)')
    parser.add_argument('--rate', metavar='HZ', type=float,
                        help='pairs per second (default: 1); not with --scenario')
    parser.add_argument('--slow-share', metavar='X', type=float,
                        help='share of the TS variance that belongs to its slowest error; the '
                        'rest is white (default: 1, the hardest case); not with --scenario')
    parser.add_argument('--probability', metavar='P', type=float, default=0.8,
                        help='probability of certifying to aim at (default: 0.8)')
    parser.add_argument('--seed', metavar='N', type=int,
                        help='seed of the simulated records (default: 1, or that of the scenario)')
    parser.add_argument('--trials', metavar='N', type=int,
                        help='simulated trials for each chance (default: 200, or 20 with '
                        '--scenario)')
    parser.add_argument('--json', metavar='F', help="write the plan as JSON; '-' for stdout")
    parser.add_argument('--plot', metavar='F', help='draw the chances by the length of the run '
                        'into F.png, F.svg or F.pdf')
    parser.add_argument('--page', metavar='F', help='write the plan with this figure as a page: '
                        'a file .html, which needs the extra report')


def run(arguments: argparse.Namespace) -> int:
    """Simulate runs of several lengths, and print the chances of each outcome."""
    settings = settings_for(load_config(arguments.config), arguments.set)
    _check(arguments)
    text, document, title, figure = (
        _plan_trial if arguments.scenario is None else _plan_scenario)(arguments, settings)
    written = json.dumps(document, indent=2) + '\n'
    if arguments.json == '-':
        sys.stdout.write(written)
    else:
        say(text, _MARKS)
    if arguments.json not in (None, '-'):
        replace_file(arguments.json, written)
    if arguments.plot:
        write_chances(arguments.plot, figure)
    if arguments.page:
        write_trial_page(arguments.page, title, text.splitlines(), chances=figure)
    return 0


def _check(arguments: argparse.Namespace) -> None:
    """Raise ValueError for options that are wrong, before anything is simulated."""
    if arguments.seed is not None and arguments.seed < 0:
        raise ValueError(f'--seed {arguments.seed}: must be at least 0')
    if arguments.trials is not None and arguments.trials < 1:
        raise ValueError(f'--trials {arguments.trials}: must be at least 1')
    if arguments.hours is not None and not 0.0 < arguments.hours < math.inf:
        raise ValueError(f'--hours {arguments.hours:g}: must be greater than 0')
    wrong = (dict.fromkeys(('hours', 'jobs'), 'is for --scenario; leave it out')
             if arguments.scenario is None else
             dict.fromkeys(('rate', 'slow_share'), 'the scenario says it; leave it out'))
    for option, why in wrong.items():
        if (value := getattr(arguments, option)) is not None:
            raise ValueError(f'--{option.replace("_", "-")} {value:g}: {why}')
    check_outputs(Outputs(json=arguments.json, plot=arguments.plot, page=arguments.page),
                  [] if arguments.scenario is None else [arguments.scenario],
                  config=arguments.config)
    if arguments.plot:
        check_picture(arguments.plot)
    check_page(arguments.page)


_Plan: TypeAlias = 'tuple[str, dict[str, Any], str, Drawing]'
"""The text, the document, the title and the figure of a plan."""


def _plan_trial(arguments: argparse.Namespace, settings: Settings) -> _Plan:
    """Plan a trial by its norms and its slowest error."""
    rate_hz = 1.0 if arguments.rate is None else arguments.rate
    slow_share = 1.0 if arguments.slow_share is None else arguments.slow_share
    seed = 1 if arguments.seed is None else arguments.seed
    with Progress('plan', arguments.quiet) as progress:
        plan = plan_trial(settings, np.random.default_rng(seed), rate_hz=rate_hz,
                          slow_share=slow_share, wanted=arguments.probability,
                          trials=arguments.trials or 200, progress=progress.show)
    figure = draw_chances(list_lines(plan.chances), f'One run, {plan.trials} trials each',
                          least_s=plan.least_s, probability=plan.wanted)
    tests = plan_tests(settings, rate_hz)
    text = '\n'.join([_table(plan, settings, rate_hz, slow_share), *_list_tests(tests)])
    document = {'levels': LEVELS, **asdict(plan), 'tests': [asdict(test) for test in tests]}
    return (text, document, 'Plan of a trial', figure)


def _plan_scenario(arguments: argparse.Namespace, settings: Settings) -> _Plan:
    """Plan a trial with the sensors of a scenario."""
    source = read_scenario(arguments.scenario, arguments.seed)
    if arguments.hours is not None:
        source = source._replace(scenario=lengthen(source.scenario, 3600.0 * arguments.hours))
    scenario = source.scenario
    voyage = read_voyage(scenario.track, source.folder) if scenario.track.file else None
    with Progress(source.name, arguments.quiet) as progress:
        plan = plan_scenario(scenario, settings, trials=arguments.trials or 20,
                             probability=arguments.probability, jobs=arguments.jobs,
                             track=None if voyage is None else voyage.track,
                             progress=progress.show)
    seeds = f'seeds {plan.seeds[0]} to {plan.seeds[-1]}'
    lines = [*name_trial(source, seeds), *(() if voyage is None else voyage.words),
             *_scenario_lines(plan, settings)]
    title = scenario.title or source.name
    figure = draw_chances(list_lines(plan.chances), f'{title}: one run, {len(plan.seeds)} trials',
                          least_s=plan.least_s, probability=plan.probability)
    return ('\n'.join(lines), {'scenario': source.name, **asdict(plan)}, title, figure)


def _scenario_lines(plan: ScenarioPlan, settings: Settings) -> Iterator[str]:
    """Yield the plan of a scenario as text."""
    yield f'TS: {plan.ts.words}'
    yield f'RS: {plan.rs.words}'
    yield least_duration_words(settings.risk)
    yield ''
    yield 'chances in percent, with their 95 % intervals'
    yield 'one run of  ' + ''.join(f'{outcome.words.upper():>19}' for outcome in OUTCOMES)
    for chance in plan.chances:
        cells = (f'{100.0 * share:.0f} ({100.0 * low:.0f} to {100.0 * up:.0f})'
                 for share, (low, up) in zip(chance.shares, chance.intervals))
        yield f'{span_words(chance.duration_s):12}' + ''.join(f'{cell:>19}' for cell in cells)
    yield ''
    longest = span_words(plan.chances[-1].duration_s)
    advice = ('no length tried does; --hours tries longer ones' if plan.advised_s is None
              else f'one run of {span_words(plan.advised_s)}')
    yield f'to certify this TS with probability {plan.probability:g}: {advice}'
    yield f'outcomes of {longest}: ' + '; '.join(
        f'{count} {reason}' for reason, count in plan.reasons.items())
    yield f'each chance is from {len(plan.seeds)} simulated trials; a shorter one is a longer ' \
        'one cut'
    if plan.tests:
        yield f'tests of the norm in {longest}, of {len(plan.seeds)} trials:'
    for words, states in plan.tests.items():
        yield f'  {words}: ' + ', '.join(
            f'{count} {STATES[state]}' for state, count in states.items() if count)


def _table(plan: TrialPlan, settings: Settings, rate_hz: float, slow_share: float) -> str:
    """Return the plan as text."""
    risk = settings.risk
    lines = [
        f'a run must last {span_words(plan.least_s)} to comply; the slowest error stated is '
        f'{span_words(plan.slowest_error_s)}',
        f'RS at {plan.sigma_ref_deg:g} deg; pairs per second: {rate_hz:g}; '
        f'{slow_share:g} of the TS variance is slow; risks: consumer '
        f'{risk.alpha_consumer:g}, producer {risk.alpha_producer:g}', '',
        'chances of COMPLIANT / NON-COMPLIANT / INDETERMINATE, in percent']
    rows: dict[tuple[int, float], list[str]] = {}
    for chance in plan.chances:
        rows.setdefault((chance.runs, chance.duration_s), []).append(' / '.join(
            f'{100.0 * share:3.0f}' for share in chance.shares))
    width = max(len(_trial(*trial)) for trial in rows) + 2
    lines += ['trial'.ljust(width) + ''.join(f'  TS at {level:g} of norm' for level in LEVELS)]
    lines += [_trial(*trial).ljust(width) + ''.join(
        f'{cell:>{len(f"  TS at {level:g} of norm")}}' for level, cell in zip(LEVELS, cells))
        for trial, cells in rows.items()]
    most, longest = max(runs for runs, _ in rows), max(s for _, s in rows)
    advice = []
    for level, runs, advised_s in zip(LEVELS, plan.advised_runs, plan.advised_s):
        several = (f'not by {most} short runs' if runs is None
                   else f'{_trial(runs, plan.short_s)} ({span_words(runs * plan.short_s)} in all)')
        single = (f'not by one run of {span_words(longest)}' if advised_s is None
                  else f'one run of {span_words(advised_s)}')
        advice.append(f'  {level:g} of its norm: {several}; or {single}')
    error = 50.0 / plan.trials ** 0.5
    return '\n'.join([
        *lines, '', f'to certify with probability {plan.wanted:g} a TS at', *advice,
        *_name_remedies(plan),
        f'several runs: set campaign.rule=sensor, and wait at least '
        f'{span_words(plan.slowest_error_s)} between runs',
        f'each chance is from {plan.trials} simulated trials; its standard error is at most '
        f'{error:.0f} percent'])


def _list_tests(tests: Sequence[PlannedTest]) -> list[str]:
    """Return the tests of the norm: what to sail for each, or why this trial cannot decide it."""
    if not tests:
        return []
    lines = ['', 'tests of the norm, and what to sail for each:']
    for test in tests:
        how = f'not decided: {test.obstacle}' if test.obstacle else test.manoeuvre
        lines.append(f'  {test.words} (limit {test.limit:.3g} {test.unit}): {how}')
    sailed = sum(test.least_s for test in tests if not test.obstacle)
    return [*lines, f'one after the other these take {span_words(sailed)} at least; legs, turns '
            'and waiting may serve several at once']


def _name_remedies(plan: TrialPlan) -> list[str]:
    """Return the lines that say what shortens the trial, the best first."""
    measured = ('not certified by any length tried' if plan.total_s is None
                else f'{span_words(plan.total_s)} measured in all')
    tried = f'a TS at {REMEDY_LEVEL:g} of its norm ({measured})'
    if not plan.remedies:
        return [f'neither a better RS, nor knowing it better, nor more pairs shortens {tried}']
    return [f'what shortens the trial of {tried}, best first:',
            *(f'  {remedy.change} ({remedy.words}): {span_words(remedy.total_s)}'
              for remedy in plan.remedies)]


def _trial(runs: int, duration_s: float) -> str:
    length = span_words(duration_s)
    return f'one run of {length}' if runs == 1 else f'{runs} runs of {length}'
