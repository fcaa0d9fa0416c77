# SPDX-License-Identifier: Apache-2.0
"""A sensor that lies in frames that are new: its reading is changed where the frame passes, the frame is sealed again.

The counter goes on, the CRC fits: nothing but the value says that something is wrong. A reading is kept within what
its bits can carry, as a converter keeps it within its rails; "no measurement" stays what it is.
"""
from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass

from .dbc import Dbc, Signal, Value
from .errors import InputError
from .frame import Frame
from .quantity import TICK_MS

Past = Callable[[int, int], Frame | None]  # the frame of an identifier so many before this one, as it was sent
MOST_CYCLES = 64  # that are kept of each message
WAYS = ("stuck", "offset", "gain", "noise", "late", "swapped_with")
LAST = "last"  # stuck at what was read last


@dataclass(frozen=True)
class SensorFault:
    """What becomes of the readings of `signals`; one way each.

    stuck         at `value` (None: the code for "no measurement"), or at the last reading before the fault ("last")
    offset, gain  `amount` added, or times it
    noise         normal, `amount` its standard deviation
    late          by `late_ticks`
    swapped_with  the reading of `other`, and the other way round
    """

    signals: tuple[str, ...]
    way: str
    value: Value | None = None
    amount: float = 0.0
    late_ticks: int = 0
    other: str = ""

    def check_fits(self, dbc: Dbc) -> None:
        for name in (*self.signals, *([self.other] if self.other else [])):
            signal = dbc.signal(name)
            if signal.role in ("counter", "crc", "checksum"):
                raise InputError(f"{name} is the {signal.role} of its frame, expected a sensor")
            if self.way == "late" and _cycles(self.late_ticks, signal) > MOST_CYCLES:
                raise InputError(f"{name}: found {self.late_ticks * TICK_MS} ms, expected at most the {MOST_CYCLES} "
                                 "frames that are kept")
            if self.way == "stuck" and self.value != LAST:
                signal.message.encode({signal.short_name: self.value})
            if self.way in ("offset", "gain", "noise") and signal.states:
                raise InputError(f"{name} is no number, expected one for {self.way}")
        if self.way == "swapped_with" and len(self.signals) != 1:
            raise InputError(f"found {len(self.signals)} sensors, expected one that is swapped with another")

    def ids(self, dbc: Dbc) -> frozenset[int]:
        names = (*self.signals, *([self.other] if self.other else []))
        return frozenset(dbc.signal(name).message.id for name in names)


class LyingSensors:
    """What becomes of frames, and the faults' memory of what was read last before them."""

    def __init__(self, dbc: Dbc, draw: random.Random) -> None:
        self._dbc, self._draw = dbc, draw
        self._kept: dict[tuple[int, str], Value | None] = {}

    def clear(self) -> None:
        self._kept.clear()

    def changed(self, fault: SensorFault, frame: Frame, past: Past) -> Frame:
        message = self._dbc.by_id[frame.id]
        if len(frame.data) != message.dlc:
            return frame
        data = frame.data
        for name in (*fault.signals, *([fault.other] if fault.other else [])):
            signal = self._dbc.signal(name)
            if signal.message.id == frame.id:
                data = signal.message.encode({signal.short_name: self._reading(fault, signal, frame, past)}, data)
        return frame._replace(data=message.seal(data, message.counter_of(frame.data)))

    def _reading(self, fault: SensorFault, signal: Signal, frame: Frame, past: Past) -> Value | None:
        truth = signal.read(frame.data)
        if fault.way == "stuck":
            return self._last(fault, signal, truth, past) if fault.value == LAST else fault.value
        if fault.way == "swapped_with":
            wanted = self._dbc.signal(fault.other if signal.name == fault.signals[0] else fault.signals[0])
            source = frame if wanted.message.id == signal.message.id else past(wanted.message.id, 1)
            return truth if source is None else wanted.read(source.data)
        if fault.way == "late":
            old = past(signal.message.id, _cycles(fault.late_ticks, signal))
            return truth if old is None else signal.read(old.data)
        if not isinstance(truth, (int, float)):
            return truth
        low, high = signal.range
        moved = {"offset": lambda: truth + fault.amount, "gain": lambda: truth * fault.amount,
                 "noise": lambda: truth + self._draw.gauss(0.0, fault.amount)}[fault.way]()
        return min(high, max(low, moved))

    def _last(self, fault: SensorFault, signal: Signal, truth: Value | None, past: Past) -> Value | None:
        key = (id(fault), signal.name)
        if key not in self._kept:
            before = past(signal.message.id, 1)
            self._kept[key] = truth if before is None else signal.read(before.data)
        return self._kept[key]


def _cycles(late_ticks: int, signal: Signal) -> int:
    """So late in frames of its own message."""
    return max(1, round(late_ticks * TICK_MS / (signal.message.cycle_ms or TICK_MS)))


def signals_of(dbc: Dbc, name: str) -> tuple[str, ...]:
    """A signal, or every number with a unit of a message or group of messages: CellVoltages are all cells."""
    if "." in name:
        return (dbc.signal(name).name,)
    found = tuple(s.name for m in dbc.select([name]) for s in m.signals.values() if s.unit)
    if not found:
        raise InputError(f"{name} has no signal with a unit, expected a sensor such as Pedals.Apps1")
    return found

