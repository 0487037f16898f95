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

"""What the motion of the ship says of the headings, in words: for a headline, and with figures."""

from __future__ import annotations

from .motion_check import is_scaled_alike, MotionCheck, SensorMotion
from .turn_rate import TurnRate

_NEAR_DEG = 25.0
_HINTS = {180.0: 'mounted backwards, or the ship goes astern', 90.0: 'turned to starboard',
          -90.0: 'turned to port'}
_COURSE = {'mirrored': 'turns against the course over ground',
           'frozen': 'stays while the course over ground changes',
           'astray': 'does not follow the course over ground'}
_TURNS = {'against': 'turns against the rate of turn',
          'astray': 'does not turn with the rate of turn'}
_MINUTE_S = 60.0


def describe_motion(check: MotionCheck) -> str:
    """
    Return what is wrong in a few words, for a headline; empty if nothing is.

    Parameters
    ----------
    check
        Of `check_motion`.

    """
    if check.kind not in ('contradicts', 'doubt'):
        return ''
    sensors = {'ts': check.ts, 'rs': check.rs}
    blamed = [check.whose] if check.whose != 'both' else ['ts', 'rs']
    descriptions = [_describe(sensors[name]) for name in blamed]
    if len(blamed) == 2 and descriptions[0] == descriptions[1]:
        return _name_both(descriptions[0])
    words = ' and '.join(f'the {name.upper()} {description}'
                         for name, description in zip(blamed, descriptions))
    partner = {'ts': 'rs', 'rs': 'ts'}.get(check.whose)
    if (partner is not None and sensors[partner].kind == 'agrees'
            and sensors[check.whose].against_s):
        words += f', which the {partner.upper()} follows'
    return words


def _name_both(description: str) -> str:
    verb, _, rest = description.partition(' ')
    plural = {'points': 'point', 'turns': 'turn', 'stays': 'stay', 'does': 'do'}.get(verb, verb)
    return f'TS and RS both {plural} {rest}'


def _describe(sensor: SensorMotion) -> str:
    """Return what is wrong with a sensor, from the verb on."""
    if sensor.kind in _COURSE:
        return _COURSE[sensor.kind]
    if sensor.kind == 'off' and sensor.off_deg is not None:
        away = min(_HINTS, key=lambda odd: abs(_apart(sensor.off_deg or 0.0, odd)))
        near = abs(_apart(sensor.off_deg, away)) <= _NEAR_DEG
        hint = f' ({_HINTS[away]})' if near else ''
        return f'points {sensor.off_deg:.0f} deg off the course over ground{hint}'
    if sensor.turns is not None and sensor.turns.kind in _TURNS:
        return _TURNS[sensor.turns.kind]
    if sensor.turns is not None and sensor.turns.kind == 'scaled':
        return f'turns {sensor.turns.slope:.2g} times as far as the rate of turn says'
    return 'contradicts the motion of the ship'


def _apart(one_deg: float, other_deg: float) -> float:
    return (one_deg - other_deg + 180.0) % 360.0 - 180.0


def explain_motion(check: MotionCheck) -> str:
    """
    Return the figures of a check in a sentence.

    Parameters
    ----------
    check
        Of `check_motion`.

    """
    parts = []
    if check.least_bound_deg is None:
        parts.append('the ship did not go straight and fast enough to compare headings with the '
                     'course over ground' if check.n_velocities or check.n_positions
                     else 'there is no course over ground')
    else:
        legs = '1 straight leg' if check.n_legs == 1 else f'{check.n_legs} straight legs'
        parts.append(f'{legs} of {check.legs_s / _MINUTE_S:.1f} min; leeway and current explain '
                     f'at least {check.least_bound_deg:.0f} deg')
        for name, sensor in (('TS', check.ts), ('RS', check.rs)):
            if sensor.off_deg is None or sensor.largest_deg is None:
                continue
            sign = '+' if sensor.kind == 'mirrored' else '-'
            against = (f', and too far for {sensor.against_s / _MINUTE_S:.1f} min'
                       if sensor.against_s else '')
            parts.append(f'{name} {sign} course is {sensor.off_deg:.1f} deg on average, '
                         f'{name} - course at most {sensor.largest_deg:.1f} deg{against}')
        if check.astern_s:
            parts.append(f'the ship seems to go astern for {check.astern_s / _MINUTE_S:.1f} min')
    turns = [(name, sensor.turns) for name, sensor in (('TS', check.ts), ('RS', check.rs))
             if sensor.turns is not None]
    parts += [f'{name} {_explain_turns(rate)}' for name, rate in turns]
    if len(turns) == 2:
        parts += _doubt_rate(check, turns[0][1], turns[1][1])
    return '; '.join(parts)


def _explain_turns(turns: TurnRate) -> str:
    if turns.slope is None or turns.correlation is None:
        return 'cannot be compared with the rate of turn: the ship turned too little'
    return (f'on rate of turn: slope {turns.slope:.3g}, correlation {turns.correlation:.2f} in '
            f'{turns.n} spans of 5 s')


def _doubt_rate(check: MotionCheck, ts: TurnRate, rs: TurnRate) -> list[str]:
    """Return what is wrong with the rate of turn itself, if anything."""
    if is_scaled_alike(ts, rs):
        return [f'the rate of turn seems to be in another unit, by a factor of {ts.slope:.3g}']
    if check.kind == 'agrees' and 'follows' not in (ts.kind, rs.kind) and (
            {ts.kind, rs.kind} & {'against', 'astray'}):
        return ['the headings follow the course, so the rate of turn is wrong']
    return []
