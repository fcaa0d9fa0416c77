# SPDX-License-Identifier: Apache-2.0
"""Lists the tables of a measurement file, or writes one of them as CSV.

    python -m voltlap_logs.tables FILE             groups, rows, channels with units
    python -m voltlap_logs.tables --json FILE
    python -m voltlap_logs.tables --csv GROUP FILE > group.csv       GROUP: its number or name, `can0.` may be left out

MF4, MDF 2 and 3, Parquet; gzip or zstd around them. Every group is a table of its own: nothing is resampled. The first
column of an MDF group is `time_s`, seconds after the start of the file; the others are called `name [unit]`.
"""
from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path

from .errors import LogError, run
from .readers import mdf_tables, parquet_tables
from .sniff import MDF3, MF4, PARQUET, sniff
from .source import Source
from .table import Table, Tables, write_csv

PROGRAM = "voltlap_logs.tables"


def chosen(tables: Tables, wanted: str, path: Path) -> Table:
    named = [table for table in tables.tables if table.name == wanted]
    named = named or [table for table in tables.tables if table.name.rpartition(".")[2] == wanted]
    if len(named) == 1:
        return named[0]
    if wanted.isdigit() and int(wanted) < len(tables.tables):
        return tables.tables[int(wanted)]
    names = ", ".join(f"{k} {table.name}" for k, table in enumerate(tables.tables[:20]))
    told = "several groups have that name; give the number" if named else "there is no such group"
    raise LogError(f"{path}: group '{wanted}': {told}: {names}{' ...' if len(tables.tables) > 20 else ''}")


def show(tables: Tables, path: Path) -> None:
    started = f", start {tables.start}" if tables.start else ""
    print(f"{path}: {tables.format}{started}, {len(tables.tables)} groups")
    for number, table in enumerate(tables.tables):
        print(f"{number:>4} {table.name}: {table.rows} rows")
        for channel in table.channels:
            print(f"       {channel.header}   {' '.join(channel.comment.split())[:60]}".rstrip())


def show_json(tables: Tables) -> None:
    print(json.dumps({"format": tables.format, "start": tables.start, "groups": [
        {"name": table.name, "rows": table.rows, "channels": [vars(channel) for channel in table.channels]}
        for table in tables.tables]}))


def work(options: argparse.Namespace) -> int:
    with Source(options.file) as source:
        found = sniff(source) if source.size else None
        if found in (MF4, MDF3):
            tables, mdf = mdf_tables.read(source)
        elif found == PARQUET:
            tables, mdf = parquet_tables.read(source), None
        else:
            told = found.name if found else "of no format that is known"
            raise LogError(f"{options.file}: {told}; expected MF4, MDF or Parquet; a recording of frames is read by "
                           "`python -m voltlap_logs.frames`")
        try:
            if options.csv is not None:
                write_csv(chosen(tables, options.csv, options.file), sys.stdout)
                sys.stdout.flush()
            elif options.json:
                show_json(tables)
            else:
                show(tables, options.file)
        finally:
            if mdf:
                mdf.close()
    return 0


def main(given: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(PROGRAM, description="Lists the tables of a measurement file, or writes one.")
    parser.add_argument("file", type=Path)
    form = parser.add_mutually_exclusive_group()
    form.add_argument("--csv", metavar="GROUP", help="number or name of a group: write it as CSV to stdout")
    form.add_argument("--json", action="store_true", help="the list as JSON")
    options = parser.parse_args(given)
    return run(lambda: work(options))


if __name__ == "__main__":
    sys.exit(main())
