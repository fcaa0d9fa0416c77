# SPDX-License-Identifier: Apache-2.0
"""MF4 with CAN bus logging (ASAM MDF bus logging: groups of CAN_DataFrame, CAN_RemoteFrame, CAN_ErrorFrame), read by
asammdf, whole columns at a time. Several groups are merged by time. BusChannel N becomes `canN`."""
from __future__ import annotations

import logging
import re
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..candump import BUS_ERROR, ERROR, EXTENDED, FD_LENGTHS, ID_MASK, LINE_ERRORS, PROTOCOL_ERROR, identifier, stamp
from ..errors import BrokenOff, LogError, need
from ..isolated import isolated
from ..source import Source
from ..tally import Tally

if TYPE_CHECKING:
    import numpy as np

KINDS = ("CAN_DataFrame", "CAN_RemoteFrame", "CAN_ErrorFrame")
OTHER_BUSES = re.compile(r"^(LIN|FLX|ETH|CAN_Overload)\w*Frame$")
BLOCK = 1 << 17
ERROR_TYPES = (0, 1, 2, 4, 0, 0)  # ASAM's ErrorType: unknown, bit, form, stuff, CRC, acknowledgement


class Group:
    """One channel group's frames as columns, in the order of the file."""

    def __init__(self, mdf: Any, number: int, kind: str) -> None:
        self._mdf, self._number, self.kind = mdf, number, kind
        self._at = {channel.name.removeprefix(f"{kind}."): k for k, channel in enumerate(mdf.groups[number].channels)}
        np = need("numpy")
        root = mdf.get(group=number, index=self._at["ID"] if "ID" in self._at else self._at[kind], raw=True)
        self.time_ns = np.rint(root.timestamps * 1e9).astype(np.int64) + mdf.header.abs_time
        rows = len(self.time_ns)
        self.bus = self._bus(rows)
        id = self._column("ID", rows).astype(np.int64)
        extended = (self._column("IDE", rows) != 0) | (id > 0x7FF)
        self.data, self.length = self._bytes(rows)
        self.fd = self._column("EDL", rows) != 0
        self.fd_flags = (self._column("BRS", rows) != 0) + 2 * (self._column("ESI", rows) != 0)
        if kind == "CAN_ErrorFrame":
            id = self._error_class(id & ID_MASK, rows)
            extended = np.zeros(rows, bool)
        self.id = np.where(extended, (id & ID_MASK) | EXTENDED, id)

    def _column(self, name: str, rows: int) -> np.ndarray[Any, Any]:
        np = need("numpy")
        if name not in self._at:
            return np.zeros(rows, np.uint8)  # type: ignore[no-any-return]
        samples, _ = self._mdf.get(group=self._number, index=self._at[name], samples_only=True)
        if len(samples) != rows:  # a damaged block: asammdf gives what it finds of each channel
            raise ValueError(f"{len(samples)} values of {self.kind}.{name} for {rows} frames")
        return samples  # type: ignore[no-any-return]

    def _bus(self, rows: int) -> np.ndarray[Any, Any]:
        np = need("numpy")
        if "BusChannel" in self._at:
            return self._column("BusChannel", rows).astype(np.int64)
        group = self._mdf.groups[self._number].channel_group
        names = [group.acq_name, *((group.acq_source.name, group.acq_source.path) if group.acq_source else ())]
        digits = next((found[1] for name in names if name and (found := re.search(r"(\d+)\D*$", name))), "0")
        return np.full(rows, int(digits))  # type: ignore[no-any-return]

    def _bytes(self, rows: int) -> tuple[Any, Any]:
        np = need("numpy")
        code = np.minimum(self._column("DLC", rows).astype(np.int64), 15)
        table = np.array(FD_LENGTHS)
        if self.kind == "CAN_RemoteFrame":
            return np.zeros((rows, 1), np.uint8), np.minimum(code, 8) if "DLC" in self._at else self._column(
                "DataLength", rows).astype(np.int64)
        data = self._column("DataBytes", rows) if "DataBytes" in self._at else np.zeros((rows, 8), np.uint8)
        if data.dtype.kind == "S":  # of variable length, as asammdf gives it
            data = np.ascontiguousarray(data).view(np.uint8)
        data = data.reshape(rows, -1).astype(np.uint8, copy=False)
        length = self._column("DataLength", rows).astype(np.int64) if "DataLength" in self._at else table[code]
        if self.kind == "CAN_ErrorFrame" and "DataBytes" not in self._at:
            length = np.full(rows, 8)
        if (short := int(length.max(initial=0)) - data.shape[1]) > 0:
            data = np.pad(data, ((0, 0), (0, short)))
        return data, length

    def _error_class(self, id: np.ndarray[Any, Any], rows: int) -> np.ndarray[Any, Any]:
        """SocketCAN's class of error; the kind of error, where ASAM's ErrorType gives it, goes into the data."""
        np = need("numpy")
        if "ErrorType" not in self._at:
            return np.where(id, id, BUS_ERROR) | ERROR  # type: ignore[no-any-return]
        kinds = np.array([LINE_ERRORS.get(kind, 0) for kind in ERROR_TYPES])
        kind = kinds[np.minimum(self._column("ErrorType", rows).astype(np.int64), 5)]
        self.data, self.length = np.zeros((rows, 8), np.uint8), np.full(rows, 8)
        self.data[:, 2] = kind
        return np.where(kind, PROTOCOL_ERROR, 0) | BUS_ERROR | ERROR  # type: ignore[no-any-return]

    def lines(self, begin: int, end: int) -> list[str]:
        """Text of the frames [begin, end)."""
        rows = slice(begin, end)
        stamps, ids = self.time_ns[rows].tolist(), self.id[rows].tolist()
        names = {id: identifier(id) for id in set(ids)}
        width, text = 2 * self.data.shape[1], self.data[rows].tobytes().hex().upper()
        if self.kind == "CAN_RemoteFrame":
            tails = [f"#R{length}" if length else "#R" for length in self.length[rows].tolist()]
        else:
            marks = [f"##{flags:X}" if fd else "#" for fd, flags in
                     zip(self.fd[rows].tolist(), self.fd_flags[rows].tolist(), strict=True)]
            tails = [mark + text[k * width:k * width + 2 * length]
                     for k, (mark, length) in enumerate(zip(marks, self.length[rows].tolist(), strict=True))]
        return [f"({stamp(time_ns)}) can{bus} {names[id]}{tail}\n" for time_ns, bus, id, tail in
                zip(stamps, self.bus[rows].tolist(), ids, tails, strict=True)]


def closed(mdf: Any) -> None:
    """In place of asammdf's own `__del__`, which tells on stderr what it misses on a file that could not be opened."""
    try:
        mdf.close()
    except Exception:
        return


def opened(path: Path) -> Any:
    """asammdf's view of the file; what it says about its own doings stays quiet."""
    logging.getLogger("asammdf").setLevel(logging.CRITICAL)
    asammdf = need("asammdf")
    for version in (3, 4):
        setattr(getattr(need(f"asammdf.blocks.mdf_v{version}"), f"MDF{version}"), "__del__", closed)
    try:
        return asammdf.MDF(path)
    except Exception as error:  # asammdf raises whatever its parser ran into
        told = " ".join(str(error).split()) or type(error).__name__
        raise LogError(f"{path}: cannot be read as MDF ({told}): the file is damaged or was not closed; open and save "
                       "it with the logger's own program, or copy it again") from error


def bus_groups(mdf: Any, tally: Tally) -> list[tuple[int, str]]:
    found = []
    for number, group in enumerate(mdf.groups):
        names = {channel.name for channel in group.channels}
        kind = next((kind for kind in KINDS if kind in names or f"{kind}.ID" in names), None)
        if kind and group.channel_group.cycles_nr:
            found.append((number, kind))
        elif other := next((name for name in names if OTHER_BUSES.match(name)), None):
            tally.skip(f"{other}s", count=group.channel_group.cycles_nr)
        elif not kind:
            tally.skip("rows of signals", count=group.channel_group.cycles_nr)
    return found


def unfinished(path: Path) -> bool:
    with path.open("rb") as file:
        return file.read(8) == b"UnFinMF "


def merged(groups: list[Group]) -> Iterator[str]:
    if len(groups) == 1:
        for begin in range(0, len(groups[0].time_ns), BLOCK):
            yield "".join(groups[0].lines(begin, begin + BLOCK))
        return
    np = need("numpy")
    # A clock that was set back is the reader's to judge: a group's frames keep the order of the file.
    order = np.argsort(np.concatenate([np.maximum.accumulate(group.time_ns) for group in groups]), kind="stable")
    owner = np.concatenate([np.full(len(group.time_ns), k, np.int32) for k, group in enumerate(groups)])[order]
    done = [0] * len(groups)
    for begin in range(0, len(owner), BLOCK):
        part = owner[begin:begin + BLOCK]
        counts = np.bincount(part, minlength=len(groups)).tolist()
        texts = [iter(group.lines(at, at + count)) for group, at, count in zip(groups, done, counts, strict=True)]
        yield "".join(next(texts[k]) for k in part.tolist())
        done = [at + count for at, count in zip(done, counts, strict=True)]


def read(source: Source, tally: Tally) -> Iterator[str]:
    path = source.file()
    yield from isolated(lambda counted: frames_of(source, path, counted), tally)


def frames_of(source: Source, path: Path, tally: Tally) -> Iterator[str]:
    mdf = opened(path)
    try:
        numbers = bus_groups(mdf, tally)
        if not numbers and any(group.channel_group.cycles_nr for group in mdf.groups):
            raise LogError(f"{source.path}: MF4 without frames: it holds signals in {len(mdf.groups)} groups; expected "
                           f"groups with {', '.join(KINDS)}: list them with `python -m voltlap_logs.tables`")
        try:
            groups = [Group(mdf, number, kind) for number, kind in numbers]
        except MemoryError:
            raise
        except Exception as error:
            told = " ".join(str(error).split()) or type(error).__name__
            raise BrokenOff(f"its blocks of frames cannot be read ({told})") from error
        if groups:
            yield from merged(groups)
    finally:
        mdf.close()
    if unfinished(path):
        raise BrokenOff("the recorder did not close the file (it is marked UnFinMF); the last frames may be missing")
