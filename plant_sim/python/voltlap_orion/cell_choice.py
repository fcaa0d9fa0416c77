# SPDX-License-Identifier: Apache-2.0
"""The cell of a pack file: one of data/cells by name, or a cell file by its path."""
from __future__ import annotations

import dataclasses
import json
import math
import pathlib
import tomllib

from voltlap_logs.errors import LogError

CELLS = pathlib.Path(__file__).resolve().parents[2] / "data" / "cells"
ASSUMED = "molicel_p42a"


@dataclasses.dataclass(frozen=True)
class Cell:
    name: str  # as the pack file is to have it
    path: pathlib.Path
    capacity_ah: float
    reference_temperature_c: float
    assumed: bool

    def toml_name(self) -> str:
        return json.dumps(self.name)  # TOML's basic strings are JSON's where all signs are printable


def number(path: pathlib.Path, table: dict, key: str, least: float, most: float) -> float:
    value = table.get(key)
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if not is_number or not math.isfinite(value) or not least <= value <= most:
        raise LogError(f"{path}: found {key} = {value!r}; expected a number from {least:g} to {most:g}. "
                       "Give a cell file as --cell.")
    return float(value)


def choose_cell(asked: str | None) -> Cell:
    name = asked or ASSUMED
    shipped = {path.stem: path for path in CELLS.glob("*.toml")}
    path = shipped.get(name, pathlib.Path(name))
    if name not in shipped and not path.is_file():
        raise LogError(f'--cell: found "{name}"; expected one of {", ".join(sorted(shipped))}, or a cell file. '
                       "`voltlap list cells` describes them.")
    if name not in shipped:
        name = str(path.resolve())
        if not name.isprintable():
            raise LogError(f"--cell: found {name!r}; expected a path of printable signs. Rename it.")
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise LogError(f"{path}: found what is no TOML ({error}); expected a cell file. Give one as --cell.") from error
    return Cell(name, path, number(path, table, "capacity_ah", 0.1, 1000.0),
                number(path, table, "reference_temperature_c", -40.0, 100.0), asked is None)
