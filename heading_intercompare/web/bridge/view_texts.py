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

"""Times and texts of messages in words, and the words of a view by the place where they stand."""

from __future__ import annotations

import math
from typing import NamedTuple, TYPE_CHECKING

from heading_intercompare.core.decision.coverage import span_words
from heading_intercompare.core.utc_text import utc
from heading_intercompare.messages.authors import clean_name
from heading_intercompare.web.figures.stream_watch import SensorView

from .bridge_records import AlertView, NodeView, RunView, Tone, WaitingAction

if TYPE_CHECKING:
    from .bridge_view import BridgeView
    from .sensors_panel import SensorRow


def shorten(text: str, most: int) -> str:
    r"""
    Return a text in one line of at most this number of letters.

    Examples
    --------
    >>> shorten('a long\ntext', 8)
    'a long …'

    """
    line = ' '.join(text.split())
    return line if len(line) <= most else f'{line[:most - 1]}…'


def integer(text: str | None) -> int | None:
    """Return the integer in a value of a message; None if it is absent or no integer."""
    try:
        return None if text is None else int(text)
    except ValueError:
        return None


def real(text: str | None) -> float | None:
    """Return the figure in a value of a message; None if it is absent, no figure, or nan."""
    try:
        value = math.nan if text is None else float(text)
    except ValueError:
        return None
    return None if math.isnan(value) else value


def clock(stamp_ns: int | None) -> str:
    """
    Return the time of day of a stamp.

    Examples
    --------
    >>> clock(1_700_000_000_000_000_000), clock(None)
    ('22:13 UTC', '-')

    """
    return '-' if stamp_ns is None else f'{utc(stamp_ns)[11:16]} UTC'


def clock_with_seconds(stamp_ns: int) -> str:
    """
    Return the time of day of a stamp to the second.

    Examples
    --------
    >>> clock_with_seconds(1_700_000_000_000_000_000)
    '22:13:20 UTC'

    """
    return f'{utc(stamp_ns)[11:19]} UTC'


def compass_words(heading_deg: float) -> str:
    """
    Return a heading; what rounds to 360 is north.

    Examples
    --------
    >>> compass_words(7.25), compass_words(359.97)
    ('007.2°', '000.0°')

    """
    return f'{round(heading_deg, 1) % 360.0:05.1f}°'


def big_difference(x_deg: float | None) -> str:
    """Return the difference with as many digits as fit its panel in any size."""
    if x_deg is None:
        return '– –'
    digits = 2 if abs(x_deg) < 9.995 else 1 if abs(x_deg) < 99.95 else 0
    # What rounds to zero is no negative difference.
    return f'{round(x_deg, digits) + 0.0:+.{digits}f}°'


def stamp_words(alert: AlertView) -> str:
    """Return for how long an alert has been standing, or since when; '' if that is not known."""
    if alert.age_s is None:
        return '' if alert.since_ns is None else f'since {clock(alert.since_ns)}'
    if not alert.active:
        return f'over, raised {clock(alert.since_ns)}'
    return f'for {span_words(float(round(alert.age_s)))}'


def coming_words(next_look_ns: int | None, ends_ns: int | None) -> str:
    """Return when the next verdict is due, in words; '' if that is not known."""
    if next_look_ns is not None and (ends_ns is None or next_look_ns < ends_ns):
        return f'next look {clock(next_look_ns)}'
    return '' if ends_ns is None else f'the run ends {clock(ends_ns)}'


def age_words(age_s: float | None) -> str:
    """
    Return an age.

    Examples
    --------
    >>> age_words(0.24), age_words(75.0), age_words(None)
    ('0.2 s', '75 s', 'never')

    """
    if age_s is None:
        return 'never'
    return f'{age_s:.1f} s' if age_s < 10.0 else span_words(age_s)


def lacking_words(n: int, needed_s: float | None, beyond: bool = False) -> str:
    """
    Return what a run in progress lacks, given whether its scatter is beyond the norm.

    Examples
    --------
    >>> lacking_words(5000, 1560.0)
    '26 min more if it goes on like this'

    """
    if needed_s is None:
        return f'too few differences to tell ({n})'
    if math.isinf(needed_s):
        return 'more time alone does not decide'
    if needed_s <= 0.0:
        return f'enough to {"reject" if beyond else "accept"} if it goes on like this'
    return f'{span_words(needed_s)} more if it goes on like this'


def mark_words(kind: str, run: RunView) -> str:
    """
    Return what a mark would do to the run in progress, for a person who is about to set it.

    Parameters
    ----------
    kind : {'start', 'stop'}
        Of the mark.
    run
        The run in progress.

    """
    if run.age_s is None:
        return 'it is not known whether a run is in progress: none was heard yet'
    size = f'{span_words(run.span_s or 0.0)} with {run.n:,} differences'
    if kind == 'start' and not run.marked:
        newest = f'run {run.number}, {size}, and ' if run.number else ''
        return ('the first start takes all before it out of the record: '
                f'{newest}each earlier run would not count')
    if not run.number:
        return 'no run is in progress'
    return f'run {run.number} would end here, after {size}, and be judged as it is'


def waiting_words(action: WaitingAction, left_s: float, run: RunView) -> str:
    """
    Return when a waiting action is done, who asked for it, and what it would do to the run.

    Parameters
    ----------
    action
        The action.
    left_s
        For how long it still waits, seconds.
    run
        The run in progress.

    """
    author = f', asked by {clean_name(action.operator)}' if action.operator else ''
    return (f'The run {"starts" if action.what == "start" else "ends"} at '
            f'{clock_with_seconds(action.due_ns)}, in {math.ceil(left_s)} s{author}: '
            f'{mark_words(action.what, run)}')


def size_words(size: int | None) -> str:
    """
    Return a number of bytes.

    Examples
    --------
    >>> size_words(81_234_567_890), size_words(None)
    ('81.2 GB', 'not known')

    """
    if size is None:
        return 'not known'
    return f'{size / 1e9:.1f} GB' if size >= 10 ** 9 else f'{size / 1e6:.0f} MB'


_SIGNS = {Tone.NONE: '…', Tone.GOOD: '✔', Tone.DOUBT: '!', Tone.BAD: '✖'}
#: Where more readings are paired than this share, the others are no news.
_MOST_PAIRED = 0.98
_LEVELS = ('OK', 'WARNING', 'ERROR')
_TONES = (Tone.NONE, Tone.DOUBT, Tone.BAD)


class Said(NamedTuple):
    """A text and its tone; the text alone says everything."""

    text: str
    tone: Tone = Tone.NONE


def tell(view: BridgeView) -> dict[str, Said]:
    """
    Return the texts of a view by their place on page and terminal.

    A figure that is stale is not among the big numerals: a dash stands there, and the line below
    says what the last one was and how old it is.
    """
    window, run, bag, lamp = view.window, view.run, view.bag, view.lamp
    verdict_time = '' if lamp.given_ns is None else f'{utc(lamp.given_ns)[:16]} UTC, '
    coming = coming_words(run.next_look_ns, run.ends_ns)
    more = f', {coming}' if coming else ''
    return {
        'ts_heading': _heading(view.ts), 'ts_state': _sensor(view.ts),
        'rs_heading': _heading(view.rs), 'rs_state': _sensor(view.rs),
        'difference': Said(big_difference(view.difference_deg)),
        'difference_state': _difference(view),
        'turn': Said('rate of turn not known' if view.turn_deg_min is None else
                     f'rate of turn {abs(view.turn_deg_min):.1f}°/min {_side(view.turn_deg_min)}'),
        'lamp': Said(f'{_SIGNS[lamp.tone]} {lamp.word}', lamp.tone),
        'lamp_given': Said(f'last verdict: {verdict_time}{lamp.what}' if verdict_time else
                           lamp.what),
        'lamp_headline': Said(lamp.headline),
        'validity': Said(f'{_SIGNS[view.validity.tone]} {view.validity.words}',
                         view.validity.tone),
        'last_run': _last_run(view),
        'run_begin': Said('' if run.start_ns is None else f'began {clock(run.start_ns)}'),
        'run_next': Said(coming or ('' if not run.number else 'judged when it ends')),
        'missing': Said('' if not run.number else run.lacking),
        'now': Said('' if any(alert.active for alert in view.alerts) else
                    f'{_SIGNS[view.validity.tone]} {view.validity.words}', view.validity.tone),
        'lacking': _aged(f'{run.lacking}{more}', run.age_s, run.stale),
        'run': Said('no run' if not run.number else f'run {run.number}: {run.n:,} differences in '
                    f'{span_words(run.span_s or 0.0)}'),
        'window': _aged(f'mean {_deg(window.mean_deg, "+")}, sd {_deg(window.std_deg)}',
                        window.age_s, window.stale),
        'norm': Said(f'norm for sd {_deg(window.limit_deg)}; {window.n:,} differences in the '
                     'window'),
        'paired': Said('share paired not known' if view.paired_share is None else
                       f'paired {view.paired_share:.1%}'),
        'unpaired': Said('' if view.paired_share is None or view.paired_share >= _MOST_PAIRED else
                         f'{1.0 - view.paired_share:.1%} of the readings have no partner',
                         Tone.DOUBT),
        'ledger': Said('no ledger' if view.paired is None else
                       f'{view.paired:,} pairs, {view.rejected:,} readings rejected'),
        'trend': Said('no pairs yet' if view.trend.newest_ns is None else
                      f'to {clock(view.trend.newest_ns)}'
                      + (f', STALE for {age_words(view.trend.age_s)}' if view.trend.stale else ''),
                      Tone.DOUBT if view.trend.stale and view.trend.newest_ns else Tone.NONE),
        'mode': Said(f'AHRS {view.mode}' if view.mode else ''),
        'bag': Said(f'bag: {bag.words}; free disk {size_words(bag.free_bytes)}'
                    + (f'; STALE, heard {age_words(bag.age_s)} ago'
                       if bag.stale and bag.age_s is not None else ''), _TONES[min(bag.level, 2)]),
        'graph': Said('nothing heard from the graph yet' if view.graph_age_s is None else
                      f'graph heard {age_words(view.graph_age_s)} ago',
                      Tone.NONE if view.judged else Tone.DOUBT),
    }


def alert_words(alert: AlertView) -> Said:
    """Return an alert in a line; the tone is that of its priority."""
    state = ', '.join(filter(None, [
        '' if alert.active else 'over', '' if alert.acknowledged else 'not acknowledged',
        f'since {clock(alert.since_ns)}' if alert.since_ns is not None else '']))
    more = ''.join(f'; follows: {words}' for words in alert.consequences)
    return Said(f'{alert.priority.upper()}: {alert.words}{more} ({state})',
                Tone.BAD if alert.active and alert.priority != 'caution' else Tone.DOUBT)


def tile_state(row: SensorRow, no_reference: bool) -> Said:
    """
    Return the state of a sensor in a word, with a sign.

    Parameters
    ----------
    row
        The sensor.
    no_reference
        The reference is silent or frozen, so nothing can be said of a tested sensor.

    """
    if row.now.age_s is None:
        return Said('not heard yet')
    if row.now.stale:
        return Said(f'{_SIGNS[Tone.BAD]} silent {age_words(row.now.age_s)}', Tone.BAD)
    if row.state or row.named:
        return Said(f'{_SIGNS[Tone.BAD]} {row.state or "differs"}', Tone.BAD)
    if row.now.flagged:
        return Said(f'{_SIGNS[Tone.DOUBT]} flags itself invalid', Tone.DOUBT)
    if no_reference and not row.reference:
        return Said(f'{_SIGNS[Tone.DOUBT]} no reference', Tone.DOUBT)
    return Said('sound')


def sensor_words(view: BridgeView) -> list[tuple[str, Said]]:
    """Return the name and the words of each of several sensors."""
    rows = view.sensors.rows if view.sensors else ()
    return [(row.name, _describe_sensor(row)) for row in rows]


def _describe_sensor(row: SensorRow) -> Said:
    state = _sensor(row.now)
    if row.reference:
        figures = 'the reference'
    elif row.std_deg is None:
        figures = 'too few differences yet'
    else:
        share = '' if row.share is None else f' = {row.share:.2f} of what both norms explain'
        figures = (f'from {row.against}: mean {_deg(row.mean_deg, "+")}, '
                   f'sd {_deg(row.std_deg)}{share}')
    verdict = '' if row.reference else f'{_SIGNS[row.lamp.tone]} {row.lamp.word}'
    words = [f'{_heading(row.now).text:<7} {state.text}', figures, verdict,
             'the vote names it now' if row.named else '']
    tones = [state.tone, row.lamp.tone, Tone.BAD if row.named else Tone.NONE]
    order = (Tone.NONE, Tone.GOOD, Tone.DOUBT, Tone.BAD)
    return Said('; '.join(filter(None, words)), max(tones, key=order.index))


def vote_words(view: BridgeView) -> Said:
    """Return the vote on the rolling window; '' for two sensors."""
    sensors = view.sensors
    if sensors is None:
        return Said('')
    return _aged(f'now: {sensors.vote}' if sensors.vote else 'no vote yet', sensors.age_s,
                 sensors.stale)._replace(tone=sensors.vote_tone)


def node_words(view: BridgeView) -> list[Said]:
    """Return a line per node."""
    return [_node_line(node) for node in view.nodes]


def _node_line(node: NodeView) -> Said:
    if node.stale:
        return Said(f'{node.name}: STALE, heard {age_words(round(node.age_s))} ago', Tone.BAD)
    return Said(f'{node.name}: {_LEVELS[node.level]}, {node.words}', _TONES[node.level])


def _heading(sensor: SensorView) -> Said:
    return Said('– –' if sensor.heading_deg is None else compass_words(sensor.heading_deg))


def _sensor(sensor: SensorView) -> Said:
    if sensor.age_s is None:
        return Said('not heard yet')
    last = '' if sensor.last_deg is None else f'last {compass_words(sensor.last_deg)}, '
    if sensor.stale:
        return Said(f'STALE: {last}{age_words(sensor.age_s)} ago', Tone.BAD)
    rate = 'rate not known' if sensor.rate_hz is None else f'{sensor.rate_hz:.1f} Hz'
    offset = '' if sensor.offset_s is None else f', stamp {_offset(sensor.offset_s)}'
    flagged = 'FLAGGED INVALID, ' if sensor.flagged else ''
    return Said(f'{flagged}age {age_words(sensor.age_s)}, {rate}{offset}',
                Tone.DOUBT if sensor.flagged else Tone.NONE)


def _offset(offset_s: float) -> str:
    if abs(offset_s) < 60.0:
        return f'{offset_s:+.2f} s'
    return f'{"+" if offset_s > 0.0 else "-"}{span_words(abs(offset_s))}'


def _difference(view: BridgeView) -> Said:
    if view.difference_age_s is None:
        return Said('no pair yet')
    if view.difference_stale:
        return Said(f'STALE: last {_deg(view.last_difference_deg, "+")}, '
                    f'{age_words(view.difference_age_s)} ago', Tone.BAD)
    return Said(f'age {age_words(view.difference_age_s)}')


def _deg(value: float | None, sign: str = '') -> str:
    return 'not known' if value is None else f'{value:{sign}.3f}°'


def _side(turn_deg_min: float) -> str:
    return '' if abs(turn_deg_min) < 0.5 else 'to starboard' if turn_deg_min > 0.0 else 'to port'


def _last_run(view: BridgeView) -> Said:
    """Return the verdict of the last run, if the lamp shows something else beside it."""
    if not view.runs or not view.lamp.what.startswith('look'):
        return Said('')
    run = view.runs[0]
    return Said(f'run {run.number}, {clock(run.start_ns)} to {clock(run.end_ns)}: {run.word}',
                run.tone)


def _aged(text: str, age_s: float | None, stale: bool) -> Said:
    """Return a text, with its age if it is stale."""
    if not stale or age_s is None:
        return Said(text)
    return Said(f'{text} (STALE, {age_words(age_s)})', Tone.DOUBT)
