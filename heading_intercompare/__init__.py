# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""
Decide, from recorded data, whether a heading sensor meets its accuracy norm.

A tested sensor (TS) is compared with a reference sensor (RS) of the same ship. Start with
`analyze`; the settings are those of the configuration file, by name.
"""

from heading_intercompare.core.diagnostics.three_cornered_hat import three_cornered_hat
from heading_intercompare.core.offline import analyze
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.pairing.pairer import pair, Pairer
from heading_intercompare.core.pipeline import Compliance, Intercomparison, join
from heading_intercompare.core.records import Differences, Headings, Pairs
from heading_intercompare.core.settings import Settings, SettingsError
from heading_intercompare.core.verdict.verdict_document import RunVerdict, Verdict
from heading_intercompare.core.version import VERSION as __version__

__all__ = ['analyze', 'Compliance', 'Differences', 'Headings', 'Intercomparison', 'join',
           'Outcome', 'pair', 'Pairer', 'Pairs', 'RunVerdict', 'Settings', 'SettingsError',
           'three_cornered_hat', 'Verdict', '__version__']
