# SPDX-License-Identifier: Apache-2.0
"""The steps of a scenario file: one reader a verb, in the table at the end. Faults of the bus: scenario_faults."""
from __future__ import annotations

import re
from collections.abc import Callable
from functools import partial

import yaml

from .car import Car
from .condition import Condition
from .dbc import LOCKSTEP_FILE
from .errors import InputError
from .nodes import ECUS
from .quantity import TICK_MS, duration_ms, number, ticks, whole
from .rig import DISTANCE_NEEDS, STAGES, START_UP_NEEDS, SWITCHES
from .scenario_faults import read_gateway, read_signals
from .step import Step
from .yaml_node import YamlNode


def read_step(node: YamlNode, car: Car) -> Step:
    verb, value = node.single(list(_READERS))
    return _READERS[verb](value, car)


def _start_up(node: YamlNode, _: Car) -> Step:
    stage = node.one_of(list(STAGES))
    return Step(f"start up to {stage}", lambda rig: rig.start_up(stage), START_UP_NEEDS, automatic=stage == "automatic")


_SWITCH_STATES = {"released": "Off", "pressed": "On", "open": "Off", "closed": "On", "automatic": "Automatic"}


def _driver(node: YamlNode, _: Car) -> Step:
    if isinstance(node.raw, yaml.ScalarNode):
        node.one_of(["automatic"])
        return Step("driver: automatic", lambda rig: rig.automatic(), automatic=True)
    pedals: dict[str, float] = {}
    switches: dict[str, str] = {}
    known = ["accelerator", "brake", *SWITCHES]
    for name, value in node.fields(known).items():
        if name in SWITCHES:
            words = ["closed", "open"] if name == "shutdown" else ["pressed", "released"]
            switches[name] = _SWITCH_STATES[value.one_of([*words, "automatic"])]
        else:
            pedals[name] = value.value(partial(number, unit="%", low=0.0, high=100.0))
    if not pedals and not switches:
        raise node.error(f"found nothing to do, expected one or more of {', '.join(known)}")
    return Step("driver", lambda rig: rig.driver(**pedals, **switches))  # type: ignore[arg-type]


# Unit of a fault's value, and how many of its codes one unit is; factors stay above nothing.
_FAULT_VALUES = {"CellOffset": ("mV", 1), "Apps1Offset": ("mV", 1), "ThermistorOffset": ("degC", 10),
                 "CellResistanceScale": ("", 100), "CellGain": ("", 1000), "CurrentOffset": ("A", 100),
                 "DcLinkStuck": ("V", 10),
                 "AirPlusSlow": ("ms", 1), "AirMinusSlow": ("ms", 1), "PrechargeSlow": ("ms", 1),
                 "AirPlusChatters": ("ms", 1), "AirMinusChatters": ("ms", 1), "InverterFollows": ("%", 1)}
_ABOVE_NOTHING = ("CellResistanceScale", "CellGain", "AirPlusChatters", "AirMinusChatters")
_NOT_NEGATIVE = ("AirPlusSlow", "AirMinusSlow", "PrechargeSlow", "InverterFollows")
_INDEXED = ("CellLost", "CellFrozen", "CellGain", "CellOffset", "CellResistanceScale", "ThermistorLost",
            "ThermistorOffset", "BrakeLost")
_BRAKE_SENSORS = 2


def _plant(node: YamlNode, car: Car) -> Step:
    found = node.fields(["fault", "index", "value"], needed=["fault"])
    fault = found["fault"].one_of(list(car.dbc.signal("PlantFault.Fault").states.values()))
    index = _index_of(fault, found["index"], car) if "index" in found else 0
    value = 0
    if fault in _FAULT_VALUES:
        unit, codes = _FAULT_VALUES[fault]
        if "value" not in found:
            raise node.error(f"'value' is missing: {fault} needs one, with unit {unit or 'none'}")
        low, high = (limit / codes for limit in car.dbc.signal("PlantFault.Value").range)
        low = 1.0 / codes if fault in _ABOVE_NOTHING else 0.0 if fault in _NOT_NEGATIVE else low
        value = round(found["value"].value(partial(number, unit=unit, low=low, high=high)) * codes)
    elif "value" in found:
        raise found["value"].error(f"{fault} has no value")
    return Step(f"plant: {fault}", lambda rig: rig.plant(fault, index, value))


def _index_of(fault: str, node: YamlNode, car: Car) -> int:
    """A part that the car has; the plant would pass over a fault of any other."""
    if fault not in _INDEXED:
        raise node.error(f"{fault} has no index")
    parts = _BRAKE_SENSORS if fault == "BrakeLost" else car.cells if fault.startswith("Cell") else car.thermistors
    return int(node.value(partial(whole, low=0, high=parts - 1)))


def _send(node: YamlNode, car: Car) -> Step:
    found = node.fields(["message", "signals"], needed=["message", "signals"])
    message = found["message"].one_of([m.name for m in car.dbc.messages.values() if m.file != LOCKSTEP_FILE])
    values = read_signals(found["signals"], [car.dbc.message(message)])
    return Step(f"send {message}", lambda rig: rig.send(message, **values), (f"{message}.",))


def _clear(node: YamlNode, _: Car) -> Step:
    what = node.one_of(["gateway", "plant"])
    if what == "gateway":
        return Step("clear the gateway", lambda rig: rig.clear_gateway(), needs_gateway=True)
    return Step("clear the plant's faults", lambda rig: rig.plant("ClearAll"))


def _kill(node: YamlNode, _: Car) -> Step:
    name = node.one_of(list(ECUS))
    return Step(f"kill {name}", lambda rig: rig.kill(name), kills=name)


_LONGEST_OFF_MS = 60_000.0  # what a supply may fail for in OffMs of MemberReset


def _reset(node: YamlNode, _: Car) -> Step:
    """`reset: bms`, or `reset: {node: bms, off: 200 ms}`."""
    fields = {} if isinstance(node.raw, yaml.ScalarNode) else node.fields(["node", "off"], needed=["node"])
    name = fields.get("node", node).one_of(list(ECUS))
    off_ms = fields["off"].value(partial(ticks, least=1)) * TICK_MS if "off" in fields else TICK_MS
    if off_ms > _LONGEST_OFF_MS:
        raise fields["off"].error(f"found {off_ms} ms, expected at most {_LONGEST_OFF_MS:g} ms")
    return Step(f"reset {name}", lambda rig: rig.reset(name, f"{off_ms} ms"), needs_process=True)


_LAP = re.compile(r"\s*lap ([1-9][0-9]{0,3})(?:\s*\+\s*(.*))?")
_FARTHEST_M = 1e6


def _distance_m(text: object, car: Car) -> float:
    """`300 m` since the start, `lap 3` where the third lap begins, or `lap 3 + 300 m`."""
    lap = _LAP.fullmatch(str(text))
    if lap is None:
        if "lap" in str(text):
            raise InputError(f"found {str(text)!r}, expected a distance such as '300 m', 'lap 3' or 'lap 3 + 300 m'")
        return number(text, "m", 0.0, _FARTHEST_M)
    if not car.lap_m:
        raise InputError(f"found {str(text)!r}, but how long a lap is the program says, which is not built yet")
    return (int(lap[1]) - 1) * car.lap_m + (number(lap[2], "m", 0.0, _FARTHEST_M) if lap[2] else 0.0)


def _drive(node: YamlNode, car: Car) -> Step:
    """Until the front wheels have rolled so far since the start."""
    found = node.fields(["to", "within"], needed=["to", "within"])
    to_m = found["to"].value(partial(_distance_m, car=car))
    within = found["within"].text()
    found["within"].value(partial(duration_ms, least_ms=TICK_MS))
    return Step(f"drive to {to_m:g} m", lambda rig: rig.drive(to_m, within), DISTANCE_NEEDS)


def _run(node: YamlNode, _: Car) -> Step:
    duration = node.text()
    node.value(partial(ticks, least=1))
    return Step(f"run {duration}", lambda rig: rig.run(duration))


def _wait(node: YamlNode, car: Car) -> Step:
    found = node.fields(["for", "within"], needed=["for", "within"])
    condition = found["for"].value(partial(Condition.parse, dbc=car.dbc))
    within = found["within"].text()
    found["within"].value(partial(duration_ms, least_ms=TICK_MS))
    return Step(f"wait for {condition.text}", lambda rig: _ignore(rig.wait(condition, within)),
                tuple(s.name for s in condition.signals))


def _ignore(_: object) -> None:
    return None


_READERS: dict[str, Callable[[YamlNode, Car], Step]] = {
    "start_up": _start_up, "driver": _driver, "plant": _plant, "gateway": read_gateway, "send": _send, "clear": _clear,
    "kill": _kill, "reset": _reset, "run": _run, "drive": _drive, "wait": _wait}
