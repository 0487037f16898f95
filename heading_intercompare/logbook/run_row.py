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

"""One judged run as a row of a logbook."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
import math
from typing import Callable, get_type_hints, Iterable, NamedTuple

from heading_intercompare.core.angles import wrap180
from heading_intercompare.core.declared_figures import find_figure, list_keys, no_key
from heading_intercompare.core.diagnostics.deviation import HeadingDependence, holds_all_round
from heading_intercompare.core.typed_reader import make_plain, read_plain
from heading_intercompare.core.verdict.verdict_document import RunVerdict, Verdict

from .run_record import encode_record, hash_record


class RunKey(NamedTuple):
    """What a run is known by; the fields are those of `RunRow`."""

    ship: str
    start_ns: int
    end_ns: int
    settings_sha256: str


@dataclass(frozen=True, slots=True)
class RunRow:
    """
    One run; the fields are the columns of the table `runs`, most with the key of their figure.

    A run is known by its ship, first and last pair, and settings: `key`.

    Attributes
    ----------
    ship
        Name of the ship or station; may be empty.
    start_ns, end_ns
        Stamps of the first and last pair, UTC nanoseconds.
    n
        Number of differences analysed.
    outcome, reason, headline, validity_effect
        As in the verdict.
    conditions
        The conditions that do not hold, such as ``losses=doubtful``, with commas between.
    mean_deg, mean_u_deg
        Mean difference and its standard uncertainty, allowing for correlation, degrees.
    sd_deg, nu
        Standard deviation of the differences, degrees, and its effective degrees of freedom.
    lower_bound_deg2, upper_bound_deg2
        Bounds of the variance of the guarded decision, square degrees.
    acceptance_limit_deg2, rejection_limit_deg2
        The limits that they are compared with.
    skew_s
        Time skew between the sensors, seconds.
    paired, ts_received, ts_unpaired, ts_rejected, rs_received, rs_unused, rs_rejected
        Counts of the ledger.
    source
        Name of the input; ``live`` for a run judged live.
    bag
        Path of the recording, if known.
    settings_sha256
        Hash of the settings.
    rule_version
        Version of the decision rule.
    software_version
        Version of the program.
    installation_offset_deg
        The installation offset, which is removed from `mean_deg` and the coefficients, degrees.
        None, like all that follows, in a row of a logbook that lacks the column.
    deviation_coefficients_deg, deviation_covariance_deg2
        A to E of the dependence on the RS heading, and their covariance; None without a fit.
    empty_arc_deg
        Largest arc without a heading of the RS, degrees.
    record_sha256
        SHA-256 of `record`. It is no figure of the run, so rows are compared without it.
    record
        The record of the run, by which it is judged together with others; no column, and None
        unless the logbook was asked for it.

    """

    ship: str
    start_ns: int = field(metadata={'key': 'start_ns'})
    end_ns: int = field(metadata={'key': 'end_ns'})
    n: int = field(metadata={'key': 'n'})
    outcome: str = field(metadata={'key': 'outcome'})
    reason: str = field(metadata={'key': 'reason'})
    headline: str = field(metadata={'key': 'headline'})
    validity_effect: str = field(metadata={'key': 'validity_effect'})
    conditions: str = field(metadata={'key': 'conditions_in_doubt'})
    mean_deg: float | None = field(metadata={'key': 'mean_deg'})
    mean_u_deg: float | None
    sd_deg: float | None = field(metadata={'key': 'std_deg'})
    nu: float | None = field(metadata={'key': 'guarded.nu'})
    lower_bound_deg2: float | None = field(metadata={'key': 'guarded.lower_bound_deg2'})
    upper_bound_deg2: float | None = field(metadata={'key': 'guarded.upper_bound_deg2'})
    acceptance_limit_deg2: float = field(metadata={'key': 'guarded.acceptance_limit_deg2'})
    rejection_limit_deg2: float = field(metadata={'key': 'guarded.rejection_limit_deg2'})
    skew_s: float | None = field(metadata={'key': 'skew.estimate.skew_s'})
    paired: int = field(metadata={'key': 'pairing.paired'})
    ts_received: int = field(metadata={'key': 'pairing.ts_received'})
    ts_unpaired: int = field(metadata={'key': 'pairing.ts_unpaired'})
    ts_rejected: int
    rs_received: int = field(metadata={'key': 'pairing.rs_received'})
    rs_unused: int = field(metadata={'key': 'pairing.rs_unused'})
    rs_rejected: int
    source: str = field(metadata={'key': 'source'})
    bag: str | None
    settings_sha256: str
    rule_version: int
    software_version: str
    installation_offset_deg: float | None = None
    deviation_coefficients_deg: tuple[float, ...] | None = field(
        default=None, metadata={'key': 'heading_dependence.coefficients_deg'})
    deviation_covariance_deg2: tuple[tuple[float, ...], ...] | None = field(
        default=None, metadata={'key': 'heading_dependence.covariance_deg2'})
    empty_arc_deg: float | None = field(
        default=None, metadata={'key': 'heading_dependence.empty_arc_deg'})
    record_sha256: str | None = field(default=None, compare=False)
    record: bytes | None = no_key()

    @property
    def measured_mean_deg(self) -> float | None:
        """Return the mean TS - RS as measured, with the installation offset; None if unknown."""
        if self.mean_deg is None or self.installation_offset_deg is None:
            return None
        return float(wrap180(self.mean_deg + self.installation_offset_deg))

    @property
    def heading_dependence(self) -> HeadingDependence | None:
        """Return the dependence on the heading; None unless a fit holds on every heading."""
        fit = HeadingDependence(
            n=self.n, reason='', condition=None, empty_arc_deg=self.empty_arc_deg,
            coefficients_deg=self.deviation_coefficients_deg,
            covariance_deg2=self.deviation_covariance_deg2)
        return fit if holds_all_round(fit) else None

    @property
    def key(self) -> RunKey:
        """Return the run that the row is about."""
        return RunKey(self.ship, self.start_ns, self.end_ns, self.settings_sha256)

    @classmethod
    def columns(cls) -> tuple[str, ...]:
        """Return the names of the columns."""
        return tuple(f.name for f in list_keys(cls))


def make_rows(verdict: Verdict, *, ship: str = '', earlier: Iterable[RunVerdict] = (),
              find_bag: Callable[[str], str | None] = lambda source: None) -> list[RunRow]:
    """
    Return a row per run of a verdict, in the order of time; none if it is intermediate.

    Parameters
    ----------
    verdict
        On one run or several.
    ship
        Name of the ship or station.
    earlier
        Runs judged with the same settings that the verdict does not cover any more.
    find_bag
        Returns the path of the recording of a source.

    """
    if verdict.intermediate:
        return []
    rows, digest, hints = [], verdict.settings_sha256, get_type_hints(RunRow)
    for run in (*earlier, *verdict.runs):
        n_effective, u_deg = run.correlation.n_effective_mean, None
        if run.variance_deg2 is not None and n_effective > 0.0:
            u_deg = math.sqrt(run.variance_deg2 / n_effective)
        rejected, record = run.pairing.rejected, encode_record(verdict, run)
        rows.append(RunRow(
            **{column.name: read_plain(hints[column.name], make_plain(
                find_figure(run, column.metadata['key'])))
               for column in fields(RunRow) if 'key' in column.metadata},
            ship=ship, mean_u_deg=make_plain(u_deg), ts_rejected=sum(rejected.ts.values()),
            rs_rejected=sum(rejected.rs.values()), bag=find_bag(run.source),
            settings_sha256=digest, rule_version=verdict.rule_version,
            software_version=verdict.software.version,
            installation_offset_deg=verdict.settings.installation_offset_deg,
            record_sha256=None if record is None else hash_record(record), record=record))
    return sorted(rows, key=lambda row: (row.start_ns, row.end_ns))
