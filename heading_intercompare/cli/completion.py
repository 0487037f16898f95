# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""What the Tab key completes: commands, options, bags and other files, settings, presets."""

from __future__ import annotations

import argparse
from typing import Any, Callable, Iterator

from heading_intercompare.core.settings import list_settings, Settings

__all__ = ['complete', 'complete_setting']

#: Which files an argument takes beside folders, by its name in the parser.
_FILES = {'bag': ('mcap',), 'bags': ('mcap',), 'inputs': ('mcap', 'csv', 'json'),
          'config': ('yaml', 'yml'), 'runs': ('csv',), 'csv': ('csv',), 'ensembles': ('csv',),
          'report': ('html', 'json'), 'json': ('json',), 'dask': ('json',),
          'logbook': ('sqlite',), 'logbooks': ('sqlite',), 'merge_into': ('sqlite',),
          'html': ('html',)}


def complete(parser: argparse.ArgumentParser) -> None:
    """
    Answer the shell, and end the process; without argcomplete return.

    Parameters
    ----------
    parser : argparse.ArgumentParser
        The whole program; of the commands those that are meant have their arguments.

    """
    try:
        import argcomplete
    except ImportError:
        return
    for action in _actions(parser):
        if action.dest in _FILES:
            _give(action, argcomplete.FilesCompleter(_FILES[action.dest]))
        elif action.dest == 'set':
            _give(action, complete_setting)
        elif action.dest == 'scenario':
            _give(action, _scenarios(argcomplete.FilesCompleter(('yaml', 'yml'))))
    argcomplete.autocomplete(parser)


def _give(action: argparse.Action, completer: Callable[..., Any]) -> None:
    """Give an argument what completes it, where argcomplete looks for it."""
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
    Return what may begin with a text behind ``--set``: names, or a name with its values.

    Examples
    --------
    >>> complete_setting('norms.sigma_r')
    ['norms.sigma_ref_max_deg=', 'norms.sigma_ref_deg=']
    >>> complete_setting('alignment.skew=a')
    ['alignment.skew=apply']

    """
    rules = {rule.name: rule for rule in list_settings(Settings)}
    name, given, _rest = prefix.partition('=')
    if not given:
        return [f'{known}=' for known in rules if known.startswith(prefix)]
    if name not in rules:
        return []
    values = list(rules[name].choices)
    if name in ('norms.preset', 'risk.sensor_class'):
        values = _named(name)
    return [text for text in (f'{name}={value}' for value in values) if text.startswith(prefix)]


def _named(setting: str) -> list[str]:
    """Return the names that a setting takes from a table."""
    # They load numpy, which no other completion of a setting needs.
    if setting == 'norms.preset':
        from heading_intercompare.core.decision.norm_presets import PRESETS
        return [*PRESETS]
    from heading_intercompare.core.decision.coverage import SENSOR_CLASSES
    return [*SENSOR_CLASSES]


def _scenarios(files: Callable[..., Any]) -> Callable[..., list[str]]:
    """Return a completer of scenarios: files, and those that come with the package by name."""
    def completer(prefix: str, **_: object) -> list[str]:
        from heading_intercompare.app.scenarios import list_scenarios

        return [*(name for name in list_scenarios() if name.startswith(prefix)), *files(prefix)]
    return completer
