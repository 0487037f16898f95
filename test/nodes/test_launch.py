# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The launch files ask for nodes that exist, with parameters that they take."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

import pytest
import yaml

from heading_intercompare.bags.recording.bag_writer import BagWriter

from .conftest import NORMS
from .launch_files import Argument, description, nodes, Shutdown

FILES = ('intercompare.launch.py', 'replay.launch.py')
TEMPLATE = Path(__file__).resolve().parents[2] / 'config' / 'heading_intercompare.yaml'


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
    return {node.name: node for node in nodes(name, **given)}


def own(node):
    """Return the parameters that the launch file itself sets."""
    return next((p for p in node.parameters if isinstance(p, dict)), {})


def test_the_live_graph_has_two_drivers_and_the_others(config):
    made = by_name(FILES[0], config=config)
    assert {name: node.executable for name, node in made.items()} == {
        'ts_driver': 'nmea_driver', 'rs_driver': 'nmea_driver', 'synchronizer': 'synchronizer',
        'compliance': 'compliance', 'recorder': 'recorder'}
    assert (own(made['ts_driver'])['topic'], own(made['rs_driver'])['topic']) == (
        'ts/heading', 'rs/heading')


def test_the_recorder_can_be_left_out_and_is_then_not_waited_for(config):
    made = by_name(FILES[0], config=config, record='false')
    assert 'recorder' not in made
    assert {own(made[n])['subscribers'] for n in ('ts_driver', 'synchronizer')} == {1}
    recorded = by_name(FILES[0], config=config)
    assert {own(recorded[n])['subscribers'] for n in ('ts_driver', 'synchronizer')} == {2}


def test_topics_of_the_parameter_file_are_kept(config):
    given = yaml.safe_load(Path(config).read_text())
    given['/**']['ros__parameters']['rs_topic'] = 'seapath'
    given['ts_driver']['ros__parameters']['topic'] = 'gyro'
    Path(config).write_text(yaml.dump(given))
    made = by_name(FILES[0], config=config)
    assert (own(made['ts_driver'])['topic'], own(made['rs_driver'])['topic']) == (
        'gyro', 'seapath')


def test_without_synchronizer_or_compliance_nothing_goes_on(config):
    made = by_name(FILES[0], config=config)
    assert {n for n, node in made.items() if isinstance(node.on_exit, Shutdown)} == {
        'synchronizer', 'compliance', 'recorder'}


def test_all_end_when_the_bag_does(config):
    made = by_name(FILES[1], config=config, bag='some/bag')
    assert set(made) == {'replayer', 'synchronizer', 'compliance'}
    assert all(isinstance(node.on_exit, Shutdown) for node in made.values())


def test_a_part_of_a_bag_is_replayed_when_it_is_asked_for(config):
    whole = own(by_name(FILES[1], config=config, bag='b')['replayer'])
    assert 'duration_s' not in whole and whole['start_paused'] is False
    part = own(by_name(FILES[1], config=config, bag='b', start='2', duration='7.5',
                       start_paused='true')['replayer'])
    assert (part['start_s'], part['duration_s'], part['start_paused']) == (2.0, 7.5, True)


@pytest.mark.parametrize('name', FILES)
def test_every_argument_is_described(name):
    declared = [a for a in description(name) if isinstance(a, Argument)]
    assert declared and all(a.description for a in declared)


def test_every_node_takes_its_parameters_from_the_template_too(ros, config, tmp_path):
    """The template sets `subscribers: 1`; what the launch file sets must win."""
    text = TEMPLATE.read_text().replace('# sigma_max_deg:', 'sigma_max_deg:').replace(
        '# sigma_ref_max_deg:', 'sigma_ref_max_deg:')
    template = tmp_path / 'template.yaml'
    template.write_text(text)
    bag = str(tmp_path / 'bag')
    with BagWriter(bag) as writer:
        for topic in ('/ts/heading', '/rs/heading'):
            writer.add_topic(topic, 'sensor_msgs/msg/Imu')
    made = nodes(FILES[0], config=str(template), output=str(tmp_path / 'new'),
                 report_dir=str(tmp_path / 'reports'))
    made += nodes(FILES[1], config=str(template), bag=bag, rate='20.0')
    for node in made:
        module = import_module(f'heading_intercompare.nodes.{node.executable}')
        make = getattr(module, node.executable.title().replace('_', ''))
        running = ros.add(make, cli_args=node.arguments(tmp_path))
        assert running.get_name() == node.name
        for key, value in own(node).items():
            assert running.get_parameter(key).value == value, (node.name, key)
        ros.nodes.remove(running)
        ros.executor.remove_node(running)
        running.destroy_node()
