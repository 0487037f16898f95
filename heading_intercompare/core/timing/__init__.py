# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Time: the skew between the sensors, drifting clocks, interpolation."""

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'bracketing_readings': ('pairs_per_reading', 'readings_per_pair'),
    'clock_drift': ('ClockDrift', 'estimate_clock_drift'),
    'heading_track': ('Track',),
    'interpolation_error': ('estimate_interpolation_error', 'InterpolationError'),
    'realignment': ('realign',),
    'skew_instrument': ('common_tracks',),
    'skew_scan': ('Scan', 'scan_skew'),
    'skew_search': ('coarser',),
    'stamp_steps': ('measure_stamp_steps', 'StampSteps'),
    'time_skew': ('estimate_skew', 'Skew'),
})
