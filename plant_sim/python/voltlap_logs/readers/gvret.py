# SPDX-License-Identifier: Apache-2.0
"""GVRET, the CSV of SavvyCAN: `Time Stamp,ID,Extended,Dir,Bus,LEN,D1,D2,...`; microseconds, identifiers and bytes in
hexadecimal. Older ones have no Dir. More than eight bytes are a CAN FD frame. Bus N becomes `canN`."""
from __future__ import annotations

from collections.abc import Iterator

from ..candump import EXTENDED, FD_LENGTHS, Frame, line
from ..errors import LogError
from ..source import Source
from ..tally import Tally

HEADER = "time stamp,id,extended,"
YES = {"true": EXTENDED, "1": EXTENDED, "false": 0, "0": 0}


def frame(cells: list[str], place: dict[str, int]) -> Frame:
    length = int(cells[place["len"]])
    data = bytes(int(cell, 16) for cell in cells[place["d1"]:place["d1"] + length])
    if len(data) != length or length not in FD_LENGTHS:
        raise ValueError(length)
    time_ns = int(float(cells[place["time stamp"]])) * 1000
    id = int(cells[place["id"]], 16) | YES[cells[place["extended"]].strip().lower()]
    return Frame(time_ns, f"can{int(cells[place['bus']])}", id, data, 0 if length > 8 else None)


def read(source: Source, tally: Tally) -> Iterator[str]:
    place: dict[str, int] = {}
    for number, text in source.lines():
        cells = text.split(",")
        if text.lower().replace(" ,", ",").startswith(HEADER):
            place = {cell.strip().lower(): k for k, cell in enumerate(cells)}
            place.setdefault("d1", place.get("len", 0) + 1)
            if missing := {"time stamp", "id", "extended", "bus", "len"} - set(place):
                raise LogError(f"{source.path}: line {number} has no column {', '.join(sorted(missing))}; expected "
                               "'Time Stamp,ID,Extended,Dir,Bus,LEN,D1,...': save it again from SavvyCAN as GVRET")
        elif text.strip():
            try:
                found = frame(cells, place)
                if not source.last_line_ends and len(cells[-1]) == 1:
                    raise ValueError("half a byte")
                yield line(found, 6)
            except (ValueError, KeyError, IndexError, OverflowError):
                tally.unreadable(source, number, text)
