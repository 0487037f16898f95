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

"""A start under ROS security: one line that says what is missing, and never a start without."""

from __future__ import annotations

from contextlib import contextmanager
import os
from pathlib import Path
from typing import Iterator

from heading_intercompare.core.declared_settings import SettingsError


def _wanted() -> bool:
    return (os.environ.get('ROS_SECURITY_ENABLE') == 'true'
            and os.environ.get('ROS_SECURITY_STRATEGY') == 'Enforce')


def check_security() -> None:
    """Raise SettingsError if security is enforced and there is no keystore."""
    keystore = os.environ.get('ROS_SECURITY_KEYSTORE', '')
    if _wanted() and not (keystore and Path(keystore, 'enclaves').is_dir()):
        raise SettingsError(
            f'ROS_SECURITY_STRATEGY is Enforce, but ROS_SECURITY_KEYSTORE = {keystore!r} is not a '
            'keystore; share/heading_intercompare/security/make_keystore.py makes one')


@contextmanager
def say_security_errors() -> Iterator[None]:
    """Turn what rcl says of missing keys or a middleware without security into SettingsError."""
    try:
        yield
    except RuntimeError as error:
        if not _wanted():
            raise
        words = ' '.join(str(error).split()).partition(', at /')[0]
        raise SettingsError(f'ROS security is enforced: {words}') from error
