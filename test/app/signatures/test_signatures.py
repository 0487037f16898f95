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

"""Each change of a signed file or folder is said, and the signer is named only by the list."""

from __future__ import annotations

import shutil
import subprocess

import pytest

from heading_intercompare.app.signatures.manifest import compare_with_manifest, manifest_path
from heading_intercompare.app.signatures.ssh_signature import (
    find_key,
    NAMESPACE,
    read_signature,
    sign_file,
    signature_path,
    SignatureError,
)
from heading_intercompare.app.signatures.verification import (
    BROKEN,
    GOOD,
    sign_path,
    UNKNOWN,
    verify_path,
)

pytestmark = [pytest.mark.process, pytest.mark.skipif(
    shutil.which('ssh-keygen') is None, reason='OpenSSH is not installed')]


@pytest.fixture(scope='module')
def keys(tmp_path_factory):
    """Return a folder with two keys without a passphrase, and one with a passphrase."""
    folder = tmp_path_factory.mktemp('keys')
    for name, passphrase in (('alice', ''), ('mallory', ''), ('locked', 'secret')):
        subprocess.run(['ssh-keygen', '-q', '-t', 'ed25519', '-N', passphrase, '-C', name,
                        '-f', folder / name], check=True)
    return folder


@pytest.fixture
def signed(keys, tmp_path):
    """Return a file that alice has signed."""
    path = tmp_path / 'verdict.txt'
    path.write_bytes(b'compliant\n')
    sign_file(path, str(keys / 'alice'))
    return path


def list_signers(keys, folder, *rows):
    """Write a list of signers, with ``{KEY}`` for the public key of a name; return its path."""
    path = folder / 'signers'
    path.write_text('\n'.join(row.format(**{
        name: (keys / f'{name}.pub').read_text().strip() for name in ('alice', 'mallory')})
        for row in rows) + '\n')
    return str(path)


def fingerprint(keys, name):
    """Return the fingerprint of a key, as ``ssh-keygen -l`` says it."""
    return subprocess.run(['ssh-keygen', '-l', '-f', keys / f'{name}.pub'], check=True, text=True,
                          stdout=subprocess.PIPE).stdout.split()[1]


def test_ssh_keygen_alone_verifies_a_signature(signed, keys, tmp_path):
    signers = list_signers(keys, tmp_path, 'alice@ship {alice}')
    with open(signed, 'rb') as file:
        said = subprocess.run(
            ['ssh-keygen', '-Y', 'verify', '-f', signers, '-I', 'alice@ship', '-n', NAMESPACE,
             '-s', f'{signed}.sig'], stdin=file, check=True, text=True, stdout=subprocess.PIPE)
    assert fingerprint(keys, 'alice') in said.stdout


@pytest.mark.parametrize('rows, name, doubt', [
    (['alice@ship {alice}'], 'alice@ship', ''),
    (['mallory {mallory}', '# us', 'a@ship,b@ship {alice}'], 'a@ship', ''),
    (['alice@ship namespaces="heading_intercompare" {alice}'], 'alice@ship', ''),
    (['mallory {mallory}'], '', ''),
    (['alice@ship namespaces="git" {alice}'], '', 'not permitted'),
    (['alice@ship valid-before="20200101" {alice}'], '', 'expired'),
    (['alice@ship'], '', 'missing key')])
def test_the_signer_is_named_by_the_list_alone(signed, keys, tmp_path, rows, name, doubt):
    signature = read_signature(signed, list_signers(keys, tmp_path, *rows))
    assert (signature.name, signature.fingerprint) == (name, fingerprint(keys, 'alice'))
    assert doubt in signature.doubt and bool(doubt) == bool(signature.doubt)
    assert signature.words.startswith(f'signed by {name} (SHA256:' if name else
                                      'signed with an unknown key SHA256:')


def test_a_signature_by_another_key_names_that_key_and_nobody(signed, keys, tmp_path):
    signers = list_signers(keys, tmp_path, 'alice@ship {alice}')
    signed.write_bytes(b'non-compliant\n')
    sign_file(signed, str(keys / 'mallory'))
    signature = read_signature(signed, signers)
    assert (signature.name, signature.fingerprint) == ('', fingerprint(keys, 'mallory'))


@pytest.mark.parametrize('change', [
    lambda path: path.write_bytes(b'compliant'),
    lambda path: path.write_bytes(b'Compliant\n'),
    lambda path: path.write_bytes(b''),
    lambda path: signature_path(path).write_text('none'),
    lambda path: signature_path(path).write_bytes(b''),
    lambda path: signature_path(path).write_text(
        signature_path(path).read_text().replace('A', 'B', 1))])
def test_each_change_of_a_signed_file_or_its_signature_is_said(signed, keys, tmp_path, change):
    change(signed)
    for signers in (None, list_signers(keys, tmp_path, 'alice@ship {alice}')):
        with pytest.raises(SignatureError, match=r'verdict.txt: changed, or not the file that '):
            read_signature(signed, signers)
        check, = verify_path(str(signed), signers)
        assert check.meaning == BROKEN and '\n' not in check.line


def test_a_signature_for_another_purpose_signs_nothing_here(signed, keys):
    with open(signed, 'rb') as file:
        signature_path(signed).write_bytes(subprocess.run(
            ['ssh-keygen', '-Y', 'sign', '-n', 'git', '-f', keys / 'alice'], stdin=file,
            check=True, capture_output=True).stdout)
    with pytest.raises(SignatureError, match='namespace does not match'):
        read_signature(signed, None)


def test_a_file_without_a_signature_is_not_signed(tmp_path):
    path = tmp_path / 'x'
    path.write_text('x')
    assert read_signature(path, None) is None
    assert verify_path(str(path), None)[0].meaning == UNKNOWN


@pytest.mark.parametrize('name, words', [
    ('locked', 'incorrect passphrase'), ('alice.txt', 'cannot sign')])
def test_a_key_that_cannot_sign_leaves_the_earlier_signature(signed, keys, name, words,
                                                             monkeypatch):
    monkeypatch.setenv('SSH_ASKPASS_REQUIRE', 'force')
    monkeypatch.setenv('SSH_ASKPASS', '/bin/false')
    (keys / 'alice.txt').write_text('no key')
    before = signature_path(signed).read_bytes()
    with pytest.raises(ValueError, match=words):
        sign_file(signed, str(keys / name))
    assert signature_path(signed).read_bytes() == before


def test_the_key_is_the_one_of_the_option_or_the_first_of_the_user(tmp_path, monkeypatch):
    monkeypatch.setenv('HOME', str(tmp_path))
    with pytest.raises(ValueError, match=r'\.ssh: has no ssh key; make one with ssh-keygen'):
        find_key(None)
    with pytest.raises(ValueError, match='--key nowhere: no such file'):
        find_key('nowhere')
    (tmp_path / '.ssh').mkdir()
    for name in ('id_rsa', 'id_ed25519'):
        (tmp_path / '.ssh' / name).write_text('')
        assert find_key(None) == str(tmp_path / '.ssh' / name)
    assert find_key('~/.ssh/id_rsa') == str(tmp_path / '.ssh' / 'id_rsa')


def test_without_openssh_one_line_says_what_to_install(signed, keys, monkeypatch):
    monkeypatch.setenv('PATH', '/nowhere')
    for action in (lambda: sign_file(signed, str(keys / 'alice')),
                   lambda: read_signature(signed, None)):
        with pytest.raises(ValueError, match=r'ssh-keygen is not installed.*openssh-client'):
            action()


@pytest.fixture
def folder(tmp_path):
    """Return a bag of two files, in names that sha256sum escapes too."""
    path = tmp_path / 'bag'
    (path / 'inner').mkdir(parents=True)
    (path / 'trial_0.mcap').write_bytes(b'0')
    (path / 'inner' / 'a\\b\nc\r').write_bytes(b'1')
    return path


def test_sha256sum_checks_the_manifest_of_a_folder(folder, keys):
    sign_path(str(folder), str(keys / 'alice'))
    said = subprocess.run(['sha256sum', '-c', 'bag.sha256'], cwd=folder.parent, text=True,
                          check=True, stdout=subprocess.PIPE).stdout
    assert said.count(': OK') == 2


@pytest.mark.parametrize('change, line', [
    (lambda path: (path / 'trial_0.mcap').write_bytes(b'2'), 'bag/trial_0.mcap: changed'),
    (lambda path: (path / 'trial_0.mcap').unlink(), 'bag/trial_0.mcap: missing'),
    (lambda path: (path / 'inner' / 'more').write_bytes(b''),
     'bag/inner/more: added after the signature'),
    (lambda path: manifest_path(path).write_bytes(b'x\n' + manifest_path(path).read_bytes()),
     'line 1 is none of sha256sum')])
def test_each_change_of_a_signed_folder_is_said(folder, keys, tmp_path, change, line):
    signers = list_signers(keys, tmp_path, 'alice@ship {alice}')
    sign_path(str(folder), str(keys / 'alice'))
    for path in (str(folder), f'{folder}/'):
        assert [check.meaning for check in verify_path(path, signers)] == [GOOD]
    change(folder)
    checks = verify_path(str(folder), signers)
    assert [line in check.line for check in checks].count(True) == 1
    assert checks[0].meaning == BROKEN and checks[0].line.startswith(f'{folder}: changed')


def test_a_manifest_that_was_made_to_fit_is_told_by_its_signature(folder, keys, tmp_path):
    signers = list_signers(keys, tmp_path, 'alice@ship {alice}')
    sign_path(str(folder), str(keys / 'alice'))
    signature = signature_path(manifest_path(folder)).read_bytes()
    (folder / 'trial_0.mcap').write_bytes(b'2')
    sign_path(str(folder), str(keys / 'mallory'))
    assert [check.meaning for check in verify_path(str(folder), signers)] == [UNKNOWN]
    signature_path(manifest_path(folder)).write_bytes(signature)
    assert compare_with_manifest(folder) == []
    assert [check.meaning for check in verify_path(str(folder), signers)] == [BROKEN]


def test_what_is_no_file_is_refused_in_a_folder(folder, keys):
    (folder / 'link').symlink_to(folder / 'inner')
    with pytest.raises(ValueError, match='bag/link: is no file, so nobody can sign it'):
        sign_path(str(folder), str(keys / 'alice'))
    empty = folder.parent / 'empty'
    empty.mkdir()
    with pytest.raises(ValueError, match='has no file to sign'):
        sign_path(str(empty), str(keys / 'alice'))
    assert verify_path(str(empty), None)[0].meaning == UNKNOWN
