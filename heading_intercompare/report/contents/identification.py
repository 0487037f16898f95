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

"""What identifies a protocol: number, ship, place, sensors, software, id of the verdict."""

from __future__ import annotations

from calendar import monthrange
from datetime import date
import hashlib
import json
from typing import Any, TYPE_CHECKING

from heading_intercompare.core.settings import Settings
from heading_intercompare.core.utc_text import utc
from heading_intercompare.core.verdict.verdict_document import SCHEMA, SCHEMA_VERSION, Verdict
from heading_intercompare.report.formatting import ABSENT, number, value

from .defaults import mark_default

if TYPE_CHECKING:
    from heading_intercompare.core.sensors.sensors_verdict import SensorsVerdict

#: 128 bits: nobody can make another verdict with the same id.
_ID_DIGITS = 32


def verdict_id(verdict: Verdict | SensorsVerdict) -> str:
    """
    Return what tells this verdict from every other.

    It is the beginning of the SHA-256 of its JSON with sorted names and no spaces, so a changed
    figure, name or input gives another id.
    """
    text = json.dumps(verdict.to_dict(), sort_keys=True, separators=(',', ':'),
                      ensure_ascii=False)
    return hashlib.sha256(text.encode('utf-8', 'surrogatepass')).hexdigest()[:_ID_DIGITS]


def name_trial(settings: Settings) -> str:
    """Return number, ship and tested sensor in one line; empty if none is given."""
    trial = settings.trial
    sensor = ' '.join(filter(None, (trial.ts_maker, trial.ts_type)))
    if trial.ts_serial:
        sensor = f'{sensor} no. {trial.ts_serial}'.strip()
    return ', '.join(filter(None, (trial.protocol_number, trial.ship, sensor)))


def span_of(verdict: Verdict) -> str:
    """Return the times of the first and the last pair, UTC; empty without a run."""
    runs = verdict.runs
    if not runs:
        return ''
    return f'{utc(min(run.start_ns for run in runs))} to {utc(max(run.end_ns for run in runs))}'


def identify(verdict: Verdict) -> list[tuple[str, list[tuple[str, str]]]]:
    """Return groups of names and values; an empty value is to be filled in by hand."""
    settings = verdict.settings
    trial = settings.trial
    return [
        ('Trial', [
            ('protocol number', trial.protocol_number),
            ('customer', trial.customer), ('purpose', trial.purpose),
            ('laboratory', trial.laboratory),
            ('operator', trial.operator), ('ship', trial.ship),
            ('place or area', trial.place), ('latitudes [deg]', _latitudes(settings)),
            ('first and last pair [UTC]', span_of(verdict) or ABSENT),
            ('sea state', _figure(trial.sea_state)),
            ('weather, manoeuvres', trial.conditions),
            ('temperature at the sensors [°C]', _figure(trial.temperature_c)),
            ('supply of the sensors', trial.supply),
            ('these names stated by: name, date', trial.filled_in_by),
            ('filled in by hand by: name, date', '')]),
        ('Sensors', [
            ('tested sensor (TS): maker', trial.ts_maker), ('TS: type', trial.ts_type),
            ('TS: serial number', trial.ts_serial),
            ('TS: certificate or service log', trial.ts_evidence),
            *_calibration('TS', trial.ts_calibration_date, trial.ts_calibration_months, verdict),
            ('reference sensor (RS): maker', trial.rs_maker), ('RS: type', trial.rs_type),
            ('RS: serial number', trial.rs_serial),
            ('RS: proof of its norm', trial.rs_evidence),
            *_calibration('RS', trial.rs_calibration_date, trial.rs_calibration_months, verdict),
            ('installation angle TS - RS [deg], as set', mark_default(
                value(settings.installation_offset_deg), settings, 'installation_offset_deg')),
            ('its standard uncertainty [deg], as set', mark_default(
                value(settings.installation_offset_u_deg), settings,
                'installation_offset_u_deg'))]),
        ('Software', [
            ('software', f'{verdict.software.name} {verdict.software.version}'),
            ('version of the decision rule', str(verdict.rule_version)),
            ('schema of the verdict', f'{SCHEMA}, version {SCHEMA_VERSION}'),
            ('verdict id', verdict_id(verdict)),
            ('SHA-256 of the settings', verdict.settings_sha256)])]


def _figure(thing: Any) -> str:
    """Return a figure or words; what nobody stated is empty."""
    return thing if isinstance(thing, str) else value(thing)


def _calibration(sensor: str, day: str | None, months: int | None,
                 verdict: Verdict) -> list[tuple[str, str]]:
    """Return when a sensor was calibrated and for how long, and whether that holds the trial."""
    # Dates of this form have the order of their letters.
    last = max((utc(run.end_ns) for run in verdict.runs), default='')[:10]
    term = '' if months is None else str(months)
    if day and months:
        due = _add_months(day, months)
        term = f'{months}, due on {due}' + (', before the trial ended' if due < last else '')
    return [(f'{sensor}: date of the last calibration or service',
             f'{day}, after the trial' if day and last and day > last else day or ''),
            (f'{sensor}: interval of calibration [months]', term)]


def _add_months(day: str, months: int) -> str:
    """Return the same day of a later month, or the last one of a month without that day."""
    start = date.fromisoformat(day)
    years, month = divmod(start.month - 1 + months, 12)
    year = start.year + years
    return date(year, month + 1, min(start.day, monthrange(year, month + 1)[1])).isoformat()


def _latitudes(settings: Settings) -> str:
    low, high = settings.trial.latitude_min_deg, settings.trial.latitude_max_deg
    if low is None and high is None:
        return '' if settings.norms.latitude_deg is None else number(settings.norms.latitude_deg)
    if low is None or high is None or low == high:
        return number(high if low is None else low)
    return f'{number(low)} to {number(high)}'
