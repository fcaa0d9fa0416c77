# SPDX-License-Identifier: Apache-2.0
"""What a listener knows of the bus: who is alive, what the signals say, what limits and why, how full the bus is.

Time is the car's: that of the ticks once a Sync was heard, the bus's before and without. Rates are those of the last
second. A frame that fails its CRC or checksum is counted and says nothing.
"""
from __future__ import annotations

from collections import Counter, deque
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from .dbc import LOCKSTEP_FILE, Dbc, Message
from .frame import EXTENDED, Frame, is_lockstep
from .frame_bits import BIT_RATE, frame_bits
from .inverter_names import AMK_WHEELS
from .quantity import TICK_MS
from .signals import Signals

FRESH, LATE, LOST, NEVER = "fresh", "late", "lost", "never"
_ORDER = [FRESH, LATE, LOST, NEVER]
_BIN_MS, _BINS = 100, 10
_SEALS = ("counter", "crc", "checksum")
# node -> (signal of its state, signal of its faults, signals that explain)
_STATES = {
    "BMS": ("BmsStatus.State", "BmsStatus.Faults", ()),
    "MASTER": ("MasterStatus.DriveState", "MasterStatus.Faults", ("MasterStatus.TorqueReason",)),
    "INVERTER": ("InverterStatus.State", None, ()),
}
_AMK_ORDER = ["Fault", "Off", "Disabled", "Enabled"]  # the worst first
_NO_CELL = 255


@dataclass
class _Heard:
    """The frames of one message."""

    message: Message
    frames: int = 0
    bad_seals: int = 0
    counter_gaps: int = 0
    counter: int | None = None
    last_ms: float = 0.0
    data: bytes = b""  # of the last good frame


@dataclass
class _Bin:
    """A tenth of a second."""

    number: int
    bits: int = 0
    frames: Counter[str] = field(default_factory=Counter)


class BusState:
    def __init__(self, dbc: Dbc) -> None:
        self.dbc = dbc
        self.signals = Signals(dbc)
        self.frames = 0
        self.lockstep = False
        self.now_ms = 0.0
        self._first_ms: float | None = None
        self._counts: dict[str, _Heard] = {}
        self._unknown: Counter[int] = Counter()
        self._bins: deque[_Bin] = deque(maxlen=_BINS + 1)
        self._sync = dbc.messages.get("Sync")
        self._first_sync: tuple[float, float] | None = None  # bus time and car time
        self._last_sync_bus_ms = 0.0

    def update(self, frames: Iterable[Frame]) -> None:
        for frame in frames:
            if is_lockstep(frame.id):
                self._follow(frame)
                continue
            if not self.lockstep:
                self.pass_time(frame.time_ms)
            self._take(frame)

    def pass_time(self, now_ms: float) -> None:
        """Time goes on without a frame. In lockstep it does not: there is no tick without one."""
        if not self.lockstep:
            self._set_time(now_ms)

    def _set_time(self, now_ms: float) -> None:
        if self._first_ms is None:
            self._first_ms = now_ms
        self.now_ms = max(self.now_ms, now_ms)

    def _follow(self, frame: Frame) -> None:
        if self._sync is None or frame.id != self._sync.id or len(frame.data) != self._sync.dlc:
            return
        now_ms = float(self._sync.signals["Tick"].raw(frame.data) * TICK_MS)
        # What came before had another time: the bus's, or an earlier run's.
        if not self.lockstep or now_ms < self.now_ms:
            self.lockstep, self._first_ms, self.now_ms = True, now_ms, now_ms
            self._first_sync = (frame.time_ms, now_ms)
            self._bins.clear()
            for count in self._counts.values():
                count.last_ms = now_ms
        self._set_time(now_ms)
        self._last_sync_bus_ms = frame.time_ms

    def _take(self, frame: Frame) -> None:
        self._set_time(self.now_ms)
        self.frames += 1
        message = self.dbc.by_id.get(frame.id)
        name = message.name if message else ""
        number = int(self.now_ms // _BIN_MS)
        if not self._bins or self._bins[-1].number != number:
            self._bins.append(_Bin(number))
        self._bins[-1].bits += frame_bits(frame.id, frame.data)
        self._bins[-1].frames[name] += 1
        if message is None or len(frame.data) != message.dlc:
            self._unknown[frame.id] += 1
            return
        count = self._counts.setdefault(name, _Heard(message))
        count.frames += 1
        if not message.sealed_ok(frame.data):
            count.bad_seals += 1
            return
        if message.counter is not None:
            counter = message.counter_of(frame.data)
            if count.counter is not None and counter != (count.counter + 1) % message.counter_round:
                count.counter_gaps += 1
            count.counter = counter
        count.last_ms, count.data = self.now_ms, frame.data
        self.signals.update(frame._replace(time_ms=self.now_ms))

    # ---- what is shown ----

    def snapshot(self) -> dict[str, Any]:
        """Everything, in plain types: what --json prints and the terminal shows."""
        self.signals.now_ms = self.now_ms
        window_s, bits, frames = self._window()
        messages = {name: self._message(count, frames[name] / window_s if window_s else 0.0)
                    for name, count in sorted(self._counts.items(), key=lambda item: item[1].message.id)}
        return {
            "clock": "lockstep" if self.lockstep else "bus", "time_s": round(self.now_ms * 1e-3, 3),
            "pace": self._pace(), "frames": self.frames,
            "frames_per_s": round(sum(frames.values()) / window_s, 1) if window_s else 0.0,
            "bus_load_pct": round(100.0 * bits / (BIT_RATE * window_s), 2) if window_s else 0.0,
            "nodes": {node: self._node(node, messages) for node in self.dbc.nodes if self._sends(node)},
            "states": {node: self._state(node) for node in _STATES}, "limits": self._limits(),
            "cells": self._extremes("CellVoltages", "V"), "temperatures": self._extremes("Temperatures", "degC"),
            "messages": messages,
            "unknown_ids": {f"0x{i & ~EXTENDED:0{8 if i & EXTENDED else 3}X}": n
                            for i, n in sorted(self._unknown.items())},
        }

    def _window(self) -> tuple[float, int, Counter[str]]:
        """Seconds, bits and frames of the last whole bins; of what there is before there is one."""
        now = int(self.now_ms // _BIN_MS)
        whole = [b for b in self._bins if now - _BINS <= b.number < now]
        first = int((self._first_ms or 0.0) // _BIN_MS)
        if now == first:
            whole, seconds = list(self._bins), max(self.now_ms - (self._first_ms or 0.0), float(TICK_MS)) * 1e-3
        else:
            seconds = min(_BINS, now - first) * _BIN_MS * 1e-3
        frames: Counter[str] = Counter()
        for b in whole:
            frames.update(b.frames)
        return seconds, sum(b.bits for b in whole), frames

    def _pace(self) -> float | None:
        """Simulated seconds a second."""
        if self._first_sync is None or self._last_sync_bus_ms <= self._first_sync[0]:
            return None
        return round((self.now_ms - self._first_sync[1]) / (self._last_sync_bus_ms - self._first_sync[0]), 2)

    def _freshness(self, message: Message, age_ms: float) -> str:
        if not message.timeout_ms or age_ms <= message.timeout_ms / 2:
            return FRESH
        return LATE if age_ms <= message.timeout_ms else LOST

    def _message(self, count: _Heard, per_s: float) -> dict[str, Any]:
        message = count.message
        age_ms = self.now_ms - count.last_ms
        good = bool(count.data)
        return {
            "id": f"0x{message.id & ~EXTENDED:03X}", "sender": message.sender, "frames": count.frames,
            "per_s": round(per_s, 1), "age_ms": round(age_ms, 1) if good else None,
            "state": self._freshness(message, age_ms) if good else NEVER, "bad_seals": count.bad_seals,
            "counter_gaps": count.counter_gaps,
            "signals": {s.short_name: {"value": s.read(count.data), "unit": s.unit}
                        for s in message.signals.values() if s.role not in _SEALS} if good else {},
        }

    def _sends(self, node: str) -> bool:
        return any(m.sender == node and m.file != LOCKSTEP_FILE for m in self.dbc.messages.values())

    def _node(self, node: str, messages: dict[str, Any]) -> dict[str, Any]:
        """As fresh as its stalest message; `never` when none was heard."""
        mine = {name: row for name, row in messages.items() if row["sender"] == node}
        worst = max((_ORDER.index(row["state"]) for row in mine.values()), default=_ORDER.index(NEVER))
        ages = [row["age_ms"] for row in mine.values() if row["age_ms"] is not None]
        return {"state": _ORDER[worst], "age_ms": min(ages, default=None), "messages": len(mine),
                "per_s": round(sum(row["per_s"] for row in mine.values()), 1),
                "lost": [name for name, row in mine.items() if row["state"] in (LOST, NEVER)]}

    def _pm100_state(self) -> str | None:
        """A PM100 says it in bits of two messages."""
        enabled, lockout = (self.signals[f"Pm100States.{name}"].value for name in ("Enabled", "Lockout"))
        words = [self.signals[f"Pm100Faults.{name}"].value for name in ("PostLow", "PostHigh", "RunLow", "RunHigh")]
        if enabled is None:
            return None
        return "Fault" if any(words) else "Lockout" if lockout else "Enabled" if enabled else "Disabled"

    def _amk_state(self) -> str | None:
        """Four AMK inverters say it in bits of a message each: the worst of those that were heard."""
        worst: str | None = None
        for wheel in AMK_WHEELS:
            bits = {name: self.signals[f"AmkActual1{wheel}.{name}"].value
                    for name in ("SystemReady", "Error", "QuitDcOn", "QuitInverterOn")}
            if bits["Error"] is None:
                continue
            said = ("Fault" if bits["Error"] else "Off" if not (bits["SystemReady"] and bits["QuitDcOn"])
                    else "Enabled" if bits["QuitInverterOn"] else "Disabled")
            worst = said if worst is None else min(worst, said, key=_AMK_ORDER.index)
        return worst

    def _state(self, node: str) -> dict[str, Any]:
        if node == "INVERTER" and (said := self._pm100_state() or self._amk_state()) is not None:
            return {"state": said, "faults": []}
        state, faults, why = _STATES[node]
        return {"state": self.signals[state].value, "faults": self.signals.bits(faults) if faults else [],
                **{name.partition(".")[2]: self.signals[name].value for name in why}}

    def _limits(self) -> list[dict[str, Any]]:
        cell = self.signals["BmsLimits.LimitingCell"].value
        rows = []
        for what in ("Discharge", "Charge"):
            limit = self.signals[f"BmsLimits.{what}Limit"]
            rows.append({"what": what.lower(), "value": limit.value, "unit": limit.unit,
                         "reason": self.signals[f"BmsLimits.{what}Reason"].value,
                         "cell": cell if what == "Discharge" and cell != _NO_CELL else None})
        return rows

    def _extremes(self, group: str, unit: str) -> dict[str, Any] | None:
        """Least and greatest of the numbered parts of one message, with their place counted from 0."""
        values = []
        for name, count in sorted(self._counts.items()):
            if name.rpartition("_")[0] == group and count.data:
                rows = [s for s in count.message.signals.values() if s.role not in _SEALS]
                first = int(name.rpartition("_")[2]) * len(rows)
                values += [(value, first + i) for i, s in enumerate(rows)
                           if isinstance(value := s.read(count.data), float | int)]
        if not values:
            return None
        (least, least_at), (most, most_at) = min(values), max(values, key=lambda v: (v[0], -v[1]))
        return {"count": len(values), "unit": unit, "least": least, "least_at": least_at, "most": most,
                "most_at": most_at}
