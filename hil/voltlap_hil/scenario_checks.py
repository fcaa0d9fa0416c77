# SPDX-License-Identifier: Apache-2.0
"""The checks of a scenario file: one reader a name, in the table at the end."""
from __future__ import annotations

from collections.abc import Callable
from functools import partial

import yaml

from . import checks, requirements
from .car import Car
from .condition import Condition
from .dbc import LOCKSTEP_FILE, Dbc
from .quantity import TICK_MS, duration_ms, whole
from .yaml_node import YamlNode

_SIMPLE = {"torque_zero_within": checks.torque_zero_within, "contactors_open_within": checks.contactors_open_within,
           "contactors_commanded_open_within": checks.contactors_commanded_open_within,
           "limit_obeyed_within": checks.limit_obeyed_within,
           "no_torque_above_limit_within": checks.no_torque_above_limit_within}


def read_check(node: YamlNode, car: Car) -> checks.Check:
    dbc = car.dbc
    name, value = node.single([*_SIMPLE, *_READERS])
    if name in _SIMPLE:
        return _simple(name, value, car)
    return _READERS[name](value, dbc)


def bound_of(text: str) -> float:
    """A time, the bound of a requirement by its id, or the sum of such: `MST-001 + 20 ms`."""
    parts = [part.strip() for part in text.split("+")]
    return sum(requirements.bound_ms(part) if requirements.ID.fullmatch(part) else duration_ms(part) for part in parts)


def _lasting(text: str) -> float:
    return duration_ms(text, TICK_MS)


def _condition(node: YamlNode, dbc: Dbc) -> Condition:
    return node.value(lambda text: Condition.parse(text, dbc))  # type: ignore[no-any-return]


def _starting(check: checks.Check, fields: dict[str, YamlNode], dbc: Dbc) -> checks.Check:
    return check.starting_at(_condition(fields["after"], dbc)) if "after" in fields else check


def _simple(name: str, node: YamlNode, car: Car) -> checks.Check:
    """`name: 100 ms`, or `name: {within: 100 ms, after: CONDITION}`."""
    if not isinstance(node.raw, yaml.MappingNode):
        return _make(name, node.value(bound_of), car)
    fields = node.fields(["within", "after"], needed=["within"])
    return _starting(_make(name, fields["within"].value(bound_of), car), fields, car.dbc)


def _make(name: str, within_ms: float, car: Car) -> checks.Check:
    if name != "no_torque_above_limit_within" or not car.arguments:
        return _SIMPLE[name](car.dbc, within_ms)
    # How well another car's drive does is not known here; without loss it takes the least.
    constant = car.keys.get("master.motor_constant_nm_per_a", checks.MOTOR_CONSTANT_NM_PER_A)
    return checks.no_torque_above_limit_within(car.dbc, within_ms, motor_constant_nm_per_a=constant, efficiency=1.0)


def _reached(node: YamlNode, dbc: Dbc) -> checks.Check:
    fields = node.fields(["condition", "within", "not_before", "after"], needed=["condition", "within"])
    within = fields["within"].value(bound_of)
    earliest = fields["not_before"].value(duration_ms) if "not_before" in fields else 0.0
    if earliest > within:
        raise fields["not_before"].error(f"found {earliest:g} ms, expected no more than 'within', {within:g} ms")
    check = checks.reached(_condition(fields["condition"], dbc), within, earliest)
    return _starting(check, fields, dbc)


def _settled(node: YamlNode, dbc: Dbc) -> checks.Check:
    fields = node.fields(["condition", "within", "after"], needed=["condition", "within"])
    condition = _condition(fields["condition"], dbc)
    check = checks.settled(f"for good {condition.text}", condition, fields["within"].value(bound_of))
    return _starting(check, fields, dbc)


def _stays(node: YamlNode, dbc: Dbc) -> checks.Check:
    fields = node.fields(["condition", "from", "for", "after"], needed=["condition", "for"])
    begin = fields["from"].value(duration_ms) if "from" in fields else 0.0
    check = checks.stays(_condition(fields["condition"], dbc), fields["for"].value(_lasting), begin)
    return _starting(check, fields, dbc)


def _counted(node: YamlNode, dbc: Dbc) -> checks.Check:
    fields = node.fields(["message", "at_least", "during"], needed=["message", "at_least", "during"])
    return checks.counted(fields["message"].one_of([m.name for m in dbc.messages.values() if m.file != LOCKSTEP_FILE]),
                          fields["at_least"].value(partial(whole, low=1, high=1_000_000)),
                          fields["during"].value(_lasting))


_READERS: dict[str, Callable[[YamlNode, Dbc], checks.Check]] = {
    "reached": _reached, "settled": _settled, "stays": _stays, "counted": _counted}
