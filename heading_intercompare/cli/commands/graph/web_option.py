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

"""The option ``--web``: the live page, served by the process that runs the graph."""

from __future__ import annotations

import argparse
from typing import Any, Mapping

from heading_intercompare.core.declared_settings import SettingsError


def add_web_argument(parser: argparse.ArgumentParser) -> None:
    """Add the option."""
    parser.add_argument('--web', nargs='?', const='', metavar='HOST:PORT',
                        help='serve the live page and print its address (default: '
                        '127.0.0.1:8080; port 0: any free one); on another address than loopback, '
                        'actions need a token')


def read_web(arguments: argparse.Namespace,
             section: Mapping[str, Any]) -> dict[str, Any] | None:
    """
    Return the parameters of the node dashboard; None without the option.

    Parameters
    ----------
    arguments
        Arguments of the command, with the option `web`.
    section
        The section `dashboard` of the parameter file; the option goes before it.

    Raises
    ------
    SettingsError
        If the address is not HOST:PORT, HOST or :PORT.

    """
    if arguments.web is None:
        return None
    address: dict[str, Any] = {}
    host, colon, port = arguments.web.rpartition(':')
    if not colon or arguments.web.endswith(']'):
        host, port = arguments.web, ''
    if port and not (port.isdecimal() and port.isascii()):
        raise SettingsError(f'--web {arguments.web}: must be HOST:PORT, e.g. 127.0.0.1:8080')
    if host:
        address['host'] = host.strip('[]')
    if port:
        address['port'] = int(port)
    return {**section, **address}
