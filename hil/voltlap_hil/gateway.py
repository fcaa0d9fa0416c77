# SPDX-License-Identifier: Apache-2.0
"""The gateway as a process between two SocketCAN channels, told by a pipe which faults to plant.

A fault is in force when `install` returns, so that a harness that holds the tick back knows from which tick it acts.
"""
from __future__ import annotations

import atexit
import gc
import multiprocessing
import select
import signal
import time
from multiprocessing.connection import Connection
from typing import NamedTuple

from .bus import Bus
from .dbc import Dbc
from .errors import HilError
from .faults import Gateway, Fault
from .frame import LOCKSTEP_FIRST, LOCKSTEP_LAST
from .quantity import TICK_MS

_CLEAR, _CLOSE = "clear", "close"
_ANSWER_S = 30.0
_UNMARKED_MS = 50  # frames without a mark behind them pass after this


class _Channels(NamedTuple):
    near: str
    far: str
    lockstep: bool
    seed: int


class _Worker:
    """A forked process that serves one gateway after the other. Forking costs more than a short run."""

    def __init__(self, dbc: Dbc) -> None:
        context = multiprocessing.get_context("fork")
        self.dbc = dbc
        self.pipe, theirs = context.Pipe()
        self.process = context.Process(target=_serve, args=(dbc, theirs, self.pipe), daemon=True)
        self.process.start()
        theirs.close()

    def ask(self, command: object) -> None:
        """Waits for the answer; anything but "done" is a reason."""
        try:
            self.pipe.send(command)
            text = self.pipe.recv() if self.pipe.poll(_ANSWER_S) else f"no answer within {_ANSWER_S:g} s"
        except (EOFError, ConnectionError):
            text = "it has died"
        if text != "done":
            raise HilError(f"gateway: {text}")

    def end(self) -> None:
        self.pipe.close()
        self.process.join(_ANSWER_S)
        if self.process.is_alive():
            self.process.kill()
            self.process.join()


_idle: list[_Worker] = []


@atexit.register
def _end_idle_workers() -> None:
    while _idle:
        _idle.pop().end()


class GatewayProcess:
    def __init__(self, near: str, far: str, dbc: Dbc, lockstep: bool = True, seed: int = 1) -> None:
        """`near` is the plant's channel, `far` that of the nodes behind the gateway."""
        known = next((worker for worker in _idle if worker.dbc is dbc and worker.process.is_alive()), None)
        if known is not None:
            _idle.remove(known)
        self._worker = known or _Worker(dbc)
        try:
            self._worker.ask(_Channels(near, far, lockstep, seed))
        except HilError:
            self._worker.end()
            raise

    def __enter__(self) -> GatewayProcess:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def install(self, fault: Fault) -> None:
        self._worker.ask(fault)

    def clear(self) -> None:
        self._worker.ask(_CLEAR)

    def check_alive(self) -> None:
        if not self._worker.process.is_alive() or self._worker.pipe.poll():
            self._worker.ask(_CLEAR)

    def close(self) -> None:
        """Ends the forwarding; the process waits for the next gateway or for the end of its owner."""
        try:
            self._worker.ask(_CLOSE)
            _idle.append(self._worker)
        except HilError:
            self._worker.end()


def _serve(dbc: Dbc, pipe: Connection, other_end: Connection) -> None:
    gc.freeze()  # a collection of what was forked would copy page after page: seconds, on a machine with other work
    other_end.close()  # else the pipe would not end when the harness dies
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the harness, which closes the pipe
    try:
        while True:
            channels = pipe.recv()
            try:
                _forward(dbc, channels, pipe)
                pipe.send("done")
            except HilError as error:
                pipe.send(str(error))
    except (EOFError, ConnectionError):
        pass


def _forward(dbc: Dbc, channels: _Channels, pipe: Connection) -> None:
    near, far = channels.near, channels.far
    with Bus(near, dbc=dbc) as first, Bus(far, dbc=dbc) as second:
        if not channels.lockstep:
            pipe.send("done")
            _forward_at_once(Gateway(dbc, channels.seed), (first, second), pipe)
            return
        marks = range(LOCKSTEP_FIRST, LOCKSTEP_LAST + 1)
        with Bus(near, dbc=dbc, ids=marks) as near_marks, Bus(far, dbc=dbc, ids=marks) as far_marks:
            pipe.send("done")
            _forward_by_marks(Gateway(dbc, channels.seed), (first, second), (near_marks, far_marks), pipe)


def _forward_by_marks(gateway: Gateway, sides: tuple[Bus, Bus], marks: tuple[Bus, Bus], pipe: Connection) -> None:
    """Wakes only for lockstep frames: what a node sends before its mark passes in one batch with it.

    A second socket a side sees nothing else, so that the first frame of a batch does not wake the gateway.
    """
    ready = select.poll()
    numbers = {side.fileno(): i for i, side in enumerate(marks)}
    for number in (*numbers, pipe.fileno()):
        ready.register(number, select.POLLIN)
    while True:
        for number, _ in ready.poll(_UNMARKED_MS) or [(number, 0) for number in numbers]:
            if number == pipe.fileno():
                if not _obey(gateway, pipe):
                    return
            else:
                marks[numbers[number]].receive()
                _pass_on(gateway, sides, numbers[number])


def _forward_at_once(gateway: Gateway, sides: tuple[Bus, Bus], pipe: Connection) -> None:
    """On a bus without Sync: every frame as it comes, delays by the wall clock."""
    ready = select.poll()
    numbers = {side.fileno(): i for i, side in enumerate(sides)}
    for number in (*numbers, pipe.fileno()):
        ready.register(number, select.POLLIN)
    start = time.monotonic()
    while True:
        events = ready.poll(TICK_MS)
        tick = int((time.monotonic() - start) * 1000 / TICK_MS)
        for side, frame in gateway.advance(tick) if tick >= gateway.next_sync else []:
            sides[1 - side].send([frame])
        for number, _ in events:
            if number == pipe.fileno():
                if not _obey(gateway, pipe):
                    return
            else:
                _pass_on(gateway, sides, numbers[number])


def _obey(gateway: Gateway, pipe: Connection) -> bool:
    """False for the command that ends the forwarding; that is answered when the channels are closed."""
    command = pipe.recv()
    if command == _CLOSE:
        return False
    if command == _CLEAR:
        gateway.clear()
    else:
        gateway.install(command)
    pipe.send("done")
    return True


def _pass_on(gateway: Gateway, sides: tuple[Bus, Bus], side: int) -> None:
    while frames := sides[side].receive():
        sides[1 - side].send([out for frame in frames for out in gateway.forward(frame, side)])
