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

"""A verdict as a Digital Calibration Certificate: XML of the PTB with units of D-SI."""

from __future__ import annotations

import math
from pathlib import Path
import re
from typing import Any
from xml.etree import ElementTree

from heading_intercompare.core.decision.norm_presets import sigma_max_deg
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.utc_text import utc
from heading_intercompare.core.validity.condition import DOUBTFUL, VOID
from heading_intercompare.core.verdict.verdict_document import RunVerdict, Verdict
from heading_intercompare.replaced_file import replace_file

from .contents.decision_rule import state_conformity
from .contents.file_names import hide_paths, name_files
from .contents.holding import is_sound, upper_bound_holds, worth_of
from .contents.identification import verdict_id

SCHEMA_VERSION = '3.2.1'
"""Version of the schema of the PTB that the certificate follows."""

_SPACES = {'xmlns:dcc': 'https://ptb.de/dcc', 'xmlns:si': 'https://ptb.de/si',
           'xmlns:xsi': 'http://www.w3.org/2001/XMLSchema-instance',
           'xsi:schemaLocation':
               f'https://ptb.de/dcc https://ptb.de/dcc/v{SCHEMA_VERSION}/dcc.xsd'}
_NEEDED = ('laboratory', 'customer', 'operator', 'ts_serial')
_LABORATORY = re.compile(r'(.+),\s*([A-Z]{2})', re.DOTALL)
#: Characters that XML cannot hold.
_NO_XML = re.compile('[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]')
_STATED = {Outcome.COMPLIANT: ('pass', 'conditionalPass'),
           Outcome.NON_COMPLIANT: ('fail', 'conditionalFail')}
_DEGREE, _ONE, _SECOND = r'\degree', r'\one', r'\second'
#: Coverage factor and probability of an expanded uncertainty.
_COVERAGE, _PROBABILITY = 2, 0.95


def check_trial(path: str | Path, settings: Settings) -> None:
    """
    Reject a certificate of several items, or without names which its schema asks for.

    Raises
    ------
    ValueError
        If there are several sensors, or a name is missing: a line that says what to state.

    """
    if settings.sensors is not None:
        raise ValueError(f'{path}: a certificate is of one item, and trial.ts_serial is the '
                         'number of one; choose two sensors with --ts NAME --rs NAME')
    missing = [f'trial.{name}' for name in _NEEDED if not getattr(settings.trial, name).strip()]
    if missing:
        raise ValueError(f'{path}: a certificate names its laboratory, customer, person and item; '
                         f'set {", ".join(missing)}')
    if _LABORATORY.fullmatch(settings.trial.laboratory.strip()) is None:
        raise ValueError(f'{path}: trial.laboratory = {settings.trial.laboratory!r:.70}: must end '
                         "in the two letters of its country for a certificate, such as 'Example "
                         "Laboratory, Kiel, DE'")


def write(verdict: Verdict, path: str | Path) -> None:
    """
    Write the certificate.

    Raises
    ------
    ValueError
        As `check_trial`, or if the verdict has no run, or is void, so its figures do not describe
        the tested sensor.
    OSError
        If the file cannot be written.

    """
    check_trial(path, verdict.settings)
    if not verdict.runs or verdict.validity_effect == VOID:
        raise ValueError(f'{path}: a certificate states figures of the tested sensor, and '
                         f'{"a void verdict" if verdict.runs else "a verdict without a run"} has '
                         'none; leave it out')
    replace_file(path, compose(verdict))


def compose(verdict: Verdict) -> bytes:
    """Return the certificate of a verdict with runs."""
    shown = hide_paths(verdict, name_files(verdict.inputs, [run.source for run in verdict.runs]))
    root = ElementTree.Element('dcc:digitalCalibrationCertificate', {
        **_SPACES, 'schemaVersion': SCHEMA_VERSION})
    _add_administration(_add(root, 'administrativeData'), shown, verdict_id(verdict))
    results = _add(root, 'measurementResults')
    for run in shown.runs:
        _add_run(results, run, shown)
    ElementTree.indent(root, ' ')
    text: bytes = ElementTree.tostring(root, 'utf-8', xml_declaration=True)
    return text + b'\n'


def _add_administration(parent: Any, verdict: Verdict, identifier: str) -> None:
    trial = verdict.settings.trial
    _add_software(_add(parent, 'dccSoftware'), verdict)
    _add_core(_add(parent, 'coreData'), verdict, identifier)
    _add_sensor(_add(parent, 'items'), 'item', 'tested heading sensor', trial.ts_maker,
                trial.ts_type, trial.ts_serial)
    match = _LABORATORY.fullmatch(trial.laboratory.strip())
    assert match is not None
    contact = _add(_add(parent, 'calibrationLaboratory'), 'contact')
    _add_text(contact, 'name', match[1])
    _add(_add(contact, 'location'), 'countryCode', match[2])
    person = _add(_add(parent, 'respPersons'), 'respPerson')
    _add_text(_add(person, 'person'), 'name', trial.operator)
    _add(person, 'mainSigner', 'true')
    customer = _add(parent, 'customer')
    _add_text(customer, 'name', trial.customer)
    _add_text(_add(customer, 'location'), 'further', 'not stated')
    _add_conformity(_add(parent, 'statements'), verdict)


def _add_software(parent: Any, verdict: Verdict) -> None:
    software = _add(parent, 'software')
    _add_text(software, 'name', verdict.software.name)
    _add(software, 'release', f'{verdict.software.version}, decision rule {verdict.rule_version}')


def _add_core(parent: Any, verdict: Verdict, identifier: str) -> None:
    trial = verdict.settings.trial
    # The laboratory has been checked to end in its country.
    _add(parent, 'countryCodeISO3166_1', trial.laboratory.strip()[-2:])
    for tag in ('usedLangCodeISO639_1', 'mandatoryLangCodeISO639_1'):
        _add(parent, tag, 'en')
    _add(parent, 'uniqueIdentifier', identifier)
    if trial.protocol_number.strip():
        _add_identification(_add(parent, 'identifications'), 'calibrationLaboratory',
                            trial.protocol_number, 'protocol number')
    _add(parent, 'beginPerformanceDate', utc(min(run.start_ns for run in verdict.runs))[:10])
    _add(parent, 'endPerformanceDate', utc(max(run.end_ns for run in verdict.runs))[:10])
    _add(parent, 'performanceLocation', 'other')
    if trial.issue_date:
        _add(parent, 'issueDate', trial.issue_date)


def _add_sensor(parent: Any, tag: str, words: str, maker: str, model: str, serial: str) -> None:
    sensor = _add(parent, tag)
    _add_text(sensor, 'name', words)
    if maker.strip():
        _add_text(_add(sensor, 'manufacturer'), 'name', maker)
    if model.strip():
        _add(sensor, 'model', model)
    if serial.strip():
        _add_identification(_add(sensor, 'identifications'), 'manufacturer', serial,
                            'serial number')


def _add_identification(parent: Any, issuer: str, value: str, words: str) -> None:
    identification = _add(parent, 'identification')
    _add(identification, 'issuer', issuer)
    _add(identification, 'value', value)
    _add_text(identification, 'name', words)


def _add_conformity(parent: Any, verdict: Verdict) -> None:
    """Add the statement of conformity; an open verdict states neither of both."""
    statement = _add(parent, 'statement')
    _add_text(statement, 'name', 'statement of conformity')
    _add_text(statement, 'description', ' '.join(
        f'{name}: {words}' for name, words in state_conformity(verdict)))
    _add(statement, 'norm', 'ISO/IEC 17025:2017, 7.8.6')
    _add_text(statement, 'declaration', '; '.join(filter(None, (
        verdict.headline, verdict.provenance))))
    if verdict.outcome in _STATED:
        _add(statement, 'conformity',
             _STATED[verdict.outcome][verdict.validity_effect == DOUBTFUL])


def _add_run(parent: Any, run: RunVerdict, verdict: Verdict) -> None:
    trial = verdict.settings.trial
    measured = _add(parent, 'measurementResult')
    _add_text(measured, 'name', f'run {run.run}: {run.headline}')
    method = _add(_add(measured, 'usedMethods'), 'usedMethod')
    _add_text(method, 'name', 'intercomparison of two heading sensors on one ship')
    _add(method, 'reference', 'Granovskii and Kudryavtsev, ALLSENSORS 2016')
    _add_sensor(_add(measured, 'measuringEquipments'), 'measuringEquipment',
                'reference heading sensor', trial.rs_maker, trial.rs_type, trial.rs_serial)
    _add_conditions(measured, verdict.settings)
    result = _add(_add(measured, 'results'), 'result')
    _add_text(result, 'name', 'differences of the headings, TS - RS')
    _add_figures(_add(result, 'data'), run, verdict.settings)
    inputs = _add(measured, 'measurementMetaData')
    for words, declaration in [
            ('settings', f'SHA-256 {verdict.settings_sha256}'),
            *((entry.path, f'SHA-256 {entry.sha256 or "unknown"}') for entry in verdict.inputs)]:
        data = _add(inputs, 'metaData')
        _add_text(data, 'name', words)
        _add_text(data, 'declaration', declaration)


def _add_conditions(parent: Any, settings: Settings) -> None:
    trial = settings.trial
    stated = [(words, value, unit) for words, value, unit in (
        ('ship', trial.ship, ''), ('place or area', trial.place, ''),
        ('southernmost latitude', trial.latitude_min_deg, _DEGREE),
        ('northernmost latitude', trial.latitude_max_deg, _DEGREE),
        ('sea state', trial.sea_state, _ONE), ('weather, manoeuvres', trial.conditions, ''),
        ('temperature at the sensors', trial.temperature_c, r'\degreecelsius'),
        ('supply of the sensors', trial.supply, ''),
        ('deviations from the method', trial.deviations, ''))
        if value is not None and str(value).strip()]
    conditions = _add(parent, 'influenceConditions') if stated else None
    for words, value, unit in stated:
        condition = _add(conditions, 'influenceCondition')
        _add_text(condition, 'name', words)
        data = _add(condition, 'data')
        if isinstance(value, str):
            _add_text(data, 'text', value)
        else:
            _add_quantity(data, words, value, unit)


def _add_figures(parent: Any, run: RunVerdict, settings: Settings) -> None:
    """Add the figures of a run; one that does not exist or hold is left out."""
    guarded = run.guarded
    u_std_deg = None if run.std_deg is None or not guarded.nu else (
        run.std_deg / math.sqrt(2.0 * guarded.nu))
    low = guarded.lower_bound_deg2 if is_sound(run) else None
    up = guarded.upper_bound_deg2 if upper_bound_holds(run) else None
    for words, value, unit, u in (
            ('number of differences', run.n, _ONE, None),
            ('effective number of differences', worth_of(run), _ONE, None),
            ('duration', run.duration_s, _SECOND, None),
            ('mean difference', run.mean_deg, _DEGREE, guarded.bias_u_deg),
            ('standard deviation of the differences', run.std_deg, _DEGREE, u_std_deg),
            ('lower bound of the standard deviation, at the stated risk', _root(low), _DEGREE,
             None),
            ('upper bound of the standard deviation, at the stated risk', _root(up), _DEGREE,
             None),
            ('acceptance limit of the standard deviation',
             _root(guarded.acceptance_limit_deg2), _DEGREE, None),
            ('norm of the TS standard deviation',
             sigma_max_deg(settings.norms, settings.model), _DEGREE, None),
            ('norm of the RS standard deviation', settings.norms.sigma_ref_max_deg, _DEGREE,
             None)):
        if value is not None and math.isfinite(value):
            _add_quantity(parent, words, value, unit, u)


def _root(variance_deg2: float | None) -> float | None:
    return None if variance_deg2 is None or variance_deg2 < 0.0 else math.sqrt(variance_deg2)


def _add_quantity(parent: Any, words: str, value: float, unit: str,
                  u: float | None = None) -> None:
    """Add a figure with its unit, and its expanded uncertainty if it has a standard one, `u`."""
    quantity = _add(parent, 'quantity')
    _add_text(quantity, 'name', words)
    real = _add(quantity, 'si:real')
    _add(real, 'si:value', repr(value))
    _add(real, 'si:unit', unit)
    if u is not None and math.isfinite(u):
        expanded = _add(real, 'si:expandedUnc')
        _add(expanded, 'si:uncertainty', repr(_COVERAGE * u))
        _add(expanded, 'si:coverageFactor', str(_COVERAGE))
        _add(expanded, 'si:coverageProbability', str(_PROBABILITY))


def _add_text(parent: Any, tag: str, words: str) -> None:
    _add(_add(parent, tag), 'content', words).set('lang', 'en')


def _add(parent: Any, tag: str, words: str | None = None) -> Any:
    """Add an element, of the certificate unless its tag says otherwise."""
    element = ElementTree.SubElement(parent, tag if ':' in tag else f'dcc:{tag}')
    if words is not None:
        element.text = _NO_XML.sub('\ufffd', words).strip()
    return element
