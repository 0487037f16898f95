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

"""The id of a verdict as a QR code that a telephone reads from paper, drawn by segno."""

from __future__ import annotations


def draw_code(text: str) -> str:
    """Return a QR code of a text as SVG for a page of HTML; empty if segno is not installed."""
    try:
        import segno
    except ModuleNotFoundError:
        return ''
    code: str = segno.make(text, error='m', micro=False).svg_inline(
        svgclass=None, lineclass=None, omitsize=True)
    return code
