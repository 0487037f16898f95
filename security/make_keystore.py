#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""
Make a keystore of SROS 2 with an enclave for each node, from the policy beside this file.

    ./make_keystore.py KEYSTORE [--namespace /ship1] [--ts TOPIC] [--rs TOPIC]

It runs `ros2 security`, which apt installs with ros-jazzy-sros2. The middleware of the Python
wheels has no security.
"""

import argparse
from pathlib import Path
import shutil
import subprocess
import sys

POLICY = Path(__file__).resolve().parent / 'heading_intercompare.policy.xml'


def fill_in(policy: str, namespace: str, topics: dict) -> str:
    """Return the policy for a namespace, with other topics of the headings."""
    policy = policy.replace('ns="/"', f'ns="{namespace}"')
    for usual, topic in topics.items():
        for end in ('', '/lost'):
            policy = policy.replace(f'<topic>{usual}{end}<', f'<topic>{topic}{end}<')
    return policy


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
    given = parser.parse_args()
    if shutil.which('ros2') is None:
        sys.stderr.write('make_keystore: error: the command ros2 is missing: install '
                         'ros-jazzy-sros2, and source /opt/ros/jazzy/setup.bash\n')
        return 2
    keystore = Path(given.keystore)
    if not (keystore / 'enclaves').is_dir():
        run('ros2', 'security', 'create_keystore', str(keystore))
    filled = keystore / 'heading_intercompare.policy.xml'
    filled.write_text(fill_in(POLICY.read_text('utf-8'), given.namespace,
                              {'ts/heading': given.ts, 'rs/heading': given.rs}), 'utf-8')
    run('ros2', 'security', 'generate_artifacts', '-k', str(keystore), '-p', str(filled))
    return 0


if __name__ == '__main__':
    sys.exit(main())
