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

"""The option --web."""

from __future__ import annotations

import argparse

import pytest

from heading_intercompare.cli.commands.graph.web_option import add_web_argument, read_web
from heading_intercompare.core.declared_settings import SettingsError


def read(*words, section=None):
    parser = argparse.ArgumentParser()
    add_web_argument(parser)
    return read_web(parser.parse_args(words), section or {})


@pytest.mark.parametrize('words, expected', [
    ([], None), (['--web'], {}), (['--web', ':9000'], {'port': 9000}),
    (['--web', '0.0.0.0'], {'host': '0.0.0.0'}), (['--web', '[::1]'], {'host': '::1'}),
    (['--web', '[::1]:0'], {'host': '::1', 'port': 0}),
    (['--web', 'ship:81'], {'host': 'ship', 'port': 81})])
def test_an_address_may_be_given_in_part(words, expected):
    assert read(*words) == expected


def test_the_option_goes_before_the_parameter_file():
    assert read('--web', ':1', section={'port': 2, 'token_file': 'x'}) == {
        'port': 1, 'token_file': 'x'}


def test_a_wrong_port_is_refused_in_one_line():
    with pytest.raises(SettingsError, match='--web ship:x: must be HOST:PORT, e.g. 127.0.0.1'):
        read('--web', 'ship:x')
