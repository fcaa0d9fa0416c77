# SPDX-License-Identifier: Apache-2.0
"""Decoded signals as the native programs leave them: `manifest.json` and one raw file of doubles for each column.

    {"origin_s": 1763828454.0, "source": "drive.log", "groups": [{"name": "BmsStatus", "bus": "can0", "id": 291,
     "rows": 3000, "time": "0.time.f64", "columns": [{"name": "PackVoltage", "unit": "V", "comment": "...",
     "file": "0.0.f64", "choices": {"0": "off"} or null}]}]}

A time is seconds after `origin_s` (since 1970). NaN is a signal that the frame of that row did not carry.
"""
from __future__ import annotations

import json
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .errors import LogError, need

if TYPE_CHECKING:
    import numpy as np

    Doubles = np.ndarray[Any, np.dtype[np.float64]]


@dataclass
class Column:
    name: str
    unit: str
    comment: str
    file: Path
    rows: int
    choices: dict[float, str] = field(default_factory=dict)
    unique: str = ""  # its name among all groups: with the frame before it where another frame has the same signal

    def values(self) -> Doubles:
        return doubles(self.file, self.rows)


@dataclass
class Group:
    name: str
    bus: str
    id: int
    rows: int
    time: Path
    columns: list[Column]

    @property
    def unique(self) -> str:
        return f"{self.bus}.{self.name}" if self.bus else self.name

    def times(self) -> Doubles:
        return doubles(self.time, self.rows)


@dataclass
class Signals:
    origin_s: float
    source: str
    groups: list[Group]

    @property
    def rows(self) -> int:
        return sum(group.rows for group in self.groups)


def doubles(path: Path, rows: int) -> Doubles:
    np = need("numpy")
    if not rows:
        return np.zeros(0)  # type: ignore[no-any-return]
    found = path.stat().st_size if path.exists() else -1
    if found != 8 * rows:
        told = f"has {found} bytes" if found >= 0 else "is missing"
        raise LogError(f"{path}: {told}; expected {8 * rows} for {rows} rows of doubles: decode the recording again")
    return np.memmap(path, "<f8", "r", shape=(rows,))  # type: ignore[no-any-return]


def choices_of(given: dict[str, str] | None) -> dict[float, str]:
    return {float(value): text for value, text in (given or {}).items()}


def name_uniquely(groups: list[Group]) -> None:
    frames = Counter(group.name for group in groups)
    signals = Counter(column.name for group in groups for column in group.columns)
    for group in groups:
        for column in group.columns:
            column.unique = column.name
            if signals[column.name] > 1:
                frame = group.unique if frames[group.name] > 1 else group.name
                column.unique = f"{frame}.{column.name}"


def load(folder: Path) -> Signals:
    path = folder / "manifest.json"
    if not path.is_file():
        raise LogError(f"{folder}: has no manifest.json; expected the folder that `voltlap log` decodes into")
    try:
        given = json.loads(path.read_text())
        groups = [Group(str(group["name"]), str(group.get("bus") or ""), int(group.get("id", 0)), int(group["rows"]),
                        folder / group["time"],
                        [Column(str(column["name"]), str(column.get("unit") or ""), str(column.get("comment") or ""),
                                folder / column["file"], int(group["rows"]), choices_of(column.get("choices")))
                         for column in group["columns"]])
                  for group in given["groups"]]
        signals = Signals(float(given["origin_s"]), str(given.get("source", "")), groups)
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise LogError(f"{path}: {type(error).__name__} at {error}; expected the fields that `voltlap log` writes: "
                       "decode the recording again") from error
    signals.groups = [group for group in groups if group.rows]
    if not signals.groups:
        raise LogError(f"{path}: no frame of the recording was decoded, so there is nothing to write; give the DBC "
                       "file of this car")
    name_uniquely(signals.groups)
    return signals
