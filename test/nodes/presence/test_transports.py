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

"""A live graph uses UDP, unless the user has chosen how processes reach each other."""

from __future__ import annotations

import os

import pytest

from heading_intercompare.nodes.presence.transports import prefer_udp, set_variable

CHOICES = ('FASTDDS_BUILTIN_TRANSPORTS', 'FASTRTPS_DEFAULT_PROFILES_FILE',
           'FASTDDS_DEFAULT_PROFILES_FILE')


@pytest.fixture(autouse=True)
def nothing_chosen(monkeypatch):
    """Let the environment say nothing about transports."""
    for name in CHOICES:
        monkeypatch.delenv(name, raising=False)


def test_without_a_choice_it_is_udp_and_only_meanwhile():
    with prefer_udp():
        assert os.environ[CHOICES[0]] == 'UDPv4'
    assert CHOICES[0] not in os.environ


@pytest.mark.parametrize('name', CHOICES)
def test_a_choice_of_the_user_stands(name, monkeypatch):
    monkeypatch.setenv(name, 'DEFAULT')
    before = dict(os.environ)
    with prefer_udp():
        assert dict(os.environ) == before
    assert dict(os.environ) == before


def test_a_variable_is_as_before_even_after_an_error(monkeypatch):
    monkeypatch.setenv(CHOICES[0], 'before')
    with pytest.raises(ValueError), set_variable(CHOICES[0], 'meanwhile'):
        assert os.environ[CHOICES[0]] == 'meanwhile'
        raise ValueError
    assert os.environ[CHOICES[0]] == 'before'
