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


"""The page for the auditor: its tests exist, and the package asks for its versions."""

from __future__ import annotations

from importlib.util import find_spec
import json
from pathlib import Path
import re
import subprocess
import sys

from packaging.requirements import Requirement
import pytest

ROOT = Path(__file__).resolve().parents[1]
PAGE = (ROOT / 'docs' / 'security.md').read_text('utf-8')
SETUP = (ROOT / 'setup.py').read_text('utf-8')


def rows_of(heading):
    """Return the rows of the table under a heading, as lists of cells."""
    section = PAGE.partition(f'\n## {heading}\n')[2].partition('\n## ')[0]
    rows = [[cell.strip() for cell in line.strip('|').split(' | ')]
            for line in section.splitlines() if line.startswith('|')]
    assert len(rows) > 3
    return rows[2:]


def test_each_requirement_names_tests_that_exist_or_says_that_nothing_is_done():
    for requirement, done, tested in rows_of('For the auditor'):
        paths = re.findall(r'`(test/[\w/.]+)`', tested)
        assert paths or done.startswith('nothing') or tested == '–', requirement
        assert all((ROOT / path).exists() for path in paths), tested


def test_the_requirements_of_the_norm_are_there_and_none_twice():
    numbers = [number for row in rows_of('For the auditor')
               for number in re.findall(r'\d\.\d+(?: RE 2)?', row[0].partition(' of ')[0])]
    assert len(numbers) == len(set(numbers)) and len(numbers) >= 35


@pytest.mark.parametrize('row', rows_of('Libraries'), ids=lambda row: row[0].split()[0])
def test_the_versions_of_the_page_are_those_that_the_package_asks_for(row):
    name, least = row[0].split()[0], row[1]
    asked = [Requirement(text) for text in re.findall(rf"'({name}[>=!\d.]*)'", SETUP)]
    assert asked and {str(requirement.specifier) for requirement in asked} == {f'>={least}'}


def test_the_address_for_weaknesses_is_in_the_manifest_alone():
    text = (ROOT / 'SECURITY.md').read_text('utf-8')
    assert 'package.xml' in text and not re.search(r'\S+@\S+|https?://', text)


@pytest.mark.process
@pytest.mark.skipif(find_spec('cyclonedx_py') is None, reason='the extra sbom is not installed')
def test_the_bill_of_materials_names_each_library_with_its_version(tmp_path):
    """As `make sbom`, of this environment."""
    place = tmp_path / 'sbom.cdx.json'
    done = subprocess.run([sys.executable, '-m', 'cyclonedx_py', 'environment', '-o', str(place),
                           sys.executable], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    bill = json.loads(place.read_text('utf-8'))
    versions = {part['name'].lower(): part['version'] for part in bill['components']}
    needed = re.search(r'install_requires=\[([^]]*)\]', SETUP)[1]
    names = {Requirement(text).name.lower() for text in re.findall(r"'([^']+)'", needed)}
    assert bill['bomFormat'] == 'CycloneDX' and len(names) == 6
    assert names <= versions.keys() and all(versions[name] for name in names)
