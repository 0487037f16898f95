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

"""All pairs of two sensors or more, each reading taken once."""

from __future__ import annotations

from functools import partial
from typing import Callable, Mapping, Sequence

from heading_intercompare.core.pairing.ledger import LedgerKey
from heading_intercompare.core.pairing.pair_sampling import PairSampler
from heading_intercompare.core.pipeline import Intercomparison
from heading_intercompare.core.records import Headings, Losses, Motion, Pairs, Quality
from heading_intercompare.core.runs.growing_columns import Keep
from heading_intercompare.core.settings import Settings

from .compared_sensors import list_sensors, pair_with_reference
from .pair_names import Names
from .pair_settings import settings_of_others, settings_of_pair


class SensorsComparison:
    """
    Compare two sensors or more, pair by pair.

    Parameters
    ----------
    settings
        Without `sensors` the two are the TS `ts` and the RS `rs`.
    source, table, keeper, progress
        As for `Intercomparison`.

    Attributes
    ----------
    sensors : tuple of Sensor
    tested : dict of str to Intercomparison
        Each tested sensor against the reference, by its name, as if the two were alone. Empty if
        no sensor is the reference.
    others : dict of (str, str) to Intercomparison
        All other pairs of sensors, by their names; two of their pairs of readings a second are
        judged.

    Raises
    ------
    SettingsError
        If a sensor has no norm.

    """

    def __init__(self, settings: Settings, *, source: str = '',
                 table: Sequence[tuple[int, int]] | None = None,
                 keeper: Callable[[], Keep | None] = lambda: None,
                 progress: Callable[[str], None] = lambda text: None) -> None:
        self.sensors = list_sensors(settings)
        compare = partial(Intercomparison, source=source, table=table, keeper=keeper,
                          progress=progress)
        self.others = {names: compare(pair_settings, sampler=PairSampler())
                       for names, pair_settings in settings_of_others(settings).items()}
        tested = pair_with_reference(settings)
        self._reference = tested[0][1].name if tested else ''
        self.tested = {sensor.name: compare(settings_of_pair(settings, sensor, reference))
                       for sensor, reference in tested}

    def update(self, headings: Mapping[str, Headings],
               now_s: float | None = None) -> dict[str, Pairs]:
        """
        Take readings by the names of their sensors; `now_s` as for `Pairer.update`.

        Returns
        -------
        dict of str to Pairs
            The new pairs of each tested sensor with the reference.

        """
        reference = headings.get(self._reference)
        pairs = {name: comparison.update(headings.get(name), reference, now_s)
                 for name, comparison in self.tested.items()}
        for (first, second), comparison in self.others.items():
            comparison.update(headings.get(first), headings.get(second), now_s)
        return pairs

    def take_motion(self, motion: Motion) -> None:
        """Take motion of the ship, before the runs that it belongs to end."""
        for comparison in self.pairs.values():
            comparison.take_motion(motion)

    def take_quality(self, name: str, quality: Quality) -> None:
        """Take what a sensor says of its readings, before the runs that they belong to end."""
        for names, comparison in self.pairs.items():
            if name in names:
                comparison.take_quality('ts' if name == names[0] else 'rs', quality)

    def lose(self, name: str, key: LedgerKey, losses: Losses) -> None:
        """Count readings of a sensor that never came; `key` is that of a TS."""
        for names, comparison in self.pairs.items():
            if name in names:
                comparison.lose(key if name == names[0] else key.of_stream('rs'), losses)

    def mark(self, kind: str, stamp_ns: int) -> None:
        """Start or stop a run of every pair."""
        for comparison in self.pairs.values():
            comparison.mark(kind, stamp_ns)

    def begin_again(self) -> dict[str, Pairs]:
        """Go on as after a restart; see `Intercomparison.begin_again`."""
        for comparison in self.others.values():
            comparison.begin_again()
        return {name: comparison.begin_again() for name, comparison in self.tested.items()}

    def finish(self) -> dict[str, Pairs]:
        """End all streams; return the last pairs of each tested sensor."""
        pairs = {name: comparison.finish() for name, comparison in self.tested.items()}
        for comparison in self.others.values():
            comparison.finish()
        return pairs

    @property
    def pairs(self) -> dict[Names, Intercomparison]:
        """All pairs by the names of their sensors; the reference is second in its pairs."""
        return {**{(name, self._reference): comparison
                   for name, comparison in self.tested.items()},
                **self.others}

    @property
    def newest_ns(self) -> int | None:
        """Return the newest stamp in any ledger; None before the first reading."""
        stamps = [comparison.pairer.ledger.newest_ns for comparison in self.pairs.values()]
        return max((stamp for stamp in stamps if stamp is not None), default=None)
