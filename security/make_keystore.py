#!/usr/bin/env python3
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
Make a keystore of SROS 2 with an enclave for each node, from the policy beside this file.

    ./make_keystore.py KEYSTORE [--namespace /ship1] [--ts TOPIC] [--rs TOPIC]
    ./make_keystore.py KEYSTORE [--namespace /ship1] --config four_sensors.yaml

It runs `ros2 security`, which apt installs with ros-jazzy-sros2. The middleware of the Python
wheels has no security.
"""

import argparse
from copy import deepcopy
from pathlib import Path
import shutil
import subprocess
import sys
from xml.etree import ElementTree

POLICY = Path(__file__).resolve().parent / 'heading_intercompare.policy.xml'


#: What stands beside the headings has a topic that ends so.
ENDS = ('', '/lost', '/quality')


def fill_in(policy: str, namespace: str, topics: dict) -> str:
    """Return the policy for a namespace, with other topics of the headings."""
    policy = policy.replace('ns="/"', f'ns="{namespace}"')
    for usual, topic in topics.items():
        for end in ENDS:
            policy = policy.replace(f'<topic>{usual}{end}<', f'<topic>{topic}{end}<')
    return policy


#: What each tested sensor has of its own, apart from the topics with numbers.
OWN = ('pairs', 'pairs/ledger', 'compliance/verdict', 'compliance/report', 'compliance/rolling',
       'compliance/run', 'compliance/intermediate_report')
#: Of these the page and the terminal hear those of each sensor.
SHOWN = ('compliance/run', 'pairs')
HEADINGS = tuple(f'{role}/heading{end}' for role in ('ts', 'rs') for end in ENDS)
ALL_SENSORS = ('sensors/figures', 'sensors/verdict', 'sensors/vote')
#: What a node hears, or publishes, of all sensors together.
HEARD = {'recorder': ('sensors/report', 'sensors/verdict'), 'dashboard': ALL_SENSORS,
         'watcher': ALL_SENSORS}
PUBLISHED = {'compliance': (*ALL_SENSORS, 'sensors/report')}


def add_sensors(policy: str, namespace: str, topics: dict, reference: str | None) -> str:
    """
    Return the policy of a graph of several sensors.

    Parameters
    ----------
    policy : str
        That of two sensors, with the namespace filled in.
    namespace : str
        Of the graph.
    topics : dict of str to str
        Topic of each sensor, by name.
    reference : str or None
        Name of the reference.

    """
    root, above = ElementTree.fromstring(policy), namespace.rstrip('/')
    topics = {name: topic if topic[0] == '/' else f'{above}/{topic}'
              for name, topic in topics.items()}
    tested = [name for name in topics if reference is not None and name != reference]

    def renew(profile, rename):
        node = profile.get('node')
        for group in profile.iter('topics'):
            names = [new for topic in group for new in rename(topic.text)]
            names += (HEARD if 'subscribe' in group.attrib else PUBLISHED).get(node, ())
            for topic in [*group]:
                group.remove(topic)
            for name in sorted(dict.fromkeys(names)):
                ElementTree.SubElement(group, 'topic').text = name
        return profile

    def expand(profile):
        node = profile.get('node')
        if node == 'rs_driver':
            return []
        if node == 'ts_driver':
            drivers = []
            for name, topic in topics.items():
                def of_sensor(text, topic=topic):
                    return [text.replace('ts/heading', topic)]
                drivers.append(renew(deepcopy(profile), of_sensor))
                drivers[-1].set('node', f'{name}_driver')
            return drivers
        shown = node in ('dashboard', 'watcher')

        def rename(topic):
            if topic in HEADINGS:
                end = topic[len('ts/heading'):]
                return [] if shown else [text + end for text in topics.values()]
            if (topic in OWN or topic.startswith('scalar/')) and node != 'operator_note':
                hidden = shown and topic not in SHOWN
                return [] if hidden else [f'{name}/{topic}' for name in tested]
            return [topic]
        return [renew(deepcopy(profile), rename)]

    enclaves = root.find('enclaves')
    for enclave in [*enclaves]:
        profiles = enclave.find('profiles')
        made = [one for profile in profiles for one in expand(profile)]
        name = enclave.get('path').rpartition('/')[2]
        if name in ('ts_driver', 'rs_driver'):
            enclaves.remove(enclave)
            for one in made:
                parent = ElementTree.SubElement(enclaves, 'enclave', path=enclave.get(
                    'path').replace(name, one.get('node')))
                ElementTree.SubElement(parent, 'profiles').append(one)
            continue
        for one in [*profiles]:
            profiles.remove(one)
        profiles.extend(made)
    return ElementTree.tostring(root, 'unicode')


def read_topics(config: str) -> tuple:
    """Return the topics of the sensors of a parameter file by name, and the reference."""
    from heading_intercompare.app.config import load_config
    from heading_intercompare.core.sensor_table import find_reference, read_sensors
    sensors = read_sensors(load_config(config).shared.get('sensors'))
    if not sensors:
        raise ValueError(f'{config}: has no setting sensors')
    reference = find_reference(sensors)
    return ({one.name: one.heading_topic for one in sensors},
            None if reference is None else reference.name)


def run(*words: str) -> None:
    """Run a command; end with its exit code if it fails."""
    code = subprocess.run(words, check=False).returncode
    if code:
        sys.exit(f'make_keystore: error: {" ".join(words[:3])} failed with code {code}; it needs '
                 'the package ros-jazzy-sros2')


def main() -> int:
    """Make the keystore."""
    parser = argparse.ArgumentParser(description=__doc__.strip().partition('\n')[0])
    parser.add_argument('keystore', help='folder to make')
    parser.add_argument('--namespace', default='/', help='namespace of the graph')
    parser.add_argument('--ts', default='ts/heading', help='topic of the tested sensor')
    parser.add_argument('--rs', default='rs/heading', help='topic of the reference sensor')
    parser.add_argument('--config', help='parameter file with the setting sensors, for several')
    given = parser.parse_args()
    try:
        several = None if given.config is None else read_topics(given.config)
    except (OSError, ValueError) as error:
        sys.stderr.write(f'make_keystore: error: {error}\n')
        return 2
    if shutil.which('ros2') is None:
        sys.stderr.write('make_keystore: error: the command ros2 is missing: install '
                         'ros-jazzy-sros2, and source /opt/ros/jazzy/setup.bash\n')
        return 2
    keystore = Path(given.keystore)
    if not (keystore / 'enclaves').is_dir():
        run('ros2', 'security', 'create_keystore', str(keystore))
    filled = keystore / 'heading_intercompare.policy.xml'
    policy = fill_in(POLICY.read_text('utf-8'), given.namespace,
                     {} if several else {'ts/heading': given.ts, 'rs/heading': given.rs})
    if several:
        policy = add_sensors(policy, given.namespace, *several)
    filled.write_text(policy, 'utf-8')
    run('ros2', 'security', 'generate_artifacts', '-k', str(keystore), '-p', str(filled))
    return 0


if __name__ == '__main__':
    sys.exit(main())
