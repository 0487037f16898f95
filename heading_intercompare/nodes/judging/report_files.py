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

"""Writing of reports: files named after what they report on and the newest stamp."""

from __future__ import annotations

from datetime import datetime, timezone
from pathlib import Path
import time
from typing import Mapping

from heading_intercompare.core.alarms.graph_watch import NOT_WRITTEN
from heading_intercompare.messages.status_messages import ERROR, OK
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.replaced_file import replace_file


def write_report(folder: str | None, kind: str, newest_ns: int | None, texts: Mapping[str, str],
                 health: Health) -> None:
    """
    Write a report, and show whether that was possible.

    Parameters
    ----------
    folder
        Where to write; None: nothing is written.
    kind
        What the names of the files begin with.
    newest_ns
        The newest stamp, UTC ns, which the names hold; None: now.
    texts
        What each file holds, by its suffix; the first one is shown.
    health
        Shows the file, or why it cannot be written.

    """
    if folder is None:
        return
    moment = datetime.fromtimestamp(time.time() if newest_ns is None else newest_ns / 1e9,
                                    timezone.utc)
    paths = {Path(folder, f'{kind}_{moment:%Y%m%dT%H%M%S}Z{suffix}'): text
             for suffix, text in texts.items()}
    first = next(iter(paths))
    try:
        for path, text in paths.items():
            replace_file(path, text)
    except OSError as error:
        health.note('report', ERROR, f'{first}: {error.strerror}', latch=True, alarm=NOT_WRITTEN)
    else:
        health.note('report', OK, f'written to {first}')
