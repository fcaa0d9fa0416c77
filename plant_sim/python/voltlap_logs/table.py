# SPDX-License-Identifier: Apache-2.0
"""One table of a measurement file: columns of one length that share their times. Nothing is resampled."""
from __future__ import annotations

import csv
import io
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, TextIO

ROWS = 1 << 15  # written at a time


@dataclass
class Channel:
    name: str
    unit: str = ""
    comment: str = ""

    @property
    def header(self) -> str:
        """`name [unit]`; a name that ends in its unit, as those of a run do (pack_voltage_v), stays alone."""
        if not self.unit or self.name.lower().endswith(f"_{self.unit.lower()}"):
            return self.name
        return f"{self.name} [{self.unit}]"


@dataclass
class Table:
    name: str
    rows: int
    channels: list[Channel]  # the time first, where there is one
    columns: Callable[[], list[Any]] = field(repr=False)  # one array or list a channel, read when they are wanted


@dataclass
class Tables:
    format: str
    start: str  # as ISO 8601, or empty
    tables: list[Table]


def cell(value: object) -> str:
    """The shortest text that reads back as the same number; nothing for what is not there."""
    if isinstance(value, float):
        if math.isnan(value):
            return ""
        text = repr(value)
        return text[:-2] if text.endswith(".0") else text
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(int(value))
    if isinstance(value, bytes):
        return value.rstrip(b"\0").decode("utf-8", "replace")
    return bytes(value).hex().upper() if isinstance(value, list) else str(value)


def texts(column: Any) -> list[str]:
    values = column.tolist() if hasattr(column, "tolist") else column
    return [cell(value) for value in values]


def quoted(words: Sequence[str]) -> str:
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerow(words)
    return out.getvalue()


def lines(table: Table) -> Iterator[str]:
    yield quoted([channel.header for channel in table.channels])
    columns = table.columns()
    rows = len(columns[0]) if columns else 0
    for begin in range(0, rows, ROWS):
        block = [texts(column[begin:begin + ROWS]) for column in columns]
        plain = not any(mark in text for column in block for text in column for mark in ',"\n\r')
        if plain:
            yield "".join(",".join(row) + "\n" for row in zip(*block, strict=True))
        else:
            yield "".join(quoted(row) for row in zip(*block, strict=True))


def write_csv(table: Table, out: TextIO) -> None:
    for text in lines(table):
        out.write(text)
