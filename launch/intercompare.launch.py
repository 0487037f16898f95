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
Compare two sensors live, or several: drivers, synchronizer with compliance, recorder.

    ros2 launch heading_intercompare intercompare.launch.py config:=FILE
        [record:=false] [drivers:=false] [dashboard:=true] [output:=BAG] [report_dir:=DIR]
        [namespace:=/ship1] [respawn:=false] [log_level:=debug] [use_sim_time:=true]

A sensor without a driver section in the parameter file is heard on its topic, `ts_topic` or
`rs_topic`: somebody else publishes it. With drivers:=false that holds for all sensors.

A section `alert_sender` with a destination or push_url sends the alarms there.

A section `motion_driver` names a source of its own for the motion of the ship. Without it the
drivers of the sensors publish what their sentences tell of it.

The nodes synchronizer and compliance are one process, `intercompare`: what pairs and what judges
have one fate, for two sensors and for several. With the setting `sensors` the sections of the
drivers are NAME_driver.
"""

from functools import partial
import os
from pathlib import Path

from launch import LaunchDescription
from launch.actions import (
    DeclareLaunchArgument,
    LogInfo,
    OpaqueFunction,
    SetEnvironmentVariable,
    Shutdown,
)
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from heading_intercompare.app.config import LIVE, load_config, settings_for, unstated
from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.core.sensor_table import describe_driver, read_sensors
from heading_intercompare.core.sensors.pair_settings import check_norms
from heading_intercompare.nodes.launching.arguments import (
    check_path,
    check_sections,
    common_arguments,
    find_misspelt,
    join_nodes,
    read_namespace,
    read_switch,
    TOGETHER,
)
from heading_intercompare.nodes.launching.node_end import NodeEnd

TEMPLATE = Path(__file__).resolve().parent.parent / 'config' / 'heading_intercompare.yaml'
NO_CONFIG = ('there is no parameter file: copy {template}, enter the norms and the sources of the '
             'sensors, and give config:=FILE; for simulated sensors use '
             'ros2 launch heading_intercompare demo.launch.py')

# How an argument is written, what it means, and its default.
ARGUMENTS = {
    'config': ('', 'ROS parameter file with the norms, and the sections ts_driver and rs_driver, '
               'or NAME_driver, of sensors with a driver'),
    'record': ('true', 'record a bag: true or false'),
    'drivers': ('true', 'start the drivers that the parameter file names: true or false; false: '
                'the headings come from other nodes'),
    'dashboard': ('false', 'serve the live page: true or false'),
    'output': ('', 'the bag; empty: that of the parameter file, or heading_<UTC>'),
    'report_dir': ('', 'folder for the reports; empty: that of the parameter file, or none'),
    'namespace': ('/', 'of all nodes and topics: one for each graph in a ROS domain'),
    'respawn': ('true', 'start a node again that was killed: true or false'),
    'log_level': ('info', 'least level that the nodes log: debug, info, warn, error or fatal'),
    'use_sim_time': ('false', 'the clock of the nodes is /clock: true or false'),
}

# One that is killed starts again, and the trial goes on.
AGAIN = {'respawn': True, 'respawn_delay': 1.0}


class Plan:
    """What the arguments and the parameter file ask for."""

    def __init__(self, context):
        given = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
        for name in ('record', 'drivers', 'dashboard', 'respawn', 'use_sim_time'):
            setattr(self, name, read_switch(name, given[name]))
        if not given['config']:
            raise SettingsError(NO_CONFIG.format(template=TEMPLATE))
        self.config = given['config']
        check_path('config', self.config, 'a ROS parameter file')
        self.output, self.report_dir = given['output'], given['report_dir']
        self.namespace, self.log_level = read_namespace(given['namespace']), given['log_level']
        self.file = load_config(self.config)
        if self.file.bare:
            raise SettingsError(f'{self.config}: {self.file.bare[0]}: ROS takes settings in '
                                "sections only: put it below '/**: ros__parameters:'")
        settings = settings_for(self.file, defaults=LIVE)
        self.unstated = unstated(LIVE, self.file)
        check_norms(settings)
        self.settings, self.sensors = settings, read_sensors(settings.sensors)
        self.started = []

    def section(self, name):
        """Return the section of a node in the parameter file."""
        return self.file.sections.get(name, {})

    def node(self, executable, name, own, over=None, **kwargs):
        """
        Return a node; its own section and `own` hold in any namespace, unlike the file's.

        With `over` its end is that of all; otherwise they go on without it.
        """
        self.started.append((executable, name))
        common, shared = common_arguments(executable, self.log_level, self.use_sim_time)
        given = [dict(values) for values in (self.section(name), {**own, **shared}) if values]
        if not self.respawn:
            kwargs = {key: value for key, value in kwargs.items() if 'respawn' not in key}
        return Node(package='heading_intercompare', executable=executable, name=name,
                    namespace=self.namespace, parameters=[self.config, *given],
                    output='screen', **common, **kwargs, on_exit=NodeEnd(
                        f'{self.namespace.rstrip("/")}/{name}', over,
                        respawn=kwargs.get('respawn', False)))

    def judging(self, own):
        """Return the process that pairs and judges, given parameters of its two nodes."""
        self.started += [(name, name) for name in TOGETHER]
        return Node(**join_nodes(self.namespace, self.config, self.file.sections, own,
                                 self.log_level, self.use_sim_time),
                    **(AGAIN if self.respawn else {}), on_exit=NodeEnd(
                        f'{self.namespace.rstrip("/")}/intercompare', end_all('the comparison'),
                        respawn=self.respawn))


def end_all(name):
    """Return what makes the action that ends all nodes because one has done its work."""
    return partial(Shutdown, reason=f'{name} has ended')


def drivers(plan):
    """Return the drivers that the parameter file has sections for."""
    topics = {f'{one.name}_driver': (one.heading_topic, describe_driver(one))
              for one in plan.sensors} or {
        'ts_driver': (plan.settings.ts_topic, {}), 'rs_driver': (plan.settings.rs_topic, {})}
    # The node that takes headings, or motion, and the recorder.
    n = 1 + plan.record
    made, alone = [], 'motion_driver' in plan.file.sections
    if alone:
        live = not str(plan.section('motion_driver').get('source', '')).startswith('file:')
        made.append(plan.node('motion_driver', 'motion_driver', {'subscribers': n},
                              respawn=live, respawn_delay=2.0))
    for name, (topic, given) in topics.items():
        section = plan.section(name)
        if name in plan.file.sections:
            # A live driver that dies starts again; a log that was played is through.
            live = not str(section.get('source', '')).startswith('file:')
            own = {key: value for key, value in given.items() if key not in section}
            # Headings wait for all that hear them.
            made.append(plan.node('nmea_driver', name,
                                  {'topic': section.get('topic', topic), **own,
                                   'subscribers': n,
                                   **({'motion': False} if alone else {})},
                                  respawn=live, respawn_delay=2.0))
    return made


def nodes(context):
    """Return the nodes; no heading is lost, in whatever order they start."""
    plan = Plan(context)
    made = drivers(plan) if plan.drivers else []
    # Without a folder for reports, the run in progress is kept beside the bag.
    judging = {'report_dir': plan.report_dir} if plan.report_dir else {}
    if not {'report_dir', 'journal'} & {*judging, *plan.section('compliance')}:
        named = plan.output or plan.section('recorder').get('output') or 'heading'
        judging['journal'] = f'{named}{plan.namespace.rstrip("/").replace("/", ".")}.journal'
    # Pairs wait for the recorder.
    made.append(plan.judging({'compliance': {**judging, **plan.unstated},
                              'synchronizer': {'subscribers': int(plan.record)}}))
    if plan.record:
        # The trial goes on without it; it starts again with a new bag.
        made.append(plan.node('recorder', 'recorder',
                              {'parameter_file': plan.config, 'go_on': True, **plan.unstated,
                               **({'output': plan.output} if plan.output else {})},
                              respawn=True, respawn_delay=2.0))
    if {'destination', 'push_url'} & plan.section('alert_sender').keys():
        # The trial goes on without it.
        made.append(plan.node('alert_sender', 'alert_sender', {}, respawn=True, respawn_delay=2.0))
    if plan.dashboard:
        # The trial goes on without it.
        made.append(plan.node('dashboard', 'dashboard', {}))
    check_sections(plan.config, plan.file.sections, plan.started)
    return made


# Fast DDS may lose a process that was stopped or killed while it used shared memory, for good.
TRANSPORTS = 'FASTDDS_BUILTIN_TRANSPORTS'


def warn(context):
    """Say which arguments have no effect."""
    return [LogInfo(msg=line)
            for line in find_misspelt(context.launch_configurations, ARGUMENTS)]


def generate_launch_description():
    """Return the graph."""
    return LaunchDescription([
        SetEnvironmentVariable(TRANSPORTS, os.environ.get(TRANSPORTS, 'UDPv4')),
        *(DeclareLaunchArgument(name, default_value=default, description=words)
          for name, (default, words) in ARGUMENTS.items()),
        OpaqueFunction(function=warn),
        OpaqueFunction(function=nodes),
    ])
