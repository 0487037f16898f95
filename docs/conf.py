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

"""Sphinx settings of the documentation site, for ``make docs`` and rosdoc2."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
import sys
from typing import Any, get_origin

DOCS = Path(__file__).resolve().parent
sys.path[:0] = [str(DOCS.parent), str(DOCS)]

from site_pages import write_pages  # noqa: E402

from heading_intercompare.core.version import VERSION  # noqa: E402

project = 'heading_intercompare'
author = 'The heading_intercompare authors'
copyright = f'2026, {author}'
version = release = VERSION

extensions = ['myst_parser', 'numpydoc', 'sphinx.ext.autodoc']
exclude_patterns = ['_build', '_site', 'static']
source_suffix = {'.md': 'markdown', '.rst': 'restructuredtext'}
myst_enable_extensions = ['colon_fence', 'deflist']
myst_heading_anchors = 4

html_theme = 'pydata_sphinx_theme'
html_title = f'heading_intercompare {VERSION}'
html_theme_options = {'show_prev_next': False, 'navigation_with_keys': False}
html_copy_source = False
html_static_path = ['static']
html_css_files = ['site.css']
html_search_scorer = str(DOCS / 'search_scorer.js')

add_module_names = False
autodoc_member_order = 'bysource'
autodoc_typehints = 'signature'
python_maximum_signature_line_length = 88
autodoc_mock_imports = [name for name in (
    'rclpy', 'rcl_interfaces', 'diagnostic_msgs', 'geometry_msgs', 'nav_msgs', 'rosgraph_msgs',
    'sensor_msgs', 'std_msgs', 'std_srvs', 'serial', 'distributed', 'isal', 'numba', 'pandas',
    'ephem')
    if find_spec(name) is None]
# Several modules have a class of one name, which signatures give without its module.
suppress_warnings = ['ref.python']
numpydoc_show_class_members = False
numpydoc_xref_param_type = False


def skip_foreign(app: object, what: str, name: str, obj: object, skip: bool,
                 options: object) -> bool | None:
    """Leave out names of types, and what a module imports from other packages."""
    is_foreign = callable(obj) and not str(getattr(obj, '__module__', '')).startswith(project)
    return True if what == 'module' and (is_foreign or get_origin(obj) is not None) else None


def setup(app: Any) -> None:
    """Write the reference pages before Sphinx looks for its sources."""
    write_pages(DOCS / 'reference')
    app.connect('autodoc-skip-member', skip_foreign)
