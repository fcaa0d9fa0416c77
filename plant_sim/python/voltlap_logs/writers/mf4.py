# SPDX-License-Identifier: Apache-2.0
"""MF4 with ASAM bus logging by asammdf: CAN_DataFrame, CAN_RemoteFrame and CAN_ErrorFrame, each a group. The error
frame's ID is SocketCAN's class of error, as python-can writes it."""
from __future__ import annotations

from array import array
from collections.abc import Iterator
from datetime import datetime, timezone
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..candump import BRS, ERROR, ESI, EXTENDED, FD_LENGTHS, ID_MASK, NS, fd_code
from ..errors import need
from ..readers.mf4 import KINDS
from ..spool import Spool

if TYPE_CHECKING:
    import numpy as np

COMPRESSED = 2  # deflate after transposition
CODES = {length: fd_code(length) for length in FD_LENGTHS}


class Columns:
    """The frames of one kind, as they come."""

    def __init__(self) -> None:
        self.time_ns, self.id, self.payload = array("q"), array("I"), bytearray()
        self.numbers = bytearray()  # a frame: channel, data length code, length, FD flags + 1

    def signal(self, kind: str, start_ns: int) -> object:
        np = need("numpy")
        blocks = need("asammdf.blocks.v4_blocks")
        constants = need("asammdf.blocks.v4_constants")
        time_ns = np.frombuffer(self.time_ns, np.int64)
        order = np.argsort(time_ns, kind="stable")
        return need("asammdf").Signal(
            name=kind, samples=self._samples(kind)[order], timestamps=(time_ns[order] - start_ns) * 1e-9,
            source=blocks.SourceInformation(source_type=constants.SOURCE_BUS, bus_type=constants.BUS_TYPE_CAN))

    def _samples(self, kind: str) -> np.ndarray[Any, Any]:
        np = need("numpy")
        rows = len(self.time_ns)
        numbers = np.frombuffer(self.numbers, np.uint8).reshape(rows, 4)
        id, length = np.frombuffer(self.id, np.uint32), numbers[:, 2].astype(np.int64)
        flags = np.where(numbers[:, 3], numbers[:, 3] - 1, 0)
        width = 8 if int(length.max(initial=0)) <= 8 else 64
        columns: list[tuple[str, Any, Any]] = [
            ("BusChannel", "<u1", numbers[:, 0]), ("ID", "<u4", id & ID_MASK), ("IDE", "<u1", (id & EXTENDED) != 0),
            ("DLC", "<u1", numbers[:, 1]), ("DataLength", "<u1", length), ("Dir", "<u1", 0)]
        if kind != "CAN_RemoteFrame":
            data = np.zeros((rows, width), np.uint8)
            data[np.arange(width) < length[:, None]] = np.frombuffer(self.payload, np.uint8)
            columns += [("DataBytes", f"({width},)u1", data), ("EDL", "<u1", numbers[:, 3] != 0),
                        ("BRS", "<u1", (flags & BRS) != 0), ("ESI", "<u1", (flags & ESI) != 0)]
        out = np.zeros(rows, dtype=[(f"{kind}.{name}", type) for name, type, _ in columns])
        for name, _, values in columns:
            out[f"{kind}.{name}"] = values
        return out  # type: ignore[no-any-return]


def collected(spool: Spool, channels: dict[str, int]) -> Iterator[tuple[str, Columns]]:
    data, remote, error = (Columns() for _ in KINDS)
    for frame in spool.frames():
        length = len(frame.data)
        into = error if frame.id & ERROR else data if frame.remote_length is None else remote
        into.time_ns.append(frame.time_ns)
        into.id.append(frame.id)
        into.numbers += bytes((channels[frame.bus], CODES[length] if frame.remote_length is None else
                               frame.remote_length, length, 0 if frame.fd_flags is None else frame.fd_flags + 1))
        into.payload += frame.data
    return iter(zip(KINDS, (data, remote, error), strict=True))


def write(path: Path, spool: Spool) -> None:
    asammdf = need("asammdf")
    channels = spool.channels(1)
    start_ns = max(spool.first_ns, 0)  # MF4 has no start before 1970
    with asammdf.MDF(version="4.11") as mdf:
        mdf.header.start_time = datetime.fromtimestamp(start_ns // NS, timezone.utc)
        mdf.header.abs_time = start_ns  # to the nanosecond, which a datetime has not
        for kind, columns in collected(spool, channels):
            if columns.time_ns or kind == "CAN_DataFrame":
                mdf.append(columns.signal(kind, start_ns), comment="CAN bus logging")
        with path.open("wb+") as out:  # given a name, asammdf may write to another one
            mdf.save(out, compression=COMPRESSED)
