# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""
Compare two sensors live: two drivers, synchronizer, compliance, recorder.

    ros2 launch heading_intercompare intercompare.launch.py config:=FILE
        [record:=false] [output:=BAG] [report_dir:=DIR]
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction, Shutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
import yaml


def node(executable, name, config, own, **kwargs):
    """Return a node; `own` overrides the parameter file, because the namespace is given."""
    return Node(package='heading_intercompare', executable=executable, name=name, namespace='/',
                parameters=[config, own] if own else [config], output='screen', **kwargs)


def nodes(context):
    """Return the nodes; no heading is lost, in whatever order they start."""
    config, record, output, report_dir = (
        LaunchConfiguration(name).perform(context)
        for name in ('config', 'record', 'output', 'report_dir'))
    with open(config, encoding='utf-8') as file:
        sections = yaml.safe_load(file)
    parameters = {name.lstrip('/'): (section or {}).get('ros__parameters') or {}
                  for name, section in sections.items()}
    # Pairs wait for compliance, headings for the synchronizer, and both for the recorder.
    heard = {'subscribers': 2 if record == 'true' else 1}
    made = []
    for role in ('ts', 'rs'):
        topic = parameters.get('**', {}).get(f'{role}_topic', f'{role}/heading')
        given = parameters.get(f'{role}_driver', {})
        made.append(node('nmea_driver', f'{role}_driver', config,
                         {'topic': given.get('topic', topic), **heard}))
    made += [node('synchronizer', 'synchronizer', config, heard,
                  on_exit=Shutdown(reason='the synchronizer has ended')),
             node('compliance', 'compliance', config,
                  {'report_dir': report_dir} if report_dir else {},
                  on_exit=Shutdown(reason='the compliance node has ended'))]
    if record == 'true':
        made.append(node('recorder', 'recorder', config,
                         {'parameter_file': config, **({'output': output} if output else {})},
                         on_exit=Shutdown(reason='the recorder has ended')))
    return made


def generate_launch_description():
    """Return the graph."""
    return LaunchDescription([
        DeclareLaunchArgument('config', description='ROS parameter file with the norms and the '
                              'sections ts_driver and rs_driver'),
        DeclareLaunchArgument('record', default_value='true', choices=['true', 'false'],
                              description='record a bag'),
        DeclareLaunchArgument('output', default_value='', description='the bag; empty: that of '
                              'the parameter file, or heading_<UTC>'),
        DeclareLaunchArgument('report_dir', default_value='', description='folder for the '
                              'reports; empty: that of the parameter file, or none'),
        OpaqueFunction(function=nodes),
    ])
