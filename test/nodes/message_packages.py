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
Message packages that are not installed here, built from their definitions for a test.

The generators of ROS write the code and gcc compiles it, in two seconds. So a test publishes and
hears messages of the real type; what it cannot show is the package as its authors build it.
"""

from __future__ import annotations

import ctypes
from importlib.util import find_spec
import os
from pathlib import Path
import shutil
import subprocess
import sys
import sysconfig

import numpy
import pytest

SENTENCE = 'std_msgs/Header header\nstring sentence\n'
_LIBRARIES = ('std_msgs__rosidl_generator_c', 'std_msgs__rosidl_generator_py',
              'std_msgs__rosidl_typesupport_fastrtps_c',
              'std_msgs__rosidl_typesupport_introspection_c',
              *(f'geometry_msgs__rosidl_{part}' for part in (
                  'generator_c', 'generator_py', 'typesupport_fastrtps_c',
                  'typesupport_introspection_c')),
              'builtin_interfaces__rosidl_generator_c', 'rosidl_runtime_c', 'rosidl_typesupport_c',
              'rosidl_typesupport_fastrtps_c', 'rosidl_typesupport_fastrtps_cpp',
              'rosidl_typesupport_introspection_c', 'fastcdr', 'rcutils')
#: What is generated, and the name of the library that it becomes.
_PARTS = {'generator': 'lib{}__rosidl_generator_c.so',
          'fastrtps': 'lib{}__rosidl_typesupport_fastrtps_c.so',
          'introspection': 'lib{}__rosidl_typesupport_introspection_c.so',
          'package': '{}_s__rosidl_typesupport_c.so'}
#: Runs in a process of its own, with the paths of the generators.
_GENERATE = """
import pathlib, sys
from rosidl_cli.command.translate.api import translate
from rosidl_generator_c.cli import GenerateC
from rosidl_generator_py.cli import GeneratePython
from rosidl_typesupport_c.cli import GenerateCTypesupport
from rosidl_typesupport_fastrtps_c.cli import GenerateFastRTPSCTypesupport
from rosidl_typesupport_introspection_c.cli import GenerateIntrospectionCTypesupport
package, folder, share, *names = sys.argv[1:]
paths = [str(path) for path in translate(
    package_name=package, interface_files=[f'{folder}/share/{package}:msg/{name}.msg'
                                           for name in names],
    include_paths=[share], output_format='idl', output_path=pathlib.Path(folder, 'idl'))]
for name, generator in (
        ('generator', GenerateC('c')), ('fastrtps', GenerateFastRTPSCTypesupport('fastrtps')),
        ('introspection', GenerateIntrospectionCTypesupport('introspection')),
        ('package', GenerateCTypesupport('c', typesupport_implementations=[
            'rosidl_typesupport_fastrtps_c', 'rosidl_typesupport_introspection_c']))):
    generator.generate(package, paths, [share], pathlib.Path(folder, name, package))
GeneratePython('py', typesupport_implementations=['rosidl_typesupport_c']).generate(
    package, paths, [share], pathlib.Path(folder, 'package', package))
"""


def _find_prefix() -> Path:
    """Return where the packages of ROS are, with the headers of std_msgs."""
    for prefix in [*os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep), sys.prefix]:
        if prefix and Path(prefix, 'include', 'std_msgs').is_dir():
            return Path(prefix)
    pytest.skip('the headers of std_msgs are not installed')


def make_package(folder: Path, package: str, definitions: dict[str, str]) -> Path:
    """
    Build a package of messages; return the folder to import it from.

    The definitions are beneath `folder/share`, as those of an installed package.
    """
    if not (shutil.which('gcc') and shutil.which('g++') and find_spec('rosidl_generator_py')):
        pytest.skip('no compiler, or no generators of ROS')
    prefix = _find_prefix()
    texts = folder / 'share' / package / 'msg'
    texts.mkdir(parents=True)
    for name, text in definitions.items():
        (texts / f'{name}.msg').write_text(text)
    environment = {**os.environ, 'AMENT_PREFIX_PATH': str(prefix)}
    subprocess.run([sys.executable, '-c', _GENERATE, package, str(folder), str(prefix / 'share'),
                    *definitions], check=True, env=environment, capture_output=True)
    includes = [f'-I{path}' for path in (
        *(folder / part for part in _PARTS),
        *filter(Path.is_dir, (prefix / 'include').iterdir()), prefix / 'include',
        sysconfig.get_path('include'), numpy.get_include())]
    linked = [f'-L{prefix / "lib"}', *(f'-l{name}' for name in _LIBRARIES),
              f'-Wl,-rpath,{prefix / "lib"}']
    libraries: list[str] = []
    for part, name in _PARTS.items():
        library = folder / 'package' / package / name.format(package)
        subprocess.run(
            ['g++', '-shared', f'-Wl,-soname,{library.name}', '-o',
             str(library), *_compile(folder / part, includes), *libraries, *linked],
            check=True, capture_output=True)
        libraries.append(str(library))
        if part != 'package':
            # So the middleware has it by its name, wherever it is.
            ctypes.CDLL(str(library), ctypes.RTLD_GLOBAL)
    return folder / 'package'


def _compile(folder: Path, includes: list[str]) -> list[str]:
    """Compile all sources in a folder; return the objects."""
    objects = []
    for source in [*folder.rglob('*.c'), *folder.rglob('*.cpp')]:
        objects.append(f'{source}.o')
        subprocess.run(['gcc' if source.suffix == '.c' else 'g++', '-fPIC', '-c', str(source),
                        '-o', objects[-1], *includes], check=True, capture_output=True)
    return objects
