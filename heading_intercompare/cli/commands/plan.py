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
from pathlib import Path
import sys

import numpy as np

from heading_intercompare.app.config import load_config, settings_for
from heading_intercompare.app.outputs import check_outputs, name_file, Outputs
from heading_intercompare.cli.terminal.console import say
from heading_intercompare.cli.terminal.progress import Progress
from heading_intercompare.core.decision.coverage import span_words
from heading_intercompare.core.decision.trial_plan import (
    LEVELS,
    plan_trial,
    REMEDY_LEVEL,
    TrialPlan,
)
from heading_intercompare.core.settings import Settings

from .analyze import add_settings_arguments

_MARKS = ((r'(?m)^(to certify|what shortens) .*$', 'bold'),)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    add_settings_arguments(parser)
    parser.add_argument('--rate', metavar='HZ', type=float, default=1.0,
                        help='pairs per second (default: 1)')
    parser.add_argument('--slow-share', metavar='X', type=float, default=1.0,
                        help='share of the TS variance that belongs to its slowest error; the '
                        'rest is white (default: 1, the hardest case)')
    parser.add_argument('--probability', metavar='P', type=float, default=0.8,
                        help='probability of certifying to aim at (default: 0.8)')
    parser.add_argument('--seed', metavar='N', type=int, default=1,
                        help='seed of the simulated records (default: 1)')
    parser.add_argument('--trials', metavar='N', type=int, default=200,
                        help='simulated trials for each chance (default: 200)')
    parser.add_argument('--json', metavar='F', help="write the plan as JSON; '-' for stdout")


def run(arguments: argparse.Namespace) -> int:
    """Simulate several short runs and single runs, and print the chances of each outcome."""
    settings = settings_for(load_config(arguments.config), arguments.set)
    if arguments.seed < 0:
        raise ValueError(f'--seed {arguments.seed}: must be at least 0')
    if arguments.trials < 1:
        raise ValueError(f'--trials {arguments.trials}: must be at least 1')
    check_outputs(Outputs(json=arguments.json), (), config=arguments.config)
    with Progress('plan', arguments.quiet) as progress:
        plan = plan_trial(settings, np.random.default_rng(arguments.seed),
                          rate_hz=arguments.rate, slow_share=arguments.slow_share,
                          wanted=arguments.probability, trials=arguments.trials,
                          progress=progress.show)
    text = json.dumps({'levels': LEVELS, **asdict(plan)}, indent=2) + '\n'
    if arguments.json == '-':
        sys.stdout.write(text)
        return 0
    say(_table(plan, settings, arguments), _MARKS)
    if arguments.json:
        with name_file(arguments.json):
            Path(arguments.json).write_text(text, 'utf-8')
    return 0


def _table(plan: TrialPlan, settings: Settings, arguments: argparse.Namespace) -> str:
    """Return the plan as text."""
    risk = settings.risk
    lines = [
        f'a run must last {span_words(plan.least_s)} to comply; the slowest error stated is '
        f'{span_words(plan.slowest_error_s)}',
        f'RS at {plan.sigma_ref_deg:g} deg; pairs per second: {arguments.rate:g}; '
        f'{arguments.slow_share:g} of the TS variance is slow; risks: consumer '
        f'{risk.alpha_consumer:g}, producer {risk.alpha_producer:g}', '',
        'chances of COMPLIANT / NON-COMPLIANT / INDETERMINATE, in percent']
    rows: dict[tuple[int, float], list[str]] = {}
    for chance in plan.chances:
        rows.setdefault((chance.runs, chance.duration_s), []).append(' / '.join(
            f'{100.0 * p:3.0f}' for p in (chance.compliant, chance.non_compliant,
                                          chance.indeterminate)))
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
