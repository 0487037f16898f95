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

"""
Objects of `core` as bytes and back, to the bit: what a process that was killed goes on with.

A pickle may name any object of any program. Here it may name only what `core` defines, and what
makes arrays of numbers; so a file that somebody else wrote can do no more than be refused.
"""

from __future__ import annotations

from functools import cache
import hashlib
import io
from pathlib import Path
import pickle
from types import FunctionType
from typing import Any
import zlib

from heading_intercompare import core
from heading_intercompare.bags.errors import BagError
from heading_intercompare.core.pairing.pair_maker import PairMaker

_PACKAGE = f'{core.__name__}.'
#: What a pickle of numbers, arrays and containers names besides.
_PLAIN = {('builtins', 'set'), ('builtins', 'slice'), ('collections', 'deque'),
          ('collections', 'Counter'), ('collections', 'defaultdict'), ('numpy', 'dtype'),
          ('numpy', 'ndarray'), ('numpy._core.multiarray', '_reconstruct'),
          ('numpy._core.multiarray', 'scalar'), ('numpy._core.numeric', '_frombuffer'),
          ('numpy.core.multiarray', '_reconstruct'), ('numpy.core.multiarray', 'scalar'),
          ('numpy.core.numeric', '_frombuffer')}
#: What wrong bytes raise.
_WRONG = (pickle.UnpicklingError, ArithmeticError, AttributeError, EOFError, ImportError,
          LookupError, MemoryError, TypeError, ValueError, zlib.error)


class _CoreUnpickler(pickle.Unpickler):
    """Reads what `freeze` wrote and nothing else."""

    def find_class(self, module: str, name: str) -> Any:
        """Return a class by its name; UnpicklingError unless it is allowed."""
        if (module, name) not in _PLAIN and not module.startswith(_PACKAGE):
            raise pickle.UnpicklingError(f'{module}.{name} is not part of a comparison')
        named = super().find_class(module, name)
        if module.startswith(_PACKAGE) and not (
                isinstance(named, (type, FunctionType)) and named.__module__ == module):
            raise pickle.UnpicklingError(f'{module}.{name} is not part of a comparison')
        return named


@cache
def hash_code() -> str:
    """Return the SHA-256 of the code of `core`: other code may not go on with what this wrote."""
    digest = hashlib.sha256()
    for source in sorted(Path(*core.__path__).rglob('*.py')):
        digest.update(source.read_bytes())
    return digest.hexdigest()


def freeze(value: Any) -> bytes:
    """Return an object of `core` as bytes."""
    return zlib.compress(pickle.dumps(value, protocol=5), 1)


def thaw_makers(data: bytes) -> list[PairMaker]:
    """Return the makers of pairs in bytes of `freeze`; BagError as `thaw`, also for others."""
    makers = thaw(data)
    if not (isinstance(makers, list) and all(isinstance(maker, PairMaker) for maker in makers)):
        raise BagError('the state of the pairing cannot be read: it is none')
    return makers


def thaw(data: bytes) -> Any:
    """
    Return the object in bytes of `freeze`.

    Raises
    ------
    BagError
        If the bytes are damaged, or name anything but objects of `core`.

    """
    try:
        return _CoreUnpickler(io.BytesIO(zlib.decompress(data))).load()
    except _WRONG as error:
        raise BagError(f'the state of the pairing cannot be read: {error}') from error
