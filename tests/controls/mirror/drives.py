# SPDX-License-Identifier: Apache-2.0
"""Draws sound cars, how they are driven, and runs the simulator; reads back what no sensor hides."""

import csv
import re
import subprocess
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from .battery import Cell

KINDS = ("cell", "pack", "car", "long")
TRACKS = ("michigan_2014", "michigan_2015")
# The cell that a kind may have, cells in series and in parallel, thermistors, vehicle that it stands in.
BATTERIES = {
    "pack": (("aesc_e5_2p", 24, 1, 6, "vtm16e"),),
    "car": (("aesc_e5_2p", 24, 1, 6, "vtm16e"), ("aesc_e5_2p", 22, 1, 6, "vtm17e")),
    "long": (("sony_vtc6", 96, 6, 20, "vtm16e"), ("molicel_p45b", 96, 4, 20, "vtm16e")),
}
DEFAULT_AIR_C = 26.85  # of a vehicle that says nothing else: a pack file says nothing of the air
LONGEST_S = 300.0


@dataclass(frozen=True)
class Settings:
    """How one drive goes: everything that a sound car may do on another day."""

    seed: int
    keys: tuple  # key=value
    arguments: tuple  # track, laps, start


@dataclass
class Car:
    """A sound car with its logger, as the parameter file that explain is given has it."""

    kind: str
    text: str  # of the parameter file
    cell: Cell
    series: int
    parallel: int
    thermistors: int
    air_c: float
    noise: bool
    candump: bool
    whole: bool
    masses_kg: float = 0.0
    loss: float = 0.0  # 1/efficiency - 1 of the inverter
    vehicle: str = ""  # the file that is driven: the parameter file, with a car around a pack

    @property
    def ending(self):
        return ".log" if self.candump else ".csv"

    @property
    def has_car(self):
        return self.kind in ("car", "long")


def draw_car(rng, kind, quick):
    noise = bool(rng.random() < 0.6)
    if kind == "cell":
        return cell_on_bench(rng, noise)
    name, series, parallel, thermistors, base = BATTERIES[kind][rng.integers(len(BATTERIES[kind]))]
    candump = bool(rng.random() < (0.4 if quick else 0.5))
    whole = bool(not quick and rng.random() < 0.12)
    cell = Cell.named(name)
    cell.capacity_ah = round(cell.capacity_ah * rng.uniform(0.9, 1.1), 3)
    air_c = DEFAULT_AIR_C if kind == "pack" else round(rng.uniform(8.0, 34.0), 1)
    efficiency = round(rng.uniform(0.90, 0.97), 3)
    mass = round(rng.uniform(180.0, 260.0), 1)
    battery = [
        "[battery]",
        f'cell = "{name}"',
        f"cells_in_series = {series}",
        f"cells_in_parallel = {parallel}",
        f"capacity_ah = {cell.capacity_ah}",
    ]
    rest = [
        "[environment]",
        f"ambient_c = {air_c}",
        "[sensors]",
        f"temperature_count = {thermistors}",
        "[vehicle]",
        f"mass_kg = {mass}",
        "[inverter]",
        f"efficiency = {efficiency}",
    ]
    vehicle = ['name = "car"', f'base = "{base}"', *battery, *rest]
    given = battery if kind == "pack" else vehicle
    return Car(kind, "\n".join(given) + "\n", cell, series, parallel, thermistors, air_c, noise, candump, whole,
               mass + 72.0, 1.0 / efficiency - 1.0, "\n".join(vehicle) + "\n")


def cell_on_bench(rng, noise):
    cell = Cell.named("aesc_e5_2p")
    factor = round(rng.uniform(0.9, 1.1), 3)
    cell.capacity_ah = round(cell.capacity_ah * factor, 3)
    original = (Path(__file__).resolve().parents[3] / "plant_sim/data/cells/aesc_e5_2p.toml").read_text()
    text = re.sub(r"(?m)^capacity_ah *= *[0-9.]+", f"capacity_ah = {cell.capacity_ah}", original)
    return Car("cell", text, cell, 1, 1, 1, DEFAULT_AIR_C, noise, False, True)


def draw_settings(rng, car, quick, sound_day=False):
    """`sound_day`: a reference, which had other air too."""
    seed = int(rng.integers(1, 2**31))
    if car.kind == "cell":
        keys = (
            f"test.temperature_c={rng.uniform(22.0, 34.0):.1f}",
            f"load.resistor_seed={int(rng.integers(1, 10000))}",
            f"schedule.pulse_s={int(rng.integers(20, 80))}",
            f"rest.seconds={int(rng.integers(30, 150))}",
            f"stop.cell_voltage_min_v={rng.uniform(3.1, 3.5):.2f}",
        )
        return Settings(seed, keys, ("random_resistors_free",))
    charge = rng.uniform(0.95, 1.0) if car.whole else rng.uniform(0.35, 1.0)
    keys = [
        f"battery.initial_soc={charge:.3f}",
        f"battery.initial_temperature_c={car.air_c + rng.uniform(0.0, 6.0):.2f}",
        f"driver.grip_use={rng.uniform(0.85, 0.98):.3f}",
    ]
    if sound_day and car.kind != "pack":
        keys.append(f"environment.ambient_c={car.air_c + rng.uniform(-2.0, 2.0):.1f}")
    arguments = ["--track", str(rng.choice(TRACKS)), "--lap-start", str(rng.choice(["flying", "standing"]))]
    if not car.whole:
        arguments += ["--laps", ("2" if car.candump else "3") if quick else "6"]
    return Settings(seed, tuple(keys), tuple(arguments))


def command(binary, car, folder, settings, out, extra=()):
    """The command of one drive; the sound car's vehicle file lies in `folder`."""
    if car.kind == "cell":
        noise = str(car.noise).lower()
        keys = (*settings.keys, "instruments.systematic=false", f"instruments.noise={noise}",
                f"instruments.quantisation={noise}", "cells.count=1", "cells.capacity_spread=0",
                "cells.resistance_spread=0", "cells.soc_spread=0", *extra)
        return [str(binary), "bench-test", *settings.arguments, "--cell", str(folder / "cell.toml"), "--seed",
                str(settings.seed), "--out", str(out), "--truth", str(out) + ".truth", "--set", *keys]
    noise = ("sensors.noise=true", "sensors.quantisation=true") if car.noise else ()
    files = ["--csv", str(out) + ".csv"] + (["--candump", str(out) + ".log"] if car.candump else [])
    return [str(binary), "endurance", "--vehicle", str(folder / "vehicle.toml"), *settings.arguments, "--seed",
            str(settings.seed), *files, "--set", *settings.keys, *noise, *extra]


class NotDriven(Exception):
    """The simulator could not drive this: the car stopped, or a key was refused."""


def true_cell(text, keys):
    """The cell file with what was hidden in it: `explain` takes no key of a cell by --set."""
    effects = []
    for key, value in (word.split("=", 1) for word in keys):
        name = key.removeprefix("cell.")
        if name.startswith("effects."):
            effects.append(f"{name.removeprefix('effects.')} = {value}")
        else:
            text, count = re.subn(rf"(?m)^{name} *=.*$", f"{name} = {value}", text)
            assert count == 1, name
    return text + "\n" + "\n".join(["[effects]", *effects, ""]) if effects else text


def told(said):
    """The line that says why a drive failed, else the last one."""
    lines = said.strip().splitlines() or ["nothing was said"]
    return next((line for line in lines if line.startswith("FAILED")), lines[-1])[:200]


@dataclass
class Simulator:
    """Runs the product's programs; `running` holds what must be ended on Ctrl-C."""

    voltlap: Path
    learn: Path
    running: set = field(default_factory=set)

    def drive(self, car, folder, settings, name, extra=()):
        """Returns (log, path of the truth)."""
        out = folder / name
        binary = self.learn if car.kind == "cell" else self.voltlap
        process = subprocess.Popen(command(binary, car, folder, settings, out, extra), stdin=subprocess.DEVNULL,
                                   stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.running.add(process)
        try:
            said, _ = process.communicate(timeout=LONGEST_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
            raise NotDriven(f"no end within {LONGEST_S:.0f} s") from None
        finally:
            self.running.discard(process)
        if process.returncode != 0:
            raise NotDriven(f"exit code {process.returncode}: " + told(said))
        if car.kind == "cell":
            table = next(out.glob("*_cell1.csv"))
            return table, Path(str(out) + ".truth")
        return Path(str(out) + car.ending), Path(str(out) + ".csv")


@dataclass
class Truth:
    """What was driven, without sensors, at equal steps; of one cell of the pack."""

    step_s: float
    current_a: np.ndarray
    soc: np.ndarray
    temperature_c: np.ndarray
    voltage_v: np.ndarray
    speed_mps: np.ndarray | None = None
    acceleration: np.ndarray | None = None
    power_w: np.ndarray | None = None
    free: np.ndarray | None = None  # rows without the brake
    torque_a: np.ndarray | None = None  # phase current

    def __len__(self):
        return len(self.current_a)


def read_truth(path, car):
    with open(path, encoding="ascii") as file:
        rows = list(csv.reader(line for line in file if not line.startswith("#")))
    names = {name: k for k, name in enumerate(rows[0])}

    def column(name):
        return np.array([float(row[names[name]]) for row in rows[1:]])

    time = column("time_s")
    if car.kind == "cell":
        return Truth(float(time[1] - time[0]), column("current_a"), column("cell_1_soc"),
                     column("cell_1_temperature_c"), column("cell_1_voltage_v"))
    truth = Truth(float(time[1] - time[0]), column("pack_current_a") / car.parallel, column("soc"),
                  column("cell_2_temperature_c"), column("cell_2_voltage_v"))
    truth.speed_mps, truth.free = column("speed_mps"), column("brake") < 1e-3
    truth.acceleration = column("longitudinal_mps2")
    truth.power_w = column("pack_current_a") * column("pack_voltage_v")
    truth.torque_a = column("phase_current_a")
    return truth


def facts_of(car):
    """What a label says about a car and its log."""
    return {"kind": car.kind, "cells": f"{car.series}s{car.parallel}p", "format": "candump" if car.candump else "CSV",
            "noise": car.noise, "whole": car.whole}
