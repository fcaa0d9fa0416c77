# SPDX-License-Identifier: Apache-2.0
"""A profile as text: what is understood with unit and certainty, and with --all everything else as it stands."""
from __future__ import annotations

from collections.abc import Iterator

from voltlap_orion.bean_file import quoted
from voltlap_orion.profile import Profile
from voltlap_orion.settings import FIRST_C, GROUPS, RAW, STEP_C, TABLES


def settings_lines(profile: Profile) -> Iterator[str]:
    for group, settings in GROUPS.items():
        yield f"\n{group}"
        if group == "battery":
            yield f"  {'populationTable':<28}{profile.populated():>10g} {'':8}{'certain':<13}cells marked"
        for setting in settings:
            value = profile.get(setting.name)
            if value is None:
                absent = f"{setting.what}; not in the file: the utility's default"
                yield f"  {setting.name:<28}{'-':>10} {'':8}{'':<13}{absent}"
                continue
            unit = "" if setting.known == RAW else setting.unit
            yield f"  {setting.name:<28}{value:>10g} {unit:8}{setting.known:<13}{setting.what}"


def table_lines(profile: Profile) -> Iterator[str]:
    for name, table in TABLES.items():
        points = profile.table(name)
        if points is None:
            yield f"\n{name}: not in the file: the utility's default"
            continue
        last_c = FIRST_C + STEP_C * (table.points - 1)
        yield (f"\n{name}: {table.what}, {table.unit}, every {STEP_C:g} degC from {FIRST_C:g} to {last_c:g} degC "
               "(inferred)")
        for first in range(0, len(points), 10):
            yield "  " + " ".join(f"{value:>7g}" for value in points[first:first + 10])


def message_lines(profile: Profile) -> Iterator[str]:
    messages = profile.messages()
    yield f"\n{len(messages)} frames of the profile's own" + (" (-: not in the file, the utility's default)" if messages
                                                             else "")
    for message in messages:
        identifier = "-" if message.identifier is None else f"0x{message.identifier:X}"
        length = "-" if message.length is None else f"{message.length} bytes"
        period = "-" if message.period_s is None else f"every {1e3 * message.period_s:g} ms"
        yield f"  {identifier:<12}{length:<10}{period}"


def profile_lines(profile: Profile, everything: bool) -> Iterator[str]:
    rest = profile.not_understood()
    yield f"{profile.bean.path}: {profile.cells()} cells in series, {len(profile.bean.values)} properties"
    yield from settings_lines(profile)
    yield from table_lines(profile)
    yield from message_lines(profile)
    if not everything:
        yield f"\n{len(rest)} properties not understood, and used for nothing: --all lists them"
        return
    yield f"\n{len(rest)} properties not understood, and used for nothing"
    for name in rest:
        value = profile.bean.values[name]
        yield f"  line {value.line:<6}{name:<52}{value.kind:<9}{quoted(value.text)}"
