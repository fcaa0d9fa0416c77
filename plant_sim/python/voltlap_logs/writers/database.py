# SPDX-License-Identifier: Apache-2.0
"""The SQLite table `messages` of python-can. It has no channel and no flags of FD; a table `channels` beside it, which
python-can passes over, has the bus of each row."""
from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from pathlib import Path

from ..candump import ERROR, EXTENDED, ID_MASK, Frame
from ..spool import Spool

Row = tuple[float, int, int, int, int, int, bytes]


def row(frame: Frame) -> Row:
    remote = frame.remote_length is not None
    return (frame.time_ns / 1e9, frame.id & ID_MASK, int(bool(frame.id & EXTENDED)), int(remote),
            int(bool(frame.id & ERROR)), frame.remote_length if frame.remote_length is not None else len(frame.data),
            frame.data)


def rows(spool: Spool) -> Iterator[Row]:
    for frame in spool.frames():
        if frame.fd_flags is not None and (frame.fd_flags or len(frame.data) <= 8):
            spool.changed["FD frames without their flags, short ones as classic frames"] += 1
        yield row(frame)


def write(path: Path, spool: Spool) -> None:
    path.unlink(missing_ok=True)
    connection = sqlite3.connect(path)
    try:
        connection.execute("PRAGMA journal_mode=OFF")
        connection.execute("CREATE TABLE messages (ts REAL, arbitration_id INTEGER, extended INTEGER, remote INTEGER, "
                           "error INTEGER, dlc INTEGER, data BLOB)")
        connection.executemany("INSERT INTO messages VALUES (?, ?, ?, ?, ?, ?, ?)", rows(spool))
        connection.execute("CREATE TABLE channels (message INTEGER PRIMARY KEY, channel TEXT)")
        connection.executemany("INSERT INTO channels VALUES (?, ?)",
                               enumerate((frame.bus for frame in spool.frames()), 1))
        connection.commit()
    finally:
        connection.close()
