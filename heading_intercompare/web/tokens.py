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

"""Who may act on the page: tokens from the environment, or from a file of their owner alone."""

from __future__ import annotations

import hmac
import os
import secrets
import stat
from typing import Mapping, NamedTuple, Sequence

from heading_intercompare.core.declared_settings import SettingsError

VARIABLE = 'HEADING_INTERCOMPARE_TOKEN'
"""The environment variable with the one token of all operators."""

_LEAST = 8
#: More bytes are no list of operators.
_MOST = 65_536


class NamedToken(NamedTuple):
    """A token, and the operator who has it; no name if all have the same."""

    operator: str
    token: str


def make_token() -> NamedToken:
    """Return a token that nobody can guess."""
    return NamedToken('', secrets.token_urlsafe(12))


def read_tokens(path: str | None, environment: Mapping[str, str]) -> tuple[NamedToken, ...]:
    """
    Return the tokens that the user states; none if there are none.

    Parameters
    ----------
    path
        File with a line ``NAME TOKEN`` for each operator; ``#`` begins a comment.
    environment
        The environment of the process.

    Raises
    ------
    OSError
        If the file cannot be read.
    SettingsError
        If others than its owner may read the file, a line is wrong, or a token is too short. The
        message is one line that repeats no token.

    """
    token = environment.get(VARIABLE)
    if path is None:
        if token is not None and len(token) < _LEAST:
            raise SettingsError(f'{VARIABLE}: a token must have at least {_LEAST} letters')
        return () if token is None else (NamedToken('', token),)
    if token is not None:
        raise SettingsError(f'token_file = {path!r} and {VARIABLE}: state one of them')
    return _parse_tokens(path, _read_private(path))


def _read_private(path: str) -> str:
    """Return the text of a file; SettingsError if others than its owner may read or write it."""
    descriptor = os.open(path, os.O_RDONLY | os.O_CLOEXEC | os.O_NONBLOCK)
    with open(descriptor, 'rb') as file:
        status = os.fstat(descriptor)
        if not stat.S_ISREG(status.st_mode):
            raise SettingsError(f'{path}: a file with tokens must be a regular file')
        if status.st_mode & 0o077:
            raise SettingsError(
                f'{path}: its mode is {stat.S_IMODE(status.st_mode):04o}, so others than its '
                f'owner may open it: chmod 600 {path}')
        data = file.read(_MOST + 1)
    if len(data) > _MOST:
        raise SettingsError(f'{path}: a file with tokens must have at most {_MOST} bytes')
    try:
        return data.decode('utf-8-sig')
    except UnicodeDecodeError as error:
        raise SettingsError(f'{path}: must be text in UTF-8') from error


def _parse_tokens(path: str, text: str) -> tuple[NamedToken, ...]:
    tokens: list[NamedToken] = []
    for number, line in enumerate(text.splitlines(), 1):
        words = line.split()
        if not words or words[0].startswith('#'):
            continue
        problem = _find_problem(words, tokens)
        if problem:
            raise SettingsError(f'{path}, line {number}: {problem}')
        tokens.append(NamedToken(' '.join(words[:-1]), words[-1]))
    if not tokens:
        raise SettingsError(f"{path}: holds no token: write a line 'NAME TOKEN' per operator")
    return tuple(tokens)


def _find_problem(words: Sequence[str], tokens: Sequence[NamedToken]) -> str:
    """Return what is wrong with a line after those before it, without its token; '' if nothing."""
    *name, token = words
    if not name:
        return "must be 'NAME TOKEN', the name of the operator first"
    if len(token) < _LEAST:
        return f'a token must have at least {_LEAST} letters'
    if not ' '.join(name).isprintable():
        return 'a name must be printable'
    if ' '.join(name) in [earlier.operator for earlier in tokens]:
        return f'{" ".join(name)!r} has a token already'
    if token in [earlier.token for earlier in tokens]:
        return 'another operator has this token: each needs a token of its own'
    return ''


def find_operator(entered: str, tokens: Sequence[NamedToken]) -> str | None:
    """
    Return the operator whose token was entered, in the same time for every wrong one.

    Returns
    -------
    str or None
        '' if no token is needed or the token names nobody; None if the token is wrong.

    Examples
    --------
    >>> find_operator('tokenofmate', [NamedToken('Mate', 'tokenofmate')])
    'Mate'
    >>> find_operator('guess', [NamedToken('Mate', 'tokenofmate')]) is None
    True

    """
    if not tokens:
        return ''
    data = entered.encode(errors='surrogatepass')
    operators = [named.operator for named in tokens
                 if hmac.compare_digest(data, named.token.encode(errors='surrogatepass'))]
    return operators[0] if operators else None
