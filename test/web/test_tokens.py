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

"""Tokens come from the environment or from a private file, and no message repeats one."""

from __future__ import annotations

import os

import pytest

from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.web.tokens import (
    find_operator,
    make_token,
    NamedToken,
    read_tokens,
    VARIABLE,
)

MATE, MASTER = NamedToken('Mate', 'geheim-ü-1'), NamedToken('Old Master', 'geheim-ü-2')


def write(path, text, mode=0o600):
    path.touch()
    path.chmod(mode)
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return str(path)


@pytest.mark.parametrize('environment, tokens', [
    ({}, ()), ({VARIABLE: 'choose-your-own'}, (NamedToken('', 'choose-your-own'),))])
def test_the_environment_may_hold_the_token_of_all(environment, tokens):
    assert read_tokens(None, environment) == tokens


@pytest.mark.parametrize('text', [
    'Mate geheim-ü-1\nOld Master geheim-ü-2\n',
    '\ufeff# bridge\r\n\r\n  Mate\tgeheim-ü-1  \r\nOld  Master geheim-ü-2'])
def test_a_file_holds_a_token_per_operator(tmp_path, text):
    assert read_tokens(write(tmp_path / 'tokens', text), {}) == (MATE, MASTER)


@pytest.mark.parametrize('mode', [0o640, 0o604, 0o620, 0o644, 0o660])
def test_a_file_that_others_may_open_is_refused(tmp_path, mode):
    path = write(tmp_path / 'tokens', 'Mate geheim-ü-1\n', mode)
    with pytest.raises(SettingsError, match=f'^{path}: its mode is {mode:04o}, .*: chmod 600 '):
        read_tokens(path, {})


@pytest.mark.parametrize('text, words', [
    ('', ": holds no token: write a line 'NAME TOKEN' per operator"),
    ('# Mate geheim-ü-1', ': holds no token: '),
    ('Mate geheim-ü-1\ngeheim-ü-2', ", line 2: must be 'NAME TOKEN', the name of the operator"),
    ('\nMate short', ', line 2: a token must have at least 8 letters'),
    ('Mate geheim-ü-1\nMate geheim-ü-2', ", line 2: 'Mate' has a token already"),
    ('Mate geheim-ü-1\nMaster geheim-ü-1', ', line 2: another operator has this token'),
    ('Ma\x07te geheim-ü-1', ', line 1: a name must be printable'),
    (b'Mate geheim-\xff\xff', ': must be text in UTF-8'),
    ('x' * 70_000, ': a file with tokens must have at most 65536 bytes')])
def test_a_wrong_file_is_refused_in_one_line_without_a_token(tmp_path, text, words):
    path = write(tmp_path / 'tokens', text)
    with pytest.raises(SettingsError) as refused:
        read_tokens(path, {})
    assert str(refused.value).startswith(path + words)
    assert '\n' not in str(refused.value) and 'geheim' not in str(refused.value)


def test_a_pipe_is_refused_at_once(tmp_path):
    os.mkfifo(tmp_path / 'tokens', 0o600)
    with pytest.raises(SettingsError, match='must be a regular file'):
        read_tokens(str(tmp_path / 'tokens'), {})


def test_a_missing_file_is_an_error_of_the_system(tmp_path):
    with pytest.raises(FileNotFoundError):
        read_tokens(str(tmp_path / 'tokens'), {})


@pytest.mark.parametrize('path, token, words', [
    (None, 'short', f'{VARIABLE}: a token must have at least 8 letters'),
    (None, '', f'{VARIABLE}: a token must have'),
    ('tokens', 'choose-your-own', f"token_file = 'tokens' and {VARIABLE}: state one of them")])
def test_a_wrong_environment_is_refused_without_the_token(path, token, words):
    with pytest.raises(SettingsError) as refused:
        read_tokens(path, {VARIABLE: token})
    assert str(refused.value).startswith(words)
    assert not token or token not in str(refused.value)


def test_a_token_names_its_operator():
    assert find_operator('geheim-ü-2', [MATE, MASTER]) == 'Old Master'
    assert find_operator('anything', []) == ''
    for wrong in ('', 'geheim-', 'geheim-ü-12', 'Mate', '\ud800'):
        assert find_operator(wrong, [MATE, MASTER]) is None


def test_a_token_that_is_made_is_never_twice_the_same():
    tokens = {make_token().token for _ in range(20)}
    assert len(tokens) == 20 and min(map(len, tokens)) >= 16
