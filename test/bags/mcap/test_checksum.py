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

"""The fast checksum equals that of MCAP, and isal is optional."""

from __future__ import annotations

import importlib
import sys
import zlib

import numpy as np
import pytest

from heading_intercompare.bags.mcap import checksum

DATA = np.random.default_rng(5).integers(0, 256, 100_003, dtype=np.uint8).tobytes()


@pytest.fixture
def without_isal(monkeypatch):
    """Return the module as it loads without isal."""
    monkeypatch.setitem(sys.modules, 'isal', None)
    monkeypatch.setitem(sys.modules, 'isal.isal_zlib', None)
    yield importlib.reload(checksum)
    monkeypatch.undo()
    importlib.reload(checksum)


@pytest.mark.parametrize('size', [0, 1, 7, 64, 4096, len(DATA)])
def test_it_is_the_crc_32_of_zlib_in_one_go_and_in_pieces(size):
    pytest.importorskip('isal')
    assert checksum.crc32 is not zlib.crc32
    data = memoryview(DATA)[:size]
    assert checksum.crc32(data) == zlib.crc32(data)
    assert checksum.crc32(data[size // 3:], checksum.crc32(data[:size // 3])) == zlib.crc32(data)


def test_without_isal_zlib_computes_it(without_isal):
    assert without_isal.crc32 is zlib.crc32
