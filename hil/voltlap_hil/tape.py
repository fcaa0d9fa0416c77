# SPDX-License-Identifier: Apache-2.0
"""Every frame that a car's process sent, as it came: two runs whose tapes have one hash sent the same frames."""
from __future__ import annotations

import hashlib
import struct

from .dbc import Dbc
from .quantity import TICK_MS

_RECORD = struct.Struct("<IBBH8s")
_SENDERS = ("plant", "BMS", "master")


class Tape:
    def __init__(self) -> None:
        self._batches: list[tuple[int, bytes]] = []  # tick, records of 16 bytes (plant_sim/io/bus/harness_bus.hpp)

    def add(self, tick: int, records: bytes) -> None:
        self._batches.append((tick, records))

    @property
    def hash(self) -> str:
        """SHA-256 over tick and records, in the order of sending."""
        digest = hashlib.sha256()
        for tick, records in self._batches:
            digest.update(struct.pack("<II", tick, len(records)))
            digest.update(records)
        return digest.hexdigest()

    def first_difference(self, expected: Tape, dbc: Dbc) -> str:
        """In words: the tick, the frame, and what it is instead; empty when there is none."""
        for (tick, own), (other_tick, other) in zip(self._batches, expected._batches, strict=False):
            if tick != other_tick or own != other:
                return f"tick {tick} ({tick * TICK_MS * 1e-3:.2f} s): {_first_of(own, other, dbc)}"
        mine, theirs = len(self._batches), len(expected._batches)
        return "" if mine == theirs else f"found {mine} batches of frames, expected {theirs}"


def _first_of(own: bytes, other: bytes, dbc: Dbc) -> str:
    mine, theirs = list(_RECORD.iter_unpack(own)), list(_RECORD.iter_unpack(other))
    for i in range(max(len(mine), len(theirs))):
        here, there = mine[i:i + 1], theirs[i:i + 1]
        if here != there:
            return f"found {_text(here, dbc)}, expected {_text(there, dbc)}"
    return "the same frames in other ticks"


def _text(record: list[tuple[int, int, int, int, bytes]], dbc: Dbc) -> str:
    if not record:
        return "no frame more"
    can_id, dlc, who, _, data = record[0]
    known = dbc.by_id.get(can_id)
    name = f" {known.name}" if known else ""
    return f"0x{can_id & 0x1FFF_FFFF:03X}{name} [{data[:dlc].hex(' ')}] of {_SENDERS[who]}"
