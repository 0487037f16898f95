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
Leave the process when a call of the middleware does not return.

Fast DDS may never return from taking down a participant whose peers were killed, or when it takes
down several at once on a busy computer. It holds the interpreter lock meanwhile, so neither a
thread of Python nor a signal handler can end the process. A timer of the C library can.
"""

from __future__ import annotations

from contextlib import contextmanager
import ctypes
import math
import sys
from typing import Iterator

_CLOCK_MONOTONIC, _SIGEV_THREAD = 1, 2


class _Event(ctypes.Structure):
    """`struct sigevent` of Linux: what a timer does, 64 bytes."""

    _fields_ = (('value', ctypes.c_uint64), ('signal', ctypes.c_int), ('notify', ctypes.c_int),
                ('function', ctypes.c_void_p), ('attributes', ctypes.c_void_p),
                ('rest', ctypes.c_char * 32))


class _Times(ctypes.Structure):
    """`struct itimerspec`: the interval and the first time, each as seconds and nanoseconds."""

    _fields_ = tuple((name, ctypes.c_long)
                     for name in ('every_s', 'every_ns', 'first_s', 'first_ns'))


@contextmanager
def leave_if_hung(seconds: float, code: int) -> Iterator[None]:
    """
    End the process if the block takes longer; only Linux has such timers.

    Parameters
    ----------
    seconds
        The longest time that the block may take, > 0.
    code
        The exit code then.

    Raises
    ------
    OSError
        If the kernel gives no timer.

    """
    if sys.platform != 'linux':
        yield
        return
    libc = ctypes.CDLL(None, use_errno=True)
    # The timer calls `_exit(code)` in a thread of its own.
    event = _Event(value=code, notify=_SIGEV_THREAD,
                   function=ctypes.cast(libc._exit, ctypes.c_void_p))
    timer = ctypes.c_void_p()
    fraction_s, whole_s = math.modf(seconds)
    times = _Times(first_s=int(whole_s), first_ns=round(fraction_s * 1e9))
    if libc.timer_create(_CLOCK_MONOTONIC, ctypes.byref(event), ctypes.byref(timer)) or (
            libc.timer_settime(timer, 0, ctypes.byref(times), None)):
        raise OSError(ctypes.get_errno(), 'no timer')
    try:
        yield
    finally:
        libc.timer_delete(timer)
