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
One tree for pip and for colcon: what is declared, and what the two make of it.

The slow tests install a copy of the checkout for real; pip needs its package index for that.
"""

from __future__ import annotations

import ast
from importlib.util import find_spec
import json
import os
from pathlib import Path
import random
import re
import shutil
import signal
import subprocess
import sys
import time
from xml.etree import ElementTree

from deadlines import DEADLINE_S
import pytest
import yaml

from heading_intercompare import __version__, node_executables as executables

ROOT = Path(__file__).resolve().parent.parent
NAME = 'heading_intercompare'
NODES = ('nmea_driver', 'sensor_simulator', 'synchronizer', 'compliance', 'intercompare',
         'recorder', 'replayer', 'dashboard', 'motion_driver', 'alert_sender')
IN_CI = os.environ.get('CI', '').lower() not in ('', '0', 'false')


def run(*command: str | Path, cwd: Path, **variables: str) -> subprocess.CompletedProcess:
    """Run a command outside the checkout, without its folder on the path of Python."""
    environment = {k: v for k, v in os.environ.items() if k != 'PYTHONPATH'}
    return subprocess.run([str(word) for word in command], cwd=cwd, text=True, timeout=600,
                          stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, env={**environment, **variables})


def need(module: str) -> None:
    """Skip if a tool is missing; fail if CI is set."""
    if find_spec(module) is None:
        (pytest.fail if IN_CI else pytest.skip)(f'{module} is not installed')


@pytest.fixture
def source(tmp_path):
    """Return a copy of the checkout in a workspace, without anything built."""
    target = tmp_path / 'workspace' / 'src' / NAME
    shutil.copytree(ROOT, target, ignore=shutil.ignore_patterns(
        '.git', '.venv*', 'build', 'install', 'log', '*.egg-info', '__pycache__', '.*_cache',
        '.hypothesis', 'demo_out'))
    return target


def manifest() -> ElementTree.Element:
    """Return package.xml."""
    return ElementTree.parse(ROOT / 'package.xml').getroot()


def test_the_version_is_the_same_everywhere():
    assert manifest().findtext('version') == __version__
    assert re.fullmatch(r'\d+\.\d+\.\d+', __version__)
    changelog = (ROOT / 'CHANGELOG.rst').read_text('utf-8')
    newest, *_ = re.findall(r'^(\d+\.\d+\.\d+) \(\d{4}-\d\d-\d\d\)\n-+$', changelog, re.MULTILINE)
    assert newest == __version__


#: Keys of rosdistro, looked up in August 2026, and the module of each; None: not in wheels.
KEYS = {
    'python3-numpy': 'numpy', 'python3-scipy': 'scipy', 'python3-yaml': 'yaml',
    'python3-jinja2': 'jinja2', 'python3-matplotlib': 'matplotlib', 'python3-serial': 'serial',
    'python3-pytest': 'pytest', 'python3-pytest-timeout': 'pytest_timeout',
    'python3-pytest-xdist': 'xdist', 'python3-hypothesis': 'hypothesis',
    'python3-jsonschema': 'jsonschema', 'mcap-ros2-support': 'mcap_ros2',
    'ros2launch': None, 'launch': None, 'launch_ros': None,
    'ament_copyright': None, 'ament_flake8': None, 'ament_pep257': None,
    **{name: name for name in ('rclpy', 'rcl_interfaces', 'rosgraph_msgs', 'diagnostic_msgs',
                               'geometry_msgs', 'nav_msgs', 'sensor_msgs', 'std_msgs',
                               'std_srvs')}}


def dependencies(*kinds: str) -> set[str]:
    """Return the dependencies of package.xml, of some kinds."""
    return {element.text for kind in kinds for element in manifest().iter(kind)}


def test_every_dependency_has_a_key_of_rosdistro_and_a_wheel():
    asked = dependencies('depend', 'build_depend', 'exec_depend', 'test_depend')
    assert asked <= KEYS.keys()
    need('rclpy')
    missing = {key for key in asked if KEYS[key] and find_spec(KEYS[key]) is None}
    assert not missing


def test_what_every_bag_needs_is_a_dependency_and_so_is_each_library_that_pip_installs():
    setup = (ROOT / 'setup.py').read_text('utf-8')
    required = re.search(r'install_requires=\[([^]]*)\]', setup)[1]
    keys = {'numpy': 'python3-numpy', 'scipy': 'python3-scipy', 'pyyaml': 'python3-yaml',
            # It brings the three of them.
            **dict.fromkeys(('mcap', 'lz4', 'zstandard'), 'mcap-ros2-support')}
    assert {keys[name] for name in re.findall(r"'([a-z0-9]+)", required)} <= dependencies(
        'exec_depend')


def test_libraries_without_a_key_have_a_rule_beside_the_package():
    rules = yaml.safe_load((ROOT / 'rosdep' / f'{NAME}.yaml').read_text('utf-8'))
    named = {name.removeprefix('python3-').removesuffix('-pip') for name in rules}
    assert {'mcap', 'lz4', 'zstandard', 'nicegui', 'pyarrow', 'ephem', 'isal', 'distributed',
            'threadpoolctl'} == named
    assert not rules.keys() & KEYS.keys()
    for name, rule in rules.items():
        assert rule.keys() == {'debian', 'ubuntu'}, name
        for one in rule.values():
            assert one == [name] or list(one['pip']['packages']) == [
                name.removeprefix('python3-').removesuffix('-pip')]


def test_the_changelog_is_in_catkin_form():
    lines = (ROOT / 'CHANGELOG.rst').read_text('utf-8').splitlines()
    assert lines[1] == f'Changelog for package {NAME}'
    assert lines[0] == lines[2] == '^' * len(lines[1])


def test_name_licence_and_maintainer_are_those_of_setup_py():
    text = (ROOT / 'setup.py').read_text('utf-8')
    assert manifest().findtext('name') == NAME
    assert manifest().findtext('license') == 'Apache-2.0'
    assert '@' not in text, 'package.xml is the only place of addresses'
    assert 'Apache License' in (ROOT / 'LICENSE').read_text('utf-8')[:200]


def test_a_release_fails_until_the_owner_has_entered_the_addresses(tmp_path):
    check = [sys.executable, ROOT / '.ci' / 'addresses']
    text = (ROOT / 'package.xml').read_text('utf-8')
    filled = re.sub(r'[.]example"', '.org"', text).replace('<author>', (
        '<url type="repository">https://h.test/r</url>'
        '<url type="bugtracker">https://h.test/i</url><author>'))
    (tmp_path / 'filled.xml').write_text(filled)
    assert run(*check, 'filled.xml', cwd=tmp_path).returncode == 0
    for name, gone in (('maintainer', ('.org"', '.example"')), ('url', ('bugtracker', 'website'))):
        (tmp_path / 'package.xml').write_text(filled.replace(*gone))
        done = run(*check, cwd=tmp_path)
        assert done.returncode == 1 and done.stdout.startswith(f'package.xml: {name}: ')
        assert len(done.stdout.splitlines()) == 1
    makefile = (ROOT / 'Makefile').read_text('utf-8')
    assert re.search(r'^release: addresses ', makefile, re.MULTILINE)


def test_the_container_is_made_with_the_steps_of_the_page():
    made = (ROOT / 'Dockerfile').read_text('utf-8')
    page = (ROOT / 'docs' / 'install.md').read_text('utf-8')
    steps = re.search(r'In a workspace.*?\n\n((?:    .*\n)+)', page, re.DOTALL)[1]
    at = [made.find(line.partition('  #')[0].strip()) for line in steps.splitlines()[:4]]
    assert len(at) == 4 and -1 not in at and at == sorted(at)
    opened = json.loads((ROOT / '.devcontainer' / 'devcontainer.json').read_text('utf-8'))
    assert (ROOT / '.devcontainer' / opened['build']['dockerfile']).resolve() == (
        ROOT / 'Dockerfile')


def test_the_readme_is_short_and_names_what_ci_runs():
    readme = (ROOT / 'README.md').read_text('utf-8')
    assert len(readme.split()) <= 700
    tested, = re.findall(r'^(make \w+)$', (ROOT / '.ci' / 'run').read_text('utf-8'), re.MULTILINE)
    assert re.search(rf'^    {tested} ', readme, re.MULTILINE)
    for link in re.findall(r'\]\(([^)#]+)\)', readme):
        assert (ROOT / link).is_file(), link


def test_pip_is_silent_unless_it_fails():
    assert '-m pip install --quiet ' in (ROOT / '.ci' / 'venv').read_text('utf-8')


def test_the_page_of_the_installation_names_each_extra():
    extras = re.search(r'extras_require=\{(.*?)\n    \}', (ROOT / 'setup.py').read_text('utf-8'),
                       re.DOTALL)[1]
    page = (ROOT / 'docs' / 'install.md').read_text('utf-8')
    rows = '\n'.join(line.split(' | ')[0] for line in page.splitlines() if line.startswith('| `'))
    assert {*re.findall(r'`(\w+)`', rows)} == {*re.findall(r"^ +'(\w+)':", extras, re.MULTILINE)}


def test_the_maintainer_has_an_address_that_colcon_accepts():
    """Colcon drops the ament hooks of a package whose maintainer has an invalid address."""
    assert re.fullmatch(r'[-\w+%]+(\.[-\w+%]+)*@[-a-zA-Z0-9]+(\.[-a-zA-Z0-9]+)*\.[a-zA-Z]{2,}',
                        manifest().find('maintainer').get('email'))


def test_every_message_package_that_nodes_import_is_a_dependency():
    imported = set()
    for path in [*(ROOT / NAME / 'nodes').rglob('*.py'), *(ROOT / NAME / 'cli').rglob('*.py')]:
        for node in ast.walk(ast.parse(path.read_text('utf-8'))):
            if isinstance(node, ast.ImportFrom) and node.module and not node.level:
                imported.add(node.module.partition('.')[0])
            elif isinstance(node, ast.Import):
                imported |= {alias.name.partition('.')[0] for alias in node.names}
    ros = {name for name in imported if name.endswith('_msgs') or name in ('rclpy', 'std_srvs',
                                                                           'builtin_interfaces')}
    assert ros <= {element.text for element in manifest().iter('exec_depend')}


@pytest.mark.parametrize('node', NODES)
def test_every_executable_has_a_module_with_main(node):
    tree = ast.parse((ROOT / NAME / 'nodes' / f'{node}.py').read_text('utf-8'))
    assert 'main' in {n.name for n in tree.body if isinstance(n, ast.FunctionDef)}
    assert callable(getattr(executables, node)) and set(executables.__all__) == {*NODES}


def test_type_checkers_are_told_that_the_package_has_types():
    assert (ROOT / NAME / 'py.typed').is_file()
    assert "package_data={NAME: ['py.typed'," in (ROOT / 'setup.py').read_text('utf-8')


USER_CODE = """
from heading_intercompare import analyze, BagReader, Headings, judge_bags, Outcome, Settings


def judge(ts: Headings, rs: Headings) -> Outcome:
    settings = Settings.from_mapping({'norms.sigma_max_deg': 0.3})
    for chunk in BagReader('bag').headings({'/ts': 'enu'}):
        print(chunk['/ts'].heading_deg.mean())
    print(judge_bags(['bag'], settings).verdict)
    return analyze(ts, rs, settings).outcome
"""


@pytest.mark.slow
@pytest.mark.process
def test_code_of_a_user_and_the_examples_pass_a_strict_type_checker(tmp_path):
    """Within the package types are checked with `mypy.ini`; here it counts as installed."""
    pytest.importorskip('mypy')
    (tmp_path / 'good.py').write_text(USER_CODE)
    (tmp_path / 'bad.py').write_text(USER_CODE.replace('-> Outcome', '-> Headings'))
    (tmp_path / 'mypy.ini').write_text(
        f'[mypy]\nstrict = True\nmypy_path = {ROOT}\n'
        f'[mypy-{NAME}.*]\nfollow_imports = silent\n')
    good, bad = (run(sys.executable, '-m', 'mypy', *files, cwd=tmp_path) for files in (
        ['good.py', *map(str, (ROOT / 'examples').glob('*.py'))], ['bad.py']))
    assert good.returncode == 0, good.stdout
    assert 'expected "Headings"' in bad.stdout


def test_the_templates_are_data_of_the_package_and_of_its_source_archive():
    templates = {p.relative_to(ROOT / NAME).as_posix()
                 for p in (ROOT / NAME / 'report' / 'templates').rglob('*') if p.is_file()}
    assert templates == {f'report/templates/{name}' for name in (
        'protocol.html', 'protocol.css', 'sensors.html', 'card.html')}
    assert "'report/templates/*'" in (ROOT / 'setup.py').read_text('utf-8')
    assert (f'recursive-include {NAME}/report/templates *.css *.html'
            in (ROOT / 'MANIFEST.in').read_text('utf-8').splitlines())


@pytest.mark.parametrize('extra, libraries', [
    ('report', ['jinja2', 'matplotlib', 'segno']), ('terminal', ['rich', 'argcomplete'])])
def test_an_extra_is_asked_for_and_installed_for_demo_and_tests(extra, libraries):
    asked = re.search(rf"'{extra}': \[([^]]*)\]", (ROOT / 'setup.py').read_text('utf-8'))[1]
    assert re.findall(r"'(\w+)", asked) == libraries
    environments = re.findall(r'venv\S* (ros\S*)', (ROOT / 'Makefile').read_text('utf-8'))
    assert len(environments) == 4
    assert all(extra in environment.split(',') for environment in environments)
    pinned = (ROOT / '.ci' / 'ubuntu-24.04.txt').read_text('utf-8')
    assert all(re.search(rf'^{library}==', pinned, re.MULTILINE) for library in libraries)


def test_what_the_protocol_is_made_with_is_a_dependency_of_the_ros_package():
    assert {'python3-jinja2', 'python3-matplotlib'} <= {
        element.text for element in manifest().iter('exec_depend')}


@pytest.mark.slow
def test_pip_installs_the_command_line_without_ros(source, tmp_path):
    """`pip install .` in a fresh environment installs no rclpy, and gives a verdict."""
    made = run(sys.executable, '-m', 'venv', tmp_path / 'venv', cwd=tmp_path)
    assert made.returncode == 0, made.stdout
    bin_folder = tmp_path / 'venv' / 'bin'
    done = run(bin_folder / 'python', '-m', 'pip', 'install', '--disable-pip-version-check',
               '--prefer-binary', source, cwd=tmp_path)
    if done.returncode and not IN_CI and re.search('No matching distribution|ConnectionError',
                                                   done.stdout):
        pytest.skip('pip does not reach its package index')
    assert done.returncode == 0, done.stdout

    code = (f'import importlib.util, {NAME}; print({NAME}.__file__, {NAME}.__version__, '
            'importlib.util.find_spec("rclpy"))')
    place, version, rclpy = run(bin_folder / 'python', '-c', code, cwd=tmp_path).stdout.split()
    assert Path(place).with_name('py.typed').is_file()
    template = Path(place).with_name('report') / 'templates' / 'protocol.html'
    assert template.read_bytes() == (ROOT / NAME / 'report' / 'templates' / 'protocol.html'
                                     ).read_bytes()
    assert place.startswith(str(tmp_path)) and version == __version__ and rclpy == 'None'
    assert (bin_folder / 'heading-intercompare').is_file()
    assert not {node for node in NODES if (bin_folder / node).exists()}, 'general names on a PATH'
    share = tmp_path / 'venv' / 'share' / NAME
    assert (share / 'package.xml').is_file()
    assert (share / 'config' / f'{NAME}.yaml').is_file()

    command = bin_folder / 'heading-intercompare'
    assert run(command, '--version', cwd=tmp_path).stdout.split()[-1] == __version__
    assert run(bin_folder / 'python', '-m', NAME, '--version', cwd=tmp_path).returncode == 0
    errors = random.Random(1)
    rows = '\n'.join(f'{i},{90 + errors.gauss(0, 0.05):.3f},90' for i in range(1, 2001))
    (tmp_path / 'pairs.csv').write_text(f'stamp_s,ts_deg,rs_deg\n{rows}\n', 'utf-8')
    judged = run(command, 'analyze', 'pairs.csv', '--set', 'norms.sigma_max_deg=0.2', '--set',
                 'norms.sigma_ref_max_deg=0.1', '--check', cwd=tmp_path)
    assert judged.returncode == 0, judged.stdout
    drawn = run(command, 'analyze', 'pairs.csv', '--set', 'norms.sigma_max_deg=0.2', '--set',
                'norms.sigma_ref_max_deg=0.1', '--report', 'r.html', cwd=tmp_path)
    assert drawn.returncode == 2 and 'heading_intercompare[report]' in drawn.stdout
    done = run(bin_folder / 'python', '-m', 'pip', 'install', '--disable-pip-version-check',
               '--prefer-binary', f'{source}[report]', cwd=tmp_path)
    assert done.returncode == 0, done.stdout
    drawn = run(command, 'analyze', 'pairs.csv', '--set', 'norms.sigma_max_deg=0.2', '--set',
                'norms.sigma_ref_max_deg=0.1', '--report', 'r.html', cwd=tmp_path)
    assert drawn.returncode == 0 and '<svg' in (tmp_path / 'r.html').read_text('utf-8')
    refused = run(command, 'demo', cwd=tmp_path)
    assert refused.returncode == 2
    assert len(refused.stdout.splitlines()) == 1 and 'rclpy' in refused.stdout


def catches(pid: int, number: int) -> bool:
    """Tell whether a process has a handler for a signal."""
    caught = re.search(r'^SigCgt:\s*([0-9a-f]+)$', Path(f'/proc/{pid}/status').read_text(),
                       re.MULTILINE)
    return bool(int(caught[1], 16) >> (number - 1) & 1)


def interrupted(command: list[str], environment: dict[str, str], cwd: Path) -> tuple[int, str]:
    """Start a node, interrupt it once it is loaded; return its exit code and output."""
    log = cwd / 'node.log'
    with log.open('w') as output:
        process = subprocess.Popen(
            command, cwd=cwd, env=environment, stdin=subprocess.DEVNULL, stdout=output,
            stderr=subprocess.STDOUT, preexec_fn=lambda: signal.signal(
                signal.SIGINT, signal.default_int_handler))
        try:
            deadline = time.monotonic() + DEADLINE_S
            while process.poll() is None and time.monotonic() < deadline:
                if catches(process.pid, signal.SIGHUP):
                    process.send_signal(signal.SIGINT)
                    break
                time.sleep(0.02)
            return process.wait(DEADLINE_S), log.read_text()
        finally:
            process.kill()
            process.wait()


@pytest.mark.process
@pytest.mark.colcon
@pytest.mark.slow
def test_colcon_builds_a_package_whose_nodes_start_and_end(source, tmp_path):
    need('colcon_core')
    need('colcon_ros')
    need('rclpy')
    workspace = source.parent.parent
    built = run(sys.executable, '-m', 'colcon', 'build', '--packages-select', NAME, cwd=workspace,
                PYTHONDONTWRITEBYTECODE='')
    assert built.returncode == 0, built.stdout
    assert 'stderr' not in built.stdout, built.stdout
    prefix = workspace / 'install' / NAME
    executables = prefix / 'lib' / NAME
    assert sorted(p.name for p in executables.iterdir()) == sorted(
        [*NODES, 'heading-intercompare'])
    share = prefix / 'share'
    assert (share / 'ament_index' / 'resource_index' / 'packages' / NAME).is_file()
    assert (share / NAME / 'hook' / 'ament_prefix_path.sh').is_file(), built.stdout
    for folder in ('config', 'launch', 'schema', 'systemd'):
        assert ({p.name for p in (ROOT / folder).rglob('*') if p.is_file() and p.suffix != '.pyc'}
                == {p.name for p in (share / NAME / folder).rglob('*') if p.is_file()})

    template = f'{NAME}/report/templates/protocol.html'
    assert [p for p in prefix.rglob('protocol.html') if p.as_posix().endswith(template)]

    setup = f'. {workspace}/install/local_setup.sh && env -0'
    listed = run('sh', '-c', setup, cwd=tmp_path, ROS_AUTOMATIC_DISCOVERY_RANGE='LOCALHOST')
    environment = dict(pair.split('=', 1) for pair in listed.stdout.split('\0') if '=' in pair)
    assert str(prefix) in environment['AMENT_PREFIX_PATH'].split(':')
    where = subprocess.run([sys.executable, '-c', f'import {NAME}; print({NAME}.__file__)'],
                           cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert where.stdout.startswith(str(prefix)), 'the nodes would run from elsewhere'

    config = share / NAME / 'config' / f'{NAME}.yaml'
    names = {'nmea_driver': 'ts_driver'}
    for node in NODES:
        # The nodes of `intercompare` keep their names.
        named = [] if node == 'intercompare' else ['-r', f'__node:={names.get(node, node)}']
        code, output = interrupted(
            [str(executables / node), '--ros-args', '--params-file', str(config), *named, '-p',
             'norms.sigma_max_deg:=0.2', '-p', 'norms.sigma_ref_max_deg:=0.1'], environment,
            tmp_path)
        if node == 'replayer':
            assert code == 2 and output.startswith('replayer: error: bag is required'), output
        elif node == 'alert_sender':
            assert code == 2 and 'alert_sender: error: destination is required' in output, output
        elif node == 'motion_driver':
            assert code == 2 and 'motion_driver: error: source is required' in output, output
        elif node == 'dashboard' and find_spec('nicegui') is None:
            assert code == 2 and "pip install 'heading_intercompare[web]'" in output, output
        else:
            assert (node, code) == (node, 0), output


@pytest.mark.colcon
@pytest.mark.slow
def test_colcon_test_runs_pytest(source):
    need('colcon_core')
    need('colcon_ros')
    workspace = source.parent.parent
    arguments = ('--packages-select', NAME)
    built = run(sys.executable, '-m', 'colcon', 'build', *arguments, cwd=workspace)
    assert built.returncode == 0, built.stdout
    tested = run(sys.executable, '-m', 'colcon', 'test', *arguments, '--pytest-args',
                 'test/core/test_angles.py', cwd=workspace)
    assert tested.returncode == 0, tested.stdout
    result = run(sys.executable, '-m', 'colcon', 'test-result', cwd=workspace).stdout
    found = re.search(r'(\d+) tests?, (\d+) errors?, (\d+) failures?, (\d+) skipped', result)
    assert found and int(found[1]) > 0 and found[2] == found[3] == '0', result
