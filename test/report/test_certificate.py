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

"""The certificate is valid by the schema of the PTB, and PyDCC reads its figures."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
import sys
from types import ModuleType

import pytest

from heading_intercompare import Settings
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.validity.condition import DOUBTFUL, VOID
from heading_intercompare.core.verdict.verdict_document import Input
from heading_intercompare.report import check_form, write
from heading_intercompare.report.certificate import compose, SCHEMA_VERSION
from heading_intercompare.report.contents.identification import verdict_id
from heading_intercompare.report.json import CONFIRMED, label, NOT_JUDGED

xmlschema = pytest.importorskip('xmlschema')

DATA = Path(__file__).parents[1] / 'data' / 'dcc'
NAMES = {'laboratory': 'Example Laboratory, Kiel, DE', 'customer': 'Example Shipping Ltd',
         'operator': 'A. Mate', 'ts_serial': '007-1234'}
ALL_NAMES = NAMES | {
    'protocol_number': 'HI-1', 'issue_date': '2026-03-05', 'ship': 'MV <Exämple> \x01 & Co',
    'place': ' German\nBight ', 'latitude_min_deg': 53.5, 'latitude_max_deg': 54.5, 'sea_state': 3,
    'temperature_c': -1.5, 'supply': '230 V', 'conditions': 'calm', 'ts_maker': 'Acme',
    'ts_type': 'Gyro 7', 'rs_maker': 'Sat & Co', 'rs_serial': 'S 55', 'deviations': 'none'}


@pytest.fixture(scope='module')
def schema():
    """Return the schema, with that of XML signatures, which signxml brings, beside it."""
    signxml = pytest.importorskip('signxml')
    signatures = Path(signxml.__file__).parent / 'schemas' / 'xmldsig-core-schema.xsd'
    return xmlschema.XMLSchema(str(DATA / 'dcc.xsd'), allow='local', locations={
        'https://ptb.de/si': str(DATA / 'SI_Format.xsd'),
        'http://www.w3.org/2000/09/xmldsig#': str(signatures)})


@pytest.fixture
def reader(monkeypatch):
    """Return the reader of PyDCC without its validators, which need X.509 and the network."""
    pytest.importorskip('signxml')
    # For signatures within the file; it does not load beside some versions of libcrypto.
    absent = ModuleType('certvalidator')
    absent.CertificateValidator = absent.errors = absent.ValidationContext = None
    monkeypatch.setitem(sys.modules, 'certvalidator', absent)
    pydcc = pytest.importorskip('dcc.dcc')
    # It would load all schemas of the PTB.
    monkeypatch.setattr(pydcc, 'DCCXMLValidator', lambda: None)
    return pydcc.DCC


def named(made, runs=1, names=NAMES, **settings):
    """Return a verdict whose trial has the names of a certificate."""
    return made(runs, **{f'trial__{name}': value for name, value in names.items()}, **settings)[0]


@pytest.mark.parametrize('names', [NAMES, ALL_NAMES, NAMES | {
    'sea_state': '3 to 4', 'temperature_c': '18 to 22', 'latitude_max_deg': 0.0}])
@pytest.mark.parametrize('runs, n', [(1, 600), (3, 600), (1, 20)])
def test_a_certificate_is_valid_by_the_schema(made, schema, tmp_path, names, runs, n):
    path = tmp_path / 'c.xml'
    write(named(made, runs, names, n=n), path)
    assert [*schema.iter_errors(str(path))] == []
    assert schema.version == SCHEMA_VERSION


@pytest.mark.parametrize('outcome, effect, stated', [
    (Outcome.COMPLIANT, 'holds', 'pass'), (Outcome.COMPLIANT, DOUBTFUL, 'conditionalPass'),
    (Outcome.NON_COMPLIANT, 'holds', 'fail'), (Outcome.NON_COMPLIANT, DOUBTFUL, 'conditionalFail'),
    (Outcome.INDETERMINATE, 'holds', None)])
def test_the_statement_of_conformity_is_that_of_the_verdict(made, schema, outcome, effect, stated):
    verdict = replace(named(made), outcome=outcome, validity_effect=effect)
    text = compose(verdict).decode()
    assert schema.is_valid(text)
    assert ('<dcc:conformity>' in text) == (stated is not None)
    assert stated is None or f'<dcc:conformity>{stated}</dcc:conformity>' in text


@pytest.mark.parametrize('words', [NOT_JUDGED, CONFIRMED])
def test_the_certificate_of_a_verdict_from_a_file_says_so_beside_its_conformity(made, schema,
                                                                                words):
    verdict = named(made)
    assert words not in compose(verdict).decode()
    text = compose(label(verdict, words)).decode()
    assert schema.is_valid(text)
    statement = text.partition('<dcc:statement>')[2].partition('</dcc:statement>')[0]
    assert f'{verdict.headline}; {words}; verdict id {verdict_id(verdict)}' in statement


def test_pydcc_reads_names_and_figures_with_their_uncertainty(made, tmp_path, reader):
    path = tmp_path / 'c.xml'
    verdict = named(made, names=ALL_NAMES, n=1500)
    write(verdict, path)
    certificate = reader(str(path))
    run, = verdict.runs
    assert certificate.uid() == verdict_id(verdict) and certificate.version() == SCHEMA_VERSION
    assert certificate.calibration_laboratory_name() == 'Example Laboratory, Kiel'
    assert certificate.item_id()['identifications']['identification']['value'] == '007-1234'
    assert f'{certificate.calibration_date():%Y-%m-%d}' == '2023-11-14'
    figures = {name.rpartition('TS - RS ')[2]: figure['real']
               for name, figure in certificate.get_calibration_results('name', 'en')}
    assert int(figures['number of differences']['value']) == run.n
    mean = figures['mean difference']
    assert float(mean['value']) == run.mean_deg and mean['unit'] == r'\degree'
    assert float(mean['expandedUnc']['uncertainty']) == 2 * run.guarded.bias_u_deg
    assert mean['expandedUnc']['coverageFactor'] == '2'
    spread = figures['standard deviation of the differences']
    assert float(spread['value']) == run.std_deg
    assert float(spread['expandedUnc']['uncertainty']) == pytest.approx(
        2 * run.std_deg / (2 * run.guarded.nu) ** 0.5)
    assert float(figures['upper bound of the standard deviation, at the stated risk'][
        'value']) ** 2 == pytest.approx(run.guarded.upper_bound_deg2)


def test_the_inputs_stand_in_it_by_name_and_sha256_without_folders(made):
    verdict = replace(named(made), inputs=(Input('/data/voyage/trial.mcap', 'ab' * 32),))
    text = compose(verdict).decode()
    assert 'SHA-256 ' + 'ab' * 32 in text and 'trial.mcap' in text and '/data' not in text


@pytest.mark.parametrize('names, words', [
    ({}, 'set trial.laboratory, trial.customer, trial.operator, trial.ts_serial'),
    (NAMES | {'customer': ' '}, 'set trial.customer'),
    (NAMES | {'laboratory': 'Example Laboratory, Kiel'}, 'must end in the two letters of its ')])
def test_a_certificate_without_its_names_is_refused_in_one_line(made, tmp_path, names, words):
    with pytest.raises(ValueError, match=f'c.xml: .*{words}') as refused:
        write(named(made, names=names), tmp_path / 'c.xml')
    assert '\n' not in str(refused.value) and not (tmp_path / 'c.xml').exists()


def test_a_certificate_of_several_sensors_is_refused_with_what_to_choose():
    settings = Settings.from_mapping({'sensors': 'a sigma_max_deg=1; b sigma_max_deg=1 rs',
                                      'trial': NAMES})
    with pytest.raises(ValueError, match='of one item.* choose two sensors with --ts NAME --rs'):
        check_form('c.xml', settings)


@pytest.mark.parametrize('runs, effect, words', [
    (0, 'holds', 'a verdict without a run has none'), (1, VOID, 'a void verdict has none')])
def test_a_verdict_that_says_nothing_of_the_sensor_becomes_no_certificate(made, tmp_path, runs,
                                                                          effect, words):
    with pytest.raises(ValueError, match=words):
        write(replace(named(made, runs), validity_effect=effect), tmp_path / 'c.xml')
