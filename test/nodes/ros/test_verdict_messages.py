# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Verdicts as messages."""

from __future__ import annotations

import json

import numpy as np
from rclpy.serialization import deserialize_message, serialize_message
from std_msgs.msg import String

from heading_intercompare.core.pipeline import Intercomparison
from heading_intercompare.core.records import Headings
from heading_intercompare.core.settings import Settings
from heading_intercompare.nodes.ros.status_messages import ERROR, OK
from heading_intercompare.nodes.ros.verdict_messages import report_message, verdict_message


def sent(message):
    """Return a message as it arrives."""
    return deserialize_message(serialize_message(message), type(message))


def values(one):
    """Return the values of a status as a mapping."""
    return {pair.key: pair.value for pair in one.values}


def test_a_verdict_says_what_was_found_and_why(judged):
    verdict = judged.verdict()
    message = sent(verdict_message(verdict, 10 ** 18))
    whole, *runs = message.status
    assert whole.message == verdict.headline
    assert values(whole)['outcome'] == verdict.outcome.value
    assert values(whole)['runs'] == '2'
    assert [run.message for run in runs] == [run.reason for run in verdict.runs]
    assert float(values(runs[0])['variance_deg2']) == verdict.runs[0].variance_deg2


def test_a_non_compliant_verdict_is_an_error_and_a_compliant_one_is_not():
    settings = {'norms': {'sigma_max_deg': 0.01, 'sigma_ref_max_deg': 0.01}}
    stamps = np.arange(1, 2001) * 10 ** 9
    levels = []
    course_deg = 90.0 + 30.0 * np.sin(np.arange(2000) / 50.0)
    for amplitude_deg in (0.001, 5.0):
        comparison = Intercomparison(Settings.from_mapping(settings))
        noise_deg = np.random.default_rng(1).standard_normal((2, 2000))
        comparison.update(ts=Headings.of(stamps, course_deg + amplitude_deg * noise_deg[0]),
                          rs=Headings.of(stamps, course_deg + 0.001 * noise_deg[1]))
        comparison.finish()
        levels.append(verdict_message(comparison.verdict(), 0).status[0].level)
    assert levels == [OK, ERROR]


def test_a_report_is_the_json_of_the_verdict(judged):
    verdict = judged.verdict()
    report = sent(report_message(verdict))
    assert isinstance(report, String)
    assert json.loads(report.data) == verdict.to_dict()
