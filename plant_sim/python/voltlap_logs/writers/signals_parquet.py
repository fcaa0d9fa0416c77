# SPDX-License-Identifier: Apache-2.0
"""Decoded signals as one Parquet file by pyarrow: a row a frame in the order of their times, a column a signal,
null where that frame does not carry it; columns `time_s` (seconds since 1970), `frame` and `bus` (dictionaries) before
them. Units, comments and value texts stand in each field's metadata.

    data = pandas.read_parquet("drive.parquet"); data.loc[data["frame"] == "BmsStatus", ["time_s", "PackVoltage"]]
"""
from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import need
from ..merge import by_time
from ..signal_folder import Column, Group, Signals
from ..source import Progress

if TYPE_CHECKING:
    import numpy as np

    Array = np.ndarray[Any, Any]

ROWS = 1 << 17  # of one row group
LEADING = ("time_s", "frame", "bus")


def about(group: Group, column: Column) -> dict[str, str]:
    texts = json.dumps({f"{value:g}": text for value, text in column.choices.items()}) if column.choices else ""
    given = {"unit": column.unit, "comment": column.comment, "choices": texts, "frame": group.name,
             "bus": group.bus}
    return {key: value for key, value in given.items() if value}


def schema(signals: Signals) -> Any:
    arrow = need("pyarrow")
    word = arrow.dictionary(arrow.int32(), arrow.string())
    fields = [arrow.field("time_s", arrow.float64(), metadata={"unit": "s"}), arrow.field("frame", word),
              arrow.field("bus", word)]
    fields += [arrow.field(column_name(column), arrow.float64(), metadata=about(group, column))
               for group in signals.groups for column in group.columns]
    return arrow.schema(fields, metadata={"source": signals.source, "origin_s": repr(signals.origin_s)})


def column_name(column: Column) -> str:
    return f"signal.{column.unique}" if column.unique in LEADING else column.unique


def spread(values: Array, at: Array, rows: int) -> Any:
    """An Arrow column of `rows` with `values` at some of them, null elsewhere and where NaN."""
    arrow, np = need("pyarrow"), need("numpy")
    there = ~np.isnan(values)
    data, valid = np.zeros(rows), np.zeros(rows, bool)
    data[at], valid[at] = np.where(there, values, 0.0), there
    bitmap = np.packbits(valid, bitorder="little")
    return arrow.Array.from_buffers(arrow.float64(), rows, [arrow.py_buffer(bitmap), arrow.py_buffer(data)],
                                    rows - int(valid.sum()))


def words(numbers: Array, names: list[str]) -> Any:
    arrow = need("pyarrow")
    return arrow.DictionaryArray.from_arrays(arrow.array(numbers, arrow.int32()), arrow.array(names, arrow.string()))


def group_columns(group: Group, at: Array, row: Array, rows: int) -> list[Any]:
    if not len(at):
        return [need("pyarrow").nulls(rows, need("pyarrow").float64()) for _ in group.columns]
    return [spread(column.values()[row], at, rows) for column in group.columns]


def write(path: Path, signals: Signals) -> None:
    arrow, parquet, np = need("pyarrow"), need("pyarrow.parquet"), need("numpy")
    times, owner, row = by_time(signals)
    buses = sorted({group.bus for group in signals.groups})
    bus_of = np.array([buses.index(group.bus) for group in signals.groups])
    frames = [group.name for group in signals.groups]
    progress, described = Progress(str(path.name)), schema(signals)
    with parquet.ParquetWriter(path, described, compression="zstd", use_dictionary=list(LEADING[1:])) as writer:
        for begin in range(0, len(times), ROWS):
            part = slice(begin, begin + ROWS)
            owners, rows = owner[part], len(owner[part])
            columns = [arrow.array(times[part] + signals.origin_s), words(owners, frames),
                       words(bus_of[owners], buses)]
            for k, group in enumerate(signals.groups):
                at = np.flatnonzero(owners == k)
                columns += group_columns(group, at, row[part][at], rows)
            writer.write_table(arrow.Table.from_arrays(columns, schema=described), row_group_size=ROWS)
            progress.tell(f"{100 * begin / len(times):.0f} %")
    progress.done()
