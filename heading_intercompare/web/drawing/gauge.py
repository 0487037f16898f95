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

"""A figure of the window beside the norm, as a horizontal gauge."""

from __future__ import annotations

from html import escape


def draw_gauge(title: str, value_deg: float | None, norm_deg: float | None) -> str:
    """
    Return a gauge as HTML: full scale is two norms, a tick stands at the norm.

    Beyond the norm it changes shape and colour, and says so in words. A figure without a norm has
    no scale.

    Examples
    --------
    >>> 'beyond the norm' in draw_gauge('sd', 0.3, 0.2)
    True

    """
    name = f'<span>{escape(title)}</span>'
    sign = '+' if title == 'mean' else ''
    if value_deg is None:
        return f'<div class="gauge">{name}<b>–</b></div>'
    if not norm_deg:
        return f'<div class="gauge">{name}<b>{value_deg:{sign}.2f}°</b></div>'
    share = abs(value_deg) / norm_deg
    beyond = share > 1.0
    # Two significant digits of the norm are what a person compares.
    digits = 3 if norm_deg < 0.1 else 2
    words = f'{share:.2g} times the norm' if beyond else f'norm {norm_deg:.{digits}f}°'
    return (f'<div class="gauge{" beyond" if beyond else ""}">{name}'
            f'<b>{value_deg:{sign}.{digits}f}°</b><div class="scale">'
            f'<i class="fill" style="width:{min(100.0, 50.0 * share):.1f}%"></i>'
            f'<i class="norm"></i></div><small>{"beyond the norm: " if beyond else ""}{words}'
            '</small></div>')
