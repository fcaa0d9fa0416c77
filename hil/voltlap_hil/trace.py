# SPDX-License-Identifier: Apache-2.0
"""The frames of a run in order, and what their signals said over time. Checks ask a trace, never a bus."""
from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field

from .dbc import Dbc, Signal, Value
from .errors import HilError
from .frame import Frame


@dataclass
class Trace:
    dbc: Dbc
    frames: list[Frame] = field(default_factory=list)

    def extend(self, frames: Iterable[Frame]) -> None:
        """Frames in the order of their times. A clock that was set while it ran makes every measured time worthless."""
        for frame in frames:
            if frame.time_ms < self.end_ms:
                raise HilError(f"the time of the bus went back from {self.end_ms:g} ms to {frame.time_ms:g} ms; leave "
                               "the clock alone during a run")
            self.frames.append(frame)

    @property
    def end_ms(self) -> float:
        return self.frames[-1].time_ms if self.frames else 0.0

    def count(self, message: str, from_ms: float, to_ms: float) -> int:
        """Frames of a message in (from, to]."""
        wanted = self.dbc.message(message).id
        return sum(f.id == wanted and from_ms < f.time_ms <= to_ms for f in self.frames)

    def states(self, signals: Iterable[Signal]) -> Iterator[tuple[float, Mapping[str, Value | None]]]:
        """(time, value of each signal) after every moment at which one of their messages came.

        A moment is all frames of one time, so that signals of several messages are seen together. Until all of them
        have been heard there is nothing to say.
        """
        by_id: dict[int, list[Signal]] = {}
        for signal in signals:
            by_id.setdefault(signal.message.id, []).append(signal)
        now: dict[str, Value | None] = {}
        heard: set[int] = set()
        time_ms = None
        for frame in self.frames:
            rows = by_id.get(frame.id)
            if rows is None or len(frame.data) != rows[0].message.dlc:
                continue
            if time_ms is not None and frame.time_ms != time_ms and len(heard) == len(by_id):
                yield time_ms, dict(now)
            time_ms = frame.time_ms
            heard.add(frame.id)
            for signal in rows:
                now[signal.name] = signal.read(frame.data)
        if time_ms is not None and len(heard) == len(by_id):
            yield time_ms, dict(now)
