# SPDX-License-Identifier: Apache-2.0
"""What can be hidden in a drive: the keys of the simulator that make it, and what it adds to each channel.

Channels: `voltage` mean cell, `cell` one cell minus the mean, `pack` pack minus cells, `temperature` mean thermistor,
`thermistor` one of them minus the mean [V, K]; `power` [W], `force` [N] of a car. A size is positive; a sign is drawn.
"""

from dataclasses import dataclass
from typing import Callable

import numpy as np

from .battery import GAS, LOW_END, ZERO_C, hysteresis, lagged, transfer_v

ALL_KINDS, PACKS, CARS = ("cell", "pack", "car", "long"), ("pack", "car", "long"), ("car", "long")
GRAVITY = 9.81


@dataclass(frozen=True)
class Effect:
    name: str  # of the cause
    main: str  # its first parameter
    least: float
    most: float  # what happens in practice, of the main parameter
    adds: Callable  # (scene, signed size) -> {channel: values by row}
    keys: Callable  # (scene, signed size) -> key=value of the simulator
    kinds: tuple = ALL_KINDS
    signs: tuple = (1, -1)
    sensor: bool = False  # the truth is as it was: a CSV of the simulator does not show it
    form: str = ""  # which of the forms of a cause
    step: float = 0.0  # that the key is rounded to
    says: Callable | None = None  # (scene, signed size) -> parameters, where they are more than the main one

    def largest(self, scene):
        """A resistance of a cell is as large as the cell's own makes likely."""
        own = scene.car.cell.middle("r0") / 1.2e-3 if self.main == "resistance_ohm" and "cell" in self.kinds else 1.0
        return self.most * own


@dataclass
class Scene:
    """A sound car, its sound drive and what was drawn beside the size."""

    car: object
    truth: object
    member: int = 1  # cell or thermistor, from 1
    tau_s: float = 10.0
    weights: tuple = (1.0, 0.0, 0.0)

    @property
    def drop(self):
        """Volts that all resistances take."""
        return self.car.cell.ocv(self.truth.soc) - self.truth.voltage_v

    @property
    def rise_kelvin(self):
        return self.truth.temperature_c - self.car.cell.reference_c


def cell_keys(name):
    return lambda scene, size: (f"cell.effects.{name}={size:.6g}",)


def series(scene, size):
    return {"voltage": -size * scene.truth.current_a}


def branch(scene, size):
    return {"voltage": -size * lagged(scene.truth.current_a, scene.tau_s, scene.truth.step_s)}


def branch_keys(name):
    return lambda scene, size: (f"cell.effects.{name}_ohm={size:.6g}", f"cell.effects.{name}_tau_s={scene.tau_s:.4g}")


def branch_says(scene, size):
    return {"resistance_ohm": size, "tau_s": scene.tau_s}


def arrhenius(scene, size):
    kelvin = scene.truth.temperature_c + ZERO_C
    factor = np.exp(size / GAS * (1.0 / kelvin - 1.0 / (scene.car.cell.reference_c + ZERO_C)))
    return {"voltage": -(factor - 1.0) * scene.drop}


def exchange(scene, size):
    current, t = scene.truth.current_a, scene.truth.temperature_c
    i0 = scene.car.cell.exchange_a()
    return {"voltage": transfer_v(i0, current, t) - transfer_v(i0 * (1.0 + size), current, t)}


def low_end(scene, size):
    return {"voltage": -size * np.maximum(0.0, 1.0 - scene.truth.soc / LOW_END) * scene.drop}


def direction(scene, size):
    drawn = scene.truth.soc[0] - scene.truth.soc
    begin = -1.0 if scene.truth.soc[0] > 0.98 else 0.0
    return {"voltage": -size * hysteresis(drawn, 20.0, begin)}


def bend(scene, soc):
    """A curve over the charge, RMS 1 over what was driven; a polygon at tenths, as the key takes it."""
    points = np.linspace(0.0, 1.0, 11)
    curve = np.sin(np.pi * points[:, None] * np.arange(1, 4)) @ np.array(scene.weights)
    driven = np.interp(np.linspace(scene.truth.soc.min(), scene.truth.soc.max(), 101), points, curve)
    curve = curve / max(1e-9, np.sqrt(np.mean(driven**2)))
    return np.interp(soc, points, curve)


def curve(scene, size):
    return {"voltage": size * bend(scene, scene.truth.soc)}


def curve_keys(scene, size):
    values = size * bend(scene, np.linspace(0.0, 1.0, 11))
    return ("cell.effects.ocv_change_v=[" + ",".join(f"{v:.6f}" for v in values) + "]",)


def charge(channel):
    def adds(scene, size):
        cell, soc = scene.car.cell, scene.truth.soc
        other = soc[0] - (soc[0] - soc) / (1.0 + size)
        return {channel: cell.ocv(other) - cell.ocv(soc)}

    return adds


def capacity_keys(scene, size):
    key = "cell.capacity_ah" if scene.car.kind == "cell" else "battery.capacity_ah"
    return (f"{key}={scene.car.cell.capacity_ah * (1.0 + size):.6g}",)


def warmth(scene, watts, mass=1.0, cooled=1.0):
    """Kelvin that more heat, by row, has made of a cell of so many times the heat capacity and cooling."""
    cell = scene.car.cell
    return lagged(watts / (cooled * cell.cooling_w_per_k), cell.cooling_s * mass / cooled, scene.truth.step_s)


def entropy(scene, size):
    t = scene.truth
    heat = -t.current_a * (t.temperature_c + ZERO_C) * size
    return {"voltage": size * scene.rise_kelvin, "temperature": warmth(scene, heat)}


def above_air(scene):
    return scene.truth.temperature_c - scene.car.air_c


def cooling(scene, size):
    watts = -size * scene.car.cell.cooling_w_per_k * above_air(scene)
    return {"temperature": warmth(scene, watts, cooled=1.0 + size)}


def cooling_keys(scene, size):
    key = "cell" if scene.car.kind == "cell" else "battery"
    return (f"{key}.convection_w_per_m2_k={scene.car.cell.convection * (1.0 + size):.6g}",)


def mass_of_heat(scene, size):
    rate = np.gradient(scene.truth.temperature_c, scene.truth.step_s)
    return {"temperature": warmth(scene, -size * scene.car.cell.heat_j_per_k * rate, mass=1.0 + size)}


def heat_keys(scene, size):
    return (f"cell.heat_capacity_j_per_kg_k={scene.car.cell.file['heat_capacity_j_per_kg_k'] * (1.0 + size):.6g}",)


def air(scene, size):
    return {"temperature": warmth(scene, np.full(len(scene.truth), size * scene.car.cell.cooling_w_per_k))}


def lag_of(channel):
    def adds(scene, size):
        t = scene.truth.temperature_c
        return {channel: lagged(t - t[0], size, scene.truth.step_s) - (t - t[0])}

    return adds


def constant(channel):
    return lambda scene, size: {channel: np.full(len(scene.truth), size)}


def leak(scene, size):
    t = scene.truth
    lost = size * t.step_s * np.arange(len(t)) / 3600.0 / (scene.car.cell.capacity_ah * scene.car.parallel)
    return {"cell": scene.car.cell.ocv(t.soc - lost) - scene.car.cell.ocv(t.soc)}


def weak(scene, size):
    return {"cell": -size * scene.drop}


def contact(scene, size):
    return {"pack": -size * scene.truth.current_a * scene.car.parallel}


def reading(change):
    """A current sensor's error: what the model makes of it, and of the car's power."""

    def adds(scene, size):
        t, car = scene.truth, scene.car
        error = change(t.current_a * car.parallel, size, t.step_s)
        cell = error / car.parallel
        drawn = car.cell.drawn(cell, t.step_s)
        out = {"voltage": car.cell.answer(cell, t.step_s) + car.cell.ocv_slope(t.soc) * drawn}
        if car.has_car:  # a pack file foresees none
            out["power"] = error * car.series * t.voltage_v
        return out

    return adds


def late(values, delay_s, step_s):
    row = np.arange(len(values))
    return np.interp(row - delay_s / step_s, row, values)


def delayed(channel, scale):
    def adds(scene, size):
        v = scene.truth.voltage_v
        return {channel: scale(scene) * (late(v, size, scene.truth.step_s) - v)}

    return adds


def scaled(channel, scale):
    return lambda scene, size: {channel: size * scale(scene) * scene.truth.voltage_v}


def one(scene):
    return 1.0


def all_cells(scene):
    return float(scene.car.series)


def sensor_keys(which, key, form="{:.6g}", base=0.0):
    return lambda scene, size: (f"sensors.{which.format(n=scene.member)}.{key}={form.format(base + size)}",)


def wheels(force):
    """A force [N] more that the car asks for: the pull that the pedal gives speeds it up less."""
    return lambda scene, size: {"force": force(scene, size)}


def pull(scene):
    """Force of the motor at the wheels [N], by the phase current."""
    return scene.truth.torque_a * 0.15 * (32 / 12) / 0.22225


def electric(share):
    return lambda scene, size: {"power": share(scene, size)}


def motor_power(scene):
    return pull(scene) * scene.truth.speed_mps * (1.0 + scene.car.loss)
