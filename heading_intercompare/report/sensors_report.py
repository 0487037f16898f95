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

"""The verdict on several sensors for people: an overview, and beside it a protocol of each."""

from __future__ import annotations

from pathlib import Path
from typing import Callable, Mapping, Sequence

from heading_intercompare.core.sensors.sensors_verdict import (
    matrix_of,
    SensorsVerdict,
    SHOWN,
    split_words,
)
from heading_intercompare.core.validity.condition import VOID
from heading_intercompare.core.verdict.headline import OUTCOME_WORDS
from heading_intercompare.core.verdict.verdict_document import Verdict
from heading_intercompare.replaced_file import replace_file

from . import annexes_path, check_form, is_protocol, json, write
from .contents.file_names import name_files
from .contents.first_page import SIGNS, tell_signature
from .series_sketch import SeriesSketch


def sensor_path(path: str | Path, name: str) -> Path:
    """Return where the file of a sensor lies, beside that of all sensors at `path`."""
    place = Path(path)
    return place.with_name(f'{place.stem}-{name}{place.suffix}')


def write_protocols(verdict: Verdict | SensorsVerdict, path: str | Path,
                    sketches: Mapping[str, Sequence[SeriesSketch]] | None = None,
                    progress: Callable[[str], None] = lambda text: None,
                    verbose: bool = False, annexes_apart: bool = False) -> list[Path]:
    """
    Write the protocol of two sensors; or an overview, and beside it that of each tested sensor.

    Parameters
    ----------
    verdict
        On two sensors, or on several.
    path
        F.html or F.pdf. The protocols beside an overview are F-NAME.html or F-NAME.pdf.
    sketches
        Data for the figures, by sensor; `ts` of two.
    progress
        Called with the progress in words.
    verbose
        Show the criteria of GK even if no setting asks for them.
    annexes_apart
        Whether the annexes of each protocol are a second file beside it.

    Returns
    -------
    list of Path
        The files written, an overview first; annexes follow their protocol.

    Raises
    ------
    ValueError
        As `check_form`.
    OSError
        If a file cannot be written.

    """
    check_form(path, verdict.settings)
    files = [Path(path)]
    annexes_apart = annexes_apart and is_protocol(path)
    if isinstance(verdict, Verdict):
        write(verdict, path, (sketches or {}).get('ts', ()), progress, verbose, annexes_apart)
        return files + [annexes_path(path)] * annexes_apart
    if files[0].suffix.lower() == '.json':
        json.write(verdict, path)
        return files
    for name, sensor_verdict in verdict.verdicts.items():
        place = sensor_path(path, name)
        write(sensor_verdict, place, (sketches or {}).get(name, ()),
              lambda text, name=name: progress(f'{name}: {text}'),  # type: ignore[misc]
              verbose, annexes_apart)
        files += [place] + [annexes_path(place)] * annexes_apart
    _write_overview(verdict, files[0], progress)
    return files


def _write_overview(verdict: SensorsVerdict, path: Path, progress: Callable[[str], None]) -> None:
    from .html import load_template
    protocols = {name: sensor_path(path, name).name for name in verdict.verdicts}
    text = load_template('sensors.html').render(
        verdict=verdict, void=VOID, words=OUTCOME_WORDS, signs=SIGNS, protocols=protocols,
        trial=verdict.settings.trial, signature=tell_signature(verdict.signed),
        names=name_files(verdict.inputs),
        sensors=[(sensor, split_words(sensor)) for sensor in verdict.sensors],
        matrices=[(title.strip(), matrix_of(verdict, text)) for title, text in SHOWN],
        evidence=[(f'{pair.first} and {pair.second}', '; '.join(pair.findings))
                  for pair in verdict.pairs if pair.findings])
    if path.suffix.lower() == '.pdf':
        from . import pdf
        pdf.print_page(text, path, progress)
    else:
        replace_file(path, text)
