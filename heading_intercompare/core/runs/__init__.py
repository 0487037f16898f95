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

"""Runs: where they begin and end, and the data kept of each."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'growing_columns': ('Keep',),
    'live_figures': ('compute_figures',),
    'rolling_window': ('Rolling',),
    'run_cutter': ('RunCutter',),
    'run_series': ('RunSeries',),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .growing_columns import Keep as Keep
    from .live_figures import compute_figures as compute_figures
    from .rolling_window import Rolling as Rolling
    from .run_cutter import RunCutter as RunCutter
    from .run_series import RunSeries as RunSeries
