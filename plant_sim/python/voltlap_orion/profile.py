# SPDX-License-Identifier: Apache-2.0
"""What a profile says, in SI units, each value checked before it is used."""
from __future__ import annotations

import dataclasses
import math
import re

from voltlap_orion.bean_file import Bean, ProfileRefused, quoted
from voltlap_orion.settings import FIRST_C, SETTINGS, STEP_C, TABLES

WHOLE = ("byte", "int", "long", "short")
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
PERIOD_S = 0.008  # of a frame: (frequency + 1) times this
CELLS = re.compile(r"populationTable\[(\d+)\]\.populated", re.ASCII)
MESSAGE = re.compile(r"customMessages\[(\d+)\]\.(id|length|frequency)", re.ASCII)


@dataclasses.dataclass(frozen=True)
class Message:
    """A frame that the profile lays out; None: not in the file, so the utility's default."""
    number: int
    identifier: int | None
    length: int | None
    period_s: float | None


def number_of(bean: Bean, name: str) -> float | None:
    """As recorded; None where the file does not have it."""
    value = bean.values.get(name)
    if value is None:
        return None
    text = value.text.strip()
    whole = value.kind in WHOLE
    if not (whole or value.kind in ("double", "float")) or not NUMBER.fullmatch(text) or len(text) > 40 or (
            whole and not re.fullmatch(r"[+-]?\d+", text, re.ASCII)):
        raise ProfileRefused(bean.where(name), f"{value.kind} {quoted(text)}", "a number", "Correct the profile")
    out = float(text)
    if not math.isfinite(out):
        raise ProfileRefused(bean.where(name), quoted(text), "a finite number", "Correct the profile")
    return out


class Profile:
    def __init__(self, bean: Bean):
        self.bean = bean

    def get(self, name: str) -> float | None:
        """A setting in its unit; None where the file does not have it."""
        setting, found = SETTINGS[name], number_of(self.bean, name)
        if found is None:
            return None
        value = found * setting.scale
        if not setting.least <= value <= setting.most:
            raise ProfileRefused(self.bean.where(name), f"{value:g} {setting.unit}".rstrip(),
                                 f"{setting.least:g} to {setting.most:g}", "Correct the profile")
        return value

    def need(self, name: str, why: str) -> float:
        value = self.get(name)
        if value is None:
            raise ProfileRefused(self.bean.where(name), "nothing: the utility leaves out what has its default",
                                 why, "Set it in the utility to another value and back to yours")
        return value

    def table(self, name: str) -> list[float] | None:
        """Its points, of which the first is for -40 degC; None where the file has none of them."""
        table, out, found = TABLES[name], [0.0] * TABLES[name].points, False
        for key in self.bean.values:
            match = re.fullmatch(re.escape(name) + r"\[(\d+)\]", key, re.ASCII)
            if match is None:
                continue
            index, value = int(match[1]), (number_of(self.bean, key) or 0.0) * table.scale
            if index >= table.points or not 0.0 <= value <= 65535.0:
                raise ProfileRefused(self.bean.where(key), f"{value:g} {table.unit}",
                                     f"{table.points} points of 0 to 65535", "Correct the profile")
            out[index], found = value, True
        return out if found else None

    def populated(self) -> int:
        """Cells that the population table marks; 0: it has none."""
        count = 0
        for key, value in self.bean.values.items():
            if CELLS.fullmatch(key):
                if value.kind != "boolean" or value.text.strip() not in ("true", "false"):
                    raise ProfileRefused(self.bean.where(key), f"{value.kind} {quoted(value.text)}", "true or false",
                                         "Correct the profile")
                count += value.text.strip() == "true"
        return count

    def cells(self) -> int:
        """Cells in series; the two places that say it agree."""
        populated, total = self.populated(), self.get("totalCells")
        if populated and total is not None and populated != total:
            raise ProfileRefused(self.bean.where("totalCells"), f"{total:g}",
                                 f"the {populated} cells that populationTable marks", "Correct one of the two")
        return populated or int(self.need("totalCells", "the number of cells"))

    def resistance_ohm(self, temperature_c: float) -> float | None:
        """Of a cell, in the limits of the Orion; between two points of the table on the line through them."""
        points, factor = self.table("resistanceTable"), self.get("intresDCMultiplier")
        if points is None or factor is None:
            return None
        place = min(max((temperature_c - FIRST_C) / STEP_C, 0.0), len(points) - 1.0)
        low = min(int(place), len(points) - 2)
        return 1e-3 * factor * (points[low] + (place - low) * (points[low + 1] - points[low]))

    def messages(self) -> list[Message]:
        numbers: dict[int, dict[str, int]] = {}
        for key in self.bean.values:
            if match := MESSAGE.fullmatch(key):
                value = number_of(self.bean, key)
                most = {"id": 0x1FFFFFFF, "length": 8, "frequency": 65535}[match[2]]
                if value is None or not 0 <= value <= most:
                    raise ProfileRefused(self.bean.where(key), f"{value:g}", f"0 to {most}", "Correct the profile")
                numbers.setdefault(int(match[1]), {})[match[2]] = int(value)
        return [Message(number, found.get("id"), found.get("length"),
                        PERIOD_S * (found["frequency"] + 1) if "frequency" in found else None)
                for number, found in sorted(numbers.items())]

    def is_understood(self, name: str) -> bool:
        table = re.fullmatch(r"(\w+)\[\d+\]", name, re.ASCII)
        return (name in SETTINGS or bool(CELLS.fullmatch(name) or MESSAGE.fullmatch(name))
                or (table is not None and table[1] in TABLES))

    def not_understood(self) -> list[str]:
        return [name for name in self.bean.values if not self.is_understood(name)]
