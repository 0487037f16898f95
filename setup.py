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

"""One package for pip (with or without ROS) and for colcon (ament_python)."""

from pathlib import Path
import re
import sys
from xml.etree import ElementTree

from setuptools import find_packages, setup

NAME = 'heading_intercompare'
VERSION = re.search(r"^VERSION = '([^']+)'", Path(NAME, 'core', 'version.py').read_text('utf-8'),
                    re.MULTILINE)[1]
# Addresses stand in package.xml only.
PACKAGE = ElementTree.parse('package.xml').getroot()
MAINTAINER = PACKAGE.find('maintainer')
# colcon and the build farm put the executables of the nodes where `ros2 run` looks (setup.cfg).
# pip would put them on everybody's PATH.
FOR_ROS = {'install', 'develop'} & {*sys.argv[1:]}
NODES = ('nmea_driver', 'sensor_simulator', 'synchronizer', 'compliance', 'intercompare',
         'recorder', 'replayer',
         'dashboard', 'motion_driver', 'alert_sender')


def list_shared(*folders):
    """Return the files in and below the folders, for share/heading_intercompare."""
    below = [p for f in folders for p in [Path(f), *Path(f).rglob('*')] if p.is_dir()]
    files = {d: sorted(str(p) for p in d.iterdir() if p.is_file() and p.suffix != '.pyc')
             for d in below}
    return [(f'share/{NAME}/{d}', found) for d, found in files.items() if found]


setup(
    name=NAME,
    version=VERSION,
    description='Intercomparison of shipboard heading sensors: does the tested one comply?',
    long_description=Path('README.md').read_text('utf-8') if Path('README.md').exists() else '',
    long_description_content_type='text/markdown',
    maintainer=MAINTAINER.text,
    maintainer_email=MAINTAINER.get('email'),
    project_urls={one.get('type'): one.text for one in PACKAGE.iter('url')},
    license='Apache-2.0',
    packages=find_packages(include=[NAME, f'{NAME}.*']),
    package_data={NAME: ['py.typed', 'report/templates/*', 'web/static/*']},
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{NAME}']),
        (f'share/{NAME}', ['package.xml']),
        *list_shared('config', 'displays', 'launch', 'schema', 'security', 'systemd'),
    ],
    zip_safe=False,
    python_requires='>=3.10',
    install_requires=['numpy>=1.22', 'scipy>=1.10', 'mcap>=1.2', 'lz4>=4.0',
                      'zstandard>=0.18', 'pyyaml>=5.4'],
    extras_require={
        'ros': ['ros-jazzy-rclpy', 'ros-jazzy-common-interfaces', 'ros-jazzy-rmw-fastrtps-cpp'],
        'serial': ['pyserial>=3.5'],
        'report': ['jinja2>=3.0', 'matplotlib>=3.5', 'segno>=1.5'],
        'pdf': ['jinja2>=3.0', 'matplotlib>=3.5', 'segno>=1.5', 'weasyprint>=61.2'],
        'terminal': ['rich>=13', 'argcomplete>=3'],
        'web': ['nicegui>=3.5'],
        'push': ['httpx>=0.24'],
        'fast': ['isal>=1.5', 'numba>=0.59'],
        'bags': ['rosbags>=0.9.22'],
        'parquet': ['pyarrow>=14.0.1'],
        'sun': ['ephem>=4.1'],
        'dask': ['distributed>=2024.2', 'threadpoolctl>=3'],
        'test': ['pytest>=7.4', 'pytest-xdist>=3.4', 'pytest-timeout>=2.2', 'hypothesis>=6',
                 'rosbags', 'pyarrow>=14.0.1', 'mcap-ros2-support', 'pybag-sdk',
                 'jsonschema>=4', 'ephem>=4.1', 'pydcc>=0.2.33', 'xmlschema>=3'],
        'browser': ['nicegui>=3.5', 'playwright>=1.40', 'axe-playwright-python>=0.1.4'],
        'docs': ['sphinx>=7', 'myst-parser>=2', 'numpydoc>=1.6', 'pydata-sphinx-theme>=0.14'],
        'notebook': ['nbclient>=0.6', 'ipykernel>=6', 'matplotlib>=3.5'],
        'sbom': ['cyclonedx-bom>=4'],
        'dev': ['ruff', 'mypy>=2.4', 'pydocstyle>=6.3', 'pytest-cov>=4.1',
                'colcon-common-extensions'],
    },
    entry_points={
        'console_scripts': [
            f'heading-intercompare = {NAME}.cli:main',
            *(f'{node} = {NAME}.node_executables:{node}' for node in NODES if FOR_ROS),
        ],
    },
)
