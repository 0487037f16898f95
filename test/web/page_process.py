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
Serves the page without ROS, and says for each line of its input how many files it can open.

NiceGUI serves a page once in a process. An action is answered with what was asked, and by whom.
"""

from __future__ import annotations

from concurrent.futures import Future
import json
import resource
import subprocess
import sys

from heading_intercompare.web.bridge.bridge_view import BridgeView
from heading_intercompare.web.controls import Controls
from heading_intercompare.web.server import PageServer


def count_files(most):
    """Return how many files a recorder could open now, up to `most`."""
    files = []
    try:
        while len(files) < most:
            files.append(open('/dev/null'))
    except OSError:
        pass
    for file in files:
        file.close()
    return len(files)


def memory_mb():
    """Return the memory of this process."""
    with open('/proc/self/status') as status:
        return next(int(line.split()[1]) for line in status if line.startswith('VmRSS')) / 1024


def answer(*action):
    """Return the answer to an action: the action."""
    done = Future()
    done.set_result(repr(action))
    return done


def serve_page(names):
    """Return a process with the page: it says its address, and ends with its input."""
    return subprocess.Popen([sys.executable, __file__, '0', names], text=True,
                            stdin=subprocess.PIPE, stdout=subprocess.PIPE)


def main(descriptors, names=None):
    """Serve the page, under these names too, until the input ends."""
    if descriptors:
        resource.setrlimit(resource.RLIMIT_NOFILE, (descriptors, descriptors))
    page = PageServer(Controls(lambda: (BridgeView(), 0.0), answer), port=0, names=names)
    print(page.url, flush=True)
    for _ in sys.stdin:
        print(json.dumps({'files': count_files(100), 'memory_mb': memory_mb()}), flush=True)
    page.close()


if __name__ == '__main__':
    main(int(sys.argv[1]), *sys.argv[2:])
