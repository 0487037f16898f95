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

"""The word beside a setting that nobody stated."""

from __future__ import annotations

from heading_intercompare.core.settings import Settings

_DEFAULTS = Settings().to_mapping()


def is_default(settings: Settings, *names: str) -> bool:
    """Tell whether all settings of these dotted names have their defaults."""
    stated = settings.to_mapping()
    return all(stated[name] == _DEFAULTS[name] for name in names)


def mark_default(text: str, settings: Settings, *names: str) -> str:
    """
    Return a text about settings, with a word where all of them have their defaults.

    Examples
    --------
    >>> mark_default('0.997', Settings(), 'norms.probability')
    '0.997, default'

    """
    return f'{text}, default' if is_default(settings, *names) else text
