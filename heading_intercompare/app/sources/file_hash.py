# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The hash by which a verdict names its inputs."""

from __future__ import annotations

import hashlib
import os
from typing import Iterable

__all__ = ['hash_files']

_BLOCK = 1 << 20


def hash_files(paths: Iterable[str | os.PathLike[str]]) -> str:
    """Return the SHA-256, in hexadecimal, of the bytes of files, one after the other."""
    digest = hashlib.sha256()
    for path in paths:
        with open(path, 'rb') as file:
            while block := file.read(_BLOCK):
                digest.update(block)
    return digest.hexdigest()
