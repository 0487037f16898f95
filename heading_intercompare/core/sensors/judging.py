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

"""Judges several sensors: from their pairs to the outcome of each."""

from __future__ import annotations

from dataclasses import replace
from typing import Callable, Collection, Mapping, Sequence

from heading_intercompare.core.decision.coverage import span_words
from heading_intercompare.core.decision.criteria import Limits
from heading_intercompare.core.decision.guarded import decide_variance, variance_risk
from heading_intercompare.core.outcome import Outcome, worst
from heading_intercompare.core.sensor_table import find_reference, Sensor
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.validity.condition import DOUBTFUL, gravest, HOLDS, VOID
from heading_intercompare.core.verdict.headline import OUTCOME_WORDS
from heading_intercompare.core.verdict.judge import RunResult
from heading_intercompare.core.verdict.verdict_document import Input, RunVerdict, Verdict

from .pair_figures import describe_pair, PairFigures
from .pair_names import Names
from .pair_settings import check_sensors, risk_of, settings_of_pair
from .sensors_verdict import SensorResult, SensorsVerdict
from .variance_split import PairVariance, SensorVariance, split_variances
from .vote import find_wrong, Vote

#: A pair may begin this much later than its sensors against the reference, seconds.
_LATEST_S = 60.0


def judge_sensors(settings: Settings, verdicts: Mapping[str, Verdict],
                  others: Mapping[Names, Sequence[RunResult]],
                  inputs: Sequence[Input] = (), *,
                  incomplete: Collection[Names] = (),
                  problems: Mapping[Names, Sequence[str]] | None = None) -> SensorsVerdict:
    """
    Judge several sensors.

    Parameters
    ----------
    settings
        With `sensors`.
    verdicts
        The verdict on each sensor against the reference; empty without one.
    others : mapping of (str, str) to sequence of RunResult
        The runs of each other pair, by the names of its sensors.
    inputs
        The sources of the runs.
    incomplete : collection of (str, str)
        The other pairs that lack a run in an input; they certify nothing.
    problems
        What other pairs missed, in words; it becomes findings of theirs.

    Returns
    -------
    SensorsVerdict

    Notes
    -----
    With a reference, each sensor has the verdict of the comparison with it alone. The vote can
    only take away: if it names the reference, no verdict against it counts.

    Without a reference, a sensor fails if the vote names it. It complies if the variance of one of
    its pairs is, with its whole uncertainty, within its own norm: the partner adds to that
    variance and takes nothing away, unless the errors of both have a common part. All pairs of a
    sensor share the consumer's risk, and all pairs share the producer's risk.

    """
    sensors = check_sensors(settings)
    reference = find_reference(sensors)
    risk = variance_risk(settings.risk)
    runs: dict[Names, Sequence[RunVerdict]] = {}
    if reference is not None:
        runs |= {(name, reference.name): verdict.runs for name, verdict in verdicts.items()}
    runs |= {names: [result.verdict for result in results] for names, results in others.items()}
    missed = problems or {}
    pairs = [_add_missing(describe_sensors(names, judged, settings, sensors, risk / len(runs)),
                          _missing_s(names, runs, reference), missed.get(names, ()))
             for names, judged in runs.items()]

    def complies(sensor: Sensor, pair: PairFigures) -> bool:
        return pair.names not in incomplete and _complies(
            sensor, pair, sensors, others.get(pair.names, ()), settings)
    return conclude_sensors(settings, verdicts, pairs, inputs, complies)


def conclude_sensors(settings: Settings, verdicts: Mapping[str, Verdict],
                     pairs: Sequence[PairFigures], inputs: Sequence[Input],
                     complies: Callable[[Sensor, PairFigures], bool]) -> SensorsVerdict:
    """
    Return the verdict on several sensors from the figures of their pairs.

    Parameters
    ----------
    settings, verdicts, inputs
        As for `judge_sensors`.
    pairs
        The figures of all pairs.
    complies
        Tells whether the runs of a pair bound the variance of a sensor within its norm, where no
        sensor is the reference.

    """
    sensors = check_sensors(settings)
    reference = find_reference(sensors)
    split = _split(sensors, pairs)
    norms = [_norm_of(sensor, sensors, settings) for sensor in sensors]
    vote = _find_wrong_sensors(sensors, pairs, [
        sensor.name for sensor, norm, share in zip(sensors, norms, split or ())
        if share.interval_deg2[0] > norm ** 2])
    judgements = []
    for at, sensor in enumerate(sensors):
        outcome: Outcome | None
        if sensor is reference:
            outcome, effect, line = _judge_reference(sensor, vote)
        elif reference is not None:
            outcome, effect, line = _judge_against(sensor, reference, verdicts[sensor.name], vote)
        else:
            outcome, effect, line = _judge_alone(sensor, pairs, vote, complies)
        judgements.append(SensorResult(
            name=sensor.name, role=sensor.role, topic=sensor.heading_topic,
            sigma_max_deg=norms[at], outcome=outcome, headline=line,
            validity_effect=effect, variance=None if split is None else split[at]))
    tested = [(judgement, judgement.outcome) for judgement in judgements
              if judgement.outcome is not None]
    return SensorsVerdict(
        outcome=worst(outcome for _, outcome in tested),
        headline='; '.join((*(_describe_result(*result) for result in tested), vote.words)),
        validity_effect=gravest(judgement.validity_effect for judgement, _ in tested),
        settings=settings, inputs=tuple(inputs), sensors=tuple(judgements), pairs=tuple(pairs),
        vote=vote, risk=variance_risk(settings.risk), verdicts=dict(verdicts))


def _find_wrong_sensors(sensors: Sequence[Sensor], pairs: Sequence[PairFigures],
                        noisy: Sequence[str]) -> Vote:
    """Return which sensor is wrong by its pairs; `noisy` names those whose variance says so."""
    return find_wrong([sensor.name for sensor in sensors],
                      {pair.names: pair.differs for pair in pairs},
                      [pair.names for pair in pairs if pair.one_source], noisy)


def _describe_result(judgement: SensorResult, outcome: Outcome) -> str:
    """Return the result of a sensor in a few words."""
    doubt = {VOID: ', VOID', DOUBTFUL: ', DOUBTFUL', HOLDS: ''}[judgement.validity_effect]
    return f'{judgement.name} {OUTCOME_WORDS[outcome.value]}{doubt}'


def _of_name(sensors: Sequence[Sensor], name: str) -> Sensor:
    return next(sensor for sensor in sensors if sensor.name == name)


def _limits(first: Sensor, second: Sensor, settings: Settings) -> Limits:
    pair_settings = settings_of_pair(settings, first, second)
    return Limits.of(pair_settings.norms, pair_settings.model)


def _norm_of(sensor: Sensor, sensors: Sequence[Sensor], settings: Settings) -> float:
    partner = next(partner for partner in sensors if partner is not sensor)
    if sensor.is_reference:
        return _limits(partner, sensor, settings).sigma_ref_max_deg
    return _limits(sensor, partner, settings).sigma_max_deg


def describe_sensors(names: Names, runs: Sequence[RunVerdict], settings: Settings,
                     sensors: Sequence[Sensor], risk: float) -> PairFigures:
    """Return the figures of a pair of these sensors, with its share of the risk."""
    first, second = (_of_name(sensors, name) for name in names)
    return describe_pair(
        names, runs, _limits(first, second, settings).rejection_limit_deg2,
        of_reference=second.is_reference, risk=risk, consumer=settings.risk.alpha_consumer)


def _missing_s(names: Names, runs: Mapping[Names, Sequence[RunVerdict]],
               reference: Sensor | None) -> float:
    """Return how much later a pair begins than both its sensors against the reference."""
    if reference is None or reference.name in names or not runs[names]:
        return 0.0
    starts = [of_pair[0].start_ns for name in names
              if (of_pair := runs.get((name, reference.name)))]
    return (runs[names][0].start_ns - max(starts)) / 1e9 if len(starts) == len(names) else 0.0


def _add_missing(pair: PairFigures, missing_s: float, missed: Sequence[str]) -> PairFigures:
    """Return a pair with what it missed, and with a doubt if its beginning is missing."""
    pair = replace(pair, findings=(*pair.findings, *missed))
    if missing_s <= _LATEST_S:
        return pair
    words = f'its first {span_words(missing_s)} are missing, because its comparison began later'
    return replace(pair, findings=(*pair.findings, words),
                   validity_effect=gravest([pair.validity_effect, DOUBTFUL]))


def _split(sensors: Sequence[Sensor],
           pairs: Sequence[PairFigures]) -> tuple[SensorVariance, ...] | None:
    at = {sensor.name: number for number, sensor in enumerate(sensors)}
    return split_variances(len(sensors), [
        PairVariance(at[pair.first], at[pair.second], pair.variance_deg2, pair.u_deg2,
                     pair.first_factor or 1.0, pair.second_factor or 1.0)
        for pair in pairs if pair.variance_deg2 is not None and pair.u_deg2 is not None])


def _judge_reference(sensor: Sensor, vote: Vote) -> tuple[None, str, str]:
    if sensor.name in vote.wrong:
        return None, VOID, f'reference, WRONG: {vote.words}'
    if sensor.name in vote.suspected:
        return None, DOUBTFUL, f'reference, DOUBTFUL: {vote.words}'
    return None, HOLDS, 'reference'


def _judge_against(sensor: Sensor, reference: Sensor, verdict: Verdict,
                   vote: Vote) -> tuple[Outcome, str, str]:
    """Return outcome, effect and headline of a sensor that has a reference."""
    alone = verdict.headline
    if reference.name in vote.wrong:
        return Outcome.INDETERMINATE, VOID, (
            f'INDETERMINATE, VOID: the reference {reference.name} is wrong, by the vote of the '
            f'sensors; against it alone: {alone}')
    effect = verdict.validity_effect
    if reference.name in vote.suspected and verdict.outcome is Outcome.NON_COMPLIANT:
        return verdict.outcome, gravest([effect, DOUBTFUL]), (
            f'{alone}; DOUBTFUL: the reference {reference.name} may be the one that is wrong')
    if sensor.name in vote.wrong:
        return verdict.outcome, effect, f'{alone}; the vote names it as wrong'
    return verdict.outcome, effect, alone


def _judge_alone(sensor: Sensor, pairs: Sequence[PairFigures], vote: Vote,
                 complies: Callable[[Sensor, PairFigures], bool]) -> tuple[Outcome, str, str]:
    """Return outcome, effect and headline of a sensor where no reference is."""
    if sensor.name in vote.wrong:
        return Outcome.NON_COMPLIANT, HOLDS, f'NON-COMPLIANT: {vote.words}'
    if sensor.name in vote.suspected:
        return Outcome.INDETERMINATE, HOLDS, f'INDETERMINATE: {vote.words}'
    own_pairs = [pair for pair in pairs if sensor.name in pair.names]
    for pair in sorted(own_pairs, key=lambda figures: figures.validity_effect != HOLDS):
        if pair.validity_effect == VOID or not complies(sensor, pair):
            continue
        line = say_that_it_complies(sensor, pair)
        if pair.validity_effect == DOUBTFUL:
            return Outcome.COMPLIANT, DOUBTFUL, f'{line}; DOUBTFUL: {"; ".join(pair.findings)}'
        return Outcome.COMPLIANT, HOLDS, line
    if own_pairs and all(pair.validity_effect == VOID for pair in own_pairs):
        return Outcome.INDETERMINATE, VOID, f'INDETERMINATE, VOID: {own_pairs[0].findings[0]}'
    if not any(pair.n for pair in own_pairs):
        return Outcome.INDETERMINATE, HOLDS, 'INDETERMINATE: no run has a pair with it'
    return Outcome.INDETERMINATE, HOLDS, (
        'INDETERMINATE: no difference from another sensor is, with its uncertainty, within its '
        f'norm, and the vote does not name it: {vote.words}')


def say_that_it_complies(sensor: Sensor, pair: PairFigures) -> str:
    """Return the headline of a sensor that complies by one of its pairs."""
    partner = pair.second if pair.first == sensor.name else pair.first
    return (f'COMPLIANT, as its differences from {partner} show; an error common to both is '
            'not covered')


def _complies(sensor: Sensor, pair: PairFigures, sensors: Sequence[Sensor],
              runs: Sequence[RunResult], settings: Settings) -> bool:
    """Tell whether each run of a pair bounds the variance of the sensor within its norm."""
    is_first = pair.first == sensor.name
    partner = _of_name(sensors, pair.second if is_first else pair.first)
    pair_settings = settings_of_pair(settings, sensor, partner)
    risk = risk_of(sensor, settings.risk)
    risk = replace(risk, alpha_consumer=risk.alpha_consumer / (len(sensors) - 1))
    for run in runs:
        spread, pairing = run.evidence.spread, run.verdict.pairing
        factor = pairing.ts_variance_factor if is_first else pairing.rs_variance_factor
        if spread is None:
            return False
        limits = Limits.of(pair_settings.norms, pair_settings.model,
                           ts_variance_factor=factor or 1.0)
        if decide_variance(spread, run.evidence.span_s, limits, risk,
                           run.evidence.drift_left_deg2)[0] is not Outcome.COMPLIANT:
            return False
    return bool(runs)
