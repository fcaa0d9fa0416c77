# SPDX-License-Identifier: Apache-2.0
"""The gateway as a process between two SocketCAN channels, told by a pipe which faults to plant.

A fault is in force when `install` returns, so that a harness that holds the tick back knows from which tick it acts.
"""
from __future__ import annotations

import multiprocessing
import select
import signal
import time
from multiprocessing.connection import Connection

from .bus import Bus
from .dbc import Dbc
from .errors import HilError
from .faults import Gateway, Rule
from .quantity import TICK_MS

_START_S, _ANSWER_S = 30.0, 10.0


class GatewayProcess:
    def __init__(self, near: str, far: str, dbc: Dbc, lockstep: bool = True) -> None:
        """`near` is the plant's channel, `far` that of the nodes behind the gateway."""
        context = multiprocessing.get_context("fork")
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(near, far, dbc, lockstep, theirs), daemon=True)
        self._process.start()
        theirs.close()
        self._answer(_START_S)

    def __enter__(self) -> GatewayProcess:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def install(self, rule: Rule) -> None:
        self._pipe.send(rule)
        self._answer(_ANSWER_S)

    def clear(self) -> None:
        self._pipe.send("clear")
        self._answer(_ANSWER_S)

    def close(self) -> None:
        """Closing the pipe ends the process."""
        self._pipe.close()
        self._process.join(_ANSWER_S)
        if self._process.is_alive():
            self._process.terminate()
            self._process.join()

    def _answer(self, patience_s: float) -> None:
        try:
            text = self._pipe.recv() if self._pipe.poll(patience_s) else "no answer"
        except (EOFError, ConnectionError):
            text = "it has died"
        if text != "done":
            raise HilError(f"gateway: {text}")


def _serve(near: str, far: str, dbc: Dbc, lockstep: bool, pipe: Connection) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the harness, which closes the pipe
    try:
        with Bus(near, dbc=dbc) as first, Bus(far, dbc=dbc) as second:
            pipe.send("done")
            _forward_until_closed(Gateway(dbc), (first, second), lockstep, pipe)
    except (EOFError, ConnectionError):
        pass
    except HilError as error:
        pipe.send(str(error))


def _forward_until_closed(gateway: Gateway, sides: tuple[Bus, Bus], lockstep: bool, pipe: Connection) -> None:
    ready = select.poll()
    numbers = {side.fileno(): i for i, side in enumerate(sides)}
    for number in (*numbers, pipe.fileno()):
        ready.register(number, select.POLLIN)
    start = time.monotonic()
    while True:
        events = ready.poll(None if lockstep else TICK_MS)
        if not lockstep:
            tick = int((time.monotonic() - start) * 1000 / TICK_MS)
            for side, frame in gateway.advance(tick) if tick >= gateway.next_sync else []:
                sides[1 - side].send([frame])
        for number, _ in events:
            if number == pipe.fileno():
                _obey(gateway, pipe)
            else:
                _pass_on(gateway, sides, numbers[number])


def _obey(gateway: Gateway, pipe: Connection) -> None:
    command = pipe.recv()
    if command == "clear":
        gateway.clear()
    else:
        gateway.install(command)
    pipe.send("done")


def _pass_on(gateway: Gateway, sides: tuple[Bus, Bus], side: int) -> None:
    frames = sides[side].receive()
    sides[1 - side].send([out for frame in frames for out in gateway.forward(frame, side)])
