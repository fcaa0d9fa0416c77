# SPDX-License-Identifier: Apache-2.0
"""What a listener with a car's DBC files knows of its buses: who speaks how often, what the signals say and between
which values they moved, how full each bus is.

Rates are those of the last second. A message is fresh up to three of its cycles, lost beyond ten: the cycle that its
file gives, else the mean one that it was heard with.
"""
from __future__ import annotations

import math
from collections import Counter, deque
from dataclasses import dataclass, field
from typing import Any

from .bus_state import FRESH, LATE, LOST
from .car_dbc import CarDbc, CarMessage, CarSignal, id_text
from .frame_bits import BIT_RATE, frame_bits
from .recording import LogFrame

_BIN_S, _BINS = 0.1, 10
_LATE, _LOST = 3.0, 10.0  # cycles
_STATES = 16  # of a signal with named values that are told
_SHORTEST_S = 0.01  # of a mean cycle that is believed
_FD_HEAD_BITS = 70  # of a CAN FD frame, about; its data may be sent faster: an upper estimate


@dataclass
class _Range:
    """One signal over what was heard."""

    signal: CarSignal
    now: float | None = None  # with sign, not scaled; None: no measurement
    least: float = math.inf
    most: float = -math.inf
    seen: dict[float, None] = field(default_factory=dict)  # of a state, in the order in which they came

    def take(self, bits: int) -> None:
        signal = self.signal
        number = signal.number(bits)
        if (signal.invalid and signal.is_invalid(bits)) or (signal.float and not math.isfinite(number)):
            self.now = None
            return
        self.now = number
        if number < self.least:
            self.least = number
        if number > self.most:
            self.most = number
        if signal.states and len(self.seen) < _STATES:
            self.seen[number] = None

    def row(self) -> dict[str, Any]:
        s = self.signal
        ends = sorted((s.scaled(self.least), s.scaled(self.most))) if self.least <= self.most else [None, None]
        row = {"value": None if self.now is None else s.shown(self.now), "unit": s.unit, "least": ends[0],
               "most": ends[1]}
        return {**row, "seen": [s.shown(number) for number in self.seen]} if s.states else row


@dataclass
class _Heard:
    """The frames of one message on one bus."""

    message: CarMessage
    bus: str
    first_s: float
    frames: int = 0
    short: int = 0
    last_s: float = 0.0
    data: bytes = b""
    signals: dict[str, _Range] = field(default_factory=dict)

    def take(self, frame: LogFrame, now_s: float) -> None:
        self.frames += 1
        self.last_s = now_s
        if frame.data == self.data and self.frames > 1:
            return
        self.data = frame.data
        self.short += len(frame.data) < self.message.length
        for signal, bits in zip(self.message.signals, self.message.decode(frame.data), strict=True):
            if bits is not None and signal.name not in self.message.hidden:
                self.signals.setdefault(signal.name, _Range(signal)).take(bits)

    @property
    def cycle_s(self) -> float:
        if self.message.cycle_s > 0.0:
            return self.message.cycle_s
        return max((self.last_s - self.first_s) / (self.frames - 1), _SHORTEST_S) if self.frames > 1 else math.inf


@dataclass
class _Bin:
    """A tenth of a second."""

    number: int
    bits: Counter[str] = field(default_factory=Counter)  # by bus
    frames: Counter[tuple[str, int]] = field(default_factory=Counter)  # by bus and identifier


class CarState:
    def __init__(self, dbc: CarDbc, bit_rate: float = BIT_RATE) -> None:
        self.dbc = dbc
        self.frames = 0
        self.now_s = 0.0
        self._bit_rate = bit_rate
        self._first_s: float | None = None
        self._heard: dict[tuple[str, int], _Heard] = {}
        self._by_bus: Counter[str] = Counter()
        self._unknown: Counter[int] = Counter()
        self._refused: Counter[int] = Counter()
        self._bins: deque[_Bin] = deque(maxlen=_BINS + 1)

    def take(self, frame: LogFrame) -> None:
        self.pass_time(frame.time_s or 0.0)
        self.frames += 1
        self._by_bus[frame.bus] += 1
        self._count(frame)
        message = self.dbc.by_id.get(frame.id)
        if message is None:
            (self._refused if frame.id in self.dbc.refused else self._unknown)[frame.id] += 1
            return
        key = frame.bus, frame.id
        heard = self._heard.get(key)
        if heard is None:
            heard = self._heard[key] = _Heard(message, frame.bus, self.now_s)
        heard.take(frame, self.now_s)

    def pass_time(self, now_s: float) -> None:
        if self._first_s is None:
            self._first_s = now_s
        self.now_s = max(self.now_s, now_s)

    def _count(self, frame: LogFrame) -> None:
        number = int(self.now_s / _BIN_S)
        if not self._bins or self._bins[-1].number != number:
            self._bins.append(_Bin(number))
        bits = frame_bits(frame.id, frame.data) if len(frame.data) <= 8 else _FD_HEAD_BITS + 8 * len(frame.data)
        self._bins[-1].bits[frame.bus] += bits
        self._bins[-1].frames[frame.bus, frame.id] += 1

    # ---- what is shown ----

    def snapshot(self) -> dict[str, Any]:
        """Everything, in plain types: what --json prints and the terminal shows."""
        seconds, bits, frames = self._window()
        by_bus: Counter[str] = Counter()
        for (bus, _), count in frames.items():
            by_bus[bus] += count
        heard = {can_id for _, can_id in self._heard}
        per_s = {key: count / seconds for key, count in frames.items()} if seconds else {}
        return {
            "time_s": round(self.now_s, 3), "frames": self.frames,
            "buses": {bus: {"frames": count, "per_s": round(by_bus[bus] / seconds, 1) if seconds else 0.0,
                            "load_pct": round(100.0 * bits[bus] / (self._bit_rate * seconds), 2) if seconds else 0.0}
                      for bus, count in sorted(self._by_bus.items())},
            "messages": [self._row(self._heard[key], per_s.get(key, 0.0)) for key in sorted(self._heard)
                         if self._heard[key].message.shown],
            "unknown": {id_text(i): n for i, n in self._unknown.most_common()},
            "never_heard": [m.name for i, m in sorted(self.dbc.by_id.items()) if i not in heard and m.shown],
            "refused": {f"{id_text(i)} {self.dbc.refused[i]}": n for i, n in self._refused.most_common()},
        }

    def _window(self) -> tuple[float, Counter[str], Counter[tuple[str, int]]]:
        """Seconds, bits and frames of the last second, or of what there is of it."""
        bits: Counter[str] = Counter()
        frames: Counter[tuple[str, int]] = Counter()
        end = int(self.now_s / _BIN_S)
        begin = int((self._first_s or 0.0) / _BIN_S)
        last = end - 1 if end > begin else end  # the bin that time is in is not whole
        for one in self._bins:
            if last - _BINS < one.number <= last:
                bits.update(one.bits)
                frames.update(one.frames)
        seconds = min(_BINS, last - begin + 1) * _BIN_S if end > begin else self.now_s - (self._first_s or 0.0)
        return seconds, bits, frames

    def _row(self, heard: _Heard, per_s: float) -> dict[str, Any]:
        message, age_s = heard.message, self.now_s - heard.last_s
        cycles = age_s / heard.cycle_s
        return {
            "id": id_text(message.id), "message": message.name, "bus": heard.bus, "sender": message.sender,
            "frames": heard.frames, "per_s": round(per_s, 1), "age_ms": round(1e3 * age_s, 1),
            "state": FRESH if cycles <= _LATE else LATE if cycles <= _LOST else LOST, "short": heard.short,
            "signals": {name: one.row() for name, one in heard.signals.items()},
        }
