# SPDX-License-Identifier: Apache-2.0
"""What a scenario may name: messages of the DBC files, and parts of the car that its `arguments` choose."""
from __future__ import annotations

import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

from .dbc import Dbc
from .errors import InputError, did_you_mean
from .nodes import program

_FLAGS = ("--vehicle", "--set")  # what plant and ECUs both take
_ANSWER_S = 20.0
_CELLS, _THERMISTORS = "battery.cells_in_series", "sensors.temperature_count"


@dataclass(frozen=True)
class Car:
    dbc: Dbc
    arguments: tuple[str, ...] = ()

    @property
    def cells(self) -> int:
        return self._count(_CELLS, "CellVoltages_", "Cell")

    @property
    def thermistors(self) -> int:
        return self._count(_THERMISTORS, "Temperatures_", "Temperature")

    def _count(self, key: str, message: str, signal: str) -> int:
        """As the program says; without it, as many as there are signals for."""
        known = _keys(self.arguments).get(key)
        return known or sum(name.startswith(signal) for m in self.dbc.messages.values() if m.name.startswith(message)
                            for name in m.signals)

    def check_arguments(self) -> None:
        """Each flag is one that plant and ECUs take, each name and value one that the program takes."""
        words = list(self.arguments)
        while words:
            flag, equals, first = words.pop(0).partition("=")
            if flag not in _FLAGS:
                raise InputError(f"found {flag!r}, expected --vehicle NAME or --set KEY=VALUE, which plant and ECUs "
                                 f"both take.{did_you_mean(flag, _FLAGS)}")
            values = [first] if equals else []
            while words and not words[0].startswith("--") and (flag == "--set" or not values):
                values.append(words.pop(0))
            if not values:
                raise InputError(f"{flag} is without its {'KEY=VALUE' if flag == '--set' else 'NAME'}")
            for value in values if flag == "--set" else []:
                if not value.partition("=")[0] or not value.partition("=")[2]:
                    raise InputError(f"--set: found {value!r}, expected KEY=VALUE such as battery.initial_soc=0.5")
        _keys(self.arguments)


@lru_cache(maxsize=256)
def _keys(arguments: Sequence[str]) -> dict[str, int]:
    """Counts of parts by the program's own reading of the arguments; none where it is not built yet."""
    try:
        asked = subprocess.run([str(program()), "list", "keys", *arguments], capture_output=True, text=True,
                               errors="replace", stdin=subprocess.DEVNULL, timeout=_ANSWER_S)
    except (InputError, OSError, subprocess.TimeoutExpired):
        return {}
    if asked.returncode == 2:
        raise InputError(asked.stderr.strip().removeprefix("voltlap: ").replace("\n", " "))
    rows = (line.split() for line in asked.stdout.splitlines())  # key, unit, low, "..", high, value, meaning
    return {row[0]: int(row[5]) for row in rows if row and row[0] in (_CELLS, _THERMISTORS) and row[5].isdigit()}
