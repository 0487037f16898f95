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

"""Statistics of correlated series: how good an estimate is."""

from typing import TYPE_CHECKING

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

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .autocorrelation import (
        autocorrelate as autocorrelate,
        compute_allan_deviation as compute_allan_deviation,
        CorrelationTimes as CorrelationTimes,
        estimate_correlation_times as estimate_correlation_times,
        sokal_times as sokal_times,
    )
    from .blocking import (
        block_means as block_means,
        block_size as block_size,
        student_95 as student_95,
        sum_covariance as sum_covariance,
    )
    from .cells import Cells as Cells
    from .confidence_bounds import (
        confidence as confidence,
        duration_factor as duration_factor,
        mean_confidence as mean_confidence,
        rate_lower as rate_lower,
        rate_upper as rate_upper,
    )
    from .drift import (
        Detrended as Detrended,
        drift_left_deg2 as drift_left_deg2,
        fit_slope as fit_slope,
        Order as Order,
        remove_polynomial as remove_polynomial,
        select_order as select_order,
        Slope as Slope,
    )
    from .ergodicity import (
        examine_homogeneity as examine_homogeneity,
        Homogeneity as Homogeneity,
        RunFigures as RunFigures,
    )
    from .moments import (
        count_outside as count_outside,
        exact_sum as exact_sum,
        Moments as Moments,
        UNIT as UNIT,
    )
    from .normality import (
        examine_normality as examine_normality,
        Normality as Normality,
        Shape as Shape,
    )
    from .resolution import find_resolution as find_resolution, Resolution as Resolution
    from .stationarity import (
        examine_stationarity as examine_stationarity,
        Stationarity as Stationarity,
    )
    from .variance_uncertainty import (
        between_runs as between_runs,
        estimate_spread as estimate_spread,
        lower_bound as lower_bound,
        MEAN_DOF as MEAN_DOF,
        pool as pool,
        Spread as Spread,
        upper_bound as upper_bound,
    )
    from .warm_up import fit_warm_up as fit_warm_up, mser5 as mser5, WarmUp as WarmUp
