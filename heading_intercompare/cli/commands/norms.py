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

"""The command ``norms``: the named norms, and the slowest errors of each class of sensor."""

from __future__ import annotations

import argparse

from heading_intercompare.cli.terminal.console import say
from heading_intercompare.core.decision.coverage import SENSOR_CLASSES, span_words
from heading_intercompare.core.decision.norm_presets import PRESETS
from heading_intercompare.core.required_tests import KINDS, RequiredTest, VERIFIED

#: Highlights on a terminal: names, and norms whose text is unverified.
_MARKS = ((r'(?m)^(?!use)(\w+): ', 'bold'), (r'(?m)\[unverified\]$', 'yellow'))


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add nothing: the command has no options of its own."""


def run(arguments: argparse.Namespace) -> int:
    """Print every named norm and every class of sensors."""
    lines = []
    for name, preset in PRESETS.items():
        secant = ' sec(lat)' if preset.secant else ''
        if preset.rms_deg is not None:
            rule = f'sigma_max = {preset.rms_deg:g}{secant} deg'
        else:
            p = f'{preset.probability:g}' if preset.probability else 'norms.probability'
            rule = f'sigma_max = {preset.limit_deg:g}{secant} deg / K({p})'
        if preset.systematic is not None:
            rule += f'; systematic error at most {preset.systematic.limit:g}{secant} deg'
        lines.append(f'{name}: {preset.title} [{preset.status}]\n    {rule}')
        lines += [f'    requires: {_say_test(test)}' for test in preset.tests]
    lines.append('use: --set norms.preset=NAME, and --set norms.latitude_deg=LAT if the rule has '
                 'sec(lat)')
    lines.append('\nclasses of sensors: the slowest error, and the shortest run it requires')
    for name, sensor_class in SENSOR_CLASSES.items():
        lines.append(f'{name}: {sensor_class.title}\n'
                     f'    slowest error {span_words(sensor_class.slowest_s)}: '
                     f'{sensor_class.source}\n'
                     f'    shortest run: {span_words(sensor_class.least_s)}; {sensor_class.trial}')
    lines.append('use: --set risk.sensor_class=NAME, or --set risk.slowest_error_s=S with '
                 'your own figure')
    say('\n'.join(lines), _MARKS)
    return 0


def _say_test(test: RequiredTest) -> str:
    """Return a required test with its limit and its clause."""
    secant = ' sec(lat)' if test.secant else ''
    status = '' if test.status == VERIFIED else f' [{test.status}]'
    by = '' if KINDS[test.kind].is_judged else '; by a type test'
    unit = KINDS[test.kind].unit
    return f'{test.words} {test.limit:g}{secant} {unit} ({test.clause}){by}{status}'
