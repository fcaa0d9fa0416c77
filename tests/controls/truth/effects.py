# SPDX-License-Identifier: Apache-2.0
"""The effects that can be hidden in a truth, one row each: what it does, in which logs it shows, how large it may be.

`main` is the parameter that sets the size; its value grows from the smallest detectable one to `high`, the largest that
happens in practice. `fixed` draws the other parameters once. `change` puts values (cases,) into a world or a situation.
The names of effects and parameters are those that a report must use; signs as there: a sensor's error is positive when
it reads too much, a delay when it is late, a change is true over assumed minus 1.
"""
import dataclasses
from collections.abc import Callable

import numpy as np

from . import cell, drive

BATTERY = ("cell", "pack", "car")
PACKS = ("pack", "car")
CAR = ("car",)


@dataclasses.dataclass(frozen=True)
class Effect:
    name: str
    kinds: tuple
    main: str
    high: float  # magnitude
    signs: tuple  # +1, -1 or both
    change: Callable  # (world, situation, value (cases,), fixed {name: (cases,)})
    fixed: Callable = lambda rng, world: {}  # {name: (cases,)}
    least: Callable = lambda world: 0.0  # smallest magnitude that is something wrong
    relative_to_ohm: bool = False  # `high` is in units of one cell's resistance, 0.09 V / capacity [Ah]


def column(value):
    return np.asarray(value, float)[:, None]


def cells(name, how):
    """Changes one array of the cells: how(old, value column) -> new."""
    def change(world, _, value, fixed):
        setattr(world.cells, name, how(getattr(world.cells, name), column(value)))
    return change


def add(old, value):
    return old + value


def scale(old, value):
    return old * (1.0 + value)


def of_car(name, how):
    def change(world, _, value, fixed):
        setattr(world.car, name, how(np.asarray(getattr(world.car, name), float), column(value)))
    return change


def instrument(table, name=None):
    """Puts the value into a table of the instruments, for one channel of all cases."""
    def change(world, _, value, fixed):
        getattr(world.instruments, table)[name] = value
    return change


def at_channel(table):
    """As instrument(), for the channel that was drawn for each case: other channels get nothing."""
    def change(world, _, value, fixed):
        for name in np.unique(fixed["channel"]):
            getattr(world.instruments, table)[str(name)] = np.where(fixed["channel"] == name, value, 0.0)
    return change


def one_of(names):
    return lambda rng, world: {"channel": rng.choice(names(world), world.shape[0])}


def cell_channels(world):
    return [f"cell_voltage_{k + 1}" for k in range(world.shape[1])]


def thermistors(world):
    if world.kind == "cell":
        return ["temperature"]
    return [f"temperature_{k + 1}" for k in range((world.shape[1] + 1) // 2)]


def one_cell(rng, world):
    return {"cell": rng.integers(1, world.shape[1] + 1, world.shape[0])}


def mask(world, fixed):
    out = np.zeros(world.shape)
    out[np.arange(world.shape[0]), fixed["cell"].astype(int) - 1] = 1.0
    return out


def branch(world, _, value, fixed):
    world.cells.branch_ohm = world.cells.branch_ohm + column(value)
    world.cells.branch_lag_s = np.broadcast_to(column(fixed["tau_s"]), world.shape).copy()


def slow_branch(world, _, value, fixed):
    world.cells.slow_ohm = world.cells.slow_ohm + column(value)
    world.cells.slow_lag_s = np.broadcast_to(column(fixed["tau_s"]), world.shape).copy()


def all_capacity(world, _, value, fixed):
    world.cells.capacity_ah = world.cells.capacity_ah * (1.0 + column(value))


def exchange(world, _, value, fixed):
    for name in ("negative_exchange_a", "positive_exchange_a"):
        setattr(world.cells, name, getattr(world.cells, name) * (1.0 + column(value)))


def bend(world, _, value, fixed):
    """rms over 0..1 of three half waves is the root of half the sum of their squares."""
    shape = np.stack([fixed["first"], fixed["second"], fixed["third"]], -1)
    shape = shape / np.sqrt(0.5 * (shape ** 2).sum(-1, keepdims=True))
    world.cells.bend_v = np.broadcast_to((column(value) * shape)[:, None, :], (*world.shape, 3)).copy()


def leak(world, _, value, fixed):
    world.cells.leak_a = world.cells.leak_a + mask(world, fixed) * column(value)


def weak(world, _, value, fixed):
    """One cell: `by_capacity` 1 lowers its capacity, 0 raises its resistance by a share of what a pulse shows of it."""
    chosen, poor = mask(world, fixed), column(fixed["by_capacity"])
    world.cells.capacity_ah = world.cells.capacity_ah * (1.0 - chosen * poor * column(value))
    total = cell.pulse_ohm(world.pack, world.cells, world.shape)
    world.cells.extra_ohm = world.cells.extra_ohm + chosen * (1.0 - poor) * column(value) * total


def all_heat(world, _, value, fixed):
    for name in ("core_j_per_k", "surface_j_per_k"):
        setattr(world.cells, name, getattr(world.cells, name) * (1.0 + column(value)))


def neighbours(world, _, value, fixed):
    world.cells.neighbour_w_per_k = world.cells.neighbour_w_per_k + column(value) * world.cells.air_w_per_k


def warmer_air(world, now, value, fixed):
    now.ambient_shift_k = value


def other_start(world, now, value, fixed):
    world.instruments.offset["soc"] = -value  # what was believed is too low by as much as the truth is higher


def contact(world, _, value, fixed):
    world.instruments.contact_ohm = value


def compensation(world, _, value, fixed):
    world.instruments.compensation_ohm = value


def saturation(world, now, value, fixed):
    """The sensor stops at (1 - value) of the largest current that a C-rate of 5 would be."""
    world.instruments.limit["current"] = (1.0 - value) * 5.0 * world.cells.capacity_ah.mean(1)


def delay_range(low, high):
    return lambda rng, world: {"tau_s": np.exp(rng.uniform(np.log(low), np.log(high), world.shape[0]))}


def waves(rng, world):
    return {name: rng.standard_normal(world.shape[0]) for name in ("first", "second", "third")}


def weak_cell(rng, world):
    return one_cell(rng, world) | {"by_capacity": rng.integers(0, 2, world.shape[0])}


def skewed(rng, world):
    names = ["current"] + (["voltage"] if world.kind == "cell" else ["pack_voltage"])
    return {"channel": rng.choice(names, world.shape[0])}


def freeze(world, now, value, fixed):
    """Stands still for `value` seconds somewhere in the drive."""
    for name in np.unique(fixed["channel"]):
        chosen = fixed["channel"] == name
        begin = (0.2 + 0.6 * fixed["where"]) * now.speed_mps.shape[1] * drive.STEP_S
        world.instruments.frozen[str(name)] = np.stack([begin, np.where(chosen, begin + value, begin)], -1)


def frozen_channel(rng, world):
    """A cell, or a thermistor whose noise moves it by its steps: of others nobody can tell that they stand."""
    noise = world.instruments.noise["temperature"]
    lively = thermistors(world) if noise.white > 0.5 * noise.step else []
    cells = ["voltage"] if world.kind == "cell" else cell_channels(world)
    return one_of(lambda _: cells + lively)(rng, world) | {"where": rng.uniform(0, 1, world.shape[0])}


def drop(world, now, value, fixed):
    world.instruments.dropped_share = value


BOTH, UP, DOWN = (1, -1), (1,), (-1,)
ALL = (
    Effect("series_resistance", BATTERY, "resistance_ohm", 0.5, UP, cells("extra_ohm", add), relative_to_ohm=True),
    Effect("polarization_resistance", BATTERY, "resistance_ohm", 0.5, UP, branch, delay_range(3.0, 60.0),
           relative_to_ohm=True),
    Effect("resistance_temperature", BATTERY, "activation_energy_j_per_mol", 25e3, BOTH,
           cells("extra_activation", add)),
    Effect("resistance_current", BATTERY, "exchange_current_change", 0.7, DOWN, exchange),
    Effect("resistance_soc", BATTERY, "low_end_change", 3.0, UP, cells("low_end", add)),
    Effect("slow_relaxation", BATTERY, "resistance_ohm", 0.5, UP, slow_branch, delay_range(150.0, 1500.0),
           relative_to_ohm=True),
    Effect("hysteresis", BATTERY, "amplitude_v", 0.040, UP, cells("hysteresis_v", add)),
    Effect("ocv_shape", BATTERY, "rms_v", 0.030, UP, bend, waves),
    Effect("capacity", BATTERY, "change", 0.20, DOWN, all_capacity),
    Effect("initial_soc", BATTERY, "soc", 0.10, BOTH, other_start),
    Effect("self_discharge", PACKS, "current_a", 0.10, UP, leak, one_cell),
    Effect("weak_cell", PACKS, "size", 0.5, UP, weak, weak_cell),
    Effect("contact_resistance", PACKS, "resistance_ohm", 0.020, UP, contact),
    Effect("reported_voltage_compensation", PACKS, "resistance_ohm", 0.020, UP, compensation),
    Effect("current_gain", BATTERY, "change", 0.04, BOTH, instrument("gain", "current")),
    Effect("current_offset", BATTERY, "current_a", 1.5, BOTH, instrument("offset", "current")),
    Effect("current_saturation", BATTERY, "size", 0.7, UP, saturation),
    Effect("voltage_gain", PACKS, "change", 0.02, BOTH, at_channel("gain"), one_of(cell_channels)),
    Effect("voltage_offset", PACKS, "voltage_v", 0.030, BOTH, at_channel("offset"), one_of(cell_channels)),
    Effect("time_skew", BATTERY, "delay_s", 0.150, UP, at_channel("delay_s"), skewed),
    Effect("entropic_heat", BATTERY, "entropy_v_per_k", 0.4e-3, BOTH, cells("entropy_v_per_k", add)),
    Effect("cooling", BATTERY, "change", 0.8, BOTH, cells("air_w_per_k", scale)),
    Effect("cooling_at_stop", BATTERY, "change", 0.9, DOWN, cells("stop_air", scale)),
    Effect("heat_capacity", BATTERY, "change", 0.4, BOTH, all_heat),
    Effect("neighbour_heat", PACKS, "fraction", 3.0, UP, neighbours),
    Effect("ambient", BATTERY, "temperature_k", 12.0, BOTH, warmer_air),
    Effect("thermistor_lag", BATTERY, "delay_s", 40.0, UP, at_channel("lag_s"), one_of(thermistors)),
    Effect("thermistor_offset", PACKS, "temperature_k", 5.0, BOTH, at_channel("offset"), one_of(thermistors)),
    Effect("auxiliary_load", CAR, "power_w", 500.0, UP, of_car("auxiliary_w", add)),
    Effect("inverter_efficiency", CAR, "change", 1.5, UP, of_car("loss_change", add)),
    Effect("motor_constant", CAR, "change", 0.15, BOTH, of_car("constant_change", add)),
    Effect("field_weakening", CAR, "base_speed_change", 0.3, DOWN, of_car("base_rad_per_s", scale)),
    Effect("motor_temperature", CAR, "torque_per_k", 2e-3, DOWN, of_car("torque_per_k", add)),
    Effect("drag_area", CAR, "change", 0.4, BOTH, of_car("drag_area_m2", scale)),
    Effect("rolling_resistance", CAR, "change", 1.0, BOTH, of_car("rolling", scale)),
    Effect("mass", CAR, "change", 0.2, BOTH, of_car("mass_kg", scale)),
    Effect("tyre_radius", CAR, "change", 0.08, BOTH, of_car("tyre_radius_m", scale)),
    Effect("tyre_slip", CAR, "change", 1.0, UP, of_car("slip_change", add)),
    Effect("grade", CAR, "slope", 0.02, BOTH, of_car("slope", add)),
    Effect("wind", CAR, "speed_mps", 8.0, BOTH, of_car("wind_mps", add)),
    Effect("grip", CAR, "change", 0.3, DOWN, of_car("friction", scale)),
    Effect("brake_fade", CAR, "friction_per_k", 2e-3, DOWN, of_car("fade_per_k", add)),
    Effect("regen_split", CAR, "fraction", 0.4, UP, of_car("regeneration", add)),
    Effect("dropped_or_late_frames", BATTERY, "count", 0.05, UP, drop),
    # Finer steps than four of the logger's own are nothing wrong.
    Effect("quantisation", BATTERY, "step", 5.0, UP, instrument("step", "current"),
           least=lambda world: 4.0 * world.instruments.noise["current"].step),
    Effect("frozen_signal", BATTERY, "duration_s", 60.0, UP, freeze, frozen_channel),
)
BY_NAME = {effect.name: effect for effect in ALL}
