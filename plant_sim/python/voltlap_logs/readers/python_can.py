# SPDX-License-Identifier: Apache-2.0
"""The two formats that are python-can's own: its CSV (which has no channel: `can0`) and its SQLite table `messages`
(`can0` too, unless a column or table beside it has channels: N is `canN`, a name stays). Neither says whether a
frame was FD: more than eight bytes are."""
from __future__ import annotations

import sqlite3
import struct
from base64 import b64decode
from collections.abc import Iterator
from pathlib import Path

from ..candump import BUS_ERROR, ERROR, EXTENDED, FD_LENGTHS, ID_MASK, NS, Frame, line
from ..errors import BrokenOff, LogError
from ..source import Source
from ..tally import Tally, shown

CSV_HEADER = "timestamp,arbitration_id,extended,remote,error,dlc,data"
EXACT_S = 4e6  # up to here a double tells nanoseconds apart; the time since 1970 only microseconds
Row = tuple[float, int, int, int, int, int, bytes]


def text_of(row: Row, bus: str) -> str:
    seconds, id, extended, remote, error, length, data = row
    exact = abs(seconds) < EXACT_S
    time_ns = round(seconds * NS) if exact else round(seconds * 1_000_000) * 1000
    decimals = 9 if exact and time_ns % 1000 else 6
    if length not in FD_LENGTHS or not (remote or len(data) == length):
        raise ValueError(length)
    if error:
        return line(Frame(time_ns, bus, ERROR | (id & ID_MASK or BUS_ERROR), data), decimals)
    tagged = (id & ID_MASK) | (EXTENDED if extended else 0)
    if remote:
        return line(Frame(time_ns, bus, tagged, b"", None, length), decimals)
    return line(Frame(time_ns, bus, tagged, data, 0 if length > 8 else None), decimals)


def read_csv(source: Source, tally: Tally) -> Iterator[str]:
    for number, text in source.lines():
        if number == 1:
            if text.strip() != CSV_HEADER:
                raise LogError(f"{source.path}: line 1 is '{shown(text[:60])}'; expected '{CSV_HEADER}': leave "
                               "--format out, or look at the file")
            continue
        if not text.strip():
            continue
        try:
            time, id, extended, remote, error, length, data = text.split(",")
            yield text_of((float(time), int(id, 16), int(extended), int(remote), int(error), int(length),
                           b64decode(data, validate=True)), "can0")
        except (ValueError, OverflowError):
            tally.unreadable(source, number, text)


def bus_name(channel: object) -> str:
    name = "_".join(str(channel).split()) if channel is not None else ""
    return f"can{name}" if name.isdigit() else name or "can0"


def missing_bytes(path: Path) -> int:
    """How much less of the file there is than its header says."""
    with path.open("rb") as file:
        header = file.read(100).ljust(100, b"\0")
    page, changed, pages, valid = *struct.unpack_from(">H", header, 16), *struct.unpack_from(">II", header, 24), \
        *struct.unpack_from(">I", header, 92)
    return (page if page > 1 else 65536) * pages - path.stat().st_size if changed == valid else 0


def read_sqlite(source: Source, tally: Tally) -> Iterator[str]:
    path = source.file()
    if not source.head(16).startswith(b"SQLite format 3"):
        raise LogError(f"{source.path}: is no SQLite file: leave --format out")
    connection = sqlite3.connect(path.resolve().as_uri() + "?mode=ro", uri=True)
    try:
        columns = [row[1] for row in connection.execute("PRAGMA table_info(messages)")]
        wanted = ["ts", "arbitration_id", "extended", "remote", "error", "dlc", "data"]
        if missing := [name for name in wanted if name not in columns]:
            raise LogError(f"{path}: an SQLite file whose table 'messages' has no column {missing[0]}; expected what "
                           f"python-can's SqliteWriter makes ({', '.join(wanted)})")
        # python-can has no channel; the table `channels` beside it is of writers/database.py
        beside = connection.execute("SELECT 1 FROM sqlite_master WHERE name = 'channels'").fetchone()
        channel = "channel" if "channel" in columns or beside else "NULL"
        join = "LEFT JOIN channels ON message = messages.rowid" if beside and "channel" not in columns else ""
        query = f"SELECT {', '.join(wanted)}, {channel} FROM messages {join} ORDER BY messages.rowid"
        for number, row in enumerate(connection.execute(query), 1):
            if beside and row[7] is None:
                raise BrokenOff(f"the bus of row {number} is missing")
            try:
                yield text_of((*row[:6], bytes(row[6] or b"")), bus_name(row[7]))
            except (ValueError, TypeError, OverflowError):
                tally.skip("unreadable rows", f"row {number}: {row}")
    except (sqlite3.Error, UnicodeDecodeError, OverflowError) as error:
        raise BrokenOff(f"the SQLite file is damaged ({error})") from error
    finally:
        connection.close()
    if (lacking := missing_bytes(path)) > 0:
        raise BrokenOff(f"the last {lacking} bytes of the SQLite file are missing")
