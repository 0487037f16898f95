# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""
Compare two sensors live: drivers, synchronizer, compliance, recorder.

    ros2 launch heading_intercompare intercompare.launch.py config:=FILE
        [record:=false] [dashboard:=true] [output:=BAG] [report_dir:=DIR] [namespace:=/ship1]

A sensor without a driver section in the parameter file is heard on its topic, `ts_topic` or
`rs_topic`: somebody else publishes it.
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
    # Pairs wait for compliance, headings for the synchronizer, and both for the recorder.
    heard = {'subscribers': 2 if record == 'true' else 1}
    made = []
    for role in ('ts', 'rs'):
        driver = f'{role}_driver'
        if driver in sections:
            topic = sections.get('**', {}).get(f'{role}_topic', f'{role}/heading')
            # A live driver that dies starts again; a log that was played is through.
            live = not str(sections[driver].get('source', '')).startswith('file:')
            made.append(node('nmea_driver', driver, namespace, parameters,
                             {'topic': sections[driver].get('topic', topic), **heard},
                             respawn=live, respawn_delay=2.0))
    # Without a folder for reports, the run in progress is kept beside the bag.
    judging = {'report_dir': report_dir} if report_dir else {}
    if not {'report_dir', 'journal'} & {*judging, *sections.get('compliance', {})}:
        named = output or sections.get('recorder', {}).get('output') or 'heading'
        judging['journal'] = f'{named}{namespace.rstrip("/").replace("/", ".")}.journal'
    # One that is killed starts again, and the trial goes on.
    made += [node('synchronizer', 'synchronizer', namespace, parameters, heard, respawn=True,
                  respawn_delay=1.0, on_exit=end_with('the synchronizer')),
             node('compliance', 'compliance', namespace, parameters, judging,
                  respawn=True, respawn_delay=1.0, on_exit=end_with('the compliance node'))]
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
                              'the sections ts_driver and rs_driver of sensors with a driver'),
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
