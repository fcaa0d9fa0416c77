# SPDX-License-Identifier: Apache-2.0
"""Sentences about signals: `PackSensor.PackCurrent > 9 A and BmsStatus.Faults has MasterLost`.

A clause is SIGNAL OP VALUE with OP one of = != < <= > >=, or SIGNAL has BIT, or SIGNAL lacks BIT; clauses are joined by
`and`. A number carries the unit of its signal. A signal that was not heard or says "no measurement" fulfils nothing.
"""
from __future__ import annotations

import operator
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from .dbc import LOCKSTEP_FILE, Dbc, Signal, Value
from .errors import InputError, did_you_mean
from .quantity import number, with_unit

_CLAUSE = re.compile(r"([\w.]+)\s*(!=|<=|>=|=|<|>|\bhas\b|\blacks\b)\s*(\S.*)", re.DOTALL)
_COMPARE: dict[str, Callable[[float, float], bool]] = {
    "=": operator.eq, "!=": operator.ne, "<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge}


@dataclass(frozen=True)
class Clause:
    signal: Signal
    operation: str
    operand: float | str  # of has and lacks: the mask of the bit

    def holds(self, value: Value | None) -> bool:
        if value is None:
            return False
        if isinstance(self.operand, str) or isinstance(value, str):
            return (value == self.operand) == (self.operation == "=")
        if self.operation in ("has", "lacks"):
            return bool(int(value) & int(self.operand)) == (self.operation == "has")
        return _COMPARE[self.operation](value, self.operand)


@dataclass(frozen=True)
class Condition:
    text: str
    clauses: tuple[Clause, ...]

    @classmethod
    def parse(cls, text: object, dbc: Dbc) -> Condition:
        return cls(" ".join(str(text).split()), tuple(_clause(part, dbc) for part in re.split(r"\band\b", str(text))))

    @property
    def signals(self) -> list[Signal]:
        return [clause.signal for clause in self.clauses]

    def holds(self, values: Mapping[str, Value | None]) -> bool:
        return all(clause.holds(values.get(clause.signal.name)) for clause in self.clauses)


def _clause(text: str, dbc: Dbc) -> Clause:
    match = _CLAUSE.fullmatch(text.strip())
    if match is None:
        raise InputError(f"found {text.strip()!r}, expected a condition such as 'BmsStatus.State = Fault', "
                         "'PackSensor.PackCurrent > 100 A' or 'BmsStatus.Faults has MasterLost'")
    signal, operation, operand = dbc.signal(match[1]), match[2], match[3]
    if signal.message.file == LOCKSTEP_FILE:
        raise InputError(f"{signal.name} is of the frames that keep the nodes in step; expected a signal of the car")
    if operation in ("has", "lacks"):
        return Clause(signal, operation, float(1 << signal.bit(operand)))
    if signal.states:
        if operation not in ("=", "!=") or operand not in signal.states.values():
            near = did_you_mean(operand, signal.states.values())
            raise InputError(f"{signal.name} cannot be {operation} {operand!r}.{near} "
                             f"Expected = or != and one of {', '.join(signal.states.values())}")
        return Clause(signal, operation, operand)
    try:
        return Clause(signal, operation, _comparable(signal, operation, operand))
    except InputError as error:
        raise InputError(f"{signal.name}: {error}") from None


def _comparable(signal: Signal, operation: str, operand: str) -> float:
    """A number that the signal can be compared with: the answer may be yes or no."""
    low, high = signal.range
    value = number(operand, signal.unit, low, high)
    if (operation, value) in ((">", high), ("<", low)):
        raise InputError(f"found {operation} {operand!r}, which never holds; it goes from {with_unit(low, signal.unit)}"
                         f" to {with_unit(high, signal.unit)}")
    steps = (value - signal.offset) / signal.scale
    if operation in ("=", "!=") and abs(steps - round(steps)) > 1e-6 * max(1.0, abs(steps)):
        step = with_unit(signal.scale, signal.unit)
        raise InputError(f"found {operation} {operand!r}, expected a multiple of {step}, in which it is sent")
    return value
