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

"""Files that take the place of an older one only when they are whole and on the disk."""

from __future__ import annotations

from contextlib import ExitStack, suppress
from itertools import count
import os
from pathlib import Path
import stat
from typing import Any, Mapping

_NUMBERS = count()

#: A draft keeps this many characters of the name: a name of a file may have 255 bytes.
_MOST_CHARACTERS = 50


def sync_folder(folder: Path) -> None:
    """Sync the names in a folder to the disk, where its file system can."""
    with suppress(OSError):
        # A folder may be open for writing and not for reading.
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


def draft_beside(target: Path) -> Path:
    """Return a path beside a file or folder for what is to take its place; no two are equal."""
    return target.with_name(
        f'{target.name[:_MOST_CHARACTERS]}.{os.getpid()}-{next(_NUMBERS)}.part')


def _is_written_in_place(path: Path) -> bool:
    """Return whether a path is a pipe, a device or a descriptor, which cannot be replaced."""
    if os.path.abspath(path).startswith(('/dev/', '/proc/')):
        return True
    try:
        return not stat.S_ISREG(os.stat(path).st_mode)
    except FileNotFoundError:
        return False


class ReplacedFile:
    """
    A file that is written beside another, synced, and renamed to it when it is whole.

    Until `commit` the older file is unchanged, and a fault or a signal leaves it so. A pipe or a
    device is written as it is, and so is a file in a folder that takes no new one. A symbolic
    link stays; what it points to is replaced.

    Parameters
    ----------
    path
        The file to replace or to create.
    mode, **options
        As for `open`.

    Attributes
    ----------
    file
        The open draft.

    Raises
    ------
    OSError
        If the draft cannot be written, here and in every method; it names `path`.

    Examples
    --------
    >>> import tempfile
    >>> folder = tempfile.TemporaryDirectory()
    >>> path = Path(folder.name, 'verdict.json')
    >>> replace_file(path, 'older')
    >>> with ReplacedFile(path, 'w') as file:
    ...     _ = file.write('newer')
    ...     path.read_text()
    'older'
    >>> path.read_text(), len(list(path.parent.iterdir()))
    ('newer', 1)
    >>> folder.cleanup()

    """

    def __init__(self, path: str | os.PathLike[str], mode: str = 'wb', **options: Any) -> None:
        self._path = path
        self._target = Path(path)
        self._draft = self._target
        if not _is_written_in_place(self._target):
            self._target = Path(os.path.realpath(path))
            self._draft = draft_beside(self._target)
        try:
            self.file = self._open(mode, options)
        except OSError as error:
            raise self._name(error) from None

    def _open(self, mode: str, options: Mapping[str, Any]) -> Any:
        """Open the draft; in a folder that takes no new file, open the file itself."""
        try:
            return open(self._draft, mode, **options)
        except PermissionError:
            if not os.access(self._target, os.W_OK, effective_ids=True):
                raise
            self._draft = self._target
            return open(self._target, mode, **options)

    def __enter__(self) -> Any:
        return self.file

    def __exit__(self, kind: type | None, error: BaseException | None, *_: object) -> None:
        if kind is None:
            self.commit()
            return
        self.discard()
        if isinstance(error, OSError):
            self._name(error)

    def _name(self, error: OSError) -> OSError:
        """Let an error of writing name the file that was asked for."""
        if error.filename in (None, os.fspath(self._draft)):
            error.filename = os.fspath(self._path)
        return error

    def write(self, data: str | bytes) -> None:
        """Write to the draft; where it cannot be written, it is discarded."""
        try:
            self.file.write(data)
        except OSError as error:
            self.discard()
            raise self._name(error) from None

    def commit(self) -> None:
        """Put the file in its place; a second call does nothing."""
        if self.file.closed:
            return
        with ExitStack() as undo:
            undo.callback(self.discard)
            try:
                self._take_place()
            except OSError as error:
                raise self._name(error) from None
            undo.pop_all()

    def _take_place(self) -> None:
        if self._draft is self._target:
            self.file.close()
            return
        self.file.flush()
        os.fsync(self.file.fileno())
        self.file.close()
        with suppress(OSError):
            os.chmod(self._draft, stat.S_IMODE(os.stat(self._target).st_mode))
        os.replace(self._draft, self._target)
        sync_folder(self._target.parent)

    def discard(self) -> None:
        """Remove the draft; the older file stays."""
        with suppress(OSError):
            self.file.close()
        if self._draft is not self._target:
            with suppress(OSError):
                self._draft.unlink()


def replace_file(path: str | os.PathLike[str], content: str | bytes,
                 errors: str = 'strict') -> None:
    """
    Replace a file by a text in UTF-8 or by bytes; see `ReplacedFile`.

    Parameters
    ----------
    path
        The file to replace or to create.
    content
        All that it holds from now on.
    errors
        What to do with what UTF-8 cannot hold; as for `open`.

    Raises
    ------
    OSError
        If it cannot be written; the older file then stays.

    """
    data = content.encode('utf-8', errors) if isinstance(content, str) else content
    with ReplacedFile(path) as file:
        file.write(data)
