# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Simulated ships and heading sensors."""

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'faults': ('FAULTS',),
    'plans': ('Event', 'EVENTS', 'parse_events', 'parse_fixed'),
    'random_noise': ('Markov', 'open_stream'),
    'sensor_presets': ('errors_of',),
    'sensors': ('Readings',),
    'settings': ('Ahrs', 'Errors', 'Scenario', 'Sensor'),
    'simulator': ('SimulatedChunk', 'Simulation', 'Trial'),
})
