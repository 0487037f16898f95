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

"""The server of the page: its address, and one line for each mistake."""

from __future__ import annotations

from importlib.util import find_spec
import socket
import subprocess
import sys

from deadlines import DEADLINE_S
import pytest

from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.web.server import PageServer


@pytest.mark.skipif(find_spec('nicegui') is None, reason='NiceGUI is not installed')
def test_an_address_in_use_is_refused_in_one_line():
    with socket.socket() as taken:
        taken.bind(('127.0.0.1', 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(SettingsError) as error:
            PageServer(None, port=port)
    assert str(error.value).startswith(f'the page cannot be served on 127.0.0.1:{port}: Address')
    assert '\n' not in str(error.value)


@pytest.mark.process
def test_without_nicegui_one_line_says_what_to_install():
    code = ('import sys\n'
            'sys.modules["nicegui"] = None\n'
            'from heading_intercompare.web.server import PageServer\n'
            'PageServer(None, port=0)')
    done = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True,
                          timeout=DEADLINE_S, check=False)
    assert done.stderr.splitlines()[-1].endswith(
        "SettingsError: the page needs NiceGUI: pip install 'heading_intercompare[web]'")
