# SPDX-License-Identifier: Apache-2.0
"""Runs rows of the table of faults and measures each: when the fault was told, when the torque was gone, when the
contactors were open, and what the car did.

Every row that expects a reaction is also driven without its fault: what is expected must not be seen then, and the car
must go on. Where the firmware is on boards outside of the process, each drive is driven inside as well: a frame that
differs fails the row. So a check that holds anyway, and a limit that stops a sound car, are failures.
"""
from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any

from . import checks
from .condition import Condition
from .dbc import Dbc
from .errors import HilError
from .fault_table import Row
from .rig import Rig
from .scenario_file import Scenario
from .tape import Tape
from .trace import Trace

PASSED, FAILED, KNOWN, NOT_RUN = "passed", "failed", "known", "not run"
_SAME_MS = 20.0    # by which a break may be longer with a fault than without
_TOLD_BY_MS = 1000.0  # BMS-060 to BMS-069 judge for so long
_BREAK_MS = 100.0  # of what a sound car keeps to: wheels spin, a limit is met
CURVES = ("InverterStatus.PhaseCurrent", "PackSensor.PackCurrent", "BmsLimits.DischargeLimit", "MasterStatus.Faults",
          "BmsStatus.Faults", "VehicleIo.AirPlusAux", "VehicleIo.AirMinusAux", "VehicleIo.PrechargeAux",
          "MasterStatus.PedalRequest")
_BEFORE_MS, _POINTS = 200.0, 400


@dataclass
class Curve:
    """Of one signal over the row: (s from the fault, value) where it changes, and the bounds on it in ms."""

    unit: str
    points: list[tuple[float, float]]
    bounds_ms: list[float]


@dataclass
class RowResult:
    """Times in ms from the fault; None: never. `did` is what the car did, in words; `results` each check."""

    id: str
    verdict: str
    drive: str = ""
    results: list[checks.Result] = field(default_factory=list)
    seen_ms: float | None = None
    torque_zero_ms: float | None = None
    contactors_open_ms: float | None = None
    did: str = ""
    sound_car: str = ""
    event_ms: float = 0.0
    wall_s: float = 0.0
    error: str = ""
    trace_hash: str = ""   # of all frames, with boards
    other_frame: str = ""  # the first that differs from the run in one process
    ecu: dict[str, Any] | None = None  # what boards say of themselves
    curves: dict[str, Curve] = field(default_factory=dict)


OpenRig = Callable[..., Rig]


class CannotDrive(HilError):
    """The sound car does not do what the drive asks, before anything has been broken."""


@dataclass
class Drive:
    """Of a scenario: its frames, when the event was, and, with boards, their account and how they differ."""

    trace: Trace
    event_ms: float
    tape: Tape | None
    account: dict[str, Any] | None


def run_row(row: Row, dbc: Dbc, open_rig: OpenRig, twins: Twins, open_inside: OpenRig | None = None) -> RowResult:
    """In the first of its drives that the sound car does. `open_inside`: the same rig with the firmware in the process,
    where `open_rig` has boards."""
    out = _run_in(row, dbc, open_rig, twins, open_inside)
    if out.verdict == NOT_RUN and row.otherwise:
        return run_row(row.otherwise, dbc, open_rig, twins, open_inside)
    return out


def _run_in(row: Row, dbc: Dbc, open_rig: OpenRig, twins: Twins, open_inside: OpenRig | None) -> RowResult:
    begin = time.monotonic()
    out = RowResult(row.id, FAILED, drive=row.situation.name)
    try:
        if row.only_with:
            raise CannotDrive(row.only_with)
        drive = _drive(row.scenario, open_rig, True)
        trace, out.event_ms, out.ecu = drive.trace, drive.event_ms, drive.account
        _judge(row, dbc, trace, out)
        if open_inside is not None and drive.tape is not None:
            out.trace_hash = drive.tape.hash
            out.other_frame = other_frame(drive, _drive(row.scenario, open_inside, True), dbc)
        if only_with_fault(row):
            out.sound_car = twins.verdict(row)
        elif row.goes_on_ms:
            out.sound_car = _went_on(row, trace, out, twins)
        held = all(result.held for result in out.results) and out.sound_car in ("", "goes on")
        if not held and row.told_by and (brought := twins.lasts_ms(row, row.told_by)) < _TOLD_BY_MS:
            raise CannotDrive(f"the sound car's drive brings '{row.told_by.text}', by which the fault is told, for "
                              f"{brought:g} ms of the {_TOLD_BY_MS:g} ms that it takes")
        out.verdict = FAILED if out.other_frame else PASSED if held else KNOWN if row.known else FAILED
    except CannotDrive as error:
        out.verdict, out.error = NOT_RUN, f"could not be run: {error}"
    except HilError as error:
        out.error = str(error)
    out.wall_s = time.monotonic() - begin
    return out


def other_frame(drive: Drive, inside: Drive, dbc: Dbc) -> str:
    """The first frame in which boards differ from the run in one process, in words."""
    assert drive.tape is not None and inside.tape is not None
    return "" if drive.tape.hash == inside.tape.hash else drive.tape.first_difference(inside.tape, dbc)


def expected(row: Row) -> list[checks.Check]:
    return [*([row.seen] if row.seen else []), *row.reactions.values()]


def bound_ms(row: Row, check: checks.Check) -> float:
    """A reaction is watched for a while longer, to see that it lasts."""
    return check.lasts_ms if check is row.seen else check.lasts_ms - checks.HOLD_MS


def only_with_fault(row: Row) -> list[checks.Check]:
    """What must be seen with the fault, and only with it."""
    reactions = [check for name, check in row.reactions.items() if name not in row.situation.ends]
    return [*([row.seen] if row.seen else []), *reactions]


def _drive(scenario: Scenario, open_rig: OpenRig, with_fault: bool) -> Drive:
    driver = {"automatic": True} if scenario.automatic else {}
    with open_rig(behind=scenario.behind, arguments=scenario.arguments, gateway=scenario.needs_gateway,
                  **driver) as rig:
        try:
            for step in scenario.given:
                step.act(rig)
        except HilError as error:
            raise CannotDrive(f"the sound car does not come to where the fault begins: {error}") from None
        event_ms = rig.now_ms
        for step in [*(scenario.when if with_fault else []), *scenario.meanwhile]:
            step.act(rig)
        rest_ms = event_ms + scenario.observe_ms - rig.now_ms
        rig.run(f"{max(0.0, rest_ms):.3f} ms")
    return Drive(rig.trace, event_ms, rig.tape, rig.ecu_account)


def _judge(row: Row, dbc: Dbc, trace: Trace, out: RowResult) -> None:
    out.results = [check.measure(trace, out.event_ms) for check in [*expected(row), *row.more]]
    if row.seen:
        out.seen_ms = out.results[0].measured
    out.torque_zero_ms = _since(trace, dbc, checks.TORQUE_ZERO, out.event_ms)
    out.contactors_open_ms = _since(trace, dbc, checks.CONTACTORS_OPEN, out.event_ms)
    out.did = _what_it_did(out, trace, dbc)
    if row.goes_on_ms:
        out.results.append(checks.stays(row.situation.sound, row.goes_on_ms).measure(trace, out.event_ms))
        out.did = "drove on" if out.results[-1].held else f"{out.did}: stopped by it"
    asserted = {name: [bound_ms(row, check) for check in expected(row) if name in check.needs]
                for check in [*expected(row), *row.more] for name in check.needs if name[-1] != "."}
    for name in dict.fromkeys([*asserted, *CURVES]):
        out.curves[name] = Curve(dbc.signal(name).unit, _curve(trace, dbc, name, out.event_ms), asserted.get(name, []))


def _breach_ms(row: Row, trace: Trace, event_ms: float) -> float:
    sound = row.situation.sound
    longest = checks.longest_breach(trace, sound.signals, sound.holds, event_ms)
    return row.goes_on_ms if longest is None else longest


def _keeps_to(sound: Condition, trace: Trace, event_ms: float) -> bool:
    """At the end it does, or but for a moment here and there."""
    if checks.last_start(trace, sound.signals, sound.holds, event_ms) is not None:
        return True
    longest = checks.longest_breach(trace, sound.signals, sound.holds, event_ms)
    return longest is not None and longest <= _BREAK_MS


def _went_on(row: Row, trace: Trace, out: RowResult, twins: Twins) -> str:
    """A car that goes on does so as the same car without the fault does: it is not asked for more than that."""
    if out.results[-1].held:
        return "goes on"
    without, with_it = twins.breach_ms(row), _breach_ms(row, trace, out.event_ms)
    if without > _BREAK_MS:
        raise CannotDrive(f"the sound car does not keep to '{row.situation.sound.text}'")
    if without > 0 and with_it <= without + _SAME_MS:
        out.results[-1] = replace(out.results[-1], held=True, detail=f"without the fault for {without:g} ms, too")
        out.did = "drove on"
        return "goes on"
    return "is stopped by it"


def _since(trace: Trace, dbc: Dbc, text: str, event_ms: float) -> float | None:
    condition = Condition.parse(text, dbc)
    since = checks.last_start(trace, condition.signals, condition.holds, event_ms)
    return None if since is None else round(since - event_ms, 3)


def _what_it_did(out: RowResult, trace: Trace, dbc: Dbc) -> str:
    if out.contactors_open_ms is not None:
        return "contactors open" if out.contactors_open_ms else "contactors stayed open"
    if out.torque_zero_ms is not None:
        return "torque gone" if out.torque_zero_ms else "stood without torque"
    torque = Condition.parse(checks.TORQUE_ZERO.replace("=", "!="), dbc)
    longest = checks.longest_breach(trace, torque.signals, torque.holds, out.event_ms) or 0.0
    return f"drove on, without torque for {longest:g} ms" if longest else "drove on"


def _curve(trace: Trace, dbc: Dbc, name: str, event_ms: float) -> list[tuple[float, float]]:
    """(s from the fault, value): where it changes, thinned to what a small chart can show."""
    signal, points = dbc.signal(name), []
    for frame in trace.frames:
        if frame.id != signal.message.id or len(frame.data) != signal.message.dlc:
            continue
        after_ms = frame.time_ms - event_ms
        if after_ms < -_BEFORE_MS:
            continue
        value: Any = signal.raw(frame.data) if signal.states else signal.read(frame.data)
        if value is not None:
            points.append((round(after_ms * 1e-3, 3), float(value)))
    steps = [p for i, p in enumerate(points) if i in (0, len(points) - 1) or p[1] != points[i - 1][1]]
    if len(steps) <= _POINTS:
        return steps
    return [steps[i * (len(steps) - 1) // (_POINTS - 1)] for i in range(_POINTS)]


class Twins:
    """The same drives without their fault, each once."""

    def __init__(self, dbc: Dbc, open_rig: OpenRig, open_inside: OpenRig | None = None) -> None:
        self._dbc, self._open_rig, self._open_inside = dbc, open_rig, open_inside
        self._drive = lru_cache(maxsize=32)(self._drive_twin)
        self._scenarios: dict[tuple[object, ...], Scenario] = {}

    def _key(self, row: Row) -> tuple[object, ...]:
        own = row.scenario
        key = (row.situation.name, tuple(own.arguments), own.behind, own.needs_gateway, own.observe_ms,
               row.id if row.own_meanwhile else "")
        self._scenarios.setdefault(key, own)
        return key

    def verdict(self, row: Row) -> str:
        trace, event_ms, other = self._drive(self._key(row))
        if other:
            return f"sends another frame than in one process: {other}"
        seen = [c.title for c in only_with_fault(row) if c.measure(trace, event_ms).held]
        if seen:
            return f"shows it without the fault: {', '.join(seen)}"
        if not _keeps_to(row.situation.sound, trace, event_ms):
            raise CannotDrive(f"the sound car does not keep to '{row.situation.sound.text}'")
        return "goes on"

    def lasts_ms(self, row: Row, condition: Condition) -> float:
        """For how long in all it holds in the sound car's drive, from the event on."""
        trace, event_ms, _ = self._drive(self._key(row))
        total, before = 0.0, event_ms
        for time_ms, values in trace.states(condition.signals):
            if time_ms > before:
                total += (time_ms - before) * condition.holds(values)
                before = time_ms
        return round(total, 3)

    def breach_ms(self, row: Row) -> float:
        """How long without a break the sound car does not keep to what it should, while the row looks."""
        trace, event_ms, _ = self._drive(self._key(row))
        return _breach_ms(row, trace, event_ms)

    def _drive_twin(self, key: tuple[object, ...]) -> tuple[Trace, float, str]:
        drive = _drive(self._scenarios[key], self._open_rig, False)
        other = ""
        if self._open_inside is not None:
            other = other_frame(drive, _drive(self._scenarios[key], self._open_inside, False), self._dbc)
        return drive.trace, drive.event_ms, other
