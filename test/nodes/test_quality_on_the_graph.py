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

"""What sensors say of themselves on the running graph: one verdict live, replayed, recorded."""

from __future__ import annotations

from checksums import with_checksum
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TwistStamped
from nodes.inside_nodes import judge_of
from nodes.killed import kill
from nodes.lines import free_port
from nodes.ros_nodes import NORMS
import numpy as np
import pytest
from rclpy.serialization import serialize_message
from sensor_msgs.msg import Imu

from heading_intercompare.app.analysis import judge_bags
from heading_intercompare.app.logs.trial_logs import judge_logs
from heading_intercompare.cli import main
from heading_intercompare.core.records import Pairs, Quality
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.verdict.compare_verdicts import find_differences
from heading_intercompare.drivers.framing import Received
from heading_intercompare.drivers.settings import DriverSettings
from heading_intercompare.messages.heading_messages import pair_messages
from heading_intercompare.messages.quality_messages import decode_quality, encode_quality
from heading_intercompare.nodes.compliance import Compliance
from heading_intercompare.nodes.graph import intercompare, Source
from heading_intercompare.nodes.interface import qos
from heading_intercompare.nodes.nmea_driver import NmeaDriver
from heading_intercompare.nodes.replayer import Replayer

S = 10 ** 9
START_NS = 1_406_894_400 * S
N = 400


def write_logs(folder, rng):
    """Write the logs of a gyrocompass, and of an INS that is without GNSS for a quarter."""
    second = np.arange(N)
    ship = 220.0 + 10.0 * np.sin(second / 40.0)
    is_poor = (second >= 200) & (second < 300)
    headings = {'gyro': ship + 0.12 * rng.standard_normal(N),
                'ins': ship + 0.02 * rng.standard_normal(N)}
    sentences = {
        'gyro': [f'HEHDT,{heading:.2f},T' for heading in headings['gyro']],
        'ins': [f'PASHR,12{at // 60:02d}{at % 60:02d}.00,{heading:.2f},T,0.1,0.2,0.0,0.01,0.01,'
                + (f'0.40{at % 10},0,1' if poor else f'0.02{at % 10},2,1')
                for at, heading, poor in zip(second, headings['ins'], is_poor)]}
    paths = []
    for name, texts in sentences.items():
        paths.append(folder / f'{name}.log')
        paths[-1].write_text(''.join(
            f'2014-08-01T12:{at // 60:02d}:{at % 60:02d}.000000Z {with_checksum(text)}\n'
            for at, text in enumerate(texts)))
    return [str(path) for path in paths]


def replay(bag, **kwargs):
    return intercompare([Source(Replayer, 'replayer', {'bag': str(bag), 'rate': 0.0})],
                        NORMS | kwargs.pop('more', {}), private=True, **kwargs)


@pytest.mark.slow
@pytest.mark.parametrize('more', [{}, {'runs.every_h': 0.05}])
def test_a_replay_gives_the_verdict_of_the_bag_and_its_recording_too(tmp_path, rng, more):
    """Of a single run, and of runs that the clock ends while the readings come."""
    bag, copy = tmp_path / 'bag', tmp_path / 'copy'
    assert main(['import', *write_logs(tmp_path, rng), '-o', str(bag), '--quiet']) == 0
    analyzed = judge_bags([bag], Settings.from_mapping(NORMS | more)).verdict
    assert sum(run.quality.rs.n_reduced for run in analyzed.runs) == 100
    replayed = replay(bag, more=more, output=str(copy))
    recorded = judge_bags([copy], Settings.from_mapping(NORMS | more)).verdict
    for verdict in (replayed, recorded):
        assert [*find_differences(analyzed, verdict)] == []
        assert [run.quality for run in verdict.runs] == [run.quality for run in analyzed.runs]


@pytest.mark.slow
def test_drivers_tell_what_their_sensors_say(tmp_path, rng):
    """The verdict live is that of its recording, and says of the sensors what the logs say."""
    logs = write_logs(tmp_path, rng)
    live = intercompare([Source(NmeaDriver, f'{role}_driver', {
        'source': f'file:{log}', 'topic': f'{role}/heading', 'speed': 20.0})
        for role, log in zip(('ts', 'rs'), logs)], NORMS, private=True,
        output=str(tmp_path / 'bag'))
    settings = Settings.from_mapping(NORMS)
    recorded = judge_bags([tmp_path / 'bag'], settings).verdict
    imported = judge_logs(dict(zip(('ts', 'rs'), logs)), settings,
                          dict.fromkeys(('ts', 'rs'), DriverSettings())).verdict
    run, = live.runs
    assert run.quality.rs.n == N and run.quality.rs.flags == {'normal': 300, 'no GNSS aiding': 100}
    assert run.quality.ts is None and run.quality.rs.reduced_share == 0.25
    assert [*find_differences(live, recorded)] == []
    assert recorded.runs[0].quality == imported.runs[0].quality == run.quality
    assert live.headline == imported.headline


def test_a_driver_publishes_flag_and_claim_of_each_reading_of_a_line(ros):
    """Also of the readings that it held while it listened; the claim stands in the covariance."""
    said = ros.listen(DiagnosticArray, 'rs/heading/quality', qos.HEADINGS_KEPT)
    headings = ros.listen(Imu, 'rs/heading', qos.HEADINGS_KEPT)
    port = free_port()
    node = ros.ours(NmeaDriver, name='rs_driver', topic='rs/heading', subscribers=0,
                    source=f'udp://127.0.0.1:{port}', learn_s=1.0)
    claims = ['0.020', '0.020', '0.400', '', '0.020']
    for at, claim in enumerate(claims):
        text = with_checksum(f'PASHR,12000{at}.00,90.00,T,0.1,0.2,0.0,0.01,0.01,{claim},2,1')
        node._take(Received(f'{text}\r\n'.encode(), START_NS + at * S // 2))
    node._pass_on()
    ros.spin_until(lambda: len(headings) == len(claims) and sum(
        len(message.status) for message in said) >= len(claims))
    rows = Quality.concatenate([decode_quality(serialize_message(message)) for message in said])
    flag, stated_deg = rows.match(START_NS + np.arange(len(claims)) * S // 2)
    wanted_deg = [float(claim or 'nan') for claim in claims]
    assert flag.tolist() == [1] * len(claims)
    assert stated_deg.tolist() == pytest.approx(wanted_deg, nan_ok=True)
    variances = [message.orientation_covariance[8] for message in headings]
    assert np.degrees(np.sqrt(variances)) == pytest.approx(np.nan_to_num(wanted_deg))


def test_a_driver_of_a_sensor_that_says_nothing_publishes_nothing_of_it(ros):
    said = ros.listen(DiagnosticArray, 'ts/heading/quality', qos.HEADINGS_KEPT)
    headings = ros.listen(Imu, 'ts/heading', qos.HEADINGS_KEPT)
    node = ros.ours(NmeaDriver, name='ts_driver', topic='ts/heading', subscribers=0,
                    source=f'udp://127.0.0.1:{free_port()}', learn_s=0.0)
    node._take(Received(f'{with_checksum("HEHDT,90.00,T")}\r\n'.encode(), START_NS))
    node._pass_on()
    ros.spin_until(lambda: len(headings) == 1)
    assert said == [] and headings[0].orientation_covariance[8] == 0.0


class Sensors:
    """Publishers of pairs, and of what the RS says, as a test plays them."""

    def __init__(self, ros, **settings):
        self.ros, self.rng, self.settings = ros, np.random.default_rng(4), settings
        self.pairs = ros.plain.create_publisher(TwistStamped, 'pairs', qos.PAIRS)
        self.quality = ros.plain.create_publisher(DiagnosticArray, 'rs/heading/quality',
                                                  qos.HEADINGS_OUT)
        self.start()

    def start(self):
        self.node = self.ros.ours(Compliance, name='compliance', **self.settings)
        self.ros.spin_until(lambda: self.pairs.get_subscription_count() == 1
                            and self.quality.get_subscription_count() == 1)

    def play(self, seconds, since=0):
        """Publish what the RS says and then the pairs; wait until they are taken."""
        stamps = START_NS + np.arange(since, seconds) * S
        flag = np.where(np.arange(since, seconds) % 4 == 0, 5, 1)
        self.quality.publish(encode_quality(Quality.of(stamps, np.full(stamps.size, 0.1), flag)))
        zeros = np.zeros(stamps.size, int)
        rs = 40.0 + self.rng.normal(0.0, 0.03, stamps.size)
        for message in pair_messages(Pairs.of(
                stamps, rs + self.rng.normal(0.0, 0.05, stamps.size), rs, zeros, zeros + 1.0),
                '1'):
            self.pairs.publish(message)
        self.ros.spin_until(lambda: judge_of(self.node).newest_ns == stamps[-1])


def test_a_node_that_is_killed_goes_on_with_what_the_sensors_said(ros, tmp_path):
    """The first rows of the run are in its journal alone: their publisher has ended by then."""
    sensors = Sensors(ros, report_dir=str(tmp_path), runs__min_duration_s=0.0)
    sensors.play(300)
    ros.spin_until(lambda: b'"sensor":"rs"' in (tmp_path / 'compliance.journal').read_bytes())
    sensors.node.journal._journal._journal.flush(1e9)
    kill(ros, sensors.node, sensors.node.journal)
    ros.plain.destroy_publisher(sensors.quality)
    sensors.quality = ros.plain.create_publisher(DiagnosticArray, 'rs/heading/quality',
                                                 qos.HEADINGS_OUT)
    sensors.start()
    sensors.play(600, since=300)
    ros.end(sensors.node)
    run, = sensors.node.verdict.runs
    assert run.quality.rs.n == 600 and run.quality.rs.n_reduced == 150
    assert run.quality.rs.flags == {'normal': 450, 'no GNSS aiding': 150}


def test_a_message_that_cannot_be_read_is_refused_and_counted(ros):
    sensors = Sensors(ros, runs__min_duration_s=0.0)
    sensors.quality.publish(encode_quality(Quality.of([START_NS], [0.1], [1]))[:40])
    _, quality = sensors.node._beside
    sensors.play(200)
    ros.spin_until(lambda: max(intake.refused for _, intake in quality._intakes) == 1)
    ros.end(sensors.node)
    run, = sensors.node.verdict.runs
    assert run.quality.rs.n == 200
