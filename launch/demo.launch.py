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
Compare simulated sensors live: simulator, synchronizer, compliance, recorder.

    ros2 launch heading_intercompare demo.launch.py
        [speed:=20.0] [scenario:=NAME or FILE] [config:=FILE] [dashboard:=true] [output:=BAG]

All other arguments are those of intercompare.launch.py. All nodes end at the end of the scenario.
"""

from functools import partial
from pathlib import Path

from launch import LaunchDescription
from launch.actions import (
    DeclareLaunchArgument,
    IncludeLaunchDescription,
    LogInfo,
    OpaqueFunction,
    Shutdown,
)
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from heading_intercompare.app.config import load_config, settings_for
from heading_intercompare.app.scenarios import read_scenario
from heading_intercompare.nodes.launching.arguments import (
    check_path,
    common_arguments,
    find_misspelt,
    read_namespace,
    read_number,
    read_switch,
)
from heading_intercompare.nodes.launching.node_end import NodeEnd

# The file that it includes warns of all others.
OWN = ('scenario', 'speed')
HERE = Path(__file__).resolve().parent
# Default and meaning of each argument of this file, and of those that it shares with the other.
ARGUMENTS = {
    'scenario': ('demo', 'what to simulate: a file, or the name of a scenario of the package'),
    'speed': ('20.0', 'speed of the simulation relative to real time; 0.0: as fast as possible'),
    'config': (str(HERE.parent / 'config' / 'demo.yaml'),
               'ROS parameter file with the norms of the simulated sensors'),
    'record': ('true', 'record a bag: true or false'),
    'namespace': ('/', 'of all nodes and topics: one for each graph in a ROS domain'),
    'log_level': ('info', 'least level that the nodes log: debug, info, warn, error or fatal'),
}


def nodes(context):
    """Return the simulator; it waits for the others."""
    given = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    check_path('config', given['config'], 'a ROS parameter file')
    scenario = read_scenario(given['scenario']).scenario
    settings = settings_for(load_config(given['config']))
    common, _ = common_arguments('sensor_simulator', given['log_level'], False)
    own = {**scenario.to_mapping(), 'speed': read_number('speed', given['speed']),
           'ts_topic': settings.ts_topic, 'rs_topic': settings.rs_topic,
           # The synchronizer, and the recorder.
           'subscribers': 1 + read_switch('record', given['record'])}
    return [Node(package='heading_intercompare', executable='sensor_simulator',
                 name='sensor_simulator', namespace=read_namespace(given['namespace']),
                 parameters=[given['config'],
                             {name: value for name, value in own.items() if value is not None}],
                 output='screen', **common, on_exit=NodeEnd('sensor_simulator', partial(
                     Shutdown, reason='the simulation has ended')))]


def check(context):
    """Tell a mistake before the first node is started: what was started by then would stay."""
    nodes(context)
    return []


def warn(context):
    """Say which arguments have no effect."""
    return [LogInfo(msg=line)
            for line in find_misspelt(context.launch_configurations, OWN)]


def generate_launch_description():
    """Return the graph."""
    return LaunchDescription([
        *(DeclareLaunchArgument(name, default_value=default, description=words)
          for name, (default, words) in ARGUMENTS.items()),
        OpaqueFunction(function=warn),
        OpaqueFunction(function=check),
        IncludeLaunchDescription(
            PythonLaunchDescriptionSource(str(HERE / 'intercompare.launch.py')),
            launch_arguments={'drivers': 'false', **{
                name: LaunchConfiguration(name)
                for name in ('config', 'record', 'namespace', 'log_level')}}.items()),
        OpaqueFunction(function=nodes),
    ])
