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

"""The headings in single messages, as a node takes them."""

from __future__ import annotations

from functools import partial

from heading_intercompare.core.records import Headings
from heading_intercompare.messages.byte_columns import read_sound
from heading_intercompare.messages.heading_messages import decode_headings


def read_headings(type_name, convention, messages):
    """Return the headings in messages, and what is wrong with each unreadable one."""
    return read_sound(partial(decode_headings, type_name, convention), messages, Headings)
