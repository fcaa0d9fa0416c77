# SPDX-License-Identifier: Apache-2.0
"""Takes frames from a channel or a recording into the state of the bus, and shows it: once, or again and again."""
from __future__ import annotations

import json
import sys
import time
from argparse import Namespace
from collections.abc import Iterator
from typing import Any, Protocol

from rich.console import Console, RenderableType
from rich.live import Live

from . import car_view, monitor_view
from .bus import Bus
from .bus_state import BusState
from .car_dbc import CarDbc
from .car_state import CarState
from .dbc import Dbc
from .errors import HilError, InputError
from .frame import Frame
from .recording import LogFrame, Progress, Recording

_REFRESH_S = 0.2
_READ_S = 0.05
_WIDTH = 120  # of a text that goes into a file
_SLICE_S = 0.02  # of a paced recording, at most, between two looks at the clock


class _Listener(Protocol):
    """Who takes frames and knows what they say."""

    def take(self, frame: LogFrame) -> None: ...
    def pass_time(self, now_s: float) -> None: ...
    def snapshot(self) -> dict[str, Any]: ...
    def view(self, snapshot: dict[str, Any], channel: str) -> RenderableType: ...
    @property
    def frames(self) -> int: ...
    @property
    def now_s(self) -> float: ...


class _OwnCar:
    """The project's car: its DBC files say who is who."""

    def __init__(self, dbc: Dbc) -> None:
        self._state = BusState(dbc)
        self.view = monitor_view.view

    def take(self, frame: LogFrame) -> None:
        self._state.update([Frame(frame.id, frame.data, round((frame.time_s) * 1e3, 3))])

    def pass_time(self, now_s: float) -> None:
        self._state.pass_time(now_s * 1e3)

    def snapshot(self) -> dict[str, Any]:
        return self._state.snapshot()

    @property
    def frames(self) -> int:
        return self._state.frames

    @property
    def now_s(self) -> float:
        return self._state.now_ms * 1e-3


class _AnyCar(CarState):
    def view(self, snapshot: dict[str, Any], channel: str) -> RenderableType:
        return car_view.view(snapshot, channel)

    def snapshot(self) -> dict[str, Any]:
        return {**super().snapshot(), "notes": list(self.dbc.notes)}


def show(options: Namespace) -> None:
    """What the monitor's command line asks for."""
    listener: _Listener
    if options.dbc:
        car = CarDbc(options.dbc)
        if options.signals:
            car.keep(options.signals)
        listener, dbc = _AnyCar(car, options.bit_rate * 1e3), Dbc([])
    else:
        dbc = Dbc.of_project()
        listener = _OwnCar(dbc)
    if options.log:
        _show_log(listener, options)
        return
    with Bus(options.bus, dbc=dbc, lossy=True) as bus:
        if options.once:
            _once(bus, listener, options)
        else:
            _live(bus, listener)


# ---- recordings ----

def _show_log(listener: _Listener, options: Namespace) -> None:
    recording = Recording(options.log, options.dbc or ())
    if options.speed:
        _play(listener, recording, options)
    else:
        progress = Progress(f"reading {options.log}")
        for frame in _chosen(listener, recording, options):
            listener.take(frame)
            if listener.frames % 4096 == 0:
                progress.tell(listener.frames, listener.now_s)
        progress.done()
    if not listener.frames:
        where = [f"from {options.start:g} s on"] if options.start else []
        where += [f"before --at {options.at:g} s"] if options.at else []
        raise InputError(f"{options.log}: found no frame{' ' + ' and '.join(where) if recording.frames else ''}"
                         + (f" ({_skipped(recording)})" if recording.skipped else ""))
    snapshot = _with_remarks(listener.snapshot(), recording, bool(options.dbc))
    _print(listener.view, snapshot, str(options.log), options.json)


def _chosen(listener: _Listener, recording: Recording, options: Namespace) -> Iterator[LogFrame]:
    """The frames from --from to --at."""
    for frame in recording:
        time_s = frame.time_s
        if options.at is not None and time_s > options.at:
            if listener.frames:
                listener.pass_time(options.at)
            return
        if time_s >= (options.start or 0.0):
            yield frame


def _play(listener: _Listener, recording: Recording, options: Namespace) -> None:
    """At --speed times real time, on a terminal with the state shown all along."""
    with Live(screen=True, auto_refresh=False) if sys.stdout.isatty() else _Nowhere() as live:
        begin = start_s = shown = None
        for frame in _chosen(listener, recording, options):
            now = time.monotonic()
            if begin is None or start_s is None or shown is None:
                begin, start_s, shown = now, frame.time_s, 0.0
            due = begin + ((frame.time_s) - start_s) / options.speed
            while now < due:
                if now - shown > _REFRESH_S:
                    shown = now
                    listener.pass_time(start_s + (now - begin) * options.speed)
                    live.update(listener.view(listener.snapshot(), str(options.log)), refresh=True)
                time.sleep(min(due - now, _SLICE_S))
                now = time.monotonic()
            listener.take(frame)
            if now - shown > _REFRESH_S:
                shown = now
                live.update(listener.view(listener.snapshot(), str(options.log)), refresh=True)


class _Nowhere:
    """In place of a terminal."""

    def __enter__(self) -> _Nowhere:
        return self

    def __exit__(self, *error: object) -> None:
        pass

    def update(self, what: RenderableType, *, refresh: bool) -> None:
        pass


def _skipped(recording: Recording) -> str:
    return ", ".join(f"{count} {kind}" for kind, count in recording.skipped.most_common())


def _with_remarks(snapshot: dict[str, Any], recording: Recording, any_car: bool) -> dict[str, Any]:
    remarks = ([f"left out: {_skipped(recording)}"] if recording.skipped else []) + recording.notes
    if any_car:
        return {**snapshot, "format": recording.format, "skipped": dict(recording.skipped),
                "notes": snapshot["notes"] + remarks}
    for remark in remarks:
        print(f"voltlap monitor: {recording.path}: {remark}", file=sys.stderr)
    return snapshot


# ---- channels ----

def _listen(bus: Bus, listener: _Listener, for_s: float) -> None:
    end = time.monotonic() + for_s
    while (left := end - time.monotonic()) > 0.0:
        begin = time.monotonic()
        frames = bus.read(min(left, _READ_S))
        for frame in frames:
            listener.take(LogFrame(frame.time_ms * 1e-3, bus.channel, frame.id, frame.data))
        if not frames and listener.frames:
            listener.pass_time(listener.now_s + time.monotonic() - begin)


def _once(bus: Bus, listener: _Listener, options: Namespace) -> None:
    _listen(bus, listener, options.wait)
    if not listener.frames:
        raise HilError(f"{options.bus}: no frame within {options.wait:g} s. Does anything run there? For instance "
                       f"`./voltlap endurance --bus {options.bus} --pace 1`; or wait longer with --wait.")
    _print(listener.view, {**listener.snapshot(), "lost_here": bus.lost_here}, options.bus, options.json)


def _print(view: Any, snapshot: dict[str, Any], channel: str, as_json: bool) -> None:
    if as_json:
        json.dump({"channel": channel, **snapshot}, sys.stdout, indent=2)
        print()
    else:
        console = Console(width=None if sys.stdout.isatty() else _WIDTH, highlight=False)
        console.print(view(snapshot, channel))


def _live(bus: Bus, listener: _Listener) -> None:
    with Live(screen=sys.stdout.isatty(), auto_refresh=False) as live:
        while True:
            _listen(bus, listener, _REFRESH_S)
            if listener.frames:
                live.update(listener.view(listener.snapshot(), bus.channel), refresh=True)
            else:
                live.update(f"{bus.channel}: no frame yet; Ctrl-C ends", refresh=True)
