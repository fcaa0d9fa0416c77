# SPDX-License-Identifier: Apache-2.0
"""Whole recordings of a cell, a pack or a car: who is made of what, what was driven, what the instruments showed.

A world is one make (cells, car) for each case. The same world driven twice with other seeds gives a log and its
references. Channels carry the names of the project's roles; values are SI, current is positive when it discharges.
"""
import dataclasses

import numpy as np

from . import car as cars
from . import cell as chemistry
from . import circuit, drive, instruments

ZERO_C = 273.15
CELLS = {"cell": 1, "pack": 8, "car": 16}
CAPACITY_AH = {"cell": (15.0, 40.0), "pack": (15.0, 40.0), "car": (90.0, 130.0)}
THERMISTOR_EVERY = 2
FAMILIES = {"particle": chemistry.Pack, "circuit": circuit.Circuit}  # another physics than the tool's, and its own


def channel_kind(name):
    """What a channel measures, a key of a logger's noise."""
    for kind, starts in {"voltage": ("cell_voltage", "voltage"), "pack_voltage": ("pack_voltage", "bus_voltage"),
                         "temperature": ("temperature", "ambient"), "speed": ("speed", "wheel_speed")}.items():
        if name.startswith(starts):
            return kind
    return name


@dataclasses.dataclass
class Instruments:
    """A logger, and what is wrong with it by channel name; arrays (cases,). Nothing is wrong in a sound log."""

    noise: dict  # {kind: instruments.Noise}
    gain: dict = dataclasses.field(default_factory=dict)
    offset: dict = dataclasses.field(default_factory=dict)
    delay_s: dict = dataclasses.field(default_factory=dict)
    lag_s: dict = dataclasses.field(default_factory=dict)
    limit: dict = dataclasses.field(default_factory=dict)
    step: dict = dataclasses.field(default_factory=dict)
    frozen: dict = dataclasses.field(default_factory=dict)  # channel: (cases, 2) begin and end [s]
    dropped_share: np.ndarray = 0.0
    contact_ohm: np.ndarray = 0.0
    compensation_ohm: np.ndarray = 0.0


@dataclasses.dataclass
class World:
    kind: str
    cells: chemistry.Cells
    car: cars.Car | None
    instruments: Instruments
    family: str = "particle"

    @property
    def shape(self):
        return self.cells.capacity_ah.shape

    @property
    def pack(self):
        """The physics of its cells, with which cell.run() drives them."""
        return FAMILIES[self.family]


# What differs from day to day though nothing is wrong: standard deviation of the share, of cells and car.
DAY_OF_CELLS = {"film_ohm": 0.005, "electrolyte_ohm": 0.01, "air_w_per_k": 0.05, "negative_exchange_a": 0.01}
DAY_OF_CAR = {"rolling": 0.03, "mass_kg": 0.003, "drag_area_m2": 0.01, "iron_w_per_rad_s": 0.02, "auxiliary_w": 0.03,
              "slip_stiffness": 0.03}


# How a drive begins: charge, spread of the cells' charge below it, warmth above the air [K], spread of the cells' [K].
START_CHARGE, START_UNEQUAL = (0.90, 1.0), 0.004
START_WARM_K, START_UNEQUAL_K = (-2.0, 4.0), 0.3


@dataclasses.dataclass
class Situation:
    """One drive of a world: arrays (cases,) and (cases, steps)."""

    speed_mps: np.ndarray
    slope: np.ndarray
    current_a: np.ndarray | None  # None: what the drive asks of the car's pack
    charge: np.ndarray  # (cases, cells)
    temperature_k: np.ndarray
    ambient_k: np.ndarray
    day: dict  # share by which a parameter of DAY_OF_CELLS and DAY_OF_CAR is larger today, (cases,)
    ambient_shift_k: np.ndarray = 0.0  # the air at the cells against the air that is reported


def make(rng, kind, cases, family="particle"):
    """Sound worlds of random make, with one random logger for all."""
    shape = (cases, CELLS[kind])
    cells = chemistry.design(rng, *shape, CAPACITY_AH[kind]).widened(shape)
    car = cars.design(rng, cases) if kind == "car" else None
    return World(kind, cells, car, Instruments(instruments.draw(rng.spawn(1)[0])), family)


def situation(rng, world, duration_s):
    """A random drive from a random start: 90 to 100 % charge, 12 to 32 degC, the air a little apart from the cells."""
    cases, cells = world.shape
    drives = [drive.endurance(rng, duration_s) for _ in range(cases)]
    speed, slope = (np.stack(part) for part in zip(*drives))
    capacity = world.cells.capacity_ah.mean(1)
    current = None
    if world.kind != "car":
        current = np.stack([drive.drive_current(rng, duration_s, c, d) for c, d in zip(capacity, drives)])
        budget = 0.72 * capacity * 3600.0
        current *= np.minimum(1.0, budget / (current.sum(1) * drive.STEP_S))[:, None]
    charge = rng.uniform(*START_CHARGE, (cases, 1)) - np.abs(START_UNEQUAL * rng.standard_normal((cases, cells)))
    ambient = ZERO_C + rng.uniform(12.0, 32.0, cases)
    temperature = (ambient + rng.uniform(*START_WARM_K, cases))[:, None]
    temperature = temperature + START_UNEQUAL_K * rng.standard_normal((cases, cells))
    day = {name: sigma * rng.standard_normal(cases) for name, sigma in day_to_day(world).items()}
    return Situation(speed, slope, current, charge, temperature, ambient, day)


def day_to_day(world):
    """{parameter: standard deviation of its share} of this kind of world."""
    return DAY_OF_CELLS | (DAY_OF_CAR if world.kind == "car" else {})


def unlike(world, now):
    """[(situation, standard deviations by which it differs from `now`)]: what two sound drives differ by.

    What changes from day to day, and the charge and the warmth that all cells and that each cell begins with. Where all
    differ a step is a tenth of the deviation, so that the difference is a slope.
    """
    out = [(dataclasses.replace(now, day=now.day | {name: now.day[name] + sigma}), 1.0)
           for name, sigma in day_to_day(world).items()]
    each = np.eye(world.shape[1]) if world.shape[1] > 1 else []
    for name, (low, high), unequal in (("charge", START_CHARGE, START_UNEQUAL * np.sqrt(1.0 - 2.0 / np.pi)),
                                       ("temperature_k", START_WARM_K, START_UNEQUAL_K)):
        before, together = getattr(now, name), (high - low) / np.sqrt(12.0)
        out.append((dataclasses.replace(now, **{name: before - 0.1 * together}), 0.1))
        out += [(dataclasses.replace(now, **{name: before - unequal * cell}), 1.0) for cell in each]
    return out


def of_today(world, day):
    """Cells and car as they are on that day."""
    def changed(thing):
        return dataclasses.replace(thing, **{name: getattr(thing, name) * (1.0 + share[:, None])
                                             for name, share in day.items() if hasattr(thing, name)})
    return changed(world.cells), None if world.car is None else changed(world.car)


def happens(drives):
    """The truth of many drives [(world, situation)] of one kind and length, computed side by side.

    All with a current, or all with what the drive asks.

    Returns [(History of the cells, Demand of the car or None)]. A step costs nearly the same for one case as for many.
    """
    kind = drives[0][0].kind
    made = [of_today(world, now.day) for world, now in drives]
    cells = _side_by_side([part for part, _ in made])
    nows = [now for _, now in drives]
    charge, temperature = (np.concatenate([getattr(now, name) for now in nows]) for name in ("charge", "temperature_k"))
    speed, slope = (np.concatenate([getattr(now, name) for now in nows]) for name in ("speed_mps", "slope"))
    air_k = np.concatenate([now.ambient_k + now.ambient_shift_k for now in nows])
    pack, standing, demand = drives[0][0].pack(cells, charge, temperature), speed < 0.05, None
    if kind == "car":
        demand = cars.drive(_side_by_side([part for _, part in made]), speed, slope, drive.STEP_S)
    if nows[0].current_a is None:
        history = chemistry.run(pack, drive.STEP_S, air_k, standing, power_w=demand.power_w)
    else:
        current = np.concatenate([now.current_a for now in nows])
        history = chemistry.run(pack, drive.STEP_S, air_k, standing, current_a=current)
    ends = np.cumsum([world.shape[0] for world, _ in drives])
    rows = [slice(end - world.shape[0], end) for end, (world, _) in zip(ends, drives)]
    return [(_cases(history, each), None if demand is None else _cases(demand, each)) for each in rows]


def _side_by_side(things):
    """One dataclass of arrays for the cases of all."""
    first = things[0]
    cases = [len(getattr(thing, "capacity_ah" if hasattr(thing, "capacity_ah") else "mass_kg")) for thing in things]

    def values(thing, name, count):
        value = np.asarray(getattr(thing, name), float)
        return value if value.ndim and len(value) == count else np.broadcast_to(value, (count, 1))
    return dataclasses.replace(first, **{
        field.name: np.concatenate([values(thing, field.name, count) for thing, count in zip(things, cases)])
        for field in dataclasses.fields(first)})


def _cases(thing, rows):
    """The rows of those cases; what all share, the time, stays."""
    return dataclasses.replace(thing, **{field.name: getattr(thing, field.name) if field.name == "time_s"
                                         else getattr(thing, field.name)[rows] for field in dataclasses.fields(thing)})


def channels(world, history, demand, now: Situation):
    """What ideal instruments show, with the faults of the instruments but without noise: {role: (cases, steps)}."""
    volts, late = history.voltage_v, history.current_a
    out = {}
    if world.kind == "cell":
        out["current"], out["voltage"] = late, volts[:, :, 0]
    else:
        out["current"] = late
        inside = volts.sum(2)
        contact, compensation = (np.broadcast_to(ohm, (world.shape[0],))[:, None]
                                 for ohm in (world.instruments.contact_ohm, world.instruments.compensation_ohm))
        out["bus_voltage"] = inside - contact * late
        out["pack_voltage"] = out["bus_voltage"] + compensation * late
        for k in range(volts.shape[2]):
            out[f"cell_voltage_{k + 1}"] = volts[:, :, k]
    for number, k in enumerate(range(0, volts.shape[2], THERMISTOR_EVERY)):
        name = "temperature" if world.kind == "cell" else f"temperature_{number + 1}"
        out[name] = history.surface_k[:, :, k] - ZERO_C
    out["ambient"] = np.broadcast_to((now.ambient_k - ZERO_C)[:, None], late.shape).copy()
    out["soc"] = history.charge.mean(2)
    if demand is not None:
        out["speed"], out["wheel_speed_1"] = demand.speed_mps, demand.wheel_speed_mps
        out["accelerator"], out["brake"] = demand.accelerator, demand.brake
        out["motor_speed"], out["motor_torque"] = demand.motor_rad_per_s, demand.torque_nm
    return faulty(out, world.instruments)


def faulty(out, wrong: Instruments):
    out = dict(out)
    for name, lag in wrong.lag_s.items():
        out[name] = instruments.lagging(out[name], lag, drive.STEP_S)
    for name, late in wrong.delay_s.items():
        out[name] = instruments.delayed(out[name], late, drive.STEP_S)
    for name, gain in wrong.gain.items():
        out[name] = out[name] * (1.0 + gain[:, None])
    for name, offset in wrong.offset.items():
        out[name] = out[name] + offset[:, None]
    for name, limit in wrong.limit.items():
        bound = np.where(limit > 0, limit, np.inf)[:, None]
        out[name] = np.clip(out[name], -bound, bound)
    return out


def measured(rng, shown, world):
    """The log: noise, resolution, frozen stretches. Dropped rows are left to the packer: {role: (cases, steps)}."""
    noise = world.instruments.noise
    log = {name: instruments.noisy(rng, values, noise[channel_kind(name)], drive.STEP_S)
           for name, values in shown.items()}
    log["ambient"] = np.round(shown["ambient"], 1)
    for name, step in world.instruments.step.items():
        coarse = np.where(step > 0, step, 1.0)[:, None]
        log[name] = np.where(step[:, None] > 0, np.round(log[name] / coarse) * coarse, log[name])
    for name, spans in world.instruments.frozen.items():
        for row, (begin, end) in zip(log[name], (spans / drive.STEP_S).astype(int)):
            row[begin:end] = row[begin] if end > begin else row[begin:end]
    return log
