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

"""The allowed imports, the limits of core, and the outward form of every file."""

from __future__ import annotations

import ast
from graphlib import TopologicalSorter
from importlib import import_module
from pathlib import Path
import pickle
import pydoc
import re
import subprocess
import sys
from typing import Iterator, NamedTuple

import pytest

from heading_intercompare import node_executables
from heading_intercompare.core import lazy_scipy

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = ROOT / 'heading_intercompare'

MESSAGES = {'(messages)', 'diagnostic_msgs', 'geometry_msgs', 'nav_msgs', 'rcl_interfaces',
            'rosgraph_msgs', 'sensor_msgs', 'std_msgs', 'std_srvs'}


class Allowed(NamedTuple):
    """What the modules of one folder may import beside the standard library and each other."""

    package: set[str]
    others: set[str]


# The table of docs/ARCHITECTURE.md, "Who may import whom". A file beside the folders is a row
# like a folder; `cli` may be either.
ALLOWED = {
    '__init__': Allowed({'core', 'drivers', 'bags', 'app'}, set()),
    'natural_order': Allowed(set(), set()),
    'yaml_file': Allowed({'core'}, {'yaml'}),
    'missing_module': Allowed(set(), set()),
    'replaced_file': Allowed(set(), set()),
    'special_files': Allowed(set(), set()),
    'node_executables': Allowed({'nodes', 'missing_module'}, set()),
    'core': Allowed(set(), {'numpy', 'scipy', 'pandas'}),
    'drivers': Allowed({'core', 'natural_order', 'special_files'},
                       {'httpx', 'numpy', 'serial', 'zstandard'}),
    'ahrs': Allowed({'core'}, {'numpy', 'numba'}),
    'messages': Allowed({'core'}, {'numpy'}),
    'bags': Allowed({'core', 'messages', 'natural_order', 'yaml_file', 'replaced_file',
                     'special_files'},
                    {'numpy', 'mcap', 'lz4', 'zstandard', 'isal'}),
    'journal': Allowed({'core', 'messages', 'bags'}, {'numpy'}),
    'readers': Allowed({'core', 'drivers', 'messages', 'bags', 'natural_order'},
                       {'numpy', 'rosbags', 'apsw', 'pyarrow'}),
    'report': Allowed({'core', 'replaced_file', 'special_files'},
                      {'numpy', 'jinja2', 'matplotlib', 'segno', 'weasyprint'}),
    'logbook': Allowed({'core', 'replaced_file'}, {'numpy'}),
    'web': Allowed({'core', 'messages'}, {'numpy', 'nicegui', 'fastapi', 'uvicorn'}),
    'nodes': Allowed({'core', 'drivers', 'ahrs', 'messages', 'bags', 'journal', 'report',
                      'logbook', 'web', 'replaced_file'},
                     {'numpy', 'rclpy'} | MESSAGES),
    'app': Allowed({'core', 'drivers', 'ahrs', 'messages', 'bags', 'journal', 'readers', 'report',
                    'logbook', 'yaml_file', 'replaced_file', 'special_files'},
                   {'numpy', 'distributed', 'threadpoolctl', 'ephem', 'pyarrow'}),
    'cli': Allowed({'app', 'core', 'drivers', 'ahrs', 'messages', 'bags', 'journal', 'readers',
                    'report', 'logbook', 'nodes', 'web', 'missing_module', 'replaced_file'},
                   {'numpy', 'yaml', 'rich', 'argcomplete'}),
    '__main__': Allowed({'cli'}, set()),
}

def read_order() -> dict[str, tuple[str, ...]]:
    """Return the table of docs/ARCHITECTURE.md, "Rooms": a room imports what stands before it."""
    text = (ROOT / 'docs' / 'ARCHITECTURE.md').read_text('utf-8')
    section = text.partition('## Rooms')[2].partition('## Who may')[0]
    rows = re.findall(r'^\| `(\w+)` \|([^|]*)\|', section, re.MULTILINE)
    return {name: tuple(re.findall(r'`(\w+)`', order)) for name, order in rows}


ORDER = read_order()

# The libraries of each extra, and the only modules that may load them.
LOADED_BY = {
    'jinja2': {'report/html'}, 'weasyprint': {'report/pdf'},
    'segno': {'report/contents/verdict_code'},
    'matplotlib': {'report/figures/style'},
    'rosbags': {'readers/rosbag_recording'}, 'apsw': {'readers/rosbag_recording'},
    'pyarrow': {'readers/parquet', 'app/history_parquet'},
    'ephem': {'app/observations/sun'}, 'httpx': {'drivers/alerts/alert_push'},
    'distributed': {'app/cluster'}, 'argcomplete': {'cli/completion'},
    'rich': {'cli/terminal/console', 'cli/terminal/progress', 'cli/terminal/live_view'},
    'nicegui': {'web/page', 'web/server'}, 'fastapi': {'web/server'}, 'uvicorn': {'web/server'},
}

# Core is a function of its input: it reads no clock, file or network, and says nothing.
FORBIDDEN_IN_CORE = {'asyncio', 'concurrent', 'datetime', 'io', 'logging', 'multiprocessing', 'os',
                     'pathlib', 'queue', 'random', 'sched', 'shutil', 'signal', 'socket',
                     'subprocess', 'sys', 'tempfile', 'threading', 'time', 'warnings'}

HEADER = """\
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

CALLS = ('__import__', 'import_module')


class Import(NamedTuple):
    """One import statement, anywhere in a module."""

    line: int
    name: str


def computed_name(argument: ast.expr) -> str:
    """Return the argument of `import_module`, or the constant or '.msg' around what it names."""
    if ast.unparse(argument) == "f'{package}.msg'":
        return '(messages)'
    if isinstance(argument, ast.JoinedStr) and argument.values:
        argument = argument.values[0]
    return argument.value if isinstance(argument, ast.Constant) else '(computed)'


def imports(source: str, package: tuple[str, ...]) -> Iterator[Import]:
    """Yield the absolute name of everything a module of `package` imports."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = package[:len(package) - node.level + 1] if node.level else ()
            module = '.'.join((*base, *([node.module] if node.module else [])))
            # `from heading_intercompare import core` names a folder, not an attribute.
            names = ([f'{module}.{alias.name}' for alias in node.names]
                     if module in ('', 'heading_intercompare') else [module])
        elif isinstance(node, ast.Call) and getattr(
                node.func, 'id', getattr(node.func, 'attr', '')) in CALLS:
            names = [computed_name(node.args[0])]
        else:
            continue
        for name in names:
            yield Import(node.lineno, name)


def offences(folder: str, source: str, package: tuple[str, ...]) -> list[str]:
    """Return the forbidden imports of a module of a folder, with their lines."""
    if folder not in ALLOWED:
        return [f'the folder {folder!r} is no row of the table']
    rule = ALLOWED[folder]
    found = []
    for line, name in imports(source, package):
        distribution, _, rest = name.partition('.')
        inner = rest.split('.')[0]
        if distribution == 'heading_intercompare':
            good = inner in rule.package or inner == folder
        elif distribution in sys.stdlib_module_names:
            good = folder != 'core' or distribution not in FORBIDDEN_IN_CORE
        else:
            # The package loads the modules that it offers names of.
            good = distribution in rule.others or (folder, name) == ('__init__', '(computed)')
        if not good:
            found.append(f'line {line}: {folder} may not import {name}')
    return found


def out_of_order(module: str, source: str, package: tuple[str, ...]) -> list[str]:
    """Return the imports of a module, named from its folder on, from rooms after its own."""
    folder, place = module.split('.')[:2]
    order, found = ORDER[folder], []
    if place not in order:
        return [f'{place!r} is no room of {folder!r}']
    for line, name in imports(source, package):
        parts = name.split('.')
        if parts[:2] == ['heading_intercompare', folder] and len(parts) > 2 and (
                parts[2] not in order[:order.index(place) + 1]):
            found.append(f'line {line}: {folder}/{place} may not import {name}')
    return found


def folder_of(path: Path) -> str:
    """Return the row of the table that a module of the package belongs to."""
    return path.relative_to(PACKAGE).with_suffix('').parts[0]


def package_of(path: Path) -> tuple[str, ...]:
    """Return the package that relative imports of the module start from."""
    return path.relative_to(ROOT).parent.parts


MODULES = sorted(PACKAGE.rglob('*.py'))
MODULE_OF = {'.'.join(p.relative_to(ROOT).with_suffix('').parts): p for p in MODULES}
SOURCES = sorted(p for top in ('heading_intercompare', 'test', 'launch', 'examples', 'benchmarks',
                               'docs') for p in (ROOT / top).rglob('*.py'))
SOURCES += [ROOT / 'setup.py', ROOT / 'conftest.py']
TEXTS = SOURCES + sorted(
    p for p in [*ROOT.iterdir(), *(q for top in ('config', 'docs', 'launch', '.ci', 'examples',
                                                 'benchmarks', 'test')
                                   for q in (ROOT / top).rglob('*'))]
    if p.is_file() and p.suffix in ('', '.md', '.rst', '.txt', '.toml', '.cfg', '.xml', '.yaml')
    and '__pycache__' not in p.parts and p.name != '.git')


def relative(path: Path) -> str:
    """Return the name of a parametrised test."""
    return str(path.relative_to(ROOT))


@pytest.mark.parametrize('path', MODULES, ids=relative)
def test_a_module_imports_only_what_its_folder_may(path):
    assert offences(folder_of(path), path.read_text('utf-8'), package_of(path)) == []


@pytest.mark.parametrize('folder, statement', [
    ('core', 'import time'),
    ('core', 'from datetime import datetime'),
    ('core', 'import os.path'),
    ('core', 'def f():\n    import random'),
    ('core', 'import rclpy'),
    ('core', 'from heading_intercompare.nodes.compliance import Compliance'),
    ('core', 'from ..drivers import nmea'),
    ('core', 'import importlib\nimportlib.import_module("heading_intercompare.cli")'),
    ('core', 'import importlib\nimportlib.import_module(name)'),
    ('drivers', 'from heading_intercompare.bags.recording.bag_writer import BagWriter'),
    ('drivers', 'from heading_intercompare import bags'),
    ('drivers', 'import rclpy'),
    ('nodes', 'from scipy import signal'),
    ('nodes', 'from heading_intercompare.cli import main'),
    ('__init__', 'from .readers.registry import FORMS'),
    ('report', 'from heading_intercompare.nodes.interface import qos'),
    ('messages', 'from heading_intercompare.bags.errors import BagError'),
    ('messages', 'from std_msgs.msg import String'),
    ('messages', 'import_module(f"{package}.msg")'),
    ('nodes', 'import_module(f"{package}.srv")'),
    ('helpers', 'import math'),
    ('cli', 'from distributed import Client'),
    ('app', 'from rich.console import Console'),
])
def test_the_check_sees_a_forbidden_import(folder, statement):
    package = ('heading_intercompare',) + (() if folder.startswith('__') else (folder,))
    assert len(offences(folder, statement, package)) == 1


@pytest.mark.parametrize('folder, statement', [
    ('core', 'import math\nimport numpy as np\nfrom .records import Pairs'),
    ('nodes', 'import numpy as np\nimport rclpy\nfrom sensor_msgs.msg import Imu'),
    ('drivers', 'import socket\nfrom heading_intercompare.core.records import Headings'),
    ('cli', 'from heading_intercompare import core'),
    ('cli', 'import_module(f"heading_intercompare.cli.{name}")'),
    ('nodes', 'import_module(f"{package}.msg")'),
])
def test_the_check_lets_an_allowed_import_pass(folder, statement):
    assert offences(folder, statement, ('heading_intercompare', folder)) == []


@pytest.mark.parametrize('path', [p for p in MODULES if folder_of(p) in ORDER
                                  and (p.stem != '__init__' or p.parent.parent != PACKAGE)],
                         ids=relative)
def test_a_module_imports_only_rooms_that_stand_before_its_own(path):
    module = '.'.join(path.relative_to(PACKAGE).with_suffix('').parts)
    assert out_of_order(module, path.read_text('utf-8'), package_of(path)) == []


def imported_at_start(path: Path) -> set[Path]:
    """Return the modules of the package that a module imports when it is loaded."""
    tree = ast.parse(path.read_text('utf-8'))
    tree.body = [node for node in tree.body
                 if not isinstance(node, (ast.FunctionDef, ast.ClassDef))
                 and not (isinstance(node, ast.If) and 'TYPE_CHECKING' in ast.dump(node.test))]
    names = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            base = package_of(path)[:len(package_of(path)) - node.level + 1] if node.level else ()
            module = '.'.join((*base, *([node.module] if node.module else [])))
            names |= {module, *(f'{module}.{alias.name}' for alias in node.names)}
    return {MODULE_OF[name] for name in names if name in MODULE_OF} - {path}


def test_no_module_imports_itself_through_others():
    order = TopologicalSorter({path: imported_at_start(path) for path in MODULES}).static_order()
    assert {*order} == {*MODULES}


@pytest.mark.parametrize('module, statement', [
    ('core.pairing.pairer', 'from heading_intercompare.core.verdict.judge import judge_run'),
    ('core.settings', 'from .offline import judge_aligned'),
    ('core.statistics.cells', 'from ..runs import run_series'),
    ('core.helpers.sums', 'import math'),
    ('bags.mcap.chunks', 'from heading_intercompare.bags.recovery import scanner'),
])
def test_the_check_sees_an_import_against_the_order(module, statement):
    package = ('heading_intercompare', *module.split('.')[:-1])
    assert len(out_of_order(module, statement, package)) == 1


@pytest.mark.parametrize('module, statement', [
    ('core.pairing.pairer', 'from .ledger import Ledger\nfrom heading_intercompare.core.angles '
     'import wrap180'),
    ('core.pipeline', 'from .verdict.judge import judge'),
    ('bags.rosbag2.bag_reader', 'from heading_intercompare.core.offline import judge_aligned'),
])
def test_the_check_lets_an_import_along_the_order_pass(module, statement):
    package = ('heading_intercompare', *module.split('.')[:-1])
    assert out_of_order(module, statement, package) == []


ROOMS = sorted(p.parent for p in MODULES if p.stem == '__init__' and p.parent != PACKAGE)


@pytest.mark.parametrize('room', ROOMS, ids=relative)
def test_a_room_says_what_it_is_for(room):
    assert ast.get_docstring(ast.parse((room / '__init__.py').read_text('utf-8')))


@pytest.mark.slow
@pytest.mark.parametrize('room', ROOMS, ids=relative)
def test_no_function_of_a_room_differs_from_a_class_in_case_only(room):
    names = {ast.FunctionDef: set(), ast.ClassDef: set()}
    for path in room.glob('*.py'):
        for node in ast.parse(path.read_text('utf-8')).body:
            if type(node) in names:
                names[type(node)].add(node.name.lower().replace('_', ''))
    # Like `field` and `Field` of dataclasses.
    assert set.intersection(*names.values()) - {'setting', 'figure'} == set()


def test_the_package_offers_its_names_in_every_way_of_asking():
    package, taken = import_module('heading_intercompare'), {}
    exec('from heading_intercompare import *', taken)
    assert {*package.__all__} == {*dir(package)} == {*taken} - {'__builtins__'}
    assert taken['Settings'] is package.Settings
    assert pickle.loads(pickle.dumps(package.Settings())) == package.Settings()
    page = pydoc.plain(pydoc.render_doc(package))
    assert {name for name in package.__all__ if name not in page} <= {'__version__'}


def test_the_package_says_which_name_it_has_not():
    with pytest.raises(AttributeError, match="'heading_intercompare' has no attribute 'no'"):
        import_module('heading_intercompare').no()


def test_type_checkers_see_the_names_that_the_package_offers():
    package = import_module('heading_intercompare')
    tree = ast.parse(Path(package.__file__).read_text('utf-8'))
    block, = (node for node in tree.body if isinstance(node, ast.If))
    seen = {node.module: tuple(alias.name for alias in node.names) for node in block.body}
    assert seen == package._OFFERED


def loaded(code: str) -> set[str]:
    """Return the modules that a process has loaded after running some code."""
    done = subprocess.run([sys.executable, '-c', f'{code}\nimport sys\nprint(*sys.modules)'],
                          cwd=ROOT, check=True, capture_output=True, text=True)
    return {*done.stdout.splitlines()[-1].split()}


def test_importing_the_package_loads_neither_numbers_nor_ros_nor_an_edge():
    edges = {*ALLOWED} - {'core', '__init__'}
    assert loaded('import heading_intercompare') & {
        'numpy', 'scipy', 'rclpy', *(f'heading_intercompare.{edge}' for edge in edges)} == set()


@pytest.mark.parametrize('question', ['--version', '--help'])
def test_the_command_line_answers_without_loading_numbers_or_ros(question):
    code = ('from heading_intercompare.cli import main\n'
            'try:\n'
            f'    main(["{question}"])\n'
            'except SystemExit:\n'
            '    pass')
    assert loaded(code) & {'numpy', 'scipy', 'rclpy', 'yaml', *LOADED_BY} == set()


@pytest.mark.slow
def test_what_an_extra_brings_is_imported_only_where_it_is_used():
    found = {library: set() for library in LOADED_BY}
    for path in MODULES:
        for _, name in imports(path.read_text('utf-8'), package_of(path)):
            if name.partition('.')[0] in LOADED_BY:
                module = path.relative_to(PACKAGE).with_suffix('').as_posix()
                found[name.partition('.')[0]].add(module)
    assert found == LOADED_BY


@pytest.mark.slow
@pytest.mark.parametrize('name', ['cli.commands.analyze', 'report',
                                  'cli.commands.graph.demo', 'app.analysis', 'nodes.compliance'])
def test_who_may_write_a_protocol_loads_what_it_needs_only_then(name):
    if name.startswith('nodes.'):
        pytest.importorskip('rclpy')
    assert loaded(f'import heading_intercompare.{name}') & {*LOADED_BY} == set()


@pytest.mark.slow
@pytest.mark.parametrize('name', ['core.records', 'core.pairing.pairer', 'drivers.nmea',
                                  'drivers.sources', 'bags.rosbag2.bag_reader', 'bags.recording',
                                  'cli.program', 'cli.commands.info',
                                  'core.offline', 'core.diagnostics.three_cornered_hat',
                                  'logbook.control_chart',
                                  *(f'nodes.{node}' for node in node_executables.__all__)])
def test_nothing_loads_scipy_before_it_is_used(name):
    if name.startswith('nodes.'):
        pytest.importorskip('rclpy')
    assert 'scipy' not in loaded(f'import heading_intercompare.{name}')


JUDGE = """
import sys
import numpy as np
from heading_intercompare import Compliance, Pairs, Settings
from heading_intercompare.core.alarms.comparison_watch import ComparisonWatch
settings = Settings.of(norms={'sigma_max_deg': 0.3, 'sigma_ref_max_deg': 0.1}, model='UN')
watch, judge = ComparisonWatch(settings), Compliance(settings)
before = 'scipy' in sys.modules
stamps = 10**18 + np.arange(900) * 10**9
judge.update(Pairs.of(stamps, 90.0 + 0.1 * np.sin(stamps % 7919), np.full(900, 90.0)))
judge.finish()
print(before, 'scipy' in sys.modules, judge.verdict().runs[0].n)
"""


@pytest.mark.slow
def test_a_judge_loads_scipy_with_its_first_judgement():
    done = subprocess.run([sys.executable, '-c', JUDGE], cwd=ROOT, check=True,
                          capture_output=True, text=True)
    assert done.stdout.split()[:3] == ['False', 'True', '900']


@pytest.mark.parametrize('path', MODULES, ids=relative)
def test_one_module_alone_imports_scipy(path):
    names = {name for _, name in imports(path.read_text('utf-8'), package_of(path))
             if name.partition('.')[0] == 'scipy'}
    is_lazy = path == PACKAGE / 'core' / 'lazy_scipy.py'
    assert names == ({'scipy'} if is_lazy else set())


def test_the_parts_of_scipy_that_are_used_are_those_that_can_be_loaded():
    used = {part for path in MODULES if 'lazy_scipy as scipy' in (text := path.read_text('utf-8'))
            for part in re.findall(r'\bscipy\.(\w+)\.', text)}
    assert used == {*lazy_scipy._PARTS}
    assert all(getattr(lazy_scipy, part) is import_module(f'scipy.{part}') for part in used)


def test_a_part_that_scipy_is_not_used_for_is_an_error():
    with pytest.raises(AttributeError, match="'heading_intercompare.core.lazy_scipy' has no "):
        lazy_scipy.stats.norm()


def table_of_the_docs() -> dict[str, Allowed]:
    """Return the import table of docs/ARCHITECTURE.md."""
    text = (ROOT / 'docs' / 'ARCHITECTURE.md').read_text('utf-8')
    section = text.split('## Who may import whom')[1].split('\n## ')[0]
    rows = re.findall(r'^\| `(\w+)` \|([^|]*)\|([^|]*)\|', section, re.MULTILINE)
    return {name: Allowed(set(re.findall(r'`(\w+)`', package)),
                          set(re.findall(r'`(\w+)`', others)))
            for name, package, others in rows}


def test_the_table_of_the_docs_is_the_one_the_test_enforces():
    expected = {name: Allowed(rule.package, rule.others - MESSAGES)
                for name, rule in ALLOWED.items()}
    assert table_of_the_docs() == expected


def test_the_order_of_the_docs_names_every_room_and_module_beside_the_rooms():
    assert {*ORDER} == {'core', 'drivers', 'ahrs', 'bags', 'readers', 'report', 'web', 'nodes',
                        'cli'}
    for folder, order in ORDER.items():
        places = {p.stem for p in (PACKAGE / folder).iterdir()
                  if not p.stem.startswith('__')
                  and (p.suffix == '.py' or (p / '__init__.py').is_file())}
        assert set(order) == places and len(set(order)) == len(order), folder


def test_every_module_is_named_in_the_architecture():
    text = (ROOT / 'docs' / 'ARCHITECTURE.md').read_text('utf-8')
    missing = [relative(p) for p in MODULES if p.stem != '__init__'
               and f'`{"/".join(p.relative_to(PACKAGE).with_suffix("").parts)}`' not in text]
    assert missing == []


def test_the_architecture_names_no_module_that_is_not_there():
    text = (ROOT / 'docs' / 'ARCHITECTURE.md').read_text('utf-8')
    folders = '|'.join(sorted(name for name in ALLOWED if not name.startswith('__')))
    named = set(re.findall(rf'`((?:{folders})(?:/\w+)+)`', text))
    assert named
    assert sorted(n for n in named if not (PACKAGE / f'{n}.py').is_file()
                  and not (PACKAGE / n).is_dir()) == []


def test_a_module_of_tests_lies_in_the_folder_of_what_it_tests():
    folders = {str(p.parent.relative_to(ROOT / 'test'))
               for p in (ROOT / 'test').rglob('test_*.py')}
    assert folders <= {str(p.parent.relative_to(PACKAGE)) for p in MODULES}


def test_the_places_of_a_newcomers_changes_are_there():
    named = re.findall(r'`(heading_intercompare/[^`]*)`', (ROOT / 'CONTRIBUTING.md').read_text())
    assert len(named) >= 10
    assert [place for place in named if not (ROOT / place).exists()] == []


def test_a_room_has_tests():
    tested = {str(p.parent.relative_to(ROOT / 'test')) for p in (ROOT / 'test').rglob('test_*.py')}
    assert {str(p.parent.relative_to(PACKAGE)) for p in MODULES} <= tested


def test_a_source_file_says_whose_it_is_and_under_what_licence():
    """In the words that ament_copyright knows."""
    texts = {path: re.sub(r'^#!.*\n', '', path.read_text('utf-8')) for path in SOURCES}
    assert [relative(path) for path, text in texts.items()
            if text and not text.startswith(HEADER)] == []


def test_a_source_file_keeps_to_99_columns():
    long = [f'{relative(path)}:{i}' for path in SOURCES
            for i, line in enumerate(path.read_text('utf-8').splitlines(), 1) if len(line) > 99]
    assert long == []


def test_no_file_names_a_place_of_one_machine():
    place = re.compile(r'(?<![\w.$}>*])/(?:home|root|Users|work|mnt|media)/\w')
    found = [f'{relative(path)}:{i}: {line.strip()}' for path in TEXTS
             for i, line in enumerate(path.read_text('utf-8', 'replace').splitlines(), 1)
             if place.search(line)]
    assert found == []


def test_the_package_knows_nothing_of_data_beside_the_checkout():
    found = [relative(path) for path in TEXTS
             if path.relative_to(ROOT).parts[0] not in ('test', 'benchmarks')
             and re.search(r'\bshared/(data|design)\b', path.read_text('utf-8', 'replace'))]
    assert found == []


def test_core_opens_no_file_and_prints_nothing():
    found = [f'{relative(path)}:{node.lineno}' for path in (PACKAGE / 'core').rglob('*.py')
             for node in ast.walk(ast.parse(path.read_text('utf-8')))
             if isinstance(node, ast.Call)
             and getattr(node.func, 'id', '') in ('open', 'print', 'input', 'exec', 'eval')]
    assert found == []


def test_commands_print_in_the_one_place_that_escapes_foreign_names():
    found = [f'{relative(path)}:{node.lineno}' for path in (PACKAGE / 'cli' / 'commands').rglob(
                 '*.py') for node in ast.walk(ast.parse(path.read_text('utf-8')))
             if isinstance(node, ast.Call) and getattr(node.func, 'id', '') == 'print']
    assert found == []


def test_nothing_catches_every_exception():
    found = [f'{relative(path)}:{node.lineno}' for path in SOURCES
             for node in ast.walk(ast.parse(path.read_text('utf-8')))
             if isinstance(node, ast.ExceptHandler)
             and (node.type is None or getattr(node.type, 'id', '') in ('Exception',
                                                                        'BaseException'))]
    assert found == []


def test_no_number_depends_on_a_global_random_state():
    found = [f'{relative(path)}:{node.lineno}' for path in MODULES
             for node in ast.walk(ast.parse(path.read_text('utf-8')))
             if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Attribute)
             and node.value.attr == 'random' and getattr(node.value.value, 'id', '') == 'np'
             and node.attr not in ('default_rng', 'Generator', 'SeedSequence', 'PCG64')]
    assert found == []


def test_the_tests_import_each_other_by_absolute_names():
    """Other tools load a file of tests by its path, without a package around it."""
    found = [f'{p.relative_to(ROOT)}:{node.lineno}' for p in (ROOT / 'test').rglob('*.py')
             for node in ast.walk(ast.parse(p.read_text('utf-8')))
             if isinstance(node, ast.ImportFrom) and node.level]
    assert found == []
