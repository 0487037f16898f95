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

"""Completions for the Tab key: commands, options, bags and other files, settings, presets."""

from __future__ import annotations

import argparse
from typing import Any, Callable, Iterator

from heading_intercompare.core.declared_settings import list_settings
from heading_intercompare.core.settings import Settings

#: Suffixes of the files that an argument takes besides folders, by its name in the parser.
_FILES = {'bag': ('mcap',), 'bags': ('mcap',), 'input': ('mcap', 'csv', 'log'),
          'table': ('csv',), 'inputs': ('mcap', 'csv', 'json', 'journal', 'log'),
          'config': ('yaml', 'yml'), 'runs': ('csv',), 'csv': ('csv',), 'runs_csv': ('csv',),
          'ensembles': ('csv',), 'card': ('html', 'pdf', 'csv'),
          'corrections': ('csv',),
          'reports': ('html', 'json', 'pdf', 'xml'), 'json': ('json',), 'dask': ('json',),
          'logbook': ('sqlite',), 'logbooks': ('sqlite',), 'merge_into': ('sqlite',),
          'html': ('html',), 'correction': ('csv', 'ang')}


def complete(parser: argparse.ArgumentParser) -> None:
    """
    Answer the shell and end the process; without argcomplete, just return.

    Parameters
    ----------
    parser
        Parser of the whole program; only the commands on the line need their arguments.

    """
    try:
        import argcomplete
    except ImportError:
        return
    for action in _actions(parser):
        if action.dest in _FILES:
            _set_completer(action, argcomplete.FilesCompleter(_FILES[action.dest]))
        elif action.dest == 'set':
            _set_completer(action, complete_setting)
        elif action.dest == 'scenario':
            _set_completer(action, _scenarios(argcomplete.FilesCompleter(('yaml', 'yml'))))
    argcomplete.autocomplete(parser)


def _set_completer(action: argparse.Action, completer: Callable[..., Any]) -> None:
    """Attach a completer to an argument, where argcomplete looks for it."""
    setattr(action, 'completer', completer)  # noqa: B010


def _actions(parser: argparse.ArgumentParser) -> Iterator[argparse.Action]:
    """Yield the arguments of a parser and of its commands."""
    for action in parser._actions:
        yield action
        if isinstance(action, argparse._SubParsersAction):
            for command in action.choices.values():
                yield from _actions(command)


def complete_setting(prefix: str, **_: object) -> list[str]:
    """
    Return the completions of a text after ``--set``: names, or a name with its values.

    Examples
    --------
    >>> complete_setting('norms.sigma_r')
    ['norms.sigma_ref_max_deg=', 'norms.sigma_ref_deg=']
    >>> complete_setting('alignment.skew=a')
    ['alignment.skew=apply']

    """
    rules = {rule.name: rule for rule in list_settings(Settings)}
    name, equals, _rest = prefix.partition('=')
    if not equals:
        return [f'{setting}=' for setting in rules if setting.startswith(prefix)]
    if name not in rules:
        return []
    values = list(rules[name].choices)
    if name in ('norms.preset', 'risk.sensor_class'):
        values = _list_names(name)
    return [text for text in (f'{name}={value}' for value in values) if text.startswith(prefix)]


def _list_names(setting: str) -> list[str]:
    """Return the names in a table that a setting accepts."""
    # These imports load numpy, which no other completion of a setting needs.
    if setting == 'norms.preset':
        from heading_intercompare.core.decision.norm_presets import PRESETS
        return [*PRESETS]
    from heading_intercompare.core.decision.coverage import SENSOR_CLASSES
    return [*SENSOR_CLASSES]


def _scenarios(files: Callable[..., Any]) -> Callable[..., list[str]]:
    """Return a completer of scenarios: files, and the names of those in the package."""
    def completer(prefix: str, **_: object) -> list[str]:
        from heading_intercompare.app.scenarios import list_scenarios

        return [*(name for name in list_scenarios() if name.startswith(prefix)), *files(prefix)]
    return completer
