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
Compare two sensors again from a bag, or several: replayer, synchronizer, compliance.

    ros2 launch heading_intercompare replay.launch.py bag:=BAG config:=FILE
        [rate:=20.0] [start:=0.0] [duration:=60.0] [start_paused:=true] [clock:=true]
        [report_dir:=DIR] [namespace:=/again] [log_level:=debug] [use_sim_time:=true]

All nodes end at the end of the bag.
"""

from functools import partial

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, LogInfo, OpaqueFunction, Shutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from heading_intercompare.app.config import load_config, settings_for
from heading_intercompare.app.recorded_looks import find_looks
from heading_intercompare.core.sensors.pair_settings import check_norms
from heading_intercompare.nodes.launching.arguments import (
    check_path,
    check_sections,
    common_arguments,
    find_misspelt,
    join_nodes,
    read_namespace,
    read_number,
    read_switch,
    TOGETHER,
)
from heading_intercompare.nodes.launching.node_end import NodeEnd

# Default and meaning of each argument.
ARGUMENTS = {
    'bag': ('', '.mcap file or rosbag2 folder'),
    'config': ('', 'ROS parameter file with the norms'),
    'rate': ('1.0', 'speed relative to the recording; 0.0: as fast as possible'),
    'start': ('0.0', 'seconds to skip at the start'),
    'duration': ('', 'seconds to replay; empty: to the end'),
    'start_paused': ('false', 'wait for the service /replayer/resume: true or false'),
    'clock': ('false', 'publish /clock: true or false'),
    'report_dir': ('', 'folder for the report; empty: that of the parameter file, or none'),
    'namespace': ('/', 'of all nodes and topics; not that of a graph that runs'),
    'log_level': ('info', 'least level that the nodes log: debug, info, warn, error or fatal'),
    'use_sim_time': ('false', 'the clock of the nodes is /clock: true or false'),
}


def nodes(context):
    """Return the nodes; no heading is lost, in whatever order they start."""
    given = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    check_path('bag', given['bag'], 'a bag', folder=True)
    check_path('config', given['config'], 'a ROS parameter file with the norms')
    file = load_config(given['config'])
    check_norms(settings_for(file))
    looks = find_looks(file, (), [given['bag']])
    namespace = read_namespace(given['namespace'])
    sim_time = read_switch('use_sim_time', given['use_sim_time'])

    started = []

    def node(name, own, reason):
        """Return a node whose end ends all; its section and `own` hold in any namespace."""
        started.append((name, name))
        common, shared = common_arguments(name, given['log_level'], sim_time)
        parameters = [dict(values) for values in (
            file.sections.get(name, {}), {**own, **shared}) if values]
        return Node(package='heading_intercompare', executable=name, name=name,
                    namespace=namespace, parameters=[given['config'], *parameters],
                    output='screen',
                    on_exit=NodeEnd(name, partial(Shutdown, reason=reason)), **common)

    replayed = {
        'bag': given['bag'], 'subscribers': 1,
        'rate': read_number('rate', given['rate']),
        'start_s': read_number('start', given['start']),
        **{name: read_switch(name, given[name]) for name in ('start_paused', 'clock')},
        **({'duration_s': read_number('duration', given['duration'])} if given['duration']
           else {})}
    made = [node('replayer', replayed, 'the bag has been replayed')]
    written = {'report_dir': given['report_dir']} if given['report_dir'] else {}
    started += [(name, name) for name in TOGETHER]
    made.append(Node(**join_nodes(
        namespace, given['config'], file.sections,
        {'compliance': {**written, **looks}, 'synchronizer': {'subscribers': 0}},
        given['log_level'], sim_time), on_exit=NodeEnd(
            f'{namespace.rstrip("/")}/intercompare', partial(
                Shutdown, reason='the comparison has ended'))))
    check_sections(given['config'], file.sections, started)
    return made


def warn(context):
    """Say which arguments have no effect."""
    return [LogInfo(msg=line)
            for line in find_misspelt(context.launch_configurations, ARGUMENTS)]


def generate_launch_description():
    """Return the graph."""
    return LaunchDescription([
        *(DeclareLaunchArgument(name, default_value=default, description=words)
          for name, (default, words) in ARGUMENTS.items()),
        OpaqueFunction(function=warn),
        OpaqueFunction(function=nodes),
    ])
