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

"""The figures of the runs of a verdict as a data frame of pandas, which is optional."""

from __future__ import annotations

from typing import TYPE_CHECKING

from heading_intercompare.core.declared_settings import flatten
from heading_intercompare.core.typed_reader import make_plain

from .verdict_document import Verdict

if TYPE_CHECKING:
    import pandas


def frame_of_runs(verdict: Verdict) -> 'pandas.DataFrame':
    """Return a data frame with a row per run; see `Verdict.to_frame`."""
    try:
        import pandas
    except ModuleNotFoundError as error:
        raise ValueError(f'to_frame needs pandas (no module {error.name}): install it, or use '
                         'the attributes of the runs') from error
    rows = [{name: figure for name, figure in flatten(make_plain(run)).items()
             if not isinstance(figure, list)} for run in verdict.runs]
    frame = pandas.DataFrame(rows)
    return frame.set_index('run') if rows else frame
