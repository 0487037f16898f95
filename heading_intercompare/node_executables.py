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
The executables of the nodes.

Loading a node takes a second or so. A Ctrl-C that comes meanwhile ends the process without a word,
because nothing has begun. Once the node is there, it ends as `ros.process` says.
"""

from __future__ import annotations

import gc
from importlib import import_module
import os
import signal
import sys
from typing import Callable

from heading_intercompare.missing_module import explain_missing

__all__ = ['alert_sender', 'compliance', 'dashboard', 'intercompare', 'motion_driver',
           'nmea_driver', 'recorder', 'replayer', 'sensor_simulator', 'synchronizer']


def _end_at_once(*_: object) -> None:
    os._exit(0)


def _starter(name: str) -> Callable[[], int]:
    """Return a function that loads a node and runs it, and returns the exit code."""
    def start() -> int:
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, _end_at_once)
        # What is loaded stays, and looking through it for garbage takes tens of milliseconds.
        gc.disable()
        try:
            module = import_module(f'heading_intercompare.nodes.{name}')
        except ModuleNotFoundError as error:
            if (words := explain_missing(error)) is None:
                raise
            sys.stderr.write(f'{name}: error: {words}\n')
            return 2
        finally:
            gc.freeze()
            gc.enable()
        code: int = module.main()
        return code
    return start


alert_sender = _starter('alert_sender')
compliance = _starter('compliance')
dashboard = _starter('dashboard')
intercompare = _starter('intercompare')
motion_driver = _starter('motion_driver')
nmea_driver = _starter('nmea_driver')
recorder = _starter('recorder')
replayer = _starter('replayer')
sensor_simulator = _starter('sensor_simulator')
synchronizer = _starter('synchronizer')
