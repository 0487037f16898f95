# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
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
