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

"""
Generate from the sources: parameter file, settings, JSON and its schema, conditions, modules.

Run it after adding or changing a setting, a figure, a condition or a module: ``make docs``. The
tests compare the files with its output.
"""

from __future__ import annotations

import ast
import inspect
import json
from pathlib import Path
import re
import textwrap
from typing import Any, Iterable, Iterator, Mapping, NamedTuple

from heading_intercompare.ahrs.settings import Scenario, Sensor
from heading_intercompare.bags.settings import BagSettings
from heading_intercompare.core.declared_figures import Figure, list_figures
from heading_intercompare.core.declared_settings import list_settings, Setting
from heading_intercompare.core.sensors.sensors_verdict import (
    PairFigures,
    SensorResult,
    SensorsVerdict,
    SensorVariance,
    Vote,
)
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.verdict.validity import CONDITIONS
from heading_intercompare.core.verdict.verdict_document import RunVerdict
from heading_intercompare.drivers.alerts.alert_settings import AlertSettings
from heading_intercompare.drivers.settings import DriverSettings
from heading_intercompare.nodes.settings import (
    ComplianceNode,
    DashboardNode,
    DriverNode,
    HeadingTypes,
    RecorderNode,
    ReplayerNode,
    Sending,
    SimulatorNode,
    SynchronizerNode,
    Taking,
)
from heading_intercompare.report.json_schema import make_schema
from heading_intercompare.report.runs_csv import COLUMNS

ROOT = Path(__file__).resolve().parent.parent
YAML = ROOT / 'config' / 'heading_intercompare.yaml'
ARCHITECTURE = ROOT / 'docs' / 'ARCHITECTURE.md'
TABLES = ROOT / 'docs' / 'settings.md'
SCENARIOS = ROOT / 'docs' / 'scenario_settings.md'
REFUSALS = ROOT / 'docs' / 'refusals.md'
SCHEMA = ROOT / 'schema' / 'verdict.schema.json'
KEYS = ROOT / 'docs' / 'verdict_json.md'
RUNS = ROOT / 'docs' / 'howto' / 'judge_many.md'


class Section(NamedTuple):
    """
    One section of the parameter file.

    Attributes
    ----------
    classes
        Classes of its settings.
    given
        Values that differ from the defaults.
    examples : mapping or None
        Example values of the settings without a default. None: write only the values in `given`.

    """

    node: str
    classes: tuple[type, ...]
    comment: str
    given: Mapping[str, Any]
    examples: Mapping[str, Any] | None


DRIVER = (DriverSettings, DriverNode, Sending, Taking)
TYPES = {'ts_message_type': 'sensor_msgs/msg/Imu', 'rs_message_type': 'sensor_msgs/msg/Imu'}

SECTIONS = (
    Section('/**', (Settings,),
            'The analysis: the same for every node and for the command line.',
            {}, {'norms.sigma_max_deg': 0.2, 'norms.limiting_error_max_deg': 0.6,
                 'norms.sigma_ref_max_deg': 0.1,
                 'norms.sigma_ref_deg': 0.05, 'norms.total_error_max_deg': 0.5,
                 'norms.systematic_max_deg': 0.75,
                 'norms.preset': 'imo_a424', 'norms.latitude_deg': 45.0,
                 'norms.tests': 'static_error 0.5; follow_up 0.5 0-10',
                 'runs.every_h': 24.0, 'runs.cut_at_utc': '00:00,08:00,16:00',
                 'sequential.plan_s': 3600.0, 'risk.slowest_error_s': 300.0,
                 'bag_namespace': '/ship1', 'risk.sensor_class': 'gyrocompass',
                 'risk.min_duration_s': 1200.0,
                 'antennas.fore_topic': 'gps/fore', 'antennas.aft_topic': 'gps/aft',
                 'antennas.baseline_m': 12.5, 'antennas.tolerance_m': 0.1,
                 'antennas.position_sigma_m': 0.01,
                 'trial.issue_date': '2026-03-05',
                 'trial.latitude_min_deg': 53.5, 'trial.latitude_max_deg': 54.5,
                 'trial.ts_calibration_date': '2026-02-10', 'trial.ts_calibration_months': 12,
                 'trial.rs_calibration_date': '2026-03-01', 'trial.rs_calibration_months': 24,
                 'exclusions': '2026-05-01T10:00Z, 2026-05-01T10:20Z, RS in dock mode',
                 'sensors': 'gyro1 sigma_max_deg=0.3; gyro2 sigma_max_deg=0.3; '
                 'gnss sigma_max_deg=0.1 rs'}),
    Section('ts_driver', DRIVER, 'The driver of the tested sensor.',
            {'source': 'udp://:10110', 'topic': 'ts/heading'},
            {'own_sentence': 'PXYZ,ATT heading=3 unit=rad', 'talker': 'HE',
             'variation_deg': 2.5, 'deviation_table': '0 1.5; 90 -2; 180 -1.5; 270 2',
             'stamp_zone': 'Europe/Oslo',
             'time_column': 'Date,Time', 'date': '2026-05-01',
             'stamp_pattern': '(?P<epoch>[0-9]{10})', 'instrument': 'GYRO1',
             'frame_id': 'gyro', 'origin_ns': 1700000000000000000}),
    Section('rs_driver', DRIVER, 'The driver of the reference sensor; it has the same settings.',
            {'source': 'udp://:10111', 'topic': 'rs/heading'}, None),
    Section('synchronizer', (SynchronizerNode, HeadingTypes, Taking), 'The node that pairs.', {},
            TYPES),
    Section('compliance', (ComplianceNode, Taking), 'The node that judges.', {},
            {'sensor': 'gyro1', 'report_dir': 'reports', 'logbook': 'logbook.sqlite',
             'ship': 'MV Example', 'bag': 'trial_1', 'journal': 'trial_1.journal',
             'report_every_h': 6.0}),
    Section('recorder', (RecorderNode, HeadingTypes, BagSettings, Taking), 'The recorder.', {},
            {'output': 'trial_2', 'continues': 'trial_1', 'note': 'MV Example, trial 1',
             'parameter_file': 'mine.yaml', **TYPES}),
    Section('dashboard', (DashboardNode, Taking), 'The live page.', {},
            {'names': 'bridge.example.com',
             'token_file': '/etc/heading-intercompare/tokens'}),
    Section('alert_sender', (AlertSettings,), 'The node that sends the alarms to the bridge.', {},
            {'destination': 'udp://239.192.0.17:60017', 'commands': 'udp://239.192.0.19:60019',
             'manufacturer': 'XYZ', 'push_url': 'https://example.com/alerts'}),
    Section('replayer', (ReplayerNode, Sending), 'The replayer of bags.', {},
            {'bag': 'trial_1', 'duration_s': 600.0}),
    Section('sensor_simulator', (SimulatorNode, Sending),
            'The simulator; it also accepts the settings of a scenario.', {}, {}),
)

CHAPTERS = (
    ('The analysis', 'Section `/**`, for every node and for the command line.', Settings),
    ('Drivers', 'Sections `ts_driver`, `rs_driver` and `motion_driver`; some are options of '
     '`import`.', DriverSettings),
    ('Drivers as nodes', 'In the same sections.', DriverNode),
    ('Synchronizer', 'Section `synchronizer`.', SynchronizerNode),
    ('Compliance', 'Section `compliance`.', ComplianceNode),
    ('Recorder', 'Section `recorder`.', RecorderNode),
    ('Bags', 'Section `recorder`, for every bag that is written.', BagSettings),
    ('Live page', 'Section `dashboard`.', DashboardNode),
    ('Alerts to the bridge', 'Section `alert_sender`.', AlertSettings),
    ('Replayer', 'Section `replayer`.', ReplayerNode),
    ('Simulator', 'Section `sensor_simulator`.', SimulatorNode),
    ('Taking messages',
     'Sections of drivers, synchronizer, compliance, recorder and dashboard.', Taking),
    ('Types of headings', 'Sections `synchronizer` and `recorder`.', HeadingTypes),
    ('Sending headings', 'Sections of drivers, replayer and simulator.', Sending),
)
#: Those of the page for who simulates: nobody sets them who judges.
SCENARIO_CHAPTERS = (
    ('Scenarios', 'Files of their own, for `simulate` and the node `sensor_simulator`.',
     Scenario),
    ('Sensors of a scenario', 'Under `ts` and under `rs` of a scenario.', Sensor),
)


def rules(section: Section) -> Iterator[Setting]:
    """Yield the settings of a section."""
    for settings in section.classes:
        yield from list_settings(settings)


def _scalar(value: Any) -> str:
    """Return a value as text that YAML 1.1 and ROS both read with the same type."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return "'" + value.replace("'", "''") + "'"
    return repr(value)


def _sentence(rule: Setting) -> str:
    return f'{rule.help[0].upper()}{rule.help[1:]}. Allowed: {rule.allowed}.'


def _section(section: Section) -> Iterator[str]:
    yield f'# {section.comment}'
    yield f'{section.node}:'
    yield '  ros__parameters:'
    if section.examples is None:
        yield from (f'    {name}: {_scalar(value)}' for name, value in section.given.items())
        return
    open_group: tuple[str, ...] = ()
    for rule in rules(section):
        *group, name = rule.name.split('.')
        if tuple(group) != open_group:
            yield ''
            for depth, word in enumerate(group):
                yield f'{"  " * (depth + 2)}{word}:'
            open_group = tuple(group)
        indent = '  ' * (len(group) + 2)
        yield from textwrap.wrap(_sentence(rule), 99, initial_indent=f'{indent}# ',
                                 subsequent_indent=f'{indent}# ', break_long_words=False)
        value = section.given.get(rule.name, rule.default)
        if value is None:
            yield f'{indent}# {name}: {_scalar(section.examples[rule.name])}'
        else:
            yield f'{indent}{name}: {_scalar(value)}'


def parameter_file() -> str:
    """Return the text of config/heading_intercompare.yaml."""
    head = textwrap.dedent("""\
        # SPDX-FileCopyrightText: 2026 The heading_intercompare authors
        # SPDX-License-Identifier: Apache-2.0
        #
        # All settings with their defaults: a ROS parameter file, also for the command line:
        #   ros2 launch heading_intercompare intercompare.launch.py config:=FILE
        #   heading-intercompare analyze BAG --config FILE
        # Copy this file and edit the copy; settings that you leave out keep their defaults. A
        # setting without a default is commented out with an example value: remove the # to set it.
        # Required are norms.sigma_ref_max_deg, and norms.sigma_max_deg or norms.preset.
        # Written by docs/generate.py.
        #
        # Most trials need no other settings of the analysis than these:
        """)
    head += ''.join(f'#   {rule.name}\n' for rule in needed())
    return head + '\n' + '\n\n'.join('\n'.join(_section(s)) for s in SECTIONS) + '\n'


def _cell(text: str) -> str:
    return text.replace('|', '\\|')


def _default(value: Any) -> str:
    return 'none' if value is None else f'`{_scalar(value)}`'


def needed() -> list[Setting]:
    """Return the settings that most trials need."""
    declared = {rule.name: rule for rule in list_settings(Settings)}
    return [declared[name] for name in Settings.NEEDED]


def _table(declared: Iterable[Setting]) -> Iterator[str]:
    yield from ('| name | default | meaning | allowed |', '|---|---|---|---|')
    for rule in declared:
        yield (f'| `{rule.name}` | {_default(rule.default)} | {_cell(rule.help)} '
               f'| {_cell(rule.allowed)} |')


def tables() -> str:
    """Return the text of docs/settings.md."""
    lines = ['# Settings', '',
             'Written by `docs/generate.py` from the classes that declare the settings. '
             'Unknown names',
             'are errors everywhere, and so is a name given twice, in a file or by `--set`.',
             'Files are YAML 1.2: `1e9` is a number, `on` and `1:30` are words. A number such as',
             '`010`, which ROS reads as 8, is rejected.',
             'An integer is accepted for a number, and settings are frozen during a run.',
             '`none` means that the row is absent. The parameter file with all defaults is',
             '[config/heading_intercompare.yaml](../config/heading_intercompare.yaml); the',
             'settings of scenarios have [a page of their own](scenario_settings.md).',
             '', '## The ones you need', '',
             'Most trials need no other settings of the analysis than these. The defaults of the',
             'others fit.', '', *_table(needed()), '',
             'These were settings, and have one value now. A file or a bag that states it is read',
             'as before; any other value is an error.', '',
             *(f'* `{name}`: {_scalar(value)}' for name, value in Settings.REMOVED.items())]
    return '\n'.join([*lines, *_tabulate(CHAPTERS)]) + '\n'


def scenario_tables() -> str:
    """Return the text of docs/scenario_settings.md."""
    lines = ['# Settings of scenarios', '',
             'Written by `docs/generate.py`, as [settings.md](settings.md). What the models are, '
             'and which',
             'errors each has, is in [ahrs.md](ahrs.md).']
    return '\n'.join([*lines, *_tabulate(SCENARIO_CHAPTERS)]) + '\n'


def _tabulate(chapters: Iterable[tuple[str, str, type]]) -> Iterator[str]:
    """Yield the lines of a table of settings per chapter."""
    for title, comment, settings in chapters:
        yield from ('', f'## {title}', '', f'{comment} Class `{settings.__module__}.'
                    f'{settings.__qualname__}`.', '', *_table(
                        rule for rule in list_settings(settings)
                        if settings is not Scenario or not rule.name.startswith(('ts.', 'rs.'))))


def schema() -> str:
    """Return the text of schema/verdict.schema.json."""
    return json.dumps(make_schema(), indent=1, ensure_ascii=False) + '\n'


def keys(text: str) -> str:
    """Return docs/verdict_json.md with a table of the keys of each dataclass of a verdict."""
    parts = {'Verdict': make_schema(), **make_schema()['$defs']}
    tables = {name: {key: declared['description'] for key, declared in part['properties'].items()}
              for name, part in parts.items()}
    for kind in (SensorsVerdict, SensorResult, SensorVariance, PairFigures, Vote):
        tables[kind.__name__] = {key: figure.text for key, figure in list_figures(kind).items()
                                 if '.' not in key}
    for name, rows in tables.items():
        text = _fill(text, name, '| key | meaning |\n|---|---|\n' + ''.join(
            f'| `{key}` | {_link(_cell(words))} |\n' for key, words in rows.items()))
    return text


def _link(text: str, folder: str = '') -> str:
    """Return a text in which the name of a page leads to it."""
    return re.sub(r'\b\w+\.md\b', lambda name: f'[{name[0]}]({folder}{name[0]})', text)


def columns(text: str) -> str:
    """Return docs/howto/judge_many.md with the columns of the table of runs."""
    figures = list_figures(RunVerdict)
    rows = ''.join(f'| `{column}` | {_link(_cell(_describe(column, key, figures)), "../")} |\n'
                   for column, key in COLUMNS.items())
    return _fill(text, 'columns', f'| column | holds |\n|---|---|\n{rows}')


def _describe(column: str, key: str, figures: Mapping[str, Figure]) -> str:
    if key not in figures:
        return inspect.getdoc(getattr(RunVerdict, key)).removeprefix('Return the ').replace(
            '``', '`').rstrip('.')
    return f'{figures[key].words} as text in UTC' if column.endswith('_utc') else figures[key].text


def _module_rows() -> Iterator[str]:
    package = ROOT / 'heading_intercompare'
    order = ('core', 'drivers', 'ahrs', 'messages', 'bags', 'journal', 'report', 'nodes', 'app',
             'cli')

    def place(path: Path) -> tuple[int, tuple[str, ...]]:
        *folders, name = path.relative_to(package).parts
        at = order.index(folders[0]) if folders and folders[0] in order else len(order)
        return at + 1 if folders else 0, (*folders, '' if name == '__init__.py' else name)

    for path in sorted(package.rglob('*.py'), key=place):
        tree = ast.parse(path.read_text('utf-8'))
        summary = (ast.get_docstring(tree) or '').partition('\n\n')[0].replace('\n', ' ')
        if path.stem == '__init__':
            if path.parent != package:
                room = path.parent.relative_to(package).as_posix()
                yield f'| **`{room}`** | {_cell(summary)} |'
            continue
        yield (f'| `{path.relative_to(package).with_suffix("").as_posix()}` '
               f'| {_cell(summary)} |')


def _fill(text: str, place: str, table: str) -> str:
    """Return a page with a table between ``<!-- place -->`` and ``<!-- end of place -->``."""
    head, mark, rest = text.partition(f'<!-- {place} -->\n')
    return head + mark + table + rest[rest.index(f'<!-- end of {place} -->'):]


def architecture(text: str) -> str:
    """Return docs/ARCHITECTURE.md with an updated list of modules."""
    rows = '\n'.join(_module_rows())
    return _fill(text, 'modules', f'| module | is for |\n|---|---|\n{rows}\n')


def refusals(text: str) -> str:
    """Return docs/refusals.md with what each condition says of itself."""
    void, doubtful = '', ''
    for condition in CONDITIONS:
        if condition.void:
            void += f'| `{condition.name}` | {condition.void_when} | {condition.void_why} |\n'
        if condition.doubtful_when:
            doubtful += f'| `{condition.name}` | {condition.doubtful_when} |\n'
    text = _fill(text, 'void', f'| condition | void when | why |\n|---|---|---|\n{void}')
    return _fill(text, 'doubtful', f'| condition | doubtful when |\n|---|---|\n{doubtful}')


if __name__ == '__main__':
    YAML.write_text(parameter_file(), 'utf-8')
    TABLES.write_text(tables(), 'utf-8')
    SCENARIOS.write_text(scenario_tables(), 'utf-8')
    SCHEMA.write_text(schema(), 'utf-8')
    ARCHITECTURE.write_text(architecture(ARCHITECTURE.read_text('utf-8')), 'utf-8')
    REFUSALS.write_text(refusals(REFUSALS.read_text('utf-8')), 'utf-8')
    KEYS.write_text(keys(KEYS.read_text('utf-8')), 'utf-8')
    RUNS.write_text(columns(RUNS.read_text('utf-8')), 'utf-8')
    print('wrote', *(str(p.relative_to(ROOT)) for p in (
        YAML, TABLES, SCENARIOS, SCHEMA, ARCHITECTURE, REFUSALS, KEYS, RUNS)))
