# SPDX-License-Identifier: Apache-2.0
"""Numbers of the car that is driven, by name: `{full_current}` in the table of faults is another one for each car."""
from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from pathlib import Path

from .car import Car
from .errors import InputError, did_you_mean

_TENS = ("cell_to_limit", "cell_below_trip")
_NAME = re.compile(r"\{([a-z][a-z_0-9]*)\}")
# Of the example car: what the numbers are worked out from where the program, which knows them, is not built.
_EXAMPLE = {"inverter.current_max_a": 550.0, "master.phase_current_max_a": 550.0, "battery.cells_in_series": 24.0,
            "bms.cell_voltage_max_v": 4.2, "bms.cell_voltage_min_v": 2.5, "bms.cell_voltage_trip_low_v": 2.4,
            "bms.cell_voltage_trip_high_v": 4.25, "bms.discharge_current_trip_a": 720.0,
            "master.motor_constant_nm_per_a": 0.15}
_OPEN_CIRCUIT_V, _RESISTANCE_OHM = 4.17, 0.0024
_CURRENT_MOST_A, _SPEED_MOST_RPM = 1000.0, 12_000.0  # that the frames carry
_FAST_CELLS, _FAST_MS, _SLOW_MS, _TICK_MS = 48, 30.0, 100.0, 10.0


def _phase_current(keys: Mapping[str, float]) -> float:
    """Of all motors."""
    return min(keys.get("powertrain.motors", 1.0) * keys["inverter.current_max_a"], keys["master.phase_current_max_a"])


def _cell_to_limit(keys: Mapping[str, float]) -> float:
    """Half way between the cell voltage that the limit keeps and the one that trips, from where the cell is."""
    aim = (keys["bms.cell_voltage_min_v"] + keys["bms.cell_voltage_trip_low_v"]) / 2
    return -1000 * (keys["open_circuit_v"] - aim)


QUANTITIES: dict[str, Callable[[Mapping[str, float]], float]] = {
    # A, of a phase: at full pedal the car comes so far / at half of it / a pedal is still obeyed
    "full_current": lambda keys: _phase_current(keys) * 8 / 11,
    "half_current": lambda keys: _phase_current(keys) * 5 / 11,
    "driving_current": lambda keys: _phase_current(keys) * 2 / 11,
    # Nm, of an inverter that reports its torque, as the two above
    "full_torque": lambda keys: _phase_current(keys) * keys["master.motor_constant_nm_per_a"] * 8 / 11,
    "driving_torque": lambda keys: _phase_current(keys) * keys["master.motor_constant_nm_per_a"] * 2 / 11,
    # A, of the pack: more than the BMS lets pass
    "current_beyond_trip": lambda keys: min(_CURRENT_MOST_A, keys["bms.discharge_current_trip_a"] * 1.25),
    # A of the pack and rpm: above the one, below the other its current is held against the inverter's power (BMS-067)
    "power_judged": lambda keys: 8000.0 / (keys["battery.cells_in_series"] * keys["open_circuit_v"]),
    "speed_judged": lambda keys: min(_SPEED_MOST_RPM, 0.6 * keys["battery.cells_in_series"] * keys["open_circuit_v"]
                                     / keys["master.motor_constant_nm_per_a"] * 60 / math.tau),
    # A of the pack: explains 5 mV and 20 mV of a cell (BMS-060, BMS-066, BMS-069)
    "current_5mv": lambda keys: math.ceil(0.005 / keys["resistance_ohm"]),
    "current_20mv": lambda keys: math.ceil(0.020 / keys["resistance_ohm"]),
    # V: what a charged DC link has; a cell's worth and a tenth
    "dc_link_charged": lambda keys: keys["battery.cells_in_series"] * keys["bms.cell_voltage_max_v"] / 1.05,
    # ms: how much later than the example car's a cell has been read twice anew, by the cycle of the frames
    "cells_later": lambda keys: 0.0 if keys["battery.cells_in_series"] <= _FAST_CELLS else 2 * (_SLOW_MS - _FAST_MS),
    # ms: and how much later a second sender of it is told (BMS-004: 100 ms, 200 ms of messages of 100 ms)
    "cells_foreign": lambda keys: 0.0 if keys["battery.cells_in_series"] <= _FAST_CELLS else 100.0 + _TICK_MS,
    # mV, to be added to what a cell at rest reads
    "cell_to_limit": _cell_to_limit,
    "cell_below_trip": lambda keys: -1000 * (keys["open_circuit_v"] - keys["bms.cell_voltage_trip_low_v"] + 0.23),
}


def full_phase_current_a(car: Car) -> float:
    """What a full pedal asks for."""
    return _phase_current({**_EXAMPLE, **car.keys})


def filled(text: str, car: Car, path: Path) -> str:
    """The text of a file with a number for each `{name}`, rounded as a person would write it."""
    keys: dict[str, float] = {}

    def number(match: re.Match[str]) -> str:
        if match[1] not in QUANTITIES:
            line = text.count("\n", 0, match.start()) + 1
            raise InputError(f"{path}:{line}: no quantity of the car {match[0]}.{did_you_mean(match[1], QUANTITIES)} "
                             f"There are: {', '.join(QUANTITIES)}")
        if not keys:
            keys.update({**_EXAMPLE, **car.keys, "open_circuit_v": car.open_circuit_v or _OPEN_CIRCUIT_V,
                         "resistance_ohm": car.resistance_ohm or _RESISTANCE_OHM})
        value = QUANTITIES[match[1]](keys)
        return f"{round(value, -1):.0f}" if match[1] in _TENS else f"{value:.0f}"

    return _NAME.sub(number, text)
