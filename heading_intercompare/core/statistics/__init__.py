# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Statistics of correlated series: what an estimate is worth."""

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'autocorrelation': ('autocorrelate', 'compute_allan_deviation', 'CorrelationTimes',
                        'estimate_correlation_times', 'sokal_times'),
    'blocking': ('block_means', 'block_size', 'student_95', 'sum_covariance'),
    'cells': ('Cells',),
    'confidence_bounds': ('confidence', 'duration_factor', 'mean_confidence', 'rate_lower',
                          'rate_upper'),
    'drift': ('Detrended', 'drift_left_deg2', 'fit_slope', 'Order', 'remove_polynomial',
              'select_order', 'Slope'),
    'ergodicity': ('examine_homogeneity', 'Homogeneity', 'RunFigures'),
    'moments': ('count_outside', 'exact_sum', 'Moments', 'UNIT'),
    'normality': ('examine_normality', 'Normality', 'Shape'),
    'resolution': ('find_resolution', 'Resolution'),
    'stationarity': ('examine_stationarity', 'Stationarity'),
    'variance_uncertainty': ('between_runs', 'estimate_spread', 'lower_bound', 'MEAN_DOF', 'pool',
                             'Spread', 'upper_bound'),
    'warm_up': ('fit_warm_up', 'mser5', 'WarmUp'),
})
