# SPDX-License-Identifier: Apache-2.0
"""How far the car has come, by its own front wheels, which are not driven: ds = (v_left + v_right) / 2 dt."""
from __future__ import annotations

from .dbc import Dbc
from .frame import Frame

NEEDS = ("WheelSpeeds.FrontLeft", "WheelSpeeds.FrontRight")
_LONGEST_S = 1.0  # a gap beyond this is no driving that anybody has seen


class Odometer:
    def __init__(self, dbc: Dbc) -> None:
        self._signals = [dbc.signal(name) for name in NEEDS]
        self._id = self._signals[0].message.id
        self._last_ms: float | None = None
        self.distance_m = 0.0

    def update(self, frame: Frame) -> None:
        if frame.id != self._id or len(frame.data) != self._signals[0].message.dlc:
            return
        speeds = [v for v in (s.read(frame.data) for s in self._signals) if isinstance(v, (int, float))]
        elapsed_s = 0.0 if self._last_ms is None else (frame.time_ms - self._last_ms) * 1e-3
        self._last_ms = frame.time_ms
        if speeds and 0.0 < elapsed_s <= _LONGEST_S:
            self.distance_m += sum(speeds) / len(speeds) * elapsed_s
