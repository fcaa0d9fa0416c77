# SPDX-License-Identifier: Apache-2.0
"""The form `gateway: {sensor: Pedals.Apps1, offset: 0.5 V}` of a scenario file: a sensor that lies in good frames."""
from __future__ import annotations

from functools import partial
from typing import Any

from .car import Car
from .dbc import Dbc, Signal, Value
from .errors import InputError
from .faults import Fault
from .quantity import TICK_MS, number, ticks
from .sensor_faults import LAST, WAYS, SensorFault, signals_of
from .step import Step
from .yaml_node import YamlNode


def read_sensor(node: YamlNode, car: Car) -> Step:
    fields = node.fields(["sensor", *WAYS, "for"], needed=["sensor"])
    ways = [name for name in fields if name in WAYS]
    if len(ways) != 1:
        raise node.error(f"found {len(ways)} ways to lie, expected one of {', '.join(WAYS)}")
    way, signals = ways[0], tuple(s for n in fields["sensor"].items() for s in n.value(partial(signals_of, car.dbc)))
    fault = SensorFault(signals, way, **_amount(way, fields[way], [car.dbc.signal(s) for s in signals], car.dbc))
    for_ms = fields["for"].value(partial(ticks, least=1)) * float(TICK_MS) if "for" in fields else None
    try:
        fault.check_fits(car.dbc)
        Fault("sensor", fault.ids(car.dbc), sensor=fault)
    except InputError as error:
        raise fields[way].error(str(error)) from None
    ids = fault.ids(car.dbc)
    return Step(f"gateway: sensor {way}", lambda rig: rig.gateway("sensor", ids, for_ms, sensor=fault),
                needs_gateway=True)


def _amount(way: str, node: YamlNode, signals: list[Signal], dbc: Dbc) -> dict[str, Any]:
    if way == "late":
        return {"late_ticks": node.value(partial(ticks, least=1))}
    if way == "swapped_with":
        return {"other": node.value(lambda text: dbc.signal(text).name)}
    units = {s.unit for s in signals}
    if len(units) != 1:
        raise node.error(f"found sensors with the units {', '.join(sorted(units))}, expected one unit")
    if way == "stuck":
        return {"value": node.value(partial(_stuck_at, signals[0]))}
    unit = "" if way == "gain" else signals[0].unit
    return {"amount": node.value(partial(number, unit=unit))}


def _stuck_at(signal: Signal, text: str) -> Value | None:
    """`last`, `invalid`, a state, or a number with the unit of the sensor."""
    if text == LAST:
        return LAST
    if text == "invalid":
        signal.message.encode({signal.short_name: None})
        return None
    low, high = signal.range
    return text if signal.states else number(text, signal.unit, low, high)
