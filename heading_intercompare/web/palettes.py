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

"""The palettes of the page, and the picture of the trend that takes its colours from them."""

from __future__ import annotations

from typing import Mapping

from heading_intercompare.web.bridge.bridge_records import TrendView

#: By palette: ground, panel, ink, faint ink, line, and the three tones of a verdict or state.
PALETTES: Mapping[str, Mapping[str, str]] = {
    'day': {'ground': '#f2f4f7', 'panel': '#ffffff', 'ink': '#101418', 'faint': '#4a5460',
            'line': '#b9c2cc', 'good': '#0b6b2e', 'doubt': '#8a4b00', 'bad': '#b00020'},
    'dusk': {'ground': '#14181d', 'panel': '#1e242b', 'ink': '#e6e9ed', 'faint': '#a4adb8',
             'line': '#414b57', 'good': '#5fd38a', 'doubt': '#ffb454', 'bad': '#ff8a80'},
    'night': {'ground': '#000000', 'panel': '#0a0000', 'ink': '#d83a2a', 'faint': '#c23424',
              'line': '#4a0f0a', 'good': '#e04030', 'doubt': '#e84a38', 'bad': '#ff5a48'},
}

_STYLE = """
html, body { background: var(--ground); color: var(--ink); margin: 0;
  font-family: system-ui, 'DejaVu Sans', sans-serif; }
.nicegui-content { padding: 0 !important; }
.bridge { display: grid; gap: 6px; padding: 6px 6px 36px 6px;
  width: 100%; box-sizing: border-box;
  grid-template-columns: repeat(12, 1fr); }
.panel { background: var(--panel); border: 1px solid var(--line); border-radius: 6px;
  padding: 4px 12px; min-width: 0; overflow: hidden; }
.title { color: var(--faint); font-size: 15px; letter-spacing: 0.04em; }
.big { font-size: clamp(56px, 7.2vw, 104px); font-weight: 700; line-height: 1.05;
  font-variant-numeric: tabular-nums; white-space: nowrap; }
.mid { font-size: 26px; font-weight: 600; line-height: 1.15;
  font-variant-numeric: tabular-nums; }
.lamp { font-size: clamp(36px, 4.2vw, 56px); font-weight: 800;
  line-height: 1.05; }
.row { font-size: 17px; line-height: 1.3;
  overflow-wrap: anywhere; font-variant-numeric: tabular-nums; }
.small { font-size: 15px; line-height: 1.3; color: var(--faint); overflow-wrap: anywhere; }
.good { color: var(--good); } .doubt { color: var(--doubt); } .bad { color: var(--bad); }
.box-good { border: 5px solid var(--good); } .box-doubt { border: 5px dashed var(--doubt); }
.box-bad { border: 5px double var(--bad); } .box-none { border: 5px solid var(--line); }
.heading { grid-column: span 4; } .wide { grid-column: span 8; } .narrow { grid-column: span 4; }
.all { grid-column: span 12; }
.bar { display: flex; flex-wrap: wrap; gap: 8px; align-items: center; }
.bridge .q-btn, .bridge .q-btn * { color: var(--ink) !important; font-size: 18px; }
.bridge .q-btn { border: 1px solid var(--faint); min-height: 44px;
  background: var(--panel) !important; }
.bridge .q-field__native, .bridge .q-field__label { color: var(--ink) !important;
  font-size: 18px; }
.bridge .q-field__control { border-bottom: 1px solid var(--faint); min-width: 220px; }
svg .mark { fill: var(--faint); font-size: 14px; } svg .limit { stroke: var(--ink);
  stroke-dasharray: 8 5; } svg .zero { stroke: var(--line); } svg .trace { fill: var(--ink); }
#page-age { position: fixed; inset: auto 0 0 0; text-align: right; font-size: 16px;
  color: var(--faint); background: var(--panel); border-top: 1px solid var(--line);
  padding: 2px 12px; z-index: 10; }
#page-dead { display: none; position: fixed; inset: 0 0 auto 0; padding: 14px; z-index: 9999;
  text-align: center; font-size: 30px; font-weight: 800; background: var(--ground);
  color: var(--bad); border: 6px double var(--bad); }
html[data-dead=yes] #page-dead { display: block; }
html[data-dead=yes] .bridge { opacity: 0.35; }
@media (max-width: 900px) { .wide, .narrow { grid-column: span 12; }
  .big { font-size: 64px; } .heading { padding: 6px; } }
"""


def style() -> str:
    """Return the style sheet of the page, with a block of colours per palette."""
    blocks = [f'html[data-palette={name}] {{ '
              + ' '.join(f'--{key}: {colour};' for key, colour in colours.items()) + ' }'
              for name, colours in PALETTES.items()]
    chosen = ',\n'.join(f'html[data-palette={name}] .bridge .k-{name}' for name in PALETTES)
    return '\n'.join([*blocks, _STYLE, f'{chosen} {{ border: 3px solid var(--ink); }}'])


_WIDTH, _HEIGHT, _LEFT, _RIGHT, _TOP, _BOTTOM = 800, 180, 66, 8, 8, 22


def draw_trend(trend: TrendView) -> str:
    """
    Return the trend as SVG: the extremes per column, the limits dashed, zero as a line.

    The picture is wide enough for the data and the limits, so neither is ever cut off.
    """
    reach = [0.02] + [abs(value) for column in trend.columns
                      for value in (column.low_deg, column.high_deg)]
    limits: tuple[float, ...] = ()
    if trend.limit_deg is not None:
        limits = (trend.center_deg - trend.limit_deg, trend.center_deg + trend.limit_deg)
        reach += [abs(limit) for limit in limits]
    most = 1.1 * max(reach)

    def place(x_deg: float) -> float:
        return _TOP + (_HEIGHT - _TOP - _BOTTOM) * (most - x_deg) / (2.0 * most)

    right = _WIDTH - _RIGHT
    scale = (right - _LEFT) / trend.span_s
    parts = [f'<svg viewBox="0 0 {_WIDTH} {_HEIGHT}" width="100%" role="img" '
             'aria-label="difference TS - RS of the last 30 min">']
    for kind, values in (('zero', (0.0,)), ('limit', limits)):
        parts += [f'<line class="{kind}" x1="{_LEFT}" x2="{right}" y1="{place(value):.1f}" '
                  f'y2="{place(value):.1f}"/>' for value in values]
    parts += [f'<text class="mark" x="{_LEFT - 6}" y="{place(value) + 5:.1f}" text-anchor="end">'
              f'{f"{value:+.2f}" if value else "0"}°</text>' for value in (*limits, 0.0)]
    for minutes in range(0, round(trend.span_s / 60.0) + 1, 10):
        at = right - scale * 60.0 * minutes
        parts.append(f'<text class="mark" x="{at:.1f}" y="{_HEIGHT - 6}" text-anchor="'
                     f'{"end" if minutes == 0 else "middle"}">{-minutes} min</text>')
    columns = []
    for column in trend.columns:
        x, top, bottom = (right - scale * column.age_s, place(column.high_deg),
                          place(column.low_deg))
        columns.append(f'M{x - 0.8:.1f} {top - 0.8:.1f}h1.6V{bottom + 0.8:.1f}h-1.6z')
    parts.append(f'<path class="trace" d="{"".join(columns)}"/></svg>')
    return ''.join(parts)
