# SPDX-License-Identifier: Apache-2.0
"""What holds in every drive, whatever breaks: checked on the frames alone, each with the faults that void it.

A fault voids an invariant where the frames no longer say what is true (a shunt that is the wrong way round), or where
nobody could tell (both accelerator sensors stuck at full).
"""
from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from . import checks
from .condition import Condition
from .dbc import Dbc
from .fault_table import Row
from .trace import Trace

_APPS_V = ((0.5, 4.0), (0.25, 2.0))  # released, travel of the two sensors: MasterConfig
_ANSWERED_MS = 70.0                # the oldest pedal that may carry torque (MST-050), and a tick each way
_FOUND_MS = 120.0                  # a second sender or a replay is believed for 100 ms (MST-061), and a tick each way
_LIMIT_MS = 500.0                  # EV.3.4.1: an excess counts over 500 ms
_OPEN_MS = 250.0                   # of a trip: 100 ms for the torque (BMS-034), the contacts, a tick each way
_SILENT_MS = 50.0
_LOST_MS = 50.0                    # five commands in a row: at 2 % once in a month of driving
_TOLERANCE_A = 1.0


_OTHER_INVERTERS = {"InverterCommand": ("Pm100Command", "AmkSetpoints")}


@dataclass(frozen=True)
class Drive:
    """A run to judge from `ready_ms` on. `by_foot`: the pedals were drawn, and never both at once; `full_a`: phase
    current of a full pedal."""

    dbc: Dbc
    trace: Trace
    ready_ms: float
    by_foot: bool
    loss: int
    faults: tuple[Row, ...]
    full_a: float = 550.0

    def has(self, *words: str) -> bool:
        """Whether a fault is about one of these; a message of an inverter by its own name, too."""
        wanted = [other for word in words for other in (word, *_OTHER_INVERTERS.get(word, ()))]
        return any(word in fault.fault for fault in self.faults for word in wanted)


def broken(drive: Drive) -> list[str]:
    found = [(name, judge(drive)) for name, judge in _INVARIANTS.items()]
    return [f"{name}: {text}" for name, text in found if text]


def _first(drive: Drive, condition: str, names: Condition | None = None) -> float | None:
    wanted = names or Condition.parse(condition, drive.dbc)
    return checks.first_time(drive.trace, wanted.signals, wanted.holds, drive.ready_ms)


def _torque_only_when_ready(drive: Drive) -> str:
    """No torque without brake and button: what is not ready to drive commands none."""
    if drive.has("InverterCommand"):
        return ""  # what was seen of it is damaged, and not what was sent
    text = "InverterCommand.PhaseCurrent > 0 A and MasterStatus.DriveState != ReadyToDrive"
    wanted = Condition.parse(text, drive.dbc)
    since_ms: float | None = None
    for time_ms, values in drive.trace.states(wanted.signals):
        if time_ms <= drive.ready_ms or not wanted.holds(values):
            since_ms = None
            continue
        since_ms = time_ms if since_ms is None else since_ms
        # Where frames are lost the last command that was seen need not be the last that was sent.
        if time_ms - since_ms >= (_LOST_MS if drive.loss else 0.0):
            return f"torque is commanded at {since_ms:g} ms by a car that is not ready to drive"
    return ""


def _never_more_than_asked(drive: Drive) -> str:
    if drive.has("InverterCommand", "MASTER", "master"):
        return ""  # nor is what a dead or silent master said last
    if any(fault.id.startswith(("apps_both", "apps_shorted", "pair_")) for fault in drive.faults):
        return ""
    signals = [drive.dbc.signal(name) for name in ("Pedals.Apps1", "Pedals.Apps2", "InverterCommand.PhaseCurrent")]
    past: list[tuple[float, float]] = []
    since_ms: float | None = None
    for time_ms, values in drive.trace.states(signals):
        *volts, command = (values[s.name] for s in signals)
        travels = [(v - zero) / span for v, (zero, span) in zip(volts, _APPS_V, strict=True)
                   if isinstance(v, (int, float))]
        past = [p for p in past if p[0] > time_ms - _ANSWERED_MS] + [(time_ms, max(travels, default=0.0))]
        most_a = drive.full_a * min(1.0, max(travel for _, travel in past)) + _TOLERANCE_A
        more = time_ms > drive.ready_ms and isinstance(command, (int, float)) and command > most_a
        since_ms = None if not more else time_ms if since_ms is None else since_ms
        if since_ms is not None and time_ms - since_ms > _FOUND_MS:
            return f"more than the pedal asks for, {most_a:.0f} A, is commanded from {since_ms:g} ms on: {command:g} A"
    return ""


def _limit_obeyed(drive: Drive) -> str:
    if drive.has("Current", "BmsLimits", "BMS", "InverterFollows", "InverterStuck"):
        return ""  # frames that do not say what is true; an inverter that does not obey has rows of its own
    result = checks.limit_obeyed_within(drive.dbc, _LIMIT_MS).measure(drive.trace, drive.ready_ms)
    return "" if result.held else f"the pack's current is beyond its limit for {result.measured} ms"


def _trip_opens(drive: Drive) -> str:
    if drive.has("Welded", "Slow", "VehicleIo", "BMS", "BmsStatus", "bms", "PLANT"):
        return ""
    at = _first(drive, "BmsStatus.State = Fault")
    if at is None:
        return ""
    result = checks.contactors_open_within(drive.dbc, _OPEN_MS).measure(drive.trace, at)
    return "" if result.held else f"contactors open {result.measured} ms after the trip at {at:g} ms"


def _sound_car_goes_on(drive: Drive) -> str:
    if any(not fault.goes_on_ms for fault in drive.faults) or (drive.faults and drive.loss) or len(drive.faults) > 1:
        return ""
    text = "MasterStatus.DriveState != ReadyToDrive"
    at = _first(drive, text)
    if at is None and not drive.faults:
        text = "BmsStatus.Faults != 0"
        at = _first(drive, text)
    return "" if at is None else f"{text} at {at:g} ms in a car that is sound"


def _nobody_is_stuck(drive: Drive) -> str:
    if drive.has("BMS", "MASTER", "BmsStatus", "MasterStatus", "bms", "master"):
        return ""
    for message in ("BmsStatus", "MasterStatus"):
        wanted, last_ms = drive.dbc.message(message).id, drive.ready_ms
        allowed_ms = _SILENT_MS if not drive.loss else 2 * _SILENT_MS
        for frame in drive.trace.frames:
            if frame.id == wanted and frame.time_ms > drive.ready_ms:
                if frame.time_ms - last_ms > allowed_ms:
                    return f"no {message} for {frame.time_ms - last_ms:g} ms until {frame.time_ms:g} ms"
                last_ms = frame.time_ms
        if drive.trace.end_ms - last_ms > allowed_ms:
            return f"no {message} from {last_ms:g} ms on"
    return ""


_INVARIANTS: dict[str, Callable[[Drive], str]] = {
    "torque only when ready": _torque_only_when_ready, "never more than asked": _never_more_than_asked,
    "limit obeyed": _limit_obeyed, "a trip opens": _trip_opens, "a sound car goes on": _sound_car_goes_on,
    "nobody is stuck": _nobody_is_stuck}
