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

"""The signature of one file by an ssh key, in a file that ``ssh-keygen`` makes and checks."""

from __future__ import annotations

from dataclasses import dataclass
import os
from pathlib import Path
import re
import subprocess

from heading_intercompare.replaced_file import replace_file
from heading_intercompare.special_files import refuse_special

NAMESPACE = 'heading_intercompare'
"""What the keys sign here; a signature for another purpose, such as a commit, is none."""

_PROGRAM = 'ssh-keygen'
_KEYS = ('id_ed25519', 'id_ed25519_sk', 'id_ecdsa', 'id_ecdsa_sk', 'id_rsa')
_FINGERPRINT = re.compile(r'SHA256:\S+')


class SignatureError(ValueError):
    """A signature that does not sign its file: one line with the file and what to do."""


@dataclass(frozen=True, slots=True)
class FileSignature:
    """
    A signature that signs the bytes of its file as they are.

    Attributes
    ----------
    fingerprint
        That of the key.
    name
        Whose key it is by the list of signers; empty if unknown.
    doubt
        Why the list does not name the signer, if it says so: the key has expired, for example.

    """

    fingerprint: str
    name: str = ''
    doubt: str = ''

    @property
    def words(self) -> str:
        """Return who signed, and that the file is unchanged."""
        if self.name:
            return f'signed by {self.name} ({self.fingerprint}), unchanged'
        doubt = f' ({self.doubt})' if self.doubt else ''
        return f'signed with an unknown key {self.fingerprint}{doubt}, unchanged'


def signature_path(path: str | os.PathLike[str]) -> Path:
    """Return where the signature of a file lies, beside it."""
    return Path(f'{os.fspath(path)}.sig')


def find_key(key: str | None, option: str = '--key') -> str:
    """
    Return the file of a key: that of the option, or the first of the usual ones.

    Raises
    ------
    ValueError
        If there is none.

    """
    if key is not None:
        place = Path(key).expanduser()
        if not place.is_file():
            raise ValueError(f'{option} {key}: no such file; name the file of an ssh key, or make '
                             'one with ssh-keygen -t ed25519')
        return os.fspath(place)
    folder = Path('~/.ssh').expanduser()
    for name in _KEYS:
        if (folder / name).is_file():
            return os.fspath(folder / name)
    raise ValueError(f'{folder}: has no ssh key; make one with ssh-keygen -t ed25519, or name one '
                     'with --key')


def find_signers(signers: str | None) -> str | None:
    """Return the list of signers: that of ``--signers``, or the usual one if it is there."""
    if signers is not None:
        refuse_special(os.path.expanduser(signers))
        with open(os.path.expanduser(signers), 'rb') as file:
            return file.name
    usual = os.path.expanduser('~/.ssh/allowed_signers')
    return usual if os.path.isfile(usual) else None


def sign_file(path: str | os.PathLike[str], key: str) -> Path:
    """
    Sign a file, in place of an earlier signature; return where the signature lies.

    Raises
    ------
    OSError
        If a file cannot be read or written.
    ValueError
        If `ssh-keygen` is not installed, or cannot sign with this key.

    """
    ended = _run(path, 'sign', '-f', key)
    if ended.returncode or not ended.stdout.startswith(b'-----BEGIN SSH SIGNATURE-----'):
        raise ValueError(f'{key}: cannot sign {os.fspath(path)}: {_find_reason(ended.stderr)}; '
                         'check the key, its passphrase, and the agent that holds it')
    place = signature_path(path)
    replace_file(place, ended.stdout)
    return place


def read_signature(path: str | os.PathLike[str], signers: str | None) -> FileSignature | None:
    """
    Return what the signature beside a file says of it; None without a signature.

    Parameters
    ----------
    path
        The file.
    signers
        A list of signers in the form of ``ssh-keygen``, ALLOWED SIGNERS; None to name nobody.

    Raises
    ------
    OSError
        If the file cannot be read.
    SignatureError
        If the signature does not sign the bytes of the file.
    ValueError
        If `ssh-keygen` is not installed.

    """
    os.stat(path)
    place = signature_path(path)
    if not place.exists():
        return None
    beside = ('-s', os.fspath(place))
    ended = _run(path, 'check-novalidate', *beside)
    fingerprint = _FINGERPRINT.search(ended.stdout.decode(errors='replace'))
    if ended.returncode or fingerprint is None:
        raise SignatureError(
            f'{os.fspath(path)}: changed, or not the file that {place.name} signs: '
            f'{_find_reason(ended.stderr)}; get the file and its signature from the signer')
    if signers is None:
        return FileSignature(fingerprint[0])
    listed = ('-f', signers)
    names = _run(path, 'find-principals', *beside, *listed)
    lines = names.stderr.decode(errors='replace').splitlines()
    for name in names.stdout.decode(errors='replace').splitlines():
        ended = _run(path, 'verify', '-I', name, *beside, *listed)
        if not ended.returncode:
            return FileSignature(fingerprint[0], name)
        lines += ended.stderr.decode(errors='replace').splitlines()
    return FileSignature(fingerprint[0], doubt='; '.join(
        line for line in lines if line.startswith(signers)))


def _run(path: str | os.PathLike[str], action: str,
         *arguments: str) -> subprocess.CompletedProcess[bytes]:
    """Return what ``ssh-keygen`` says of the bytes of a file."""
    purpose = () if action == 'find-principals' else ('-n', NAMESPACE)
    try:
        with open(path, 'rb') as file:
            return subprocess.run([_PROGRAM, '-Y', action, *purpose, *arguments], stdin=file,
                                  capture_output=True)
    except FileNotFoundError as error:
        if error.filename != _PROGRAM:
            raise
        raise ValueError(f'{_PROGRAM} is not installed, which signs and checks: install OpenSSH '
                         '(apt: openssh-client)') from None


def _find_reason(text: bytes) -> str:
    """Return why ``ssh-keygen`` refuses, without what it says of its work."""
    lines = text.decode(errors='replace').replace('Enter passphrase: ', '').splitlines()
    return '; '.join(line.strip() for line in lines if line.strip()
                     and not line.startswith('Signing ')) or 'ssh-keygen gives no reason'
