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

"""A server of HTTP that keeps what is posted to it."""

from __future__ import annotations

from http.server import BaseHTTPRequestHandler, HTTPServer
import json
from threading import Thread


class Office:
    """A server ashore: it answers with these codes, the last one again and again."""

    def __init__(self, *codes):
        self.posted, self.codes = [], [*codes]
        office = self

        class Handler(BaseHTTPRequestHandler):
            def do_POST(self):
                body = json.loads(self.rfile.read(int(self.headers['Content-Length'])))
                office.posted.append(body)
                self.send_response(office.codes[0])
                if len(office.codes) > 1:
                    office.codes.pop(0)
                self.send_header('Content-Length', '0')
                self.end_headers()

            def log_message(self, *_):
                """Say nothing."""
        self._server = HTTPServer(('127.0.0.1', 0), Handler)
        self.url = f'http://127.0.0.1:{self._server.server_port}/alerts?key=secret'
        self._thread = Thread(target=self._server.serve_forever, daemon=True)
        self._thread.start()

    def close(self):
        """Go away."""
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()
