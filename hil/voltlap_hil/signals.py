# SPDX-License-Identifier: Apache-2.0
"""What a bus said last, by the names of its signals; and frames made from names, sealed as the DBC files ask."""
from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from .dbc import Dbc, Value
from .frame import Frame


class Reading(NamedTuple):
    """One signal as last seen. `value` is None when it was never seen or says "no measurement"."""

    value: Value | None
    unit: str
    age_ms: float | None


class Signals:
    def __init__(self, dbc: Dbc) -> None:
        self.dbc = dbc
        self._last: dict[int, Frame] = {}
        self._counter: dict[int, int] = {}
        self.now_ms = 0.0

    def update(self, frame: Frame) -> None:
        self._last[frame.id] = frame
        self.now_ms = max(self.now_ms, frame.time_ms)

    def last(self, message: str) -> Frame | None:
        return self._last.get(self.dbc.message(message).id)

    def __getitem__(self, name: str) -> Reading:
        signal = self.dbc.signal(name)
        frame = self._last.get(signal.message.id)
        if frame is None or len(frame.data) != signal.message.dlc:
            return Reading(None, signal.unit, None)
        return Reading(signal.read(frame.data), signal.unit, self.now_ms - frame.time_ms)

    def bits(self, name: str) -> list[str]:
        """Names of the bits that are set, for example the faults of BmsStatus.Faults."""
        signal = self.dbc.signal(name)
        value = self[name].value
        return [bit for i, bit in enumerate(signal.bits) if isinstance(value, (int, float)) and int(value) >> i & 1]

    def write(self, message: str, values: Mapping[str, Value | None]) -> Frame:
        """A frame with `values` over what was last seen, with the counter after the last one seen or written."""
        row = self.dbc.message(message)
        last = self._last.get(row.id)
        data = row.encode(values, last.data if last else None)
        seen = row.counter_of(last.data) if last else -1
        counter = self._counter[row.id] = (self._counter.get(row.id, seen) + 1) % row.counter_round
        return Frame(row.id, row.seal(data, counter), self.now_ms)
