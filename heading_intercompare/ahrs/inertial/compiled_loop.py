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

"""The control loop compiled by numba, if the extra ``fast`` is installed."""

from __future__ import annotations

from functools import cache
import hashlib
from importlib.util import find_spec
from operator import attrgetter
from pathlib import Path
from typing import Any, Callable, NamedTuple

import numpy as np

from heading_intercompare.ahrs.random_noise import Markov, recur
from heading_intercompare.ahrs.ship import earth, steering
from heading_intercompare.core.records import Reals

from . import control_laws, loop
from .computer import Computer
from .platform import Platform

COMPILED = (earth.radii, earth.gravity, loop.set_latitude, loop.resolve, loop.integrate,
            loop.free, loop.hold, loop.fine, loop.gyrocompass, loop.schuler, loop.show,
            loop.step, loop.take, loop.transport_without_azimuth, loop.run, steering.sail)
USED = frozenset(name for function in COMPILED for name in function.__code__.co_names)
"""The names of all attributes that the loop reads or writes, among others."""


class CompiledLoop:
    """`loop.run` on records that hold the state of the objects while it runs."""

    def __init__(self, platform: Platform, computer: Computer) -> None:
        parts = platform.instruments
        self._twins = [_Twin(thing) for thing in (platform, computer, parts, parts.thermostat)]
        compiled = _compile()
        self._run = compiled.run
        for noise in parts.coloured.values():
            noise.recur = compiled.recur

    def begin(self) -> None:
        """Read the constant lists of the objects; they may change between blocks, not within."""
        for twin in self._twins:
            twin.pack_lists()

    def run(self, law: int, rows: Reals, first: int, stop: int, states: Reals) -> None:
        """Run a law over some control steps: see `loop.run`."""
        for twin in self._twins:
            twin.pack()
        self._run(law, *[twin.records for twin in self._twins], rows, first, stop, states)
        for twin in self._twins:
            twin.unpack()


class _Twin:
    """A record with the attributes of an object that the loop uses, and its constant lists."""

    def __init__(self, thing: Any) -> None:
        public = {name: value for name, value in vars(thing).items() if name[0] != '_'}
        lists = {name: value for name, value in public.items() if isinstance(value, list)}
        self._names = [name for name, value in public.items()
                       if isinstance(value, (bool, float)) and name in USED]
        self._lists = tuple(lists)
        self._thing, self._attributes, self._read = thing, vars(thing), attrgetter(*self._names)
        self.records = np.zeros(1, dtype=[
            *((name, '?' if isinstance(public[name], bool) else 'f8') for name in self._names),
            *((name, 'f8', (len(value),)) for name, value in lists.items())])
        self._plain = self.records[self._names]

    def pack(self) -> None:
        """Write the attributes to the record."""
        self._plain[0] = self._read(self._thing)

    def pack_lists(self) -> None:
        """Write the lists to the record."""
        for name in self._lists:
            self.records[name][0] = getattr(self._thing, name)

    def unpack(self) -> None:
        """Write the record to the attributes."""
        self._attributes.update(zip(self._names, self._plain.item()))


def compile_for(platform: Platform, computer: Computer) -> CompiledLoop | None:
    """Return the compiled loop of a platform and its computer; None without numba."""
    return CompiledLoop(platform, computer) if find_spec('numba') else None


def compile_recursion(noise: Markov) -> None:
    """Let a noise outside the loop use the compiled recursion too, if numba is installed."""
    if find_spec('numba'):
        noise.recur = _compile().recur


def compile_steering(course: steering.Steering) -> None:
    """Let an autopilot steer by compiled steps too, if numba is installed."""
    if find_spec('numba'):
        course.sail = _compile().sail


class _Compiled(NamedTuple):
    """`loop.run` for arrays of one record each, and two functions as they are."""

    run: Callable[..., None]
    recur: Callable[..., Reals]
    sail: Callable[..., steering.State]


@cache
def _compile() -> _Compiled:
    """Return what numba makes of the functions, or has in its cache."""
    import numba
    from numba.extending import register_jitable
    sources = b''.join(Path(module.__file__ or '').read_bytes()
                       for module in (earth, control_laws, loop, steering))
    for function in COMPILED:
        register_jitable(function)
    version, run, sail = hashlib.sha256(sources).hexdigest(), loop.run, steering.sail

    # No type says that the records p, c, i and t have the fields of the objects.
    def enter(law: int, p: Any, c: Any, i: Any, t: Any, rows: Any, first: int, stop: int,
              states: Any) -> None:
        # Named here, it belongs to the key under which numba keeps the machine code.
        version  # noqa: B018
        run(law, p[0], c[0], i[0], t[0], rows, first, stop, states)

    def enter_steering(*given: Any) -> steering.State:
        version  # noqa: B018
        return sail(*given)

    functions: list[Callable[..., Any]] = [enter, recur, enter_steering]
    try:
        return _Compiled(*(numba.njit(cache=True)(function) for function in functions))
    except RuntimeError:
        # There is no place where numba may write.
        return _Compiled(*(numba.njit(function) for function in functions))
