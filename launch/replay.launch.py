# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""
Compare two sensors again from a bag, or several: replayer, synchronizer, compliance.

    ros2 launch heading_intercompare replay.launch.py bag:=BAG config:=FILE
        [rate:=20.0] [start:=0.0] [duration:=60.0] [start_paused:=true] [clock:=true]
        [report_dir:=DIR] [namespace:=/again]

All nodes end at the end of the bag.
"""

import os

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction, Shutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
import yaml

from heading_intercompare.core.rows.sensor_table import list_tested, read_sensors
from heading_intercompare.nodes.sensors.places import count_subscribers, remap_rules


def enclave(name):
    """Return the enclave of a node under ROS security, as the policy names it."""
    if os.environ.get('ROS_SECURITY_ENABLE') != 'true':
        return {}
    return {'ros_arguments': ['--enclave', f'/heading_intercompare/{name}']}


def node(name, namespace, parameters, own, reason, **kwargs):
    """Return a node whose end ends all; its section and `own` hold in any namespace."""
    file, sections = parameters
    given = [values for values in (sections.get(name, {}), own) if values]
    return Node(package='heading_intercompare', executable=name, name=name, namespace=namespace,
                parameters=[file, *given], output='screen', on_exit=Shutdown(reason=reason),
                **enclave(name), **kwargs)


def nodes(context):
    """Return the nodes; no heading is lost, in whatever order they start."""
    bag, config, rate, start, duration, start_paused, clock, report_dir, namespace = (
        LaunchConfiguration(name).perform(context) for name in (
            'bag', 'config', 'rate', 'start', 'duration', 'start_paused', 'clock', 'report_dir',
            'namespace'))
    with open(config, encoding='utf-8') as file:
        sections = yaml.safe_load(file)
    sections = {name.lstrip('/'): (section or {}).get('ros__parameters') or {}
                for name, section in sections.items()}
    parameters = config, sections
    sensors = read_sensors(sections.get('**', {}).get('sensors'))
    replayed = {'bag': bag, 'rate': float(rate), 'start_s': float(start),
                'start_paused': start_paused == 'true', 'clock': clock == 'true',
                'subscribers': count_subscribers(sensors, False),
                **({'duration_s': float(duration)} if duration else {})}
    made = [node('replayer', namespace, parameters, replayed, 'the bag has been replayed')]
    written = {'report_dir': report_dir} if report_dir else {}
    remaps = [*remap_rules(sensors, namespace).items()]
    for name in [one.name for one in list_tested(sensors)] if sensors else ['']:
        place = f'{namespace.rstrip("/")}/{name}' if name else namespace
        own = {'sensor': name} if name else {}
        several = {'remappings': remaps} if name else {}
        made += [node('synchronizer', place, parameters, {'subscribers': 1, **own},
                      'the synchronizer has ended', **several),
                 node('compliance', place, parameters, {**written, **own},
                      'the compliance node has ended', **several)]
    if sensors:
        made.append(node('sensors_watch', namespace, parameters, written,
                         'the node sensors_watch has ended'))
    return made


def generate_launch_description():
    """Return the graph."""
    return LaunchDescription([
        DeclareLaunchArgument('bag', description='.mcap file or rosbag2 folder'),
        DeclareLaunchArgument('config', description='ROS parameter file with the norms'),
        DeclareLaunchArgument('rate', default_value='1.0', description='speed relative to the '
                              'recording; 0.0: as fast as possible'),
        DeclareLaunchArgument('start', default_value='0.0',
                              description='seconds to skip at the start'),
        DeclareLaunchArgument('duration', default_value='',
                              description='seconds to replay; empty: to the end'),
        DeclareLaunchArgument('start_paused', default_value='false', choices=['true', 'false'],
                              description='wait for the service /replayer/resume'),
        DeclareLaunchArgument('clock', default_value='false', choices=['true', 'false'],
                              description='publish /clock'),
        DeclareLaunchArgument('report_dir', default_value='', description='folder for the '
                              'report; empty: that of the parameter file, or none'),
        DeclareLaunchArgument('namespace', default_value='/', description='of all nodes and '
                              'topics; not that of a graph that runs'),
        OpaqueFunction(function=nodes),
    ])
