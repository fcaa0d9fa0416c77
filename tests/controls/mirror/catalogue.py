# SPDX-License-Identifier: Apache-2.0
"""The effects of the mirror, one row each; sizes are those that happen in practice.

Not hidden: `cooling_at_stop`, `neighbour_heat`, `reported_voltage_compensation`, `brake_fade`, `regen_split`,
`field_weakening`, `motor_temperature`, `grade`, which no key of the simulator makes; `wind`, which turns along a closed
course; `grip` and `tyre_slip`, whose signature stands nowhere here yet; `initial_soc`, since a start is never a finding
unless it was recorded; the findings of the gate.
"""

import numpy as np

from . import effects as e
from .effects import CARS, PACKS, Effect


def channel(name):
    return lambda scene, size: {"channel": name.format(n=scene.member)}


def with_channel(main, name):
    return lambda scene, size: {main: size, "channel": name.format(n=scene.member)}


def of_cell(main):
    return lambda scene, size: {main: size, "cell": scene.member}


def limit(scene, size):
    return (1.0 - size) * float(np.max(scene.truth.current_a)) * scene.car.parallel


def clipped(current, size, step_s):
    return np.minimum(current, (1.0 - size) * current.max()) - current


CELL = (
    Effect("series_resistance", "resistance_ohm", 1e-6, 3e-3, e.series, e.cell_keys("series_ohm"), signs=(1,)),
    Effect("polarization_resistance", "resistance_ohm", 1e-6, 3e-3, e.branch, e.branch_keys("polarization"), signs=(1,),
           says=e.branch_says),
    Effect("slow_relaxation", "resistance_ohm", 1e-6, 3e-3, e.branch, e.branch_keys("slow_relaxation"), signs=(1,),
           says=e.branch_says),
    Effect("resistance_temperature", "activation_energy_j_per_mol", 100.0, 35000.0, e.arrhenius,
           e.cell_keys("activation_energy_j_per_mol"), signs=(1,)),
    Effect("resistance_current", "exchange_current_change", 0.01, 0.8, e.exchange,
           e.cell_keys("exchange_current_change")),
    Effect("resistance_soc", "low_end_change", 0.002, 4.0, e.low_end, e.cell_keys("low_end_change"), signs=(1,)),
    Effect("hysteresis", "amplitude_v", 5e-4, 0.05, e.direction, e.cell_keys("hysteresis_v"), signs=(1,)),
    Effect("ocv_shape", "rms_v", 2e-4, 0.03, e.curve, e.curve_keys, signs=(1,)),
    Effect("capacity", "change", 0.002, 0.25, e.charge("voltage"), e.capacity_keys),
    Effect("entropic_heat", "entropy_v_per_k", 1e-5, 1e-3, e.entropy, e.cell_keys("entropy_v_per_k")),
    Effect("cooling", "change", 0.02, 4.0, e.cooling, e.cooling_keys, kinds=PACKS, signs=(1,)),
    Effect("heat_capacity", "change", 0.01, 0.6, e.mass_of_heat, e.heat_keys),
    Effect("thermistor_lag", "delay_s", 1.0, 90.0, e.lag_of("temperature"), e.sensor_keys("thermistors", "lag_s"),
           kinds=PACKS, signs=(1,), sensor=True, form="all"),
)
PACK = (
    Effect("ambient", "temperature_k", 0.3, 20.0, e.air,
           lambda s, size: (f"environment.ambient_c={s.car.air_c + size:.4g}",), kinds=CARS),
    Effect("self_discharge", "current_a", 0.01, 5.0, e.leak,
           lambda s, size: (f"battery.cells.{s.member}.leak_a={size:.6g}",), kinds=PACKS, signs=(1,),
           says=of_cell("current_a")),
    Effect("weak_cell", "resistance_change", 0.005, 1.5, e.weak,
           lambda s, size: (f"battery.cells.{s.member}.resistance_scale={1 + size:.6g}",), kinds=PACKS, signs=(1,),
           form="resistance", says=of_cell("resistance_change")),
    Effect("weak_cell", "capacity_change", 0.002, 0.4, e.charge("cell"),
           lambda s, size: (f"battery.cells.{s.member}.capacity_scale={1 + size:.6g}",), kinds=PACKS, signs=(-1,),
           form="capacity", says=of_cell("capacity_change")),
    Effect("contact_resistance", "resistance_ohm", 2e-5, 0.03, e.contact,
           lambda s, size: (f"battery.contact_resistance_ohm={size:.6g}",), kinds=PACKS, signs=(1,)),
)
SENSORS = (
    Effect("current_gain", "change", 0.001, 0.08, e.reading(lambda i, s, dt: s * i),
           e.sensor_keys("pack_current", "gain", base=1.0), kinds=PACKS, sensor=True),
    Effect("current_offset", "current_a", 0.05, 6.0, e.reading(lambda i, s, dt: np.full(len(i), s)),
           e.sensor_keys("pack_current", "offset_a"), kinds=PACKS, sensor=True),
    Effect("current_saturation", "limit_a", 0.02, 0.6, e.reading(clipped),
           lambda s, size: (f"sensors.pack_current.max_a={limit(s, size):.6g}",), kinds=PACKS, signs=(1,), sensor=True,
           says=lambda s, size: {"limit_a": limit(s, size)}),
    Effect("time_skew", "delay_s", 0.01, 0.4, e.reading(lambda i, s, dt: e.late(i, s, dt) - i),
           e.sensor_keys("pack_current", "delay_s", "{:.2f}"), kinds=PACKS, signs=(1,), sensor=True, form="current",
           step=0.01, says=with_channel("delay_s", "current")),
    Effect("time_skew", "delay_s", 0.01, 0.4, e.delayed("pack", e.all_cells),
           e.sensor_keys("pack_voltage", "delay_s", "{:.2f}"), kinds=PACKS, signs=(1,), sensor=True, form="pack",
           step=0.01, says=with_channel("delay_s", "pack_voltage")),
    Effect("voltage_gain", "change", 1e-4, 0.03, e.scaled("pack", e.all_cells),
           e.sensor_keys("pack_voltage", "gain", base=1.0), kinds=PACKS, sensor=True, form="pack",
           says=with_channel("change", "pack_voltage")),
    Effect("voltage_offset", "voltage_v", 5e-3, 3.0, e.constant("pack"), e.sensor_keys("pack_voltage", "offset_v"),
           kinds=PACKS, sensor=True, form="pack", says=with_channel("voltage_v", "pack_voltage")),
    Effect("voltage_offset", "voltage_v", 5e-4, 0.06, e.constant("cell"), e.sensor_keys("cells.{n}", "offset_v"),
           kinds=PACKS, sensor=True, form="one cell", says=with_channel("voltage_v", "cell_voltage_{n}")),
    Effect("thermistor_offset", "temperature_k", 0.05, 10.0, e.constant("thermistor"),
           e.sensor_keys("thermistors.{n}", "offset_c"), kinds=PACKS, sensor=True,
           says=with_channel("temperature_k", "temperature_{n}")),
    Effect("thermistor_lag", "delay_s", 1.0, 240.0, e.lag_of("thermistor"), e.sensor_keys("thermistors.{n}", "lag_s"),
           kinds=PACKS, signs=(1,), sensor=True, form="one", says=with_channel("delay_s", "temperature_{n}")),
)


def masses(scene, size):
    return size * scene.car.masses_kg * scene.truth.acceleration


def drag(scene, size):
    return size * 0.5 * 1.225 * 3.1 * 0.12 * scene.truth.speed_mps**2


def rolling(scene, size):
    return np.full(len(scene.truth), size * 0.01 * scene.car.masses_kg * e.GRAVITY)


CAR = (
    Effect("auxiliary_load", "power_w", 5.0, 500.0, e.electric(lambda s, x: np.full(len(s.truth), x)),
           lambda s, x: (f"low_voltage.power_w={670 + x:.6g}",), kinds=CARS),
    Effect("inverter_efficiency", "change", 0.02, 3.0, e.electric(lambda s, x: x * s.car.loss * e.motor_power(s)),
           lambda s, x: (f"inverter.efficiency={1 / (1 + (1 + x) * s.car.loss):.6g}",), kinds=CARS, signs=(1,)),
    Effect("motor_constant", "change", 0.002, 0.1, lambda s, x: {"force": x * e.pull(s), "power": x * e.motor_power(s)},
           lambda s, x: (f"motor.constant_nm_per_a={0.15 * (1 + x):.6g}", "master.motor_constant_nm_per_a=0.15"),
           kinds=CARS),
    Effect("mass", "change", 0.002, 0.3, e.wheels(masses),
           lambda s, x: (f"vehicle.mass_kg={s.car.masses_kg * (1 + x) - 72:.6g}",), kinds=CARS),
    Effect("drag_area", "change", 0.01, 0.8, e.wheels(drag),
           lambda s, x: (f"aero.drag_coefficient={3.1 * (1 + x):.6g}",), kinds=CARS),
    Effect("rolling_resistance", "change", 0.02, 3.0, e.wheels(rolling),
           lambda s, x: (f"tyres.rolling_resistance={0.01 * (1 + x):.6g}",), kinds=CARS, signs=(1,)),
    Effect("tyre_radius", "change", 0.002, 0.1, lambda s, x: {"force": -x * e.pull(s)},
           lambda s, x: (f"tyres.radius_m={0.22225 * (1 + x):.6g}",), kinds=CARS),
)
ALL = (*CELL, *PACK, *SENSORS, *CAR)
NAMES = tuple(sorted({effect.name for effect in ALL}))
TAU_S = {"polarization_resistance": (2.0, 60.0), "slow_relaxation": (150.0, 1500.0)}


def able(kind, candump, names=None):
    """The effects that a log of this kind can hold."""
    return [x for x in ALL if kind in x.kinds and (candump or not x.sensor) and (not names or x.name in names)]


def parameters_of(effect, scene, size):
    """What a report should give; the number that is scored comes first."""
    return effect.says(scene, size) if effect.says else {effect.main: size}
