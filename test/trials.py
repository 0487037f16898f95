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

"""Trials of a TS and an RS, for tests: their verdicts, findings and bags."""

from __future__ import annotations

from typing import Any, Callable, Mapping

import numpy as np
from numpy.typing import ArrayLike

from heading_intercompare import analyze
from heading_intercompare.bags.mcap.chunk_writer import Rows
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.settings import BagSettings
from heading_intercompare.core.pipeline import Compliance
from heading_intercompare.core.records import Headings, Motion, Pairs
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.validity.condition import Finding
from heading_intercompare.core.verdict.verdict_document import Verdict
from heading_intercompare.messages.heading_messages import encode_imu, IMU

__all__ = ['find_finding', 'judge_headings', 'judge_pairs', 'judge_turning_ship', 'make_settings',
           'make_turning_ship', 'NORMS', 'write_headings']

#: The norms of most tests.
NORMS = {'sigma_max_deg': 0.3, 'sigma_ref_max_deg': 0.1}
#: From one run of a turning ship to the next, seconds.
RUN_S = 50_000


def make_settings(norms: Mapping[str, float] = NORMS, **settings: Any) -> Settings:
    """Return settings; a keyword is a section, or a name with two underscores for its point."""
    return Settings.from_mapping(
        {**{f'norms.{name}': value for name, value in norms.items()},
         **{name.replace('__', '.'): value for name, value in settings.items()}})


def make_turning_ship(run: int, error_deg: ArrayLike, rs_error_deg: ArrayLike = 0.0,
                      ) -> tuple[Headings, Headings]:
    """Return a run of a ship that turns, one reading a second of a TS and of an RS."""
    n = np.size(error_deg)
    stamps = (np.arange(n) + RUN_S * run + 1_700_000_000) * 10 ** 9
    ship = 180.0 + 170.0 * np.sin(np.arange(n) / 40.0)
    return Headings.of(stamps, ship + error_deg), Headings.of(stamps, ship + rs_error_deg)


def judge_turning_ship(runs: int = 1, n: int = 600, *, mean_deg: float = 0.05,
                       sigma_deg: float = 0.2, seed: int | None = None,
                       **settings: Any) -> Verdict:
    """Return the verdict on runs of a turning ship; the errors of the TS are white."""
    rng = np.random.default_rng(n if seed is None else seed)
    trials = [make_turning_ship(run, mean_deg + rng.normal(0.0, sigma_deg, n))
              for run in range(runs)]
    return analyze([ts for ts, _ in trials], [rs for _, rs in trials], make_settings(**settings))


def judge_headings(ts_deg: ArrayLike, rs_deg: ArrayLike, stamps: np.ndarray,
                   rs_stamps: np.ndarray | None = None, *, motion: Motion | None = None,
                   norms: Mapping[str, float] = NORMS, **settings: Any) -> Verdict:
    """Return the verdict on two streams of headings, in the order in which they were sent."""
    ts = Headings.as_sent(stamps, np.mod(ts_deg, 360.0))
    rs = Headings.as_sent(stamps if rs_stamps is None else rs_stamps, np.mod(rs_deg, 360.0))
    return analyze(ts, rs, make_settings(norms, **settings), motion=motion)


def judge_pairs(pairs: Pairs, settings: Settings) -> Verdict:
    """Return the verdict on pairs, without a ledger of the readings."""
    compliance = Compliance(settings)
    compliance.update(pairs)
    compliance.finish()
    return compliance.verdict()


def find_finding(judged: Any, condition: str) -> Finding | None:
    """Return the finding of a run, or of all runs together, on a condition; None if none is."""
    findings = [finding for finding in judged.validity if finding.condition == condition]
    assert len(findings) < 2
    return findings[0] if findings else None


def write_headings(path: Any, streams: Mapping[str, Headings], *, frame: str = 'x',
                   records: Mapping[str, Mapping[str, Any]] | None = None,
                   settings: BagSettings | None = None,
                   came_ns: Mapping[str, Any] | None = None,
                   write_more: Callable[[BagWriter], object] = lambda writer: None) -> str:
    """
    Write a bag: metadata, the headings of each topic as Imu messages, and more.

    They came at their stamps, or at the times `came_ns` of a topic.
    """
    with BagWriter(path, settings or BagSettings()) as writer:
        for name, record in (records or {}).items():
            writer.metadata(name, record)
        for topic in streams:
            writer.add_topic(topic, IMU)
        writer.write_rows([Rows(topic, encode_imu(headings, frame),
                                (came_ns or {}).get(topic, headings.stamp_ns))
                           for topic, headings in streams.items()])
        write_more(writer)
    return str(path)
