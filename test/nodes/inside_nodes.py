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

"""What nodes of two sensors hold for the tested one."""


def judgement_of(compliance):
    """Return what a compliance node publishes of the tested sensor."""
    judgement, = compliance._judgements.values()
    return judgement


def judge_of(compliance):
    """Return what judges the pairs of a compliance node."""
    return judgement_of(compliance).compliance


def pairer_of(synchronizer):
    """Return what pairs the readings of a synchronizer."""
    maker, = synchronizer._makers.values()
    return maker.pairer


def stream_alarms_of(synchronizer):
    """Return the alarms of a synchronizer."""
    alarms, = synchronizer._alarms.values()
    return alarms


def panel_of(node):
    """Return the panel of a node on which the alarms about its graph are."""
    if hasattr(node, 'panels'):
        return node.panels[0]
    return stream_alarms_of(node).panel if hasattr(node, '_makers') else node.alarms.panel
