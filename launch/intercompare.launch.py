# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""
Compare two sensors live, or several: drivers, synchronizer, compliance, recorder.

    ros2 launch heading_intercompare intercompare.launch.py config:=FILE
        [record:=false] [dashboard:=true] [output:=BAG] [report_dir:=DIR] [namespace:=/ship1]

A sensor without a driver section in the parameter file is heard on its topic, `ts_topic` or
`rs_topic`: somebody else publishes it.

With the setting `sensors` the sections of the drivers are NAME_driver. Each tested sensor has a
synchronizer and a compliance node in a namespace NAME, and `sensors_watch` joins them.
"""

import os

from launch import LaunchDescription
from launch.actions import (
    DeclareLaunchArgument,
    OpaqueFunction,
    SetEnvironmentVariable,
    Shutdown,
)
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
import yaml

from heading_intercompare.core.rows.sensor_table import describe_driver, list_tested, read_sensors
from heading_intercompare.core.settings import Settings
from heading_intercompare.nodes.sensors.places import (
    count_subscribers,
    further_subscribers,
    remap_rules,
)


def enclave(name):
    """Return the enclave of a node under ROS security, as the policy names it."""
    if os.environ.get('ROS_SECURITY_ENABLE') != 'true':
        return {}
    return {'ros_arguments': ['--enclave', f'/heading_intercompare/{name}']}


def node(executable, name, namespace, parameters, own, **kwargs):
    """Return a node; its own section and `own` hold in any namespace, unlike the file's."""
    file, sections = parameters
    given = [values for values in (sections.get(name, {}), own) if values]
    return Node(package='heading_intercompare', executable=executable, name=name,
                namespace=namespace, parameters=[file, *given], output='screen',
                **enclave(name), **kwargs)


def end_with(name):
    """Return what to do when a node ends: it has ended by itself, or it starts again."""
    def act(event, _):
        # 0: it has done its work; 2: a mistake of the user, told in one line.
        return Shutdown(reason=f'{name} has ended') if event.returncode in (0, 2) else None
    return act


def drivers(namespace, parameters, sensors, recorded):
    """Return the drivers that the parameter file has sections for."""
    _, sections = parameters
    shared = sections.get('**', {})
    topics = {f'{one.name}_driver': (one.heading_topic, describe_driver(one))
              for one in sensors} or {
        f'{role}_driver': (shared.get(f'{role}_topic', f'{role}/heading'), {})
        for role in ('ts', 'rs')}
    n = count_subscribers(sensors, recorded)
    further = further_subscribers(Settings(sensors=shared.get('sensors')))
    made = []
    for driver, (topic, given) in topics.items():
        if driver in sections:
            # A live driver that dies starts again; a log that was played is through.
            live = not str(sections[driver].get('source', '')).startswith('file:')
            own = {name: value for name, value in given.items() if name not in sections[driver]}
            # Headings wait for all that hear them.
            made.append(node('nmea_driver', driver, namespace, parameters,
                             {'topic': sections[driver].get('topic', topic), **own,
                              'subscribers': n + further.get(topic, 0)},
                             respawn=live, respawn_delay=2.0))
    return made


def nodes(context):
    """Return the nodes; no heading is lost, in whatever order they start."""
    config, record, page, output, report_dir, namespace = (
        LaunchConfiguration(name).perform(context)
        for name in ('config', 'record', 'dashboard', 'output', 'report_dir', 'namespace'))
    with open(config, encoding='utf-8') as file:
        sections = yaml.safe_load(file)
    sections = {name.lstrip('/'): (section or {}).get('ros__parameters') or {}
                for name, section in sections.items()}
    parameters = config, sections
    shared = sections.get('**', {})
    sensors = read_sensors(shared.get('sensors'))
    heard = {'subscribers': 2 if record == 'true' else 1}
    made = drivers(namespace, parameters, sensors, record == 'true')
    # Without a folder for reports, the run in progress is kept beside the bag.
    judging = {'report_dir': report_dir} if report_dir else {}
    if not {'report_dir', 'journal'} & {*judging, *sections.get('compliance', {})}:
        named = output or sections.get('recorder', {}).get('output') or 'heading'
        judging['journal'] = f'{named}{namespace.rstrip("/").replace("/", ".")}.journal'
    # One that is killed starts again, and the trial goes on.
    again = {'respawn': True, 'respawn_delay': 1.0}
    remaps = [*remap_rules(sensors, namespace).items()]
    for name in [one.name for one in list_tested(sensors)] if sensors else ['']:
        place = f'{namespace.rstrip("/")}/{name}' if name else namespace
        own = {'sensor': name} if name else {}
        several = {'remappings': remaps} if name else {}
        # Pairs wait for compliance and the recorder.
        made += [node('synchronizer', 'synchronizer', place, parameters, {**heard, **own},
                      on_exit=end_with('the synchronizer'), **several, **again),
                 node('compliance', 'compliance', place, parameters, {**judging, **own},
                      on_exit=end_with('the compliance node'), **several, **again)]
    if sensors:
        given = {**sections.get('compliance', {}), **judging}
        shared = {name: given[name] for name in ('report_dir', 'journal', 'resume_within_s')
                  if name in given and name not in sections.get('sensors_watch', {})}
        if report_dir:
            shared['report_dir'] = report_dir
        made.append(node('sensors_watch', 'sensors_watch', namespace, parameters, shared,
                         on_exit=end_with('the node sensors_watch'), **again))
    if record == 'true':
        # The trial goes on without it; it starts again with a new bag.
        made.append(node('recorder', 'recorder', namespace, parameters,
                         {'parameter_file': config, 'go_on': True,
                          **({'output': output} if output else {})},
                         respawn=True, respawn_delay=2.0))
    if page == 'true':
        # The trial goes on without it.
        made.append(node('dashboard', 'dashboard', namespace, parameters, {}))
    return made


# Fast DDS may lose a process that was stopped or killed while it used shared memory, for good.
TRANSPORTS = 'FASTDDS_BUILTIN_TRANSPORTS'


def generate_launch_description():
    """Return the graph."""
    return LaunchDescription([
        SetEnvironmentVariable(TRANSPORTS, os.environ.get(TRANSPORTS, 'UDPv4')),
        DeclareLaunchArgument('config', description='ROS parameter file with the norms, and '
                              'the sections ts_driver and rs_driver, or NAME_driver, of '
                              'sensors with a driver'),
        DeclareLaunchArgument('record', default_value='true', choices=['true', 'false'],
                              description='record a bag'),
        DeclareLaunchArgument('dashboard', default_value='false', choices=['true', 'false'],
                              description='serve the live page'),
        DeclareLaunchArgument('output', default_value='', description='the bag; empty: that of '
                              'the parameter file, or heading_<UTC>'),
        DeclareLaunchArgument('report_dir', default_value='', description='folder for the '
                              'reports; empty: that of the parameter file, or none'),
        DeclareLaunchArgument('namespace', default_value='/', description='of all nodes and '
                              'topics: one for each graph in a ROS domain'),
        OpaqueFunction(function=nodes),
    ])
