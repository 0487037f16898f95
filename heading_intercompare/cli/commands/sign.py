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

"""The command ``sign``: signs verdicts, protocols and bags with an ssh key."""

from __future__ import annotations

import argparse

from heading_intercompare.app.signatures.ssh_signature import find_key
from heading_intercompare.app.signatures.verification import sign_path
from heading_intercompare.cli.terminal.console import say_lines

from .verify import list_signed


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument('files', nargs='+', metavar='FILE',
                        help='a file, whose signature is written to FILE.sig; or a folder, such '
                        'as a bag: FOLDER.sha256 lists the SHA-256 of its files, and is signed')
    parser.add_argument('--key', metavar='F', help='file of an ssh key, also the public one of a '
                        'key that an agent holds (default: ~/.ssh/id_ed25519, or another of ssh)')


def run(arguments: argparse.Namespace) -> int:
    """Sign each file, and say where the signatures are."""
    key = find_key(arguments.key)
    for path in list_signed(arguments.files):
        say_lines([f'signature: {sign_path(path, key)}'])
    return 0
