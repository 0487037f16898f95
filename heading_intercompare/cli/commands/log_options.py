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

"""The options that say how the logs of sensors and tables are read, and what they mean."""

from __future__ import annotations

import argparse
from typing import Any, Sequence

from heading_intercompare.core.declared_settings import from_mapping
from heading_intercompare.core.units.full_turns import ANGLE_UNITS
from heading_intercompare.drivers.settings import DriverSettings, SENTENCES, STAMP_FORMATS

_ROLES = ('ts', 'rs')

SHARED_OPTIONS = {
    'time': ('stamp headings of logs with the time of receipt (of the line; default) or of '
             'validity (ZDA, RMC, GGA, PASHR)', ('receipt', 'validity')),
    'stamp_format': ('form of the stamps of the lines (default: recognised automatically): '
                     + ', '.join(STAMP_FORMATS), None),
    'stamp_pattern': ('regular expression for stamps of another form, with named groups: epoch; '
                      'or year, month, day, hour, minute, second, fraction', None),
    'stamp_zone': ('zone of stamps that name none, such as +02:00 or Europe/Oslo (default: UTC)',
                   None),
    'time_column': ('column of the times of a csv or Parquet table; of several, such as '
                    'Date,Time, their names in this order (default: by their names)', None),
    'date': ('date of the first line, YYYY-MM-DD, for times of day without one', None),
    'variation_deg': ('magnetic variation, positive to the east, for magnetic headings without '
                      'one (HDG, HDM, VHW)', None),
    'deviation_table': ('deviation of that compass, positive to the east: file:PATH with rows of '
                        "heading and deviation, or the rows: '0 1.5; 90 -2; 180 -1; 270 2'", None),
    'checksum': ('take sentences without a checksum too, or only those with one (default)',
                 ('required', 'if_present')),
    'bursts': ('take the stamp of a burst for all its lines, or for the first of a kind (default)',
               ('reject', 'accept')),
}
_ROLE_OPTIONS = {
    'sentence': 'kind of sentence in the log of the {}: ' + ', '.join(SENTENCES)
                + ' (default: the first present)',
    'own_sentence': 'sentence of the {} that is not among these, in one line, such as '
                    "'PXYZ,ATT heading=3 unit=rad'; see Import NMEA logs in the docs",
    'talker': 'talker of the {}, such as HE, several as GN,GP, or any (default: the first '
              'present), or its stream in a file with several, such as a source of NMEA 2000',
    'instrument': 'word of the lines of the {}, if a log has several instruments',
}

LOG_OPTIONS = (*(f'{role}_{name}' for name in (*_ROLE_OPTIONS, *SHARED_OPTIONS)
                 for role in _ROLES), *SHARED_OPTIONS, 'motion', 'rs_antennas')
"""Options of `add_log_arguments`, by their names in the parser."""

OF_TABLES = ('stamp_format', 'stamp_pattern', 'stamp_zone', 'time_column', 'date')
"""Those of them that hold for a table of several sensors, too."""


def add_log_arguments(parser: argparse._ActionsContainer,
                      roles: Sequence[str] = _ROLES) -> None:
    """Add the options that say how the logs of some sensors are read; see `drivers_for`."""
    for name, words in _ROLE_OPTIONS.items():
        _add_role_options(parser, name.replace('_', '-'), words, roles, metavar=name[0].upper())
    for name, (words, choices) in SHARED_OPTIONS.items():
        option, value_type = name.replace('_', '-'), float if name.endswith('_deg') else str
        parser.add_argument(f'--{option}', metavar=None if choices else name[0].upper(),
                            choices=choices, type=value_type,
                            help=words if len(roles) < 2 else
                            f'{words}; --ts-{option}, --rs-{option}: of one log')
        for role in roles:
            parser.add_argument(f'--{role}-{option}', choices=choices, type=value_type,
                                help=argparse.SUPPRESS)


def add_unit_arguments(parser: argparse._ActionsContainer) -> None:
    """Add the options that state the units of headings, `ts_unit` and `rs_unit`."""
    _add_role_options(parser, 'unit', 'unit of the headings of the {}, in files of numbers and in '
                      'fields of messages', _ROLES, choices=('auto', *ANGLE_UNITS))


def _add_role_options(parser: argparse._ActionsContainer, option: str, words: str,
                      roles: Sequence[str], **form: Any) -> None:
    """Add an option for each role; the help shows the first, and names the other beside it."""
    for role in roles:
        others = ''.join(f'; --{other}-{option}: of the {other.upper()}' for other in roles[1:])
        parser.add_argument(f'--{role}-{option}', **form,
                            help=words.format(role.upper()) + others if role == roles[0]
                            else argparse.SUPPRESS)


def drivers_for(arguments: argparse.Namespace,
                roles: Sequence[str] = _ROLES) -> dict[str, DriverSettings]:
    """Return how to read the log of each sensor and that of the motion; SettingsError if wrong."""
    drivers = {}
    for role in (*roles, 'motion'):
        options = {name: getattr(arguments, name) for name in SHARED_OPTIONS}
        options.update((name, value) for name in (*_ROLE_OPTIONS, *SHARED_OPTIONS)
                       if (value := getattr(arguments, f'{role}_{name}', None)) is not None)
        drivers[role] = from_mapping(DriverSettings, {
            name: value for name, value in options.items() if value is not None})
    return drivers
