# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Sentences for the drivers of a test, and ports to send them to."""

from __future__ import annotations

import socket

from checksums import with_checksum


def sentence(heading) -> str:
    """Return an HDT sentence with a heading, a number or text."""
    body = f'HEHDT,{heading},T'
    return f'{with_checksum(body)}\r\n'


def free_port() -> int:
    """Return a port of UDP that nobody listens to."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(('127.0.0.1', 0))
        return probe.getsockname()[1]
