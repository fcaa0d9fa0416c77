# SPDX-License-Identifier: Apache-2.0
"""The harness as a member of the barrier that keeps the processes in step, and the clock of a bus without one.

Both clocks give the car's frames of the next moment and its time; the lockstep clock holds simulated time still between
two calls. Order of a tick: plant frames, Sync, BMS frames, DoneBms, master frames, DoneMaster, DoneHil.
"""
from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterable
from typing import Protocol

from .bus import Bus
from .dbc import Dbc, Value
from .errors import HilError
from .frame import Frame, is_lockstep
from .quantity import TICK_MS

_READY_EVERY_S = 0.1
_LOOK_EVERY_S = 0.5
MEMBERS = {"bms": "Bms", "master": "Master", "logger": "Logger", "hil": "Hil"}
_BEFORE_US = "DoneMaster"  # the mark after which it is the harness's turn
NOTHING: Callable[[], None] = lambda: None  # noqa: E731


class Clock(Protocol):
    @property
    def now_ms(self) -> float: ...

    def advance(self) -> list[Frame]:
        """Lets time go on to the next moment; the car's frames of that moment."""

    def tell(self, message: str, **values: Value | None) -> None:
        """A frame to the plant that takes effect in the next tick."""

    def send(self, frames: list[Frame]) -> None:
        """Car frames from the harness, before those of the next tick."""

    def close(self) -> None: ...


class LockstepClock:
    def __init__(self, channel: str, dbc: Dbc, listen_to: Iterable[int] | None,
                 check_processes: Callable[[], None] = NOTHING, interface: str = "socketcan",
                 patience_s: float = 60.0) -> None:
        """`check_processes` raises when one that should live has died."""
        self._dbc, self._check_processes, self._patience_s = dbc, check_processes, patience_s
        self._turn = dbc.message(_BEFORE_US)
        self._sync, self._alive = dbc.message("Sync").id, dbc.message("Alive").id
        # Two sockets: one that wakes the harness once a tick, one that gathers what came until then.
        self._barrier = Bus(channel, interface, dbc, [self._turn.id])
        ids = None if listen_to is None else [*listen_to, self._sync, self._alive]
        self._car = Bus(channel, interface, dbc, ids)
        self.tick = -1
        self._sent = 0

    @property
    def now_ms(self) -> float:
        return float(max(0, self.tick) * TICK_MS)

    def advance(self) -> list[Frame]:
        if self.tick < 0:
            self._join()
        else:
            self._tell("DoneHil", Tick=self.tick, FramesSent=self._sent)
            self._await_turn()
        self._sent = 0
        time_ms = self.now_ms
        return [Frame(f.id, f.data, time_ms) for f in self._gathered() if not is_lockstep(f.id)]

    def tell(self, message: str, **values: Value | None) -> None:
        self._tell(message, Tick=self.tick + 1, **values)

    def send(self, frames: list[Frame]) -> None:
        self._barrier.send(frames)
        self._sent += len(frames)

    def lost(self, node: str) -> None:
        """A node's process is dead: the plant need not wait for it."""
        self._tell("MemberLost", Member=MEMBERS[node])

    def stop(self) -> None:
        self._tell("StopRequest", Reason="Finished")
        if self.tick >= 0:
            self._tell("DoneHil", Tick=self.tick, FramesSent=self._sent)

    def close(self) -> None:
        self._barrier.close()
        self._car.close()

    def _tell(self, message: str, **values: Value | None) -> None:
        row = self._dbc.message(message)
        self._barrier.send([Frame(row.id, row.encode(values))])

    def _join(self) -> None:
        give_up = time.monotonic() + self._patience_s
        while time.monotonic() < give_up:
            self._tell("ReadyHil", Member="Hil")
            if self._take_turn(_READY_EVERY_S):
                return
            self._check_processes()
        raise HilError(f"no tick within {self._patience_s:g} s: plant or a member of its barrier is missing "
                       "on this bus")

    def _await_turn(self) -> None:
        give_up = time.monotonic() + self._patience_s
        while not self._take_turn(_LOOK_EVERY_S):
            self._check_processes()
            if any(self._ends_run(frame) for frame in self._gathered()):
                raise HilError(f"the plant ended the run at {self.now_ms:g} ms")
            if time.monotonic() > give_up:
                raise HilError(f"no {self._turn.name} within {self._patience_s:g} s after tick {self.tick}")

    def _take_turn(self, timeout_s: float) -> bool:
        frames = self._barrier.receive(timeout_s)
        if not frames:
            return False
        before, self.tick = self.tick, int(self._turn.signals["Tick"].raw(frames[-1].data))
        if before >= 0 and self.tick != before + 1:
            raise HilError(f"tick {self.tick} came after tick {before}: the plant went on without the harness, and "
                           "what was measured is worthless")
        return True

    def _gathered(self) -> list[Frame]:
        frames: list[Frame] = []
        while batch := self._car.receive():
            frames += batch
        return frames

    def _ends_run(self, frame: Frame) -> bool:
        return frame.id in (self._sync, self._alive) and bool(self._dbc.by_id[frame.id].signals["Stop"].raw(frame.data))


def ask_on_terminal(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


class BusClock:
    """The time of a bus that nobody holds: a real car, a bench, or a plant in real time."""

    def __init__(self, channel: str, dbc: Dbc, listen_to: Iterable[int] | None, interface: str = "socketcan",
                 operator: Callable[[str], None] = ask_on_terminal) -> None:
        self._bus = Bus(channel, interface, dbc, listen_to)
        self._operator = operator
        self.now_ms = 0.0

    def advance(self) -> list[Frame]:
        frames = [f for f in self._bus.read(TICK_MS * 1e-3) if not is_lockstep(f.id)]
        self.now_ms = max(self.now_ms, frames[-1].time_ms) if frames else self.now_ms + TICK_MS
        return frames

    def tell(self, message: str, **values: Value | None) -> None:
        """Nobody but a person can do it at a real car."""
        done = ", ".join(f"{name} {value}" for name, value in values.items() if value not in (None, "Automatic"))
        self._operator(f"voltlap hil: please set at the car: {message}: {done or 'everything as the driver wants'}")

    def send(self, frames: list[Frame]) -> None:
        self._bus.send(frames)

    def close(self) -> None:
        self._bus.close()
