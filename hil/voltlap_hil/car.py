# SPDX-License-Identifier: Apache-2.0
"""What a scenario may name: messages of the DBC files, and parts of the car that its `arguments` choose."""
from __future__ import annotations

import json
import re
import subprocess
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from .dbc import Dbc
from .errors import InputError, did_you_mean
from .nodes import program

COURSE = "michigan_2015"  # unless the plant is told another, which a scenario does not
_FLAGS = ("--vehicle", "--set")  # what plant and ECUs both take
_ANSWER_S = 20.0
_WORD = re.compile(r'(\S+) +- +"([^"]*)"')
_ROW = re.compile(r"(\S+) +.*?\S+ +\.\. +\S+ +([-+0-9.e]+) ")
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
        known = int(_keys(self.arguments).get(key, 0))
        return known or sum(name.startswith(signal) for m in self.dbc.messages.values() if m.name.startswith(message)
                            for name in m.signals)

    @property
    def keys(self) -> dict[str, float]:
        """Every number of the car by its key; none where the program is not built yet."""
        return _keys(self.arguments)

    @property
    def words(self) -> dict[str, str]:
        """As `keys`, of those whose value is a word."""
        found = (_WORD.match(line) for line in _answer("list", "keys", *self.arguments).splitlines())
        return {row[1]: row[2] for row in found if row}

    @property
    def lap_m(self) -> float:
        """Of the course that the plant's own driver drives; 0 where the program is not built yet."""
        text = _answer("track", "show", COURSE, "--json", "-")
        return float(json.loads(text)["length_m"]) if text else 0.0

    @property
    def open_circuit_v(self) -> float:
        """Of a cell at the start of a run, as the BMS's tables have it; 0 where the program is not built yet."""
        return 1e-4 * self._at_start("kOcvSoc", "kOcvVoltage")

    @property
    def resistance_ohm(self) -> float:
        """As `open_circuit_v`, of cells in parallel."""
        return 1e-6 * self._at_start("kResistanceSoc", "kResistance")

    def _at_start(self, axis: str, name: str) -> float:
        return _table(self.arguments, self.keys.get("battery.initial_soc", 1.0), axis, name)

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
def _keys(arguments: Sequence[str]) -> dict[str, float]:
    """Numbers by the program's own reading of the arguments; none where it is not built yet."""
    # A row: key, unit, low, "..", high, value, meaning.
    rows = (_ROW.match(line) for line in _answer("list", "keys", *arguments).splitlines())
    return {row[1]: float(row[2]) for row in rows if row}


@lru_cache(maxsize=256)
def _answer(*arguments: str) -> str:
    """What the program prints; nothing where it is not built yet."""
    try:
        asked = subprocess.run([str(program()), *arguments], capture_output=True, text=True, errors="replace",
                               stdin=subprocess.DEVNULL, timeout=_ANSWER_S)
    except (InputError, OSError, subprocess.TimeoutExpired):
        return ""
    if asked.returncode == 2:
        raise InputError(asked.stderr.strip().removeprefix("voltlap: ").replace("\n", " "))
    return asked.stdout


@lru_cache(maxsize=256)
def _table(arguments: Sequence[str], soc: float, axis: str, name: str) -> float:
    """Of a cell at this charge, by the tables that an image gets; 0 where the program is not built yet."""
    with tempfile.TemporaryDirectory(prefix="voltlap-hil-") as folder:
        out = Path(folder) / "pack_config.hpp"
        _answer.__wrapped__("firmware-tables", *arguments, "--out", str(out))
        header = out.read_text() if out.exists() else ""
    found = [re.search(rf"{one}\[\] = {{[^\n]*\n([^}}]*)}}", header) for one in (axis, name)]
    if not all(found):
        return 0.0
    socs, values = ([float(n) for n in one[1].split(",") if n.strip()] for one in found if one)
    wanted = soc * 1e6
    k = max(1, next((i for i, s in enumerate(socs) if s >= wanted), len(socs) - 1))
    share = (wanted - socs[k - 1]) / (socs[k] - socs[k - 1])
    return values[k - 1] + share * (values[k] - values[k - 1])
