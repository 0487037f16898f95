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

"""What a recording lacks, by its own numbers and records, has its rows and binds its verdict."""

from __future__ import annotations

from mcap.writer import Writer
import numpy as np
import pytest
from trials import find_finding

from heading_intercompare import Headings, judge_bags, Settings, Verdict
from heading_intercompare.bags.mcap.chunk_writer import Rows
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.bags.rosbag2.provenance import RECORD
from heading_intercompare.core.records import Losses
from heading_intercompare.messages.heading_messages import encode_imu, IMU
from heading_intercompare.messages.ledger_messages import encode_losses
from heading_intercompare.messages.schemas import shipped_schema
from heading_intercompare.messages.status_messages import STATUS_TYPE

S = 1_000_000_000
STAMPS = 1_400_000_000 * S + np.arange(1, 6001) * (S // 10)
SETTINGS = Settings.from_mapping({
    'norms': {'sigma_max_deg': 0.3, 'sigma_ref_max_deg': 0.1},
    'pairing': {'method': 'interpolate'}, 'risk': {'min_duration_s': 300.0}})


def write(path, kept, *, numbered=True, recording=None, told=()):
    """Write 10 min of both sensors at 10 Hz; of the RS only some messages, with their numbers."""
    rng = np.random.default_rng(5)
    t = STAMPS / 1e9
    ship = 90.0 + 40.0 * np.sin(t / 100.0) + np.sin(2.0 * np.pi * t / 8.0)
    with BagWriter(path) as bag:
        bag.metadata(RECORD, {'version': '0'})
        rows = []
        for topic, sigma, mine in (('/ts/heading', 0.1, np.arange(6000)),
                                   ('/rs/heading', 0.05, kept)):
            bag.add_topic(topic, IMU)
            readings = Headings.of(STAMPS, ship + sigma * rng.standard_normal(6000))[mine]
            rows.append(Rows(topic, encode_imu(readings, 'x'), readings.stamp_ns,
                             sequence=mine + 1 if numbered else 0))
        bag.write_rows(rows)
        for topic, message in told:
            bag.add_topic(topic, STATUS_TYPE)
            bag.write(topic, message, int(STAMPS[-1]))
        if recording:
            bag.metadata('recording', recording)
    return path


def some(n):
    """Return n of the 6000 messages, the first and the last among them."""
    inner = np.random.default_rng(1).choice(np.arange(1, 5999), n - 2, replace=False)
    return np.sort(np.concatenate(([0], inner, [5999])))


def judged(path, **settings):
    """Return the only run of a bag, and its finding on the losses."""
    rule = Settings.from_mapping({**SETTINGS.to_mapping(), **settings})
    run, = judge_bags([path], rule).verdict.runs
    return run, find_finding(run, 'losses')


@pytest.mark.parametrize('kept, effect, outcome', [
    (6000, 'holds', 'compliant'), (5500, 'holds', 'compliant'),
    (3985, 'doubtful', 'compliant'), (2900, 'void', 'indeterminate')])
def test_messages_missing_from_a_bag_bind_its_verdict(tmp_path, kept, effect, outcome):
    """The TS is complete, and the RS is interpolated across the gaps: the pairs lack nothing."""
    run, losses = judged(write(tmp_path / 'bag', some(kept)))
    assert (losses.effect, run.outcome.value) == (effect, outcome)
    assert run.pairing.lost.ts == {}
    assert run.pairing.lost.rs == ({'on_the_way': 6000 - kept} if kept < 6000 else {})
    assert run.pairing.rs_received == kept
    if kept == 3985:
        assert losses.words == '34 % of the RS lost on the way'
        assert 'DOUBTFUL' in run.headline and losses.words in run.headline


def test_a_bag_without_numbers_has_no_such_rows(tmp_path):
    run, losses = judged(write(tmp_path / 'bag', some(3985), numbered=False))
    assert run.pairing.lost.rs == {} and losses.effect == 'holds'


def test_numbers_of_a_program_that_counts_all_topics_together_are_not_believed(tmp_path):
    messages = sorted(BagReader(write(tmp_path / 'bag', some(6000))).messages(),
                      key=lambda message: message.log_time_ns)
    with open(tmp_path / 'other.mcap', 'wb') as file:
        writer = Writer(file)
        writer.start('ros2')
        schema = writer.register_schema(IMU, 'ros2msg', shipped_schema(IMU).text.encode())
        channels = {topic: writer.register_channel(topic, 'cdr', schema)
                    for topic in ('/ts/heading', '/rs/heading')}
        for number, each in enumerate(messages):
            writer.add_message(channels[each.topic], each.log_time_ns, each.data,
                               each.publish_time_ns, number)
        writer.finish()
    run, losses = judged(tmp_path / 'other.mcap')
    assert (run.n, run.pairing.lost.rs, losses.effect) == (6000, {}, 'holds')


def test_a_gap_that_ends_a_run_is_in_no_run(tmp_path):
    """Nobody recorded the RS for 400 of 600 s: two runs of 100 s that lack nothing."""
    kept = np.concatenate((np.arange(1000), np.arange(5000, 6000)))
    verdict = judge_bags([write(tmp_path / 'bag', kept)], SETTINGS).verdict
    assert [run.n for run in verdict.runs] == [1000, 1000]
    for run in verdict.runs:
        assert find_finding(run, 'losses').effect == 'holds'
    assert sum(run.pairing.lost.rs.get('on_the_way', 0) for run in verdict.runs) == 4000


def test_what_the_recorder_could_not_write_at_the_end_is_counted_after_the_run(tmp_path):
    path = write(tmp_path / 'bag', np.arange(5000), recording={
        'not_written./rs/heading': 900, 'lost_on_the_way./rs/heading': 100})
    run, losses = judged(path)
    assert run.pairing.lost.rs == {'on_the_way': 1000} and losses.effect == 'holds'


def test_what_both_numbers_and_recorder_tell_is_counted_once(tmp_path):
    path = write(tmp_path / 'bag', some(5000), recording={
        'not_written./rs/heading': 900, 'lost_on_the_way./rs/heading': 100})
    assert judged(path)[0].pairing.lost.rs == {'on_the_way': 1000}


def test_the_bursts_that_a_driver_told_are_in_the_verdict(tmp_path):
    gap = Losses.of([STAMPS[3000]], [STAMPS[2999]], [1500])
    path = write(tmp_path / 'bag', some(6000), told=[
        ('/rs/heading/lost', encode_losses({'rejected.burst': gap}))])
    run, losses = judged(path)
    assert (losses.effect, losses.words) == ('doubtful', '20 % of the RS rejected')
    assert run.pairing.lost.rs == {} and run.pairing.rejected.rs == {'burst': 1500}
    assert run.pairing.rs_received == 7500


@pytest.mark.parametrize('kept, effect, words', [
    (np.arange(6000), 'holds', ''),
    (np.flatnonzero(np.arange(6000) % 5 > 0), 'doubtful', '20 % of the RS lost at the source')])
def test_the_datagrams_that_a_driver_told_count_where_readings_are_missing(
        tmp_path, kept, effect, words):
    """The kernel dropped 1500 datagrams; 1200 readings of the RS are missing, or none."""
    gap = Losses.of([STAMPS[3001]], [STAMPS[2999]], [1500])
    path = write(tmp_path / 'bag', kept, numbered=False, told=[
        ('/rs/heading/lost', encode_losses({'lost.at_source': gap}))])
    run, losses = judged(path)
    assert (losses.effect, losses.words) == (effect, words)
    assert run.pairing.lost.rs == {'at_source': 1500}
    assert run.pairing.rs_received == kept.size


def test_a_damaged_message_of_losses_is_named_and_stops_nothing(tmp_path):
    path = write(tmp_path / 'bag', some(6000), told=[('/rs/heading/lost', b'\0\1\0\0')])
    found = judge_bags([path], SETTINGS)
    assert any('1 message about losses cannot be read; the first: topic /rs/heading/lost' in note
               for note in found.notes)
    assert found.verdict.runs[0].pairing.rs_received == 6000


def test_rejected_readings_of_more_than_one_in_a_hundred_are_said(tmp_path):
    """60 of 6000 are 1 %, and nothing to say."""
    for n, said in ((60, False), (61, True)):
        gap = Losses.of([STAMPS[3000]], [STAMPS[2999]], [n])
        path = write(tmp_path / f'bag_{n}', np.delete(np.arange(6000), np.s_[50:50 + n]), told=[
            ('/rs/heading/lost', encode_losses({'rejected.burst': gap}))])
        run, losses = judged(path)
        words = '1 % of the RS readings were rejected: 61 burst'
        assert (words in run.warnings) == said and losses.effect == 'holds'


def test_an_aligned_run_keeps_its_losses(tmp_path):
    run, losses = judged(write(tmp_path / 'bag', some(3985)), **{'alignment.skew': 'apply'})
    assert any(words.startswith('aligned') for words in run.warnings)
    assert losses.effect == 'doubtful'
    assert run.pairing.lost.rs['on_the_way'] == pytest.approx(2015, abs=50)


@pytest.mark.parametrize('helpers', [0, 2])
def test_the_rows_are_the_same_however_the_bag_is_decoded(tmp_path, helpers, monkeypatch):
    monkeypatch.setattr('heading_intercompare.bags.parallel.decode_workers._FEWEST', 1)
    monkeypatch.setattr('heading_intercompare.bags.mcap.mcap_file._BLOCK_BYTES', 20_000)
    kept = some(3985)
    reader = BagReader(write(tmp_path / 'bag', kept))
    found = []
    for _ in reader.headings({'ts/heading': 'enu', 'rs/heading': 'enu'}, helpers,
                             lambda *told: found.append(told)):
        pass
    assert {told[:2] for told in found} == {('rs/heading', 'lost.on_the_way')}
    rows = Losses.concatenate(losses for _, _, losses in found)
    gaps = np.flatnonzero(np.diff(kept) > 1)
    assert rows == Losses.of(STAMPS[kept[gaps + 1]], STAMPS[kept[gaps]],
                             np.diff(kept)[gaps] - 1)


def test_a_recording_that_lacks_messages_says_so_in_its_ledger(tmp_path):
    whole = judge_bags([write(tmp_path / 'whole', some(6000))], SETTINGS).verdict
    assert (whole.ledger_complete, whole.ledger_problems) == (True, ())
    path = write(tmp_path / 'bag', np.arange(5000), recording={'not_written./rs/heading': 900})
    found = judge_bags([path], SETTINGS)
    assert found.verdict.ledger_complete is False
    assert found.verdict.ledger_problems == (f'{path}: 900 messages received but not written',)
    assert found.notes == found.verdict.ledger_problems
    again = Verdict.from_dict(found.verdict.to_dict())
    assert again.to_dict() == found.verdict.to_dict()
    for words in ('the ledger is not complete', '900 messages received but not written'):
        assert words in str(found.verdict) and words in found.verdict._repr_html_()


def test_what_was_judged_live_and_is_not_in_the_bag_is_in_a_note(tmp_path):
    path = write(tmp_path / 'bag', np.arange(5000, 6000), recording={
        'missed_at_first./rs/heading': 40})
    judged = judge_bags([path], SETTINGS)
    assert judged.notes == (f'{path}: 40 messages judged live came before the first one of their '
                            'publisher that the recorder heard, and count as lost here',)
    assert judged.verdict.ledger_complete
    assert judged.verdict.runs[0].pairing.lost.rs == {'before_start': 5000}


def test_what_was_sent_before_the_recording_began_has_a_row_and_binds_nothing(tmp_path):
    run, finding = judged(write(tmp_path / 'bag', np.arange(5000, 6000)))
    assert run.pairing.lost.rs == {'before_start': 5000} and run.pairing.lost.ts == {}
    assert run.pairing.rs_received == 1000
    assert finding.effect == 'holds' and 'of the RS rejected 0 %' in finding.evidence


def test_a_bag_that_goes_on_with_another_one_does_not_count_what_that_one_has(tmp_path):
    with BagWriter(tmp_path / 'bag') as bag:
        bag.metadata(RECORD, {'version': '0', 'continues': 'before'})
        for topic in ('/ts/heading', '/rs/heading'):
            bag.add_topic(topic, IMU)
            readings = Headings.of(STAMPS, np.full(6000, 90.0))[1000:]
            bag.write_rows([Rows(topic, encode_imu(readings, 'x'), readings.stamp_ns,
                                 sequence=np.arange(1001, 6001))])
    run, _ = judged(tmp_path / 'bag')
    assert run.pairing.lost.ts == run.pairing.lost.rs == {}
