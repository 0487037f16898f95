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

"""The protocol says all that the verdict holds, and shows every name literally."""

from __future__ import annotations

from dataclasses import replace
from html.parser import HTMLParser
import json
from pathlib import Path
import re

import numpy as np
import pytest

from heading_intercompare import analyze, Headings, Outcome, Settings, Verdict
from heading_intercompare.core.declared_settings import settings_sha256
from heading_intercompare.core.statistics.stationarity import Homogeneity
from heading_intercompare.core.verdict.verdict_document import Input, OperatorNote
from heading_intercompare.core.version import RULE_VERSION
from heading_intercompare.report import json as verdict_json, SeriesSketch, write
from heading_intercompare.report.contents.decision_rule import describe_norms, state_conformity
from heading_intercompare.report.contents.identification import verdict_id
from heading_intercompare.report.figures.gallery import draw_figures

pytest.importorskip('jinja2')
pytest.importorskip('matplotlib')

from heading_intercompare.report import html  # noqa: E402

VOID = {'meta', 'br', 'hr', 'img', 'input', 'link'}


class Page(HTMLParser):
    """The text, cells and elements of a page, and the faults of their nesting."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.open, self.names, self.faults = [], [], []
        self.text, self.cells, self.links, self.ids = [], [], [], []
        self.feed(page)
        self.close()
        self.faults += self.open

    def handle_starttag(self, tag, attrs):
        self.names.append(tag)
        self.links += [v for k, v in attrs if k in ('href', 'src', 'xlink:href')]
        self.faults += [k for k, _ in attrs if k.startswith('on')]
        self.ids += [v for k, v in attrs if k == 'id']
        if tag == 'td':
            self.cells.append('')
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.handle_endtag(tag)

    def handle_endtag(self, tag):
        if not self.open or self.open.pop() != tag:
            self.faults.append(tag)

    def handle_data(self, data):
        if 'style' not in self.open:
            self.text.append(data)
        if 'td' in self.open:
            self.cells[-1] += data


def numbers(cells):
    """Return all numbers in some texts."""
    return [float(m) for cell in cells
            for m in re.findall(r'-?\d+(?:\.\d+)?(?:e[-+]?\d+)?', cell)]


def changed(verdict, change):
    """Return a verdict whose mapping was changed."""
    mapping = verdict.to_dict()
    change(mapping)
    return Verdict.from_dict(mapping)


@pytest.mark.slow
@pytest.mark.parametrize('runs', [0, 1, 3, 7])
def test_the_page_is_nested_well_and_needs_nothing_from_elsewhere(made, runs):
    page = html.render(*made(runs))
    read = Page(page)
    assert read.faults == []
    assert all(link.startswith('#') for link in read.links)
    assert len(read.ids) == len({*read.ids}) and {link[1:] for link in read.links} <= {*read.ids}
    assert 'script' not in read.names
    assert '@import' not in page and 'url(' not in page.replace('url(#', '')
    assert read.names.count('figure') == 11 * runs


@pytest.mark.slow
@pytest.mark.parametrize('runs', [0, 1, 3])
def test_an_absent_figure_is_a_dash(made, runs):
    cells = Page(html.render(*made(runs, n=20))).cells
    words = {word.strip('.,;') for cell in cells for word in cell.split()}
    assert not words & {'None', 'nan', 'inf', '-inf', 'null', 'NaN', 'True', 'False'}
    assert '-' in words


def marked(thing, marks):
    """Return a block with each number replaced by a unique one, an integer by an integer."""
    if isinstance(thing, dict):
        return {key: marked(inner, marks) for key, inner in thing.items()}
    if isinstance(thing, list):
        return [marked(inner, marks) for inner in thing]
    if isinstance(thing, bool) or not isinstance(thing, (int, float)):
        return thing
    mark = 5000 + len(marks) if isinstance(thing, int) else 7000.25 + len(marks)
    marks.append(mark)
    return mark


@pytest.mark.slow
@pytest.mark.parametrize('block', ['variance_criterion', 'count_criterion', 'total_error',
                                   'guarded', 'pairing'])
def test_every_number_of_the_criteria_is_in_the_page(made, block):
    """
    Each number is made unique first, so that none is mistaken for another.

    A length that would decide stands only beside an open verdict, see `test_holding`.
    """
    verdict, _ = made(3, norms__total_error_max_deg=1.0, norms__m_low=0.5,
                      risk__min_duration_s=60.0)
    assert verdict.outcome is Outcome.COMPLIANT
    marks = []

    def mark(mapping):
        for run in mapping['runs']:
            run['pairing']['rejected'] = {'ts': {'invalid': 1, 'no_stamp': 2},
                                          'rs': {'invalid': 3}}
            kept = {key: run[block].pop(key) for key in ('duration_factor', 'hours_needed')
                    if key in run[block]}
            run[block] = {**marked(run[block], marks), **kept}
    found = set(numbers(Page(html.render(changed(verdict, mark))).cells))
    assert len(marks) >= 3 * 3
    assert [mark for mark in marks if mark not in found] == []


def test_every_number_of_a_run_and_of_the_worst_run_is_in_the_page(made):
    """The page has one mean: the circular one of the same differences stays in the JSON."""
    verdict, _ = made(2)
    marks = []

    def mark(mapping):
        for part in (*mapping['runs'], mapping['campaign']):
            part |= {key: marked(v, marks) for key, v in part.items()
                     if key not in ('start_ns', 'end_ns', 'run', 'circular_mean_deg')
                     and not isinstance(v, (dict, list))}
    found = set(numbers(Page(html.render(changed(verdict, mark))).cells))
    assert len(marks) > 20
    assert [mark for mark in marks if mark not in found] == []


@pytest.mark.slow
def test_a_hostile_name_is_shown_and_not_obeyed(made):
    verdict, sketches = made(1)
    name = '<script>alert("1")</script>&amp;\x00\udcff.mcap\'"><img src=x onerror=y>'

    def spoil(mapping):
        run = mapping['runs'][0]
        run |= {'source': name, 'warnings': [name], 'reason': name, 'validity_effect': name}
        run['pairing']['rejected'] = {'ts': {name: 3}, 'rs': {}}
        run['skew']['estimate']['kind'] = name
        run['assumptions'] = [{'id': 'a', 'statement': name, 'state': name, 'evidence': name}]
        run['validity'] = [{'condition': name, 'effect': name, 'words': name, 'evidence': name}]
        mapping['inputs'] = [{'path': name, 'sha256': name, 'ts_topic': name, 'rs_topic': name}]
        mapping['settings']['ts_topic'] = mapping['headline'] = name
        mapping['settings_sha256'] = settings_sha256(mapping['settings'])
        mapping['software'] = {'name': name, 'version': name}
        mapping['campaign']['reason'] = mapping['campaign']['rule'] = name
    sketches[0].source = name
    spoilt = changed(verdict, spoil)
    page = html.render(spoilt, sketches)
    read = Page(page)
    assert read.faults == []
    assert not {'script', 'img'} & set(read.names)
    shown = name.replace('\x00', '\ufffd').replace('\udcff', '\ufffd')
    assert shown in read.cells
    page.encode('utf-8')


@pytest.mark.parametrize('letter', ['\x00', '\x1f', '\x7f', '\x85', '\ud800', '\udcff', '\ufffe',
                                    '\uffff'])
def test_a_letter_that_html_cannot_hold_is_replaced_wherever_it_stands(made, letter):
    verdict = made(1)[0]
    word = f'a{letter}b'
    run = replace(verdict.runs[0], source=word, warnings=[word])
    page = html.render(replace(verdict, runs=[run], headline=word, inputs=[
        Input(word, word, word, word, (OperatorNote(0, word),))]))
    assert letter not in page
    assert page.count('a\ufffdb') == 10


def test_words_are_markup_neither_in_an_attribute_nor_when_they_look_escaped(made):
    words = '\' onload="x" {{ verdict }} {% raw %} </style></title>&lt;b&gt; ]]>--><!--'
    page = html.render(replace(made(1)[0], inputs=[Input(words, '1', words, 'b')]))
    read = Page(page)
    assert read.faults == [] and words in read.cells
    assert read.names.count('title') == read.names.count('style') == 1


def test_a_gap_that_is_not_filled_is_a_fault_and_no_empty_cell():
    jinja2 = pytest.importorskip('jinja2')
    with pytest.raises(jinja2.UndefinedError):
        html.load_template('protocol.html').environment.from_string('{{ nothing }}').render()


def test_an_input_that_could_not_be_read_is_named_with_its_fault(made):
    verdict = replace(made(1)[0], inputs=[Input('b.mcap', error='empty <file>')])
    assert 'b.mcap was not judged: empty &lt;file&gt;' in html.render(verdict)


def test_the_operators_notes_are_among_the_events(made):
    notes = (OperatorNote(1406851500 * 10 ** 9, 'turn <hard>'),)
    verdict = replace(made(1)[0], inputs=[Input('b.mcap', '1', 'a', 'b', notes)])
    page = html.render(verdict)
    events = page[page.index('Events, exclusions'):]
    assert '2014-08-01 00:05:00.000 UTC' in events and 'turn &lt;hard&gt;' in events
    assert 'events during the trial' in events
    assert "operator's note" not in html.render(made(1)[0]).replace('&#x27;', "'")


@pytest.mark.slow
def test_constant_data_are_drawn(made):
    verdict, sketches = made(1, noise_deg=0.0)
    read = Page(html.render(verdict, sketches))
    assert read.faults == []
    assert read.names.count('svg') > 0


@pytest.mark.slow
def test_a_single_pair_is_drawn(made):
    read = Page(html.render(*made(1, n=1)))
    assert read.faults == []
    assert read.names.count('figure') == 4


@pytest.mark.slow
def test_a_few_wild_differences_do_not_squeeze_the_histogram(made):
    verdict, sketches = made(1, n=600)
    verdict_wild, sketches_wild = made(1, n=600)
    sketches_wild[0].histogram.update(sketches_wild[0].time.bins.mean_deg[:1] * 0.0 + 120.0)
    sketches_wild[0].time.bins.up_deg[0] = 120.0
    assert 'beyond the axis' not in html.render(verdict, sketches)
    assert ', 1 beyond the axis' in html.render(verdict_wild, sketches_wild)


def test_an_empty_sketch_says_so(made):
    assert 'No difference to draw.' in html.render(made(1)[0], [SeriesSketch('x')])


def test_the_outcome_and_its_reason_stand_in_words(made):
    good = ''.join(Page(html.render(made(1, risk__min_duration_s=0.0)[0])).text)
    assert 'the variance is within the acceptance limit' in good
    assert 'sigma_max of the TS: met' in good
    bad = ''.join(Page(html.render(made(1, noise_deg=0.6)[0])).text)
    assert 'the variance is above the rejection limit' in bad
    assert 'sigma_max of the TS: not met' in bad


def test_the_producers_risk_is_shared_among_the_runs(made):
    assert '0.05 / 3 = 0.0167' in dict(state_conformity(made(3)[0]))['several runs']
    assert '0.05 / 1 = 0.05' in dict(state_conformity(made(1)[0]))['several runs']


def test_a_published_norm_is_named_with_its_status_and_figure(made):
    words = dict(describe_norms(made(1, norms__preset='imo_a424', norms__latitude_deg=60.0,
                                     norms__sigma_max_deg=None)[0].settings))
    assert words['published norm'].startswith('imo_a424: gyro-compass')
    assert words['status of its text here'] == 'unverified'
    assert words['norm of the TS standard deviation, sigma_max [deg]'] == '0.5'


@pytest.mark.slow
def test_the_protocol_names_the_rule_and_the_hash_of_the_settings(made):
    verdict, sketches = made(1)
    page = html.render(verdict, sketches)
    assert verdict.settings_sha256 in page
    assert f'decision rule</th><td>{RULE_VERSION}</td>' in page


def test_the_protocol_says_whether_the_ledger_is_complete(made):
    verdict, sketches = made(1)
    assert 'The ledger is complete.' in html.render(verdict, sketches)
    page = html.render(replace(verdict, ledger_problems=('it was <restarted>',)))
    assert 'The ledger is not complete:' in page and '<li>it was &lt;restarted&gt;</li>' in page


def test_the_findings_are_shown_in_words(made):
    verdict, _ = made(1)
    run = verdict.runs[0]
    allan = replace(run.allan, deviation_deg=(0.03125,) * len(run.allan.tau_s))
    skew = replace(run.skew, estimate=replace(run.skew.estimate, skew_s=0.1251, u_s=0.0123))
    page = html.render(replace(
        verdict, runs=[replace(run, allan=allan, skew=skew), replace(run, run=2)],
        campaign=replace(verdict.campaign, homogeneity=Homogeneity(2, q_p=0.4375))))
    assert {'0.125 ± 0.012', '0.03125', '0.4375'} <= set(Page(page).cells)
    assert 'latency or clock offset' in page
    assert 'probability of one as large if the means are equal' in page


@pytest.mark.slow
def test_write_picks_the_form_by_the_suffix(made, tmp_path):
    verdict, sketches = made(1)
    write(verdict, tmp_path / 'r.HTML', sketches)
    write(verdict, str(tmp_path / 'r.json'))
    assert (tmp_path / 'r.HTML').read_text('utf-8') == html.render(verdict, sketches)
    assert json.loads((tmp_path / 'r.json').read_text('utf-8')) == verdict.to_dict()
    read = verdict_json.read(tmp_path / 'r.json')
    assert read.provenance in html.render(read)
    assert html.render(replace(read, provenance=None)) == html.render(verdict)


@pytest.mark.parametrize('data, words', [
    (b'', 'is not JSON: '), (b'{"schema": ', 'is not JSON: '), (b'[1]', 'must be an object, not '),
    (b'3', 'must be an object, not int'), (b'{}', 'schema = None: must be '),
    (b'\xff\xfe\xfd', 'is not UTF-8'), (b'"\xe9"', 'is not UTF-8'),
    (b'[' * 100_000, 'nested too deeply')])
def test_a_file_that_is_no_verdict_is_named_with_what_is_wrong(tmp_path, data, words):
    path = tmp_path / 'v.json'
    path.write_bytes(data)
    with pytest.raises(ValueError) as told:
        verdict_json.read(path)
    assert str(told.value).startswith(f'{path}: ') and words in str(told.value)


@pytest.mark.parametrize('name', ['r.odt', 'r', 'html'])
def test_an_unknown_suffix_is_refused_and_the_known_ones_are_named(made, tmp_path, name):
    with pytest.raises(ValueError, match=r'must end in \.html or \.json or \.pdf'):
        write(made(0)[0], tmp_path / name)
    assert not (tmp_path / name).exists()


def test_a_doubtful_certificate_is_not_called_met_without_a_word(rng):
    """A sound TS five degrees off."""
    stamps = np.arange(1, 9001) * 10 ** 8
    rs = 100.0 + 30.0 * np.sin(np.arange(9000) / 500.0)
    verdict = analyze(Headings.as_sent(stamps, rs + 5.0 + 0.1 * rng.standard_normal(9000)),
                      Headings.as_sent(stamps, rs + 0.05 * rng.standard_normal(9000)),
                      Settings.from_mapping({'norms': {'sigma_max_deg': 0.2,
                                                       'sigma_ref_max_deg': 0.1}}))
    page = html.render(verdict)
    assert 'sigma_max of the TS: met, but doubtful: see the validity of the comparison' in page
    assert 'COMPLIANT, DOUBTFUL: the mean difference is 5.00 deg' in page


@pytest.mark.slow
def test_the_first_page_shows_the_run_with_the_largest_variance_and_no_figure_stands_twice(made):
    verdict, sketches = made(3)
    page = html.render(replace(verdict, campaign=replace(
        verdict.campaign, worst_variance_run=2)), sketches)
    first, rest = page.split('<nav class="contents">')
    assert 'id="input2-differences"' in first and 'id="input2-differences"' not in rest
    drawn = sum(bool(figure.svg) for k, sketch in enumerate(sketches)
                for figure in draw_figures(sketch, verdict, f'x{k}'))
    assert drawn > 20 and first.count('<figure') == 1 and rest.count('<figure') == drawn - 1


@pytest.mark.slow
def test_the_contents_lead_to_every_section(made):
    page = html.render(*made(1))
    listed = re.findall(r'<li><a href="#(s\d+)">([^<]+)</a>', page)
    assert listed == re.findall(r'<h2 id="(s\d+)">([^<]+)</h2>', page) and len(listed) > 12
    assert listed[0][1] == '1. Identification' and listed[-1][1].startswith('Annex E.')


@pytest.mark.parametrize('stated, cell', [
    ('', '<span class="blank"></span>'), ('drift <left in>', 'drift &lt;left in&gt;')])
def test_the_protocol_has_a_line_for_deviations_and_ends_with_its_id(made, stated, cell):
    verdict = made(1, n=100, trial__deviations=stated)[0]
    page = html.render(verdict)
    events = page[page.index('Events, exclusions'):]
    assert f'deviations from the method</th><td>{cell}</td>' in events
    end = f'End of the protocol of the verdict {html.verdict_id(verdict)}</p>\n</body>'
    assert page.count(end) == 1


def test_the_annexes_apart_are_a_second_file_that_the_first_names(made, tmp_path):
    verdict = made(2, n=100)[0]
    write(verdict, tmp_path / 'p & q.html', annexes_apart=True)
    assert {path.name for path in tmp_path.iterdir()} == {'p & q.html', 'p & q-annexes.html'}
    protocol, annexes = (Path(tmp_path, name).read_text('utf-8')
                         for name in ('p & q.html', 'p & q-annexes.html'))
    assert 'a second file, p &amp; q-annexes.html' in protocol
    for page in (protocol, annexes):
        read = Page(page)
        assert read.faults == [] and len(read.ids) == len({*read.ids})
        assert {link[1:] for link in read.links} <= {*read.ids}
    worst = verdict.campaign.worst_variance_run
    assert f'Budget of run {worst}' in protocol and f'Budget of run {3 - worst}' not in protocol
    assert 'Budget of run 1' in annexes and 'Budget of run 2' in annexes


def test_a_name_in_the_running_head_cannot_leave_its_string(made):
    name = '"; } body { display: none } </style><b>\\'
    page = html.render(made(0, trial__ship=name)[0])
    style = page[page.index('<style>'):page.index('</style>')]
    assert 'display: none' not in style and '<b>' not in style
    assert html._quote_css('a"é 1') == 'a\\22 \\e9 \\20 1'
    assert Page(page).faults == [] and name in Page(page).cells


@pytest.mark.slow
def test_it_says_how_many_figures_are_drawn(made):
    """A terminal shows the time left from that."""
    verdict, sketches = made(2)
    told = []
    html.render(verdict, sketches, told.append)
    done = [int(text.split(' of ')[0]) for text in told]
    whole = 12 * len(sketches)
    assert done == sorted(done) and done[-1] == whole and len(done) >= whole
    assert {text.partition(' of ')[2] for text in told} == {f'{whole} figures drawn'}


@pytest.fixture
def many(made):
    """Return a verdict on 12 runs, of which run 7 alone does not comply, and their sketches."""
    verdict, sketches = made(12, n=200)
    runs = [replace(run, outcome=Outcome.NON_COMPLIANT if run.run == 7 else Outcome.COMPLIANT)
            for run in verdict.runs]
    return replace(verdict, runs=runs), sketches


def test_many_runs_are_listed_the_worst_first_and_have_a_page_each(many, tmp_path):
    html.write(many[0], tmp_path / 'trial.html', many[1])
    page = (tmp_path / 'trial.html').read_text('utf-8')
    assert '11 of 12 runs comply' in page
    links = re.findall(r'href="(trial-runs/run-\d+\.html)"', page)
    assert links[0] == 'trial-runs/run-7.html' and len({*links}) == 12
    assert page.count('<h3>Budget of run ') == 5 and '<h3>Budget of run 7<' in page
    assert {place.name for place in (tmp_path / 'trial-runs').iterdir()} == {
        Path(link).name for link in links}
    for link in links:
        of_run = (tmp_path / link).read_text('utf-8')
        assert 'href="../trial.html"' in of_run and verdict_id(many[0]) in of_run
        assert of_run.count('<h3>Budget of run ') == 1 and of_run.count('-differences"') == 1
        assert 'These are the figures of' not in of_run and 'Annex D' in of_run


def test_the_figures_of_the_worst_runs_alone_stand_in_the_list_of_many(many, tmp_path):
    html.write(many[0], tmp_path / 'trial.html', many[1])
    page = (tmp_path / 'trial.html').read_text('utf-8')
    assert page.count('-differences"') <= 5
    assert 'Each run has a page of its own' in page


def test_ten_runs_stand_in_one_page(made, tmp_path):
    html.write(made(10, n=200)[0], tmp_path / 'trial.html')
    page = (tmp_path / 'trial.html').read_text('utf-8')
    assert page.count('<h3>Budget of run ') == 10 and not (tmp_path / 'trial-runs').exists()


def test_many_runs_on_paper_have_a_list_without_links(many):
    page = html.render(*many)
    assert 'Runs, the worst first' in page and 'run-7.html' not in page
    assert 'The protocol in HTML has a page for each run' in page
