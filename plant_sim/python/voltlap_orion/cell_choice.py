# SPDX-License-Identifier: Apache-2.0
"""The cell of a pack file: one of data/cells by name, or a cell file by its path."""
from __future__ import annotations

import dataclasses
import json
import math
import pathlib
import re

from voltlap_logs.errors import LogError

CELLS = pathlib.Path(__file__).resolve().parents[2] / "data" / "cells"
ASSUMED = "molicel_p42a"


@dataclasses.dataclass(frozen=True)
class Cell:
    name: str  # as the pack file is to have it
    path: pathlib.Path
    capacity_ah: float
    reference_temperature_c: float
    voltage_max_v: float
    assumed: bool

    def toml_name(self) -> str:
        return json.dumps(self.name)  # TOML's basic strings are JSON's where all signs are printable


def number(path: pathlib.Path, text: str, key: str, least: float, most: float) -> float:
    """One number of the top of a cell file: Python has a reader of TOML from 3.11 on only."""
    top = re.split(r"(?m)^\s*\[", text, maxsplit=1)[0]
    found = re.search(rf"(?m)^{key}\s*=\s*([0-9.eE_+-]{{1,40}})\s*(?:#|$)", top, re.ASCII)
    try:
        value = float(found[1]) if found else math.nan
    except ValueError:
        value = math.nan
    if not least <= value <= most:
        raise LogError(f"{path}: found {key} = {found[1] if found else 'nothing'}; expected a number from {least:g} to "
                       f"{most:g}. Give a cell file as --cell.")
    return value


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
        text = path.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise LogError(f"{path}: found what is no text ({error}); expected a cell file. Give one as --cell.") from error
    return Cell(name, path, number(path, text, "capacity_ah", 0.1, 1000.0),
                number(path, text, "reference_temperature_c", -40.0, 100.0),
                number(path, text, "voltage_max_v", 1.0, 5.0), asked is None)
