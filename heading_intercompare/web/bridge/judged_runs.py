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

"""The runs that were judged, and what the sensor was like on each day."""

from __future__ import annotations

from itertools import groupby
import math
from typing import Sequence

from heading_intercompare.core.norm_tests.judged_test import MET, NOT_MET
from heading_intercompare.core.utc_text import utc
from heading_intercompare.core.validity.condition import VOID
from heading_intercompare.messages.status_messages import Status
from heading_intercompare.messages.verdict_messages import TEST

from .bridge_records import JudgedDayView, JudgedRunView, JudgedTestView, Tone
from .verdict_lamp import GRAVITY, make_lamp
from .view_texts import integer, real, shorten

_TONES = {MET: Tone.GOOD, NOT_MET: Tone.BAD}
#: The runs of a month, one a day or one a watch.
_MOST_RUNS = 200


def list_runs(statuses: Sequence[Status]) -> tuple[JudgedRunView, ...]:
    """Return the judged runs of a message on `compliance/verdict`, the newest first."""
    runs = []
    for status in statuses:
        number = integer(status.name.removeprefix('run '))
        if number is None:
            continue
        values = status.values
        validity = values.get('validity', '')
        lamp = make_lamp(values.get('outcome', ''), validity, 0, '', '')
        runs.append(JudgedRunView(
            number=number, start_ns=integer(values.get('start_ns')),
            end_ns=integer(values.get('end_ns')), n=integer(values.get('n')) or 0,
            mean_deg=real(values.get('mean_deg')), std_deg=real(values.get('std_deg')),
            word=lamp.word, tone=lamp.tone,
            reason=shorten(values.get('headline') or status.message, 400),
            void=validity == VOID))
    return tuple(sorted(runs, key=lambda run: -run.number))[:_MOST_RUNS]


def list_tests(statuses: Sequence[Status]) -> tuple[JudgedTestView, ...]:
    """Return the tests of the norm in a message on `compliance/verdict`."""
    return tuple(JudgedTestView(
        shorten(status.name.removeprefix(TEST), 80), shorten(status.message, 200),
        shorten(status.values.get('notes', ''), 400),
        _TONES.get(status.values.get('state', ''), Tone.DOUBT))
        for status in statuses if status.name.startswith(TEST))


def group_by_day(runs: Sequence[JudgedRunView]) -> tuple[JudgedDayView, ...]:
    """Return judged runs, the newest first, by the days of UTC on which they ended."""
    return tuple(_sum_up(date, tuple(runs_of_day)) for date, runs_of_day in
                 groupby(runs, lambda run: utc(run.end_ns).partition(' ')[0]))


def _sum_up(date: str, runs: tuple[JudgedRunView, ...]) -> JudgedDayView:
    worst = max(runs, key=lambda run: GRAVITY.index(run.tone))
    figures = [(run.n, run.mean_deg, run.std_deg) for run in runs
               if not run.void and run.n and run.mean_deg is not None and run.std_deg is not None]
    n = sum(n for n, _, _ in figures)
    mean_deg = std_deg = None
    if n:
        mean_deg = sum(n * mean for n, mean, _ in figures) / n
        std_deg = math.sqrt(sum(
            n * (std ** 2 + (mean - mean_deg) ** 2) for n, mean, std in figures) / n)
    return JudgedDayView(date, runs, n, mean_deg, std_deg, worst.word, worst.tone)
