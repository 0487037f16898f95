# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The checks of the ROS index: those of ament_lint where it is installed, and what stands in."""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
import re

import pytest

ROOT = Path(__file__).resolve().parent.parent
FOLDERS = [str(ROOT / name) for name in (
    'benchmarks', 'conftest.py', 'docs', 'examples', 'heading_intercompare', 'launch', 'security',
    'setup.py', 'test')]
#: What ament_pep257 leaves out.
IGNORED = ['D100', 'D101', 'D102', 'D103', 'D104', 'D105', 'D106', 'D107', 'D203', 'D212', 'D404']
HEADER = re.compile(
    r'(#!.*\n)?# Copyright 2026 The heading_intercompare authors\n#\n'
    r'# Licensed under the Apache License, Version 2\.0 \(the "License"\);\n'
    r'(#.*\n)*# limitations under the License\.\n(\n|\Z|#\n)')


@pytest.mark.slow
@pytest.mark.parametrize('name', ['copyright', 'flake8', 'pep257'])
def test_the_package_passes_ament(name):
    """As the tests of a package of ROS do, under colcon."""
    module = f'ament_{name}.main'
    if find_spec(f'ament_{name}') is None:
        pytest.skip(f'ament_{name} is not installed; it comes with ROS, not from PyPI')
    assert import_module(module).main(argv=FOLDERS) == 0


@pytest.mark.slow
def test_each_docstring_is_one_that_ament_pep257_takes():
    pydocstyle = pytest.importorskip('pydocstyle', reason='pydocstyle is not installed')
    files = [path for one in FOLDERS for path in (
        sorted(Path(one).rglob('*.py')) if Path(one).is_dir() else [Path(one)])]
    found = pydocstyle.check([str(path) for path in files], ignore=IGNORED)
    assert [str(error) for error in found] == []
    assert len(files) > 400


def test_each_source_begins_with_the_header_that_ament_copyright_knows():
    files = [path for one in FOLDERS for path in (
        Path(one).rglob('*.py') if Path(one).is_dir() else [Path(one)])]
    assert [str(path) for path in files
            if path.read_text('utf-8') and not HEADER.match(path.read_text('utf-8'))] == []
