# SPDX-License-Identifier: Apache-2.0
"""A Parquet file by pyarrow: one table; of a file that writers/signals_parquet.py wrote, one for each frame."""
from __future__ import annotations

from typing import Any

from ..errors import LogError, need
from ..source import Source
from ..table import Channel, Table, Tables


def plain(column: Any) -> Any:
    """Dates as seconds since 1970, dictionaries as their words; what Python shows as a number or text stays."""
    arrow, compute = need("pyarrow"), need("pyarrow.compute")
    kind = column.type
    if arrow.types.is_dictionary(kind):
        column = column.cast(kind.value_type)
    elif arrow.types.is_timestamp(kind) or arrow.types.is_date(kind):
        ns = column.cast(arrow.timestamp("ns"), safe=False).cast(arrow.int64())
        column = compute.divide(ns.cast(arrow.float64(), safe=False), 1e9)
    return column.to_pylist()


def channel(field: Any) -> Channel:
    arrow = need("pyarrow")
    about = {key.decode(): value.decode() for key, value in (field.metadata or {}).items()}
    seconds = arrow.types.is_timestamp(field.type) or arrow.types.is_date(field.type)
    unit = "" if field.name.endswith("_s") else about.get("unit", "s" if seconds else "")
    return Channel(field.name, unit, about.get("comment", ""))


def whole(file: Any, name: str) -> Table:
    schema = file.schema_arrow
    return Table(name, file.metadata.num_rows, [channel(field) for field in schema],
                 lambda: [plain(column) for column in file.read().columns])


def by_frame(file: Any) -> list[Table]:
    """One table a frame: the columns that it carries, its rows."""
    keys = file.read(columns=["bus", "frame"])
    pairs = keys.group_by(["bus", "frame"]).aggregate([([], "count_all")]).to_pylist()
    several = len({pair["frame"] for pair in pairs}) < len(pairs)
    found = []
    for pair in sorted(pairs, key=lambda pair: (pair["bus"], pair["frame"])):
        name = f"{pair['bus']}.{pair['frame']}" if several else pair["frame"]
        found.append(frame_table(file, name, pair))
    return found


def frame_table(file: Any, name: str, pair: dict[str, Any]) -> Table:
    """The rows of one frame; each signal's field says which frame carries it."""
    arrow, compute = need("pyarrow"), need("pyarrow.compute")
    own = {b"frame": pair["frame"].encode(), b"bus": (pair["bus"] or "").encode()}
    fields = [field for field in file.schema_arrow if field.name == "time_s" or field.metadata and all(
        field.metadata.get(key, b"") == value for key, value in own.items())]

    def columns() -> list[Any]:
        names = [field.name for field in fields]
        parts = []
        for number in range(file.num_row_groups):
            rows = file.read_row_group(number, columns=[*names, "frame", "bus"])
            wanted = compute.and_(compute.equal(rows["frame"], pair["frame"]), compute.equal(rows["bus"], pair["bus"]))
            parts.append(rows.select(names).filter(wanted))
        return [plain(column) for column in arrow.concat_tables(parts).columns]

    return Table(name, pair["count_all"], [channel(field) for field in fields], columns)


def read(source: Source) -> Tables:
    parquet, path = need("pyarrow.parquet"), source.file()
    try:
        file = parquet.ParquetFile(path)
        own = b"origin_s" in (file.schema_arrow.metadata or {}) and "frame" in file.schema_arrow.names
        return Tables("Parquet", "", by_frame(file) if own else [whole(file, source.path.stem)])
    except (need("pyarrow").ArrowException, OSError) as error:
        told = " ".join(str(error).split())
        raise LogError(f"{source.path}: cannot be read as Parquet ({told}): the file is damaged or was cut; write it "
                       "again") from error


