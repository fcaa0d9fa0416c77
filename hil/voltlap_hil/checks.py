# SPDX-License-Identifier: Apache-2.0
"""What must have happened, as a measured number against its bound. A check asks a trace and never stops a run.

Times are counted from the event, or from the first moment after it at which `after` holds. A reaction that must last
(torque zero, contactors open, a limit obeyed) is measured to the moment from which it holds until the trace ends.
"""
from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from .condition import Condition
from .dbc import Dbc, Value
from .trace import Trace

TORQUE_ZERO = "InverterStatus.PhaseCurrent = 0 A"
CONTACTORS_OPEN = "VehicleIo.AirPlusAux = 0 and VehicleIo.AirMinusAux = 0 and VehicleIo.PrechargeAux = 0"
CONTACTORS_COMMANDED_OPEN = ("ContactorCommand.AirPlusClose = 0 and ContactorCommand.AirMinusClose = 0 "
                             "and ContactorCommand.PrechargeClose = 0")
READY = "MasterStatus.DriveState = ReadyToDrive"


@dataclass(frozen=True)
class Result:
    """`measured` is None when what was waited for never came."""

    check: str
    held: bool
    measured: float | None
    bound: str
    unit: str
    detail: str = ""

    def __str__(self) -> str:
        value = "never" if self.measured is None else f"{self.measured:g} {self.unit}"
        return f"{'held' if self.held else 'not held'}: {self.check}: {value}, bound {self.bound}" + (
            f" ({self.detail})" if self.detail else "")


@dataclass(frozen=True)
class Check:
    """`needs`: signals it looks at; `lasts_ms`: how long after the event the trace must go on."""

    title: str
    needs: tuple[str, ...]
    lasts_ms: float
    judge: Callable[[Trace, float], Result]
    after: Condition | None = None

    def measure(self, trace: Trace, event_ms: float) -> Result:
        if self.after is None:
            return self.judge(trace, event_ms)
        start = first_time(trace, self.after.signals, self.after.holds, event_ms)
        if start is None:
            return Result(self.title, False, None, "", "ms", f"'{self.after.text}' never came")
        return self.judge(trace, start)

    def starting_at(self, after: Condition) -> Check:
        return Check(f"{self.title} after {after.text}", self.needs + tuple(s.name for s in after.signals),
                     self.lasts_ms, self.judge, after)


Holds = Callable[[Mapping[str, Value | None]], bool]
HOLD_MS = 100.0  # how long a reaction must at least be seen to last


def first_time(trace: Trace, signals: list, holds: Holds, from_ms: float) -> float | None:  # type: ignore[type-arg]
    """First moment at or after `from_ms` at which it holds; what holds already holds at `from_ms`."""
    before = False
    for time_ms, values in trace.states(signals):
        if time_ms <= from_ms:
            before = holds(values)
            continue
        if before:
            return from_ms
        if holds(values):
            return time_ms
    return from_ms if before else None


def last_start(trace: Trace, signals: list, holds: Holds, from_ms: float) -> float | None:  # type: ignore[type-arg]
    """The moment from which it holds until the trace ends; None when it does not hold at the end."""
    start: float | None = None
    for time_ms, values in trace.states(signals):
        if not holds(values):
            start = None
        elif start is None or time_ms <= from_ms:
            start = max(time_ms, from_ms)
    return start


def longest_breach(trace: Trace, signals: list, holds: Holds, from_ms: float) -> float | None:  # type: ignore[type-arg]
    """Longest time without a break in which it does not hold; None when nothing was heard."""
    longest: float | None = None
    start: float | None = None
    for time_ms, values in trace.states(signals):
        if time_ms <= from_ms:
            continue
        if not holds(values) and start is None:
            start = time_ms
        longest = max(longest or 0.0, 0.0 if start is None else time_ms - start)
        if holds(values):
            start = None
    return longest


def _needs(condition: Condition) -> tuple[str, ...]:
    return tuple(s.name for s in condition.signals)


def _timed(title: str, since: float | None, event_ms: float, within_ms: float, not_before_ms: float = 0.0) -> Result:
    took = None if since is None else round(since - event_ms, 3)
    bound = f"{within_ms:g} ms" if not not_before_ms else f"{not_before_ms:g} to {within_ms:g} ms"
    return Result(title, took is not None and not_before_ms <= took <= within_ms, took, bound, "ms")


def settled(title: str, condition: Condition, within_ms: float) -> Check:
    """The condition becomes true in time and stays true."""
    def judge(trace: Trace, event_ms: float) -> Result:
        since = last_start(trace, condition.signals, condition.holds, event_ms)
        return _timed(title, since, event_ms, within_ms)
    return Check(title, _needs(condition), within_ms + HOLD_MS, judge)


def torque_zero_within(dbc: Dbc, within_ms: float) -> Check:
    """The motor's current, as the inverter reports it, is zero for good."""
    return settled("torque zero", Condition.parse(TORQUE_ZERO, dbc), within_ms)


def contactors_open_within(dbc: Dbc, within_ms: float) -> Check:
    """All auxiliary contacts say open for good."""
    return settled("contactors open", Condition.parse(CONTACTORS_OPEN, dbc), within_ms)


def contactors_commanded_open_within(dbc: Dbc, within_ms: float) -> Check:
    """The BMS asks for open contactors for good; also where a welded one cannot follow."""
    return settled("contactors commanded open", Condition.parse(CONTACTORS_COMMANDED_OPEN, dbc), within_ms)


def reached(condition: Condition, within_ms: float, not_before_ms: float = 0.0) -> Check:
    """The condition becomes true in time, however short."""
    def judge(trace: Trace, event_ms: float) -> Result:
        since = first_time(trace, condition.signals, condition.holds, event_ms)
        return _timed(condition.text, since, event_ms, within_ms, not_before_ms)
    return Check(condition.text, _needs(condition), within_ms, judge)


def reached_state(dbc: Dbc, signal: str, state: str, within_ms: float) -> Check:
    return reached(Condition.parse(f"{signal} = {state}", dbc), within_ms)


def stays(condition: Condition, for_ms: float, from_ms: float = 0.0) -> Check:
    """The condition holds at every moment of a window after the event; measured is how long it did."""
    title = f"stays {condition.text}"

    def judge(trace: Trace, event_ms: float) -> Result:
        start, lasted = event_ms + from_ms, 0.0
        for time_ms, values in trace.states(condition.signals):
            if start < time_ms <= start + for_ms:
                if not condition.holds(values):
                    return Result(title, False, lasted, f"{for_ms:g} ms", "ms", f"ended at {time_ms - event_ms:g} ms")
                lasted = round(time_ms - start, 3)
        return Result(title, lasted >= for_ms, lasted, f"{for_ms:g} ms", "ms")
    return Check(title, _needs(condition), from_ms + for_ms, judge)


def _obeyed(title: str, dbc: Dbc, names: tuple[str, ...], holds: Holds, within_ms: float) -> Check:
    signals = [dbc.signal(name) for name in names]

    def judge(trace: Trace, event_ms: float) -> Result:
        longest = longest_breach(trace, signals, holds, event_ms)
        return Result(title, longest is not None and longest <= within_ms, longest, f"{within_ms:g} ms", "ms")
    return Check(title, names, within_ms + HOLD_MS, judge)


# What the limit cannot shed: the low-voltage system takes 575 W from the pack.
_MARGIN_A = 10.0
MOTOR_CONSTANT_NM_PER_A = 0.15  # of the example car


def limit_obeyed_within(dbc: Dbc, within_ms: float, margin_a: float = _MARGIN_A) -> Check:
    """Whenever the pack's current is beyond a limit of the BMS by more than the margin, it is back in time."""
    names = ("PackSensor.PackCurrent", "BmsLimits.DischargeLimit", "BmsLimits.ChargeLimit")

    def inside(values: Mapping[str, Value | None]) -> bool:
        current, discharge, charge = (values[name] for name in names)
        return (isinstance(current, (int, float)) and isinstance(discharge, (int, float))
                and isinstance(charge, (int, float)) and -charge - margin_a <= current <= discharge + margin_a)

    return _obeyed("limit obeyed", dbc, names, inside, within_ms)


def no_torque_above_limit_within(dbc: Dbc, within_ms: float, margin_a: float = _MARGIN_A,
                                 motor_constant_nm_per_a: float = MOTOR_CONSTANT_NM_PER_A,
                                 efficiency: float = 0.9) -> Check:
    """Whenever the commanded phase current needs more DC current than the BMS allows, it is back in time.

    I_dc = I_phase K |omega| / (eta V), with the firmware's assumed motor constant K and efficiency eta.
    """
    names = ("InverterCommand.PhaseCurrent", "InverterStatus.MotorSpeed", "PackSensor.PackVoltage",
             "BmsLimits.DischargeLimit")

    def lawful(values: Mapping[str, Value | None]) -> bool:
        phase, speed, voltage, limit = (values[name] for name in names)
        if not (isinstance(phase, (int, float)) and isinstance(speed, (int, float))
                and isinstance(voltage, (int, float)) and isinstance(limit, (int, float)) and voltage > 0):
            return False
        omega = abs(speed) * math.pi / 30.0
        return phase * motor_constant_nm_per_a * omega / (efficiency * voltage) <= limit + margin_a

    return _obeyed("no torque above limit", dbc, names, lawful, within_ms)


def counted(message: str, at_least: int, during_ms: float) -> Check:
    """So many frames of a message in a time: that a fault of the bus was really there."""
    title = f"{message} seen"

    def judge(trace: Trace, event_ms: float) -> Result:
        count = trace.count(message, event_ms, event_ms + during_ms)
        return Result(title, count >= at_least, count, f"at least {at_least}", f"frames in {during_ms:g} ms")
    return Check(title, (f"{message}.",), during_ms, judge)
