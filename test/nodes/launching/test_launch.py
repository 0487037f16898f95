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

"""The launch files ask for nodes that exist, with parameters that they take."""

from __future__ import annotations

from ast import literal_eval
from functools import partial
from importlib import import_module
from pathlib import Path
import re
import types

from nodes.launch_files import Argument, Context, description, lines, nodes, Shutdown
from nodes.lines import free_port
from nodes.ros_nodes import NORMS
import pytest
import yaml

from heading_intercompare.app.config import load_config
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.rosbag2.provenance import describe_origin, RECORD
from heading_intercompare.cli.commands.graph import demo
from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.core.settings import Settings
from heading_intercompare.nodes.compliance import Compliance
from heading_intercompare.nodes.launching.arguments import OWN_SETTINGS
from heading_intercompare.nodes.launching.node_end import NodeFailure
from heading_intercompare.nodes.sending import source_thread
from heading_intercompare.nodes.synchronizer import Synchronizer

FILES = ('intercompare.launch.py', 'replay.launch.py')
DEMO = 'demo.launch.py'
TEMPLATE = Path(__file__).resolve().parents[3] / 'config' / 'heading_intercompare.yaml'


@pytest.fixture
def config(tmp_path):
    """Return a parameter file without topics."""
    path = tmp_path / 'config.yaml'
    path.write_text(yaml.dump({
        '/**': {'ros__parameters': NORMS},
        'ts_driver': {'ros__parameters': {'source': 'udp://127.0.0.1:20110'}},
        'rs_driver': {'ros__parameters': {'source': 'udp://127.0.0.1:20111'}}}))
    return str(path)


def by_name(name, **given):
    """Return the nodes of a launch file by name."""
    return {node.label: node for node in nodes(name, **given)}


def own(node, of=''):
    """Return the parameters that the launch file itself sets; `of` one of several nodes."""
    return node.own(of)


def test_the_live_graph_has_two_drivers_and_the_others(config):
    made = by_name(FILES[0], config=config)
    assert {name: node.executable for name, node in made.items()} == {
        'ts_driver': 'nmea_driver', 'rs_driver': 'nmea_driver', 'intercompare': 'intercompare',
        'recorder': 'recorder'}
    assert (own(made['ts_driver'])['topic'], own(made['rs_driver'])['topic']) == (
        'ts/heading', 'rs/heading')


def test_a_live_graph_uses_udp_unless_the_user_chooses(config, monkeypatch):
    monkeypatch.delenv('FASTDDS_BUILTIN_TRANSPORTS', raising=False)
    assert {node.transports for node in nodes(FILES[0], config=config)} == {'UDPv4'}
    monkeypatch.setenv('FASTDDS_BUILTIN_TRANSPORTS', 'LARGE_DATA')
    assert {node.transports for node in nodes(FILES[0], config=config)} == {'LARGE_DATA'}


def test_the_recorder_can_be_left_out_and_is_then_not_waited_for(config):
    made = by_name(FILES[0], config=config, record='false')
    assert 'recorder' not in made
    recorded = by_name(FILES[0], config=config)
    assert [(own(graph['ts_driver'])['subscribers'],
             own(graph['intercompare'], 'synchronizer')['subscribers'])
            for graph in (made, recorded)] == [(1, 0), (2, 1)]


def test_topics_of_the_parameter_file_are_kept(config):
    given = yaml.safe_load(Path(config).read_text())
    given['/**']['ros__parameters']['rs_topic'] = 'seapath'
    given['ts_driver']['ros__parameters']['topic'] = 'gyro'
    Path(config).write_text(yaml.dump(given))
    made = by_name(FILES[0], config=config)
    assert (own(made['ts_driver'])['topic'], own(made['rs_driver'])['topic']) == (
        'gyro', 'seapath')


def nodes_of(node):
    """Return the names of the nodes of a process that a launch file starts."""
    return [node.name] if node.name else ['compliance', 'synchronizer']


def follow(node, *codes, is_shutdown=False):
    """Return what follows when a node ends with these exit codes, one after the other."""
    followed = []
    for code in codes:
        try:
            action = node.on_exit(types.SimpleNamespace(returncode=code),
                                  types.SimpleNamespace(is_shutdown=is_shutdown))
        except NodeFailure as error:
            action = str(error)
        followed.append(action)
    return followed


def test_the_end_of_the_comparison_ends_all_unless_it_was_killed(config):
    node = by_name(FILES[0], config=config)['intercompare']
    killed, failed, refused, over = follow(node, -9, 1, 2, 0)
    assert killed is failed is None and node.respawn
    assert refused == '/intercompare was refused; its line above says why'
    assert isinstance(over, Shutdown)


def test_a_node_that_is_refused_at_its_start_is_a_failure_of_the_launch(config):
    """Its address is taken: `ros2 launch` went on, and ended with 0."""
    made = by_name(FILES[0], config=config, dashboard='true', namespace='/ship1')
    assert {'ts_driver', 'recorder', 'dashboard'} < made.keys()
    for name, node in made.items():
        assert follow(node, 2) == [f'/ship1/{name} was refused; its line above says why']


@pytest.mark.parametrize('name', ['ts_driver', 'recorder'])
def test_a_node_whose_device_is_gone_when_it_starts_again_ends_nothing(config, name):
    node = by_name(FILES[0], config=config)[name]
    assert follow(node, -9, 2, 2, 0) == [None] * 4 and node.respawn


def test_what_ends_after_ctrl_c_is_no_failure(config):
    for node in nodes(FILES[0], config=config):
        assert follow(node, 2, is_shutdown=True) == [None]


def test_a_needed_node_that_does_not_start_again_is_a_failure_when_it_dies(config):
    made = by_name(FILES[0], config=config, respawn='false')
    assert follow(made['intercompare'], -9) == ['/intercompare died with exit code -9']
    assert follow(made['ts_driver'], -9) == [None]


@pytest.mark.parametrize('given, journal', [
    ({}, 'heading.journal'), ({'output': 'trial'}, 'trial.journal'),
    ({'output': 'trial', 'namespace': '/a/b'}, 'trial.a.b.journal'),
    ({'report_dir': 'reports'}, None)])
def test_the_run_in_progress_is_kept_beside_the_bag_or_the_reports(config, given, journal):
    node = by_name(FILES[0], config=config, **given)['intercompare']
    assert own(node, 'compliance').get('journal') == journal


@pytest.mark.parametrize('stated, plan_s', [
    ({}, 'open'), ({'sequential': {'plan_s': 'none'}}, None),
    ({'sequential.plan_s': 900.0}, None), ({'sequential.looks': 3}, 'open')])
def test_a_live_graph_looks_at_its_runs_unless_the_file_states_otherwise(config, stated, plan_s):
    """The bag holds what its judge took; a plan that the file states comes from there."""
    given = yaml.safe_load(Path(config).read_text())
    given['/**']['ros__parameters'] |= stated
    Path(config).write_text(yaml.dump(given))
    made = by_name(FILES[0], config=config)
    assert {own(made['intercompare'], 'compliance').get('sequential.plan_s'),
            own(made['recorder']).get('sequential.plan_s')} == {plan_s}


@pytest.mark.parametrize('stated, looks', [
    ({}, {'sequential.plan_s': 'open', 'sequential.looks': 5}),
    ({'sequential': {'looks': 3}}, {'sequential.plan_s': 'open'}),
    ({'sequential': {'plan_s': 'none'}}, {})])
def test_a_bag_is_replayed_to_the_looks_that_it_was_judged_by(config, tmp_path, stated, looks):
    given = yaml.safe_load(Path(config).read_text())
    given['/**']['ros__parameters'] |= stated
    Path(config).write_text(yaml.dump(given))
    bag = tmp_path / 'bag'
    with BagWriter(bag) as writer:
        writer.metadata(RECORD, describe_origin(Settings.from_mapping(
            {**NORMS, 'sequential.plan_s': 'open', 'sequential.looks': 5}).to_mapping()))
        writer.add_topic('ts/heading', 'sensor_msgs/msg/Imu')
    judging = own(by_name(FILES[1], config=config, bag=str(bag))['intercompare'], 'compliance')
    assert {name: value for name, value in judging.items()
            if name.startswith('sequential.')} == looks


def test_drivers_of_live_sources_and_the_recorder_start_again(config):
    made = by_name(FILES[0], config=config)
    assert {n for n, node in made.items() if node.respawn} == {
        'ts_driver', 'rs_driver', 'recorder', 'intercompare'}
    named = by_name(FILES[0], config=config, output='trial')['recorder']
    assert named.respawn and own(named)['go_on'], 'the bag is there: it goes on in another one'
    given = yaml.safe_load(Path(config).read_text())
    given['ts_driver']['ros__parameters']['source'] = 'file:gyro.log'
    Path(config).write_text(yaml.dump(given))
    assert not by_name(FILES[0], config=config)['ts_driver'].respawn, 'a log ends'


def test_a_source_of_its_own_for_the_motion_replaces_that_of_the_sensors(config):
    given = yaml.safe_load(Path(config).read_text())
    assert 'motion' not in own(by_name(FILES[0], config=config)['ts_driver'])
    given['motion_driver'] = {'ros__parameters': {'source': 'udp://127.0.0.1:20112'}}
    Path(config).write_text(yaml.dump(given))
    made = by_name(FILES[0], config=config)
    assert made['motion_driver'].executable == 'motion_driver' and made['motion_driver'].respawn
    assert own(made['motion_driver'])['subscribers'] == 2
    assert [own(made[f'{role}_driver'])['motion'] for role in ('ts', 'rs')] == [False, False]


def test_alarms_go_to_the_bridge_if_the_file_says_where(config):
    given = yaml.safe_load(Path(config).read_text())
    given['alert_sender'] = {'ros__parameters': {'destination': 'udp://239.192.0.17:60017'}}
    Path(config).write_text(yaml.dump(given))
    sender = by_name(FILES[0], config=config)['alert_sender']
    assert sender.respawn and own(sender)['destination'] == 'udp://239.192.0.17:60017'
    given['alert_sender']['ros__parameters'] = {'destination': 'file:x'}
    Path(config).write_text(yaml.dump(given))
    with pytest.raises(SettingsError, match="'alert_sender': destination = 'file:x': must be"):
        nodes(FILES[0], config=config)
    given['alert_sender']['ros__parameters'] = {'talker': 'II'}
    Path(config).write_text(yaml.dump(given))
    assert 'alert_sender' not in by_name(FILES[0], config=config)


def test_a_sensor_without_a_driver_section_is_heard_on_its_topic(config):
    given = yaml.safe_load(Path(config).read_text())
    del given['rs_driver']
    Path(config).write_text(yaml.dump(given))
    assert set(by_name(FILES[0], config=config)) == {
        'ts_driver', 'intercompare', 'recorder'}


@pytest.mark.parametrize('name', FILES)
def test_a_graph_in_a_namespace_takes_the_sections_of_its_file(config, name):
    """A section named `synchronizer` does not hold for `/ship1/synchronizer` by itself."""
    given = yaml.safe_load(Path(config).read_text())
    given['synchronizer'] = {'ros__parameters': {'startup_wait_s': 33.0}}
    Path(config).write_text(yaml.dump(given))
    made = by_name(name, config=config, namespace='/ship1',
                   **({'bag': config} if name == FILES[1] else {}))
    assert {node.namespace for node in made.values()} == {'/ship1'}
    assert own(made['intercompare'], 'synchronizer')['startup_wait_s'] == 33.0
    if name == FILES[0]:
        assert own(made['ts_driver'])['source'] == 'udp://127.0.0.1:20110'


def test_all_end_when_the_bag_does(config):
    made = by_name(FILES[1], config=config, bag=config)
    assert set(made) == {'replayer', 'intercompare'}
    for name, node in made.items():
        over, refused, killed = follow(node, 0, 2, -9)
        assert isinstance(over, Shutdown) and name in refused and name in killed


def test_a_part_of_a_bag_is_replayed_when_it_is_asked_for(config):
    whole = own(by_name(FILES[1], config=config, bag=config)['replayer'])
    assert 'duration_s' not in whole and whole['start_paused'] is False
    part = own(by_name(FILES[1], config=config, bag=config, start='2', duration='7.5',
                       start_paused='true')['replayer'])
    assert (part['start_s'], part['duration_s'], part['start_paused']) == (2.0, 7.5, True)


def test_a_word_for_true_or_false_may_have_any_case(config):
    assert 'recorder' not in by_name(FILES[0], config=config, record='False')
    assert 'dashboard' in by_name(FILES[0], config=config, dashboard='TRUE')
    assert own(by_name(FILES[1], config=config, bag=config, clock='True')['replayer'])['clock']


def test_without_drivers_all_headings_come_from_other_nodes(config):
    assert set(by_name(FILES[0], config=config, drivers='false')) == {
        'intercompare', 'recorder'}


def test_nothing_starts_again_if_the_user_does_not_want_it(config):
    assert not any(node.respawn for node in nodes(FILES[0], config=config, respawn='false'))


@pytest.mark.parametrize('name', FILES)
def test_all_nodes_get_the_level_of_the_log_and_the_clock(name, config):
    bag = {'bag': config} if name == FILES[1] else {}
    for node in nodes(name, config=config, log_level='DEBUG', use_sim_time='true', **bag):
        assert node.ros_arguments[:2] == ['--log-level', 'debug']
        assert all(own(node, of)['use_sim_time'] is True for of in nodes_of(node))
    assert not any('use_sim_time' in own(node, of) for node in nodes(name, config=config, **bag)
                   for of in nodes_of(node))


@pytest.mark.parametrize('name', FILES)
def test_a_namespace_needs_no_leading_slash(name, config):
    bag = {'bag': config} if name == FILES[1] else {}
    made = nodes(name, config=config, namespace='ship1/', **bag)
    assert {node.namespace for node in made} == {'/ship1'}


@pytest.mark.parametrize('name', (*FILES, DEMO))
def test_a_node_has_time_to_end_before_it_is_killed(name, config):
    """`ros2 launch` waits 5 s by default, and the recorder waits for the last verdict."""
    bag = {'bag': config} if name == FILES[1] else {}
    assert all(float(node.sigterm_timeout) > 2 * 9 for node in nodes(name, config=config, **bag))


TWO_NORMS = '/**: {ros__parameters: {norms: {sigma_max_deg: 0.2, sigma_ref_max_deg: 0.1}}}\n'


@pytest.mark.parametrize('name, given, words', [
    (FILES[0], {}, 'there is no parameter file: copy .*heading_intercompare.yaml.*config:=FILE.*'
     'demo.launch.py'),
    (FILES[0], {'config': 'none.yaml'}, 'config:=none.yaml: does not exist'),
    (FILES[0], {'text': ''}, 'norms.sigma_max_deg is missing'),
    (FILES[0], {'text': '- a'}, 'is not a ROS parameter file'),
    (FILES[0], {'text': '/**: 3'}, 'must hold ros__parameters'),
    (FILES[0], {'text': 'norms: {sigma_max_deg: 1}'}, 'norms: ROS takes settings in sections'),
    (FILES[0], {'text': 'a: b: c'}, 'line 1'),
    (FILES[0], {'text': '/**: {ros__parameters: {norms: {sigma_max: 1}}}'}, 'sigma_max'),
    (FILES[0], {'record': 'maybe'}, 'record:=maybe: must be true or false'),
    (FILES[0], {'log_level': 'loud'}, 'log_level:=loud: must be one of debug'),
    (FILES[0], {'config': str(TEMPLATE.parent)}, 'Is a directory; give the path of a ROS'),
    (FILES[0], {'namespace': '/a b'}, 'namespace:=/a b: must be names of letters'),
    (FILES[0], {'namespace': 'fleet/1st'}, 'namespace:=fleet/1st: must be names'),
    (FILES[0], {'text': TWO_NORMS + 'ts_driver: {ros__parameters: {sorce: x}}'},
     "section 'ts_driver': unknown parameter 'sorce'; did you mean 'source'"),
    (FILES[0], {'text': TWO_NORMS + 'rs_driver: {ros__parameters: {source: 17}}'},
     "section 'rs_driver': source = 17"),
    (FILES[0], {'text': TWO_NORMS + 'rs_driver: {ros__parameters: {source: "udp://:99999"}}'},
     "section 'rs_driver': source = 'udp://:99999'"),
    (FILES[0], {'text': TWO_NORMS + 'ts_driver: {ros__parameters: {}}'},
     "section 'ts_driver': source is required"),
    (FILES[0], {'text': TWO_NORMS + 'motion_driver: {ros__parameters: {}}'},
     "section 'motion_driver': source is required"),
    (FILES[0], {'text': TWO_NORMS + 'recorder: {ros__parameters: {outptu: x}}'},
     "section 'recorder': unknown parameter 'outptu'; did you mean 'output'"),
    (FILES[0], {'text': TWO_NORMS + 'compliance: {ros__parameters: {norms.sigma_max_deg: 2.0}}'},
     "section 'compliance': norms.sigma_max_deg holds for every node"),
    (FILES[1], {'text': TWO_NORMS + 'replayer: {ros__parameters: {rate: fast}}', 'bag': '.'},
     "section 'replayer': rate = "),
    (FILES[1], {}, 'bag is missing: give bag:=PATH of a bag'),
    (FILES[1], {'bag': 'none'}, 'bag:=none: does not exist'),
    (FILES[1], {'bag': '.'}, 'config is missing'),
    (FILES[1], {'rate': 'fast'}, 'rate:=fast: must be a number'),
    (FILES[1], {'rate': '-1'}, 'rate:=-1: must be a number of at least 0'),
    (DEMO, {'scenario': 'none'}, 'none: is neither a file nor one of the scenarios'),
    (DEMO, {'speed': 'inf'}, 'speed:=inf: must be a number')])
def test_a_mistake_is_told_in_one_line(name, given, words, config, tmp_path):
    given = dict(given)
    if 'text' in given:
        Path(config).write_text(given.pop('text'))
        given['config'] = config
    elif name != DEMO and not {'config', 'bag'} & {*given} and given:
        given |= {'config': config, **({'bag': config} if name == FILES[1] else {})}
    with pytest.raises(SettingsError, match=words) as error:
        nodes(name, **given)
    assert '\n' not in str(error.value)


@pytest.mark.parametrize('given', [
    {'scenario': 'none'}, {'speed': 'fast'}, {'log_level': 'loud'}, {'config': 'none'}])
def test_a_mistake_of_the_demo_is_told_before_it_starts_a_node(given):
    """The nodes of the file that it includes would run on, without anybody to end them."""
    actions = description(DEMO)
    first = next(a for a in actions if getattr(a, 'function', description).__name__ == 'check')
    context = {a.name: given.get(a.name, a.default_value)
               for a in actions if isinstance(a, Argument)}
    with pytest.raises(SettingsError):
        first.function(Context(context))


@pytest.mark.parametrize('name, given, known', [
    (FILES[0], 'recrod', 'record'), (FILES[0], 'name_space', 'namespace'),
    (FILES[1], 'durations', 'duration'), (DEMO, 'recrod', 'record'),
    (DEMO, 'scenaro', 'scenario')])
def test_a_misspelt_argument_is_named_once(name, given, known, config):
    files = {} if name == DEMO else {'config': config, 'bag': config}
    assert lines(name, **files, **{given: 'false'}) == [
        f'{given}:= has no effect; did you mean {known}:=?']


@pytest.mark.parametrize('name', [*FILES, DEMO])
def test_an_argument_of_a_launch_file_that_includes_it_is_left_alone(name, config):
    files = {} if name == DEMO else {'config': config, 'bag': config}
    assert lines(name, **files, camera='left', scenario='demo') == []


def test_a_log_that_cannot_be_played_ends_all_and_one_that_was_played_does_not(config):
    given = yaml.safe_load(Path(config).read_text())
    given['ts_driver']['ros__parameters']['source'] = 'file:gyro.log'
    Path(config).write_text(yaml.dump(given))
    made = by_name(FILES[0], config=config)
    assert follow(made['ts_driver'], 0) == [None]
    made = by_name(FILES[0], config=config)
    assert follow(made['ts_driver'], 2) == ['/ts_driver was refused; its line above says why']


@pytest.mark.parametrize('executable', OWN_SETTINGS)
def test_the_sections_of_a_node_are_checked_by_what_it_declares(executable, ros, monkeypatch):
    def note(node, *classes, **_):
        raise SettingsError(repr({getattr(c, 'settings_class', c).__name__ for c in classes}))
    module = import_module(f'heading_intercompare.nodes.{executable}')
    # The two drivers have one base.
    for place in (module, source_thread):
        monkeypatch.setattr(place, 'declare', note, raising=False)
    with pytest.raises(SettingsError) as error:
        getattr(module, executable.title().replace('_', ''))(context=ros.context)
    assert literal_eval(str(error.value)) == {
        'Settings', *(one.__name__ for one in OWN_SETTINGS[executable])}


def test_the_demo_judges_simulated_sensors_by_the_norms_of_the_command_demo():
    made = by_name(DEMO)
    assert {name: node.executable for name, node in made.items()} == {
        'sensor_simulator': 'sensor_simulator', 'intercompare': 'intercompare',
        'recorder': 'recorder'}
    assert own(made['sensor_simulator'])['subscribers'] == 2
    assert isinstance(follow(made['sensor_simulator'], 0)[0], Shutdown)
    assert follow(made['sensor_simulator'], 2)[0].startswith('sensor_simulator was refused')
    config = load_config(made['intercompare'].parameters[0])
    assert config.shared == demo.NORMS and not config.sections


def test_the_demo_without_a_recorder_waits_for_one_subscriber_less():
    made = by_name(DEMO, record='False', namespace='ship')
    assert 'recorder' not in made and own(made['sensor_simulator'])['subscribers'] == 1
    assert {node.namespace for node in made.values()} == {'/ship'}


@pytest.mark.parametrize('name', (*FILES, DEMO))
def test_every_argument_is_described(name):
    declared = [a for a in description(name) if isinstance(a, Argument)]
    assert declared and all(a.description for a in declared)


@pytest.mark.parametrize('name', (*FILES, DEMO))
def test_every_argument_is_in_the_documentation(name):
    page = (TEMPLATE.parents[1] / 'docs' / 'ros.md').read_text('utf-8')
    table = page.partition('## Launch files')[2].partition('\n## ')[0]
    assert all(f'`{a.name}`' in table for a in description(name) if isinstance(a, Argument))


FOUR = str(TEMPLATE.with_name('four_sensors.yaml'))


@pytest.mark.parametrize('name', FILES)
def test_one_process_pairs_and_judges_all_sensors(name):
    bag = {'bag': FOUR} if name == FILES[1] else {}
    made = nodes(name, config=FOUR, namespace='/ship1', **bag)
    assert {node.namespace for node in made} == {'/ship1'}
    assert [node.label for node in made].count('intercompare') == 1


def test_each_of_several_sensors_has_a_driver_that_waits_for_all_that_hear_it():
    made = by_name(FILES[0], config=FOUR)
    drivers = {name: own(node) for name, node in made.items() if name.endswith('_driver')}
    assert {name: (given['topic'], given['subscribers'], given.get('talker'))
            for name, given in drivers.items()} == {
        'gyro1_driver': ('gyro1/heading', 2, 'HE'), 'gyro2_driver': ('gyro2/heading', 2, 'HE'),
        'ins_driver': ('ins/heading', 2, None), 'gnss_driver': ('gnss/heading', 2, None)}


def test_without_a_reference_the_nodes_are_the_same(tmp_path):
    path = tmp_path / 'free.yaml'
    path.write_text(Path(FOUR).read_text().replace('gnss_compass  rs', 'gnss_compass'))
    assert {node.executable for node in nodes(FILES[0], config=str(path))} == {
        'nmea_driver', 'intercompare', 'recorder'}


def run(ros, node, folder):
    """Return the running nodes of a process that a launch file starts."""
    words = node.arguments(folder)
    if not node.name:
        judge = ros.add(partial(Compliance, True), cli_args=words)
        return [judge, ros.add(partial(Synchronizer, judge), cli_args=words)]
    module = import_module(f'heading_intercompare.nodes.{node.executable}')
    return [ros.add(getattr(module, node.executable.title().replace('_', '')), cli_args=words)]


def test_the_nodes_of_several_sensors_take_their_parameters(ros, tmp_path):
    made = nodes(FILES[0], config=FOUR, record='false', report_dir=str(tmp_path / 'reports'))
    for node in made:
        if node.executable != 'nmea_driver':
            run(ros, node, tmp_path)
    heard = {topic for topic, _ in ros.plain.get_topic_names_and_types()}
    assert {'/gyro1/compliance/verdict', '/ins/pairs', '/sensors/vote'} <= heard
    assert ros.plain.count_subscribers('/compliance/marker') == 1
    assert (tmp_path / 'reports' / 'gyro2').is_dir()


def test_every_node_takes_its_parameters_from_the_template_too(ros, config, tmp_path):
    """The template sets `subscribers: 1`; what the launch file sets must win."""
    text = TEMPLATE.read_text().replace('# sigma_max_deg:', 'sigma_max_deg:').replace(
        '# sigma_ref_max_deg:', 'sigma_ref_max_deg:')
    template = tmp_path / 'template.yaml'
    # Whoever else uses those of the template is not to be disturbed.
    template.write_text(re.sub(r'(?<=udp://:)\d+', lambda _: str(free_port()), text))
    bag = str(tmp_path / 'bag')
    with BagWriter(bag) as writer:
        for topic in ('/ts/heading', '/rs/heading'):
            writer.add_topic(topic, 'sensor_msgs/msg/Imu')
    made = nodes(FILES[0], config=str(template), output=str(tmp_path / 'new'),
                 report_dir=str(tmp_path / 'reports'))
    made += nodes(FILES[1], config=str(template), bag=bag, rate='20.0')
    made += nodes(DEMO, config=str(template), record='false')
    for node in made:
        running = run(ros, node, tmp_path)
        assert [one.get_name() for one in running] == nodes_of(node)
        for one in running:
            for key, value in own(node, one.get_name()).items():
                assert one.get_parameter(key).value == value, (one.get_name(), key)
            ros.nodes.remove(one)
            ros.executor.remove_node(one)
        for one in reversed(running):
            one.destroy_node()
