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

"""The command ``verify``: who signed files, and whether they are unchanged."""

from __future__ import annotations

import argparse
from typing import Sequence

from heading_intercompare.app.signatures.ssh_signature import find_signers
from heading_intercompare.app.signatures.verification import BROKEN, verify_path
from heading_intercompare.cli.terminal.console import say_lines


def add_signers_argument(parser: argparse._ActionsContainer) -> None:
    """Add the option that names the signers."""
    parser.add_argument('--signers', metavar='F', help='list of signers and their keys, in the '
                        'form of ssh-keygen, allowed signers (default: ~/.ssh/allowed_signers)')


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument('files', nargs='+', metavar='FILE',
                        help='a file with FILE.sig beside it, or a folder with FOLDER.sha256 and '
                        'FOLDER.sha256.sig; of a verdict in JSON its inputs and recordings are '
                        'checked too')
    add_signers_argument(parser)


def list_signed(paths: Sequence[str]) -> list[str]:
    """
    Return the files without signatures, which a pattern of the shell may have among them.

    Raises
    ------
    ValueError
        If no other file is left.

    """
    signed = [path for path in paths if not path.endswith('.sig')]
    if not signed:
        raise ValueError(f'{paths[0]}: is a signature; give the file that it signs')
    return signed


def run(arguments: argparse.Namespace) -> int:
    """Print who signed each file; return 1 if one is changed, 3 if a signer is unknown."""
    signers = find_signers(arguments.signers)
    meanings = []
    for path in list_signed(arguments.files):
        checks = verify_path(path, signers)
        say_lines(check.line for check in checks)
        meanings += [check.meaning for check in checks]
    return BROKEN if BROKEN in meanings else max(meanings)
