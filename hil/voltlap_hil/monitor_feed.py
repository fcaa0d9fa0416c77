# SPDX-License-Identifier: Apache-2.0
"""Takes frames from a channel or a log into the state of the bus, and shows it: once, or again and again."""
from __future__ import annotations

import json
import sys
import time
from argparse import Namespace
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import can
from rich.console import Console
from rich.live import Live

from .bus import Bus, to_frame
from .dbc import Dbc
from .errors import HilError, InputError
from .frame import Frame
from .monitor_view import view
from .bus_state import BusState

_REFRESH_S = 0.2
_READ_S = 0.05
_WIDTH = 120  # of a text that goes into a file


def show(options: Namespace) -> None:
    """What the monitor's command line asks for."""
    dbc = Dbc.of_project()
    if options.log:
        state = BusState(dbc)
        for frame in _frames_of(options.log, options.at):
            state.update([frame])
        if not state.frames:
            raise InputError(f"{options.log}: found no frame{' before --at' if options.at else ''}")
        _print(state.snapshot(), str(options.log), options.json)
        return
    with Bus(options.bus, dbc=dbc, lossy=True) as bus:
        if options.once:
            _once(bus, options)
        else:
            _live(bus)


def _frames_of(path: Path, until_s: float | None) -> Iterator[Frame]:
    try:
        first = None
        for m in can.LogReader(path):
            first = m.timestamp if first is None else first
            time_s = m.timestamp - first
            if until_s is not None and time_s > until_s:
                return
            if not m.is_error_frame and not m.is_remote_frame:
                yield to_frame(m, round(time_s * 1e3, 3))
    except OSError as error:
        raise InputError(f"{path}: {error.strerror or error}") from None
    except Exception as error:  # the readers end in any of Python's own on bytes that only look like a log
        text = " ".join(str(error).split())[:200] or type(error).__name__
        raise InputError(f"{path}: not a log that can be read ({text}); expected candump -l, .asc or .blf") from None


def _listen(bus: Bus, state: BusState, for_s: float) -> None:
    end = time.monotonic() + for_s
    while (left := end - time.monotonic()) > 0.0:
        begin = time.monotonic()
        frames = bus.read(min(left, _READ_S))
        if frames:
            state.update(frames)
        elif state.frames:
            state.pass_time(state.now_ms + (time.monotonic() - begin) * 1e3)


def _once(bus: Bus, options: Namespace) -> None:
    state = BusState(bus.dbc)
    _listen(bus, state, options.wait)
    if not state.frames:
        raise HilError(f"{options.bus}: no frame within {options.wait:g} s. Does anything run there? For instance "
                       f"`./voltlap endurance --bus {options.bus} --pace 1`; or wait longer with --wait.")
    _print({**state.snapshot(), "lost_here": bus.lost_here}, options.bus, options.json)


def _print(snapshot: dict[str, Any], channel: str, as_json: bool) -> None:
    if as_json:
        json.dump({"channel": channel, **snapshot}, sys.stdout, indent=2)
        print()
    else:
        console = Console(width=None if sys.stdout.isatty() else _WIDTH, highlight=False)
        console.print(view(snapshot, channel))


def _live(bus: Bus) -> None:
    state = BusState(bus.dbc)
    with Live(screen=sys.stdout.isatty(), auto_refresh=False) as live:
        while True:
            _listen(bus, state, _REFRESH_S)
            if state.frames:
                live.update(view(state.snapshot(), bus.channel), refresh=True)
            else:
                live.update(f"{bus.channel}: no frame yet; Ctrl-C ends", refresh=True)
