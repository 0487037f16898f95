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

"""The motion of the ship on the running graph: one verdict live, replayed, recorded, imported."""

from __future__ import annotations

from datetime import datetime, timezone
from functools import partial, reduce
from operator import xor
from pathlib import Path
import sys

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TwistStamped
from nodes.inside_nodes import judge_of, judgement_of
from nodes.killed import kill
from nodes.lines import free_port
from nodes.rclpy_objects import heading_messages
from nodes.ros_nodes import NORMS
import numpy as np
import pytest
from sensor_msgs.msg import Imu
from std_msgs.msg import String

from heading_intercompare.app.analysis import judge_bags
from heading_intercompare.app.logs.trial_logs import judge_logs
from heading_intercompare.core.records import Headings, KNOT_M_S, Motion, Pairs
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.verdict.compare_verdicts import find_differences
from heading_intercompare.drivers.settings import DriverError, DriverSettings
from heading_intercompare.messages.heading_messages import pair_messages
from heading_intercompare.messages.motion.motion_messages import split_motion
from heading_intercompare.nodes.compliance import Compliance
from heading_intercompare.nodes.graph import intercompare, Source
from heading_intercompare.nodes.interface import qos
from heading_intercompare.nodes.motion_driver import MotionDriver
from heading_intercompare.nodes.nmea_driver import NmeaDriver
from heading_intercompare.nodes.replayer import Replayer
from heading_intercompare.nodes.synchronizer import Synchronizer

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / 'core' / 'motion'))

from sailing import sail, START_NS  # noqa: E402

S = 10 ** 9


def line(stamp_ns, body):
    """Return a line of a log: its stamp, a sentence."""
    at = datetime.fromtimestamp(stamp_ns / S, timezone.utc)
    return f'{at:%Y-%m-%dT%H:%M:%S.%fZ} ${body}*{reduce(xor, body.encode(), 0):02X}\r\n'


def write_logs(folder, *, off_deg=180.0, seconds=300):
    """Write the logs of a TS with a rate of turn, an RS, and a receiver with courses."""
    voyage, rng = sail(2, duration_s=float(seconds)), np.random.default_rng(2)
    ts, rs = voyage.sensors(rng)
    logs = {'ts': [], 'rs': [], 'gps': []}
    for role, degrees in (('ts', ts + off_deg), ('rs', rs)):
        logs[role] = [(stamp, line(stamp, f'HEHDT,{heading % 360.0:.3f},T')) for stamp, heading
                      in zip(voyage.stamp_ns.tolist(), degrees.tolist())]
    # A little after the headings, so that the order of the lines is plain.
    courses = voyage.courses
    stamps = (courses.stamp_ns + 10 ** 7).tolist()
    for stamp, knots, course in zip(stamps, courses.speed_kn, courses.course_deg % 360.0):
        logs['gps'].append((stamp, line(stamp, f'GPVTG,{course:.1f},T,,M,{knots:.1f},N,,K,A')))
    for stamp, rate in zip(stamps, voyage.rates.rate_deg_s):
        logs['ts'].append((stamp, line(stamp, f'HEROT,{60 * rate:.1f},A')))
    paths = {}
    for name, rows in logs.items():
        paths[name] = folder / f'{name}.log'
        paths[name].write_text(''.join(text for _, text in sorted(rows)))
    return {name: str(path) for name, path in paths.items()}


def play(logs, **kwargs):
    """Run the graph on some logs as fast as they are taken; return the verdict."""
    sources = [Source(NmeaDriver, f'{role}_driver', {
        'source': f'file:{logs[role]}', 'topic': f'{role}/heading', 'speed': 20.0,
        'motion': 'gps' not in logs}) for role in ('ts', 'rs')]
    if 'gps' in logs:
        sources.append(Source(MotionDriver, 'motion_driver',
                              {'source': f'file:{logs["gps"]}', 'speed': 20.0}))
    return intercompare(sources, NORMS, private=True, **kwargs)


@pytest.mark.slow
@pytest.mark.parametrize('own', [True, False])
def test_live_replayed_recorded_and_imported_verdicts_are_one(tmp_path, own):
    """The TS is mounted backwards; the courses come from a receiver, or the log of the RS."""
    logs = write_logs(tmp_path)
    if not own:
        both = sorted(Path(logs['rs']).read_text().splitlines(True)
                      + Path(logs['gps']).read_text().splitlines(True))
        Path(logs['rs']).write_text(''.join(both))
    given = logs.pop('gps')
    live = play({**logs, **({'gps': given} if own else {})}, output=str(tmp_path / 'bag'))
    (run,) = live.runs
    assert run.motion.whose == 'ts' and run.motion.n_velocities > 270
    # The driver of the TS tells the rate of turn, which no other source does.
    assert (run.motion.n_rates > 270) is not own
    settings = Settings.from_mapping(NORMS)
    recorded = judge_bags([tmp_path / 'bag'], settings).verdict
    replayed = intercompare([Source(Replayer, 'replayer', {'bag': str(tmp_path / 'bag'),
                                                           'rate': 0.0})],
                            NORMS, private=True)
    drivers = dict.fromkeys(('ts', 'rs', 'motion'), DriverSettings())
    imported = judge_logs(logs, settings, drivers, motion=given if own else None)
    for other in (recorded, replayed, imported.verdict):
        # A mean of 180 deg leaves few digits of a skewness.
        assert [one for one in find_differences(live, other) if 'skewness' not in one
                and 'kurtosis' not in one] == []


def rows(seconds, course_deg=40.0, *, since=0):
    """Return a course a second at 10 knots."""
    stamps = START_NS + np.arange(since, seconds) * S
    return Motion.of_courses(stamps, np.full(stamps.size, course_deg), np.full(stamps.size, 10.0))


def pairs(seconds, rng, *, since=0, heading_deg=40.0):
    stamps = START_NS + np.arange(since, seconds) * S
    zeros = np.zeros(stamps.size, int)
    rs = heading_deg + rng.normal(0.0, 0.03, stamps.size)
    return Pairs.of(stamps, rs + rng.normal(0.0, 0.05, stamps.size), rs, zeros, zeros + 1.0)


class Ship:
    """Publishers of the pairs and of the course, as a test plays them."""

    def __init__(self, ros, **settings):
        self.ros, self.rng = ros, np.random.default_rng(4)
        self.alarms = ros.listen(DiagnosticArray, 'compliance/alarms', qos.STATE_IN)
        self.pairs = ros.plain.create_publisher(TwistStamped, 'pairs', qos.PAIRS)
        self.course = ros.plain.create_publisher(TwistStamped, 'ship/velocity', qos.HEADINGS_OUT)
        self.settings = settings
        self.start()

    def start(self):
        self.node = self.ros.ours(Compliance, name='compliance', **self.settings)
        self.ros.spin_until(lambda: self.pairs.get_subscription_count() == 1
                            and self.course.get_subscription_count() == 1)

    def play(self, seconds, since=0, **kwargs):
        """Publish courses and pairs of some seconds, and wait until they are taken."""
        for message in split_motion(rows(seconds, since=since), 'velocity', 'ship'):
            self.course.publish(message)
        for message in pair_messages(pairs(seconds, self.rng, since=since, **kwargs), '1'):
            self.pairs.publish(message)
        # Not their number: what a publisher sends again to a new node counts in it, too.
        last_ns = START_NS + (seconds - 1) * S
        self.ros.spin_until(lambda: judge_of(self.node).newest_ns == last_ns)

    def state(self, name):
        """Return state and words of an alarm as last told."""
        for message in reversed(self.alarms):
            for status in message.status:
                if status.name.endswith(f': {name}'):
                    return {pair.key: pair.value for pair in status.values}['state'], \
                        status.message
        return None


def test_a_heading_against_the_motion_is_an_alarm_while_it_happens(ros):
    ship = Ship(ros)
    ship.play(240)
    judgement_of(ship.node).alarms.look()
    assert judgement_of(ship.node).alarms.panel['motion'].state == 'normal'
    ship.play(480, since=240, heading_deg=220.0)
    judgement_of(ship.node).alarms.look()
    ros.spin_until(lambda: (ship.state('motion') or [''])[0] == 'active_unacknowledged')
    assert ship.state('motion')[1] == ('TS and RS both point 180 deg off the course over ground '
                                       '(mounted backwards, or the ship goes astern)')
    acknowledge = ros.plain.create_publisher(String, 'compliance/acknowledge', qos.ACKNOWLEDGE)
    ros.spin_until(lambda: acknowledge.get_subscription_count() == 1)
    acknowledge.publish(String(data='motion'))
    ros.spin_until(lambda: ship.state('motion')[0] == 'active_acknowledged')
    ship.play(800, since=480)
    judgement_of(ship.node).alarms.look()
    ros.spin_until(lambda: ship.state('motion')[0] == 'normal')


def test_a_compliance_node_that_is_killed_goes_on_with_the_motion_of_its_run(ros, tmp_path):
    """Publishers send their last messages again, which must not count twice."""
    ship = Ship(ros, report_dir=str(tmp_path), runs__min_duration_s=0.0)
    ship.play(300)
    ros.spin_until(lambda: b'"velocity"' in (tmp_path / 'compliance.journal').read_bytes())
    ship.node.journal._journal._journal.flush(1e9)
    killed = ship.node
    killed.journal._journal._journal._syncing.close()
    killed.journal._journal._journal.close(remove=False)
    ros.executor.remove_node(killed)
    ros.nodes.remove(killed)
    killed.destroy_node()
    ship.start()
    assert judge_of(ship.node).run_start_ns == START_NS
    ship.play(600, since=300)
    ros.end(ship.node)
    (run,) = ship.node.verdict.runs
    assert run.motion.n_velocities == 600 and run.motion.kind == 'agrees'
    assert not any('motion' in problem for problem in ship.node.verdict.ledger_problems)


def test_motion_after_the_end_of_its_run_is_counted_and_said(ros):
    ship = Ship(ros, runs__min_duration_s=0.0, runs__every_h=0.05)
    late = rows(100, since=40)
    ship.play(40)
    first_ns = judge_of(ship.node).run_start_ns
    end = int(np.ceil((first_ns - START_NS) / S)) + 400
    ship.play(end, since=40)
    assert judge_of(ship.node).finished_runs >= 1
    for message in split_motion(late, 'velocity', 'ship'):
        ship.course.publish(message)
    ros.spin_until(lambda: judge_of(ship.node).motion.late == 60)
    ros.end(ship.node)
    assert ('60 messages of the motion of the ship came after their run was judged'
            in ship.node.verdict.ledger_problems)


def test_only_one_driver_publishes_what_several_hear(ros):
    """The driver of the RS comes first; that of the TS leaves the same sentences out."""
    heard = ros.listen(TwistStamped, 'ship/velocity', qos.HEADINGS_KEPT)
    nodes = {}
    for role in ('ts', 'rs'):
        nodes[role] = ros.ours(NmeaDriver, name=f'{role}_driver', topic=f'{role}/heading',
                               source=f'udp://127.0.0.1:{free_port()}', learn_s=0.0)
        nodes[role]._motion.feed((line(START_NS, 'GPVTG,90.0,T,,M,10.0,N,,K,A').partition(' ')[2]
                                  .encode(), START_NS))
    ros.spin_until(lambda: len(heard) == 1)
    sender = nodes['ts']._motion._sender
    ros.spin_until(lambda: sender.left_out == 1)
    assert nodes['rs']._motion.n_published == 1 and nodes['ts']._motion.n_published == 0
    assert heard[0].twist.linear.x == pytest.approx(10 * KNOT_M_S)


def test_a_driver_takes_over_when_the_other_one_ends(ros):
    heard = ros.listen(TwistStamped, 'ship/velocity', qos.HEADINGS_KEPT)
    told = line(START_NS, 'GPVTG,90.0,T,,M,10.0,N,,K,A').partition(' ')[2].encode()
    rs, ts = (ros.ours(NmeaDriver, name=f'{role}_driver', source=f'udp://127.0.0.1:{free_port()}',
                       topic=f'{role}/heading', learn_s=0.0) for role in ('rs', 'ts'))
    rs._motion.feed((told, START_NS))
    ros.spin_until(lambda: len(heard) == 1)
    ros.end(rs)
    ts._motion.feed((told, START_NS + S))
    ros.spin_until(lambda: len(heard) == 2)


def join(ros, **values):
    """Return the synchronizer of a process that pairs and judges."""
    judge = ros.ours(partial(Compliance, True), **values)
    return ros.ours(partial(Synchronizer, judge), sensors=values['sensors'], subscribers=0)


def test_the_motion_also_counts_for_the_pairs_without_the_reference(ros):
    node = join(ros, sensors='a sigma_max_deg=0.2; b sigma_max_deg=0.2; c sigma_max_deg=0.1 rs')
    course = ros.plain.create_publisher(TwistStamped, 'ship/velocity', qos.HEADINGS_OUT)
    ros.spin_until(lambda: course.get_subscription_count() == 1)
    for message in split_motion(rows(30), 'velocity', 'ship'):
        course.publish(message)
    pairs = node.judge.comparison.pairs
    assert len(pairs) == 3
    ros.spin_until(lambda: all(pair.compliance.motion.rows is not None
                               and len(pair.compliance.motion.rows) == 30
                               for pair in pairs.values()))


def test_a_comparison_that_is_killed_goes_on_with_the_motion_of_its_runs(ros, tmp_path):
    """Publishers send their last messages again, which must not count twice."""
    course = ros.plain.create_publisher(TwistStamped, 'ship/velocity', qos.HEADINGS_OUT)
    publishers = [ros.plain.create_publisher(Imu, f'{name}/heading', qos.HEADINGS_OUT)
                  for name in 'ab']

    def start():
        node = join(ros, sensors='a sigma_max_deg=0.2; b sigma_max_deg=0.2',
                    report_dir=str(tmp_path))
        ros.spin_until(lambda: all(publisher.get_subscription_count() == 1
                                   for publisher in (course, *publishers)))
        return node, node.judge.comparison.others['a', 'b'].compliance

    def play(seconds, since=0):
        for message in split_motion(rows(seconds, since=since), 'velocity', 'ship'):
            course.publish(message)
        stamps = START_NS + np.arange(since, seconds) * S
        for message in heading_messages(Headings.of(stamps, np.full(stamps.size, 40.0)), 'x'):
            for publisher in publishers:
                publisher.publish(message)
        ros.spin_until(lambda: compliance.motion.rows is not None
                       and len(compliance.motion.rows) == seconds
                       and (compliance.newest_ns or 0) == stamps[-2])
    node, compliance = start()
    play(300)
    ros.spin_until(lambda: b'"velocity"' in (tmp_path / 'compliance.journal').read_bytes())
    kill(ros, node)
    kill(ros, node.judge, node.judge.journal)
    node, compliance = start()
    assert compliance.run_start_ns == START_NS and len(compliance.motion.rows) == 300
    play(600, since=300)
    ros.end(node, node.judge)
    run, = node.judge.comparison.others['a', 'b'].results()
    assert run.verdict.n == 600
    assert run.verdict.motion.n_velocities == 600 and run.verdict.motion.kind == 'agrees'


def test_a_log_without_motion_is_refused_in_one_line(ros, tmp_path):
    path = tmp_path / 'gyro.log'
    path.write_text(line(START_NS, 'HEHDT,10.0,T'))
    with pytest.raises(DriverError, match='gyro.log: has no motion of the ship: no VTG'):
        ros.ours(MotionDriver, source=f'file:{path}')


def test_a_driver_that_is_told_to_publishes_no_motion(ros):
    node = ros.ours(NmeaDriver, source=f'udp://127.0.0.1:{free_port()}', learn_s=0.0, motion=False)
    told = line(START_NS, 'GPVTG,90.0,T,,M,10.0,N,,K,A').partition(' ')[2].encode()
    node._motion.feed((told, START_NS))
    node._motion.flush()
    assert node._motion.n_published == 0 and node._motion.publishers == []
