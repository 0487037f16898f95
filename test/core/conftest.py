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

"""Real ship logs, and the figures that independent programs found in them."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from scipy.signal import lfilter

from heading_intercompare.core.pairing.difference import subtract
from heading_intercompare.core.pairing.pairer import pair
from heading_intercompare.core.settings import Settings
from heading_intercompare.drivers.logs import read_log
from heading_intercompare.drivers.settings import DriverSettings

LOGS = {'gyr1': ('nbp1406/NBP1406_gyr1-2014-08-01', 'HDT'),
        's330': ('nbp1406/NBP1406_s330-2014-08-01', 'HDT'),
        'seap': ('nbp1406/NBP1406_seap-2014-08-01', 'HDT'),
        'adcp': ('nbp1406/NBP1406_adcp-2014-08-01', 'PUHAW,UVH'),
        'lgyr': ('lmg1903/LMG1903_lgyr.d085', 'HDT'),
        'lsep': ('lmg1903/LMG1903_lsep.d085', 'PSXN,23')}


@pytest.fixture(scope='session')
def golden(shared_data):
    """Return the figures by name of the pair, TS first, and those of three sensors."""
    found = json.loads((shared_data / 'golden_nbp1406_lmg1903.json').read_text('utf-8'))['sets']
    pairs = {**found['NBP1406']['pairs'], **found['LMG1903']['pairs']}
    return {'pairs': pairs, 'hats': found['NBP1406']['hats']}


@pytest.fixture(scope='session')
def logs(shared_data):
    """Return the headings of each log."""
    return {name: read_log(shared_data / path, DriverSettings(sentence=sentence))[0]
            for name, (path, sentence) in LOGS.items()}


@pytest.fixture(scope='session')
def real(logs):
    """Return a function that gives pairs and differences of two logs, 'gyr1-s330'."""
    def of(name):
        ts, rs = (logs[part] for part in name.split('-'))
        pairs, _ = pair(ts, rs, Settings.from_mapping({
            'pairing.method': 'interpolate', 'pairing.kernel': 'line'}))
        return pairs, subtract(pairs).x_deg
    return of


@pytest.fixture
def ar1(rng):
    """Return a function that makes n samples of unit variance and correlation time tau."""
    def of(n, tau):
        phi = math.exp(-1.0 / tau)
        white = rng.standard_normal(n) * math.sqrt(1.0 - phi * phi)
        return lfilter([1.0], [1.0, -phi], white, zi=[phi * rng.standard_normal()])[0]
    return of


@pytest.fixture
def yaw(rng):
    """Return a function of time (s) that gives a heading which yaws by a degree or so."""
    period, phase = rng.uniform(5.0, 12.0, 12), rng.uniform(0.0, 2.0 * np.pi, 12)

    def of(t_s):
        t = np.asarray(t_s)[..., np.newaxis]
        return 100.0 + 0.5 * np.sin(2.0 * np.pi * t / period + phase).sum(axis=-1)
    return of
