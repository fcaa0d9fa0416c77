# SPDX-License-Identifier: Apache-2.0
"""Other teams' cars, drawn: motor, pack, cell, gear, mass, temperatures, charge, power, regeneration, inverter. A sound
car is never stopped by its firmware, the rule of 80 kW holds and the ledger closes; what ends a run early is physics,
and named. VOLTLAP_TEST_SEED repeats a draw, VOLTLAP_DRAWN_CARS draws more."""
import json
import os
import pathlib
import random
import re
import subprocess

import pytest

BUILD = pathlib.Path(os.environ["VOLTLAP_BUILD_DIR"])
VOLTLAP = BUILD / "bin" / "voltlap"
SEED = int(os.environ.get("VOLTLAP_TEST_SEED") or random.randrange(2**32))
CARS = int(os.environ.get("VOLTLAP_DRAWN_CARS", "14"))
CELLS = ("lg_m50lt", "melasta_slpbb042126", "molicel_p42a", "molicel_p45b", "samsung_30q", "sony_vtc6")
# What a car may be too weak, too small or too hot for.
PHYSICS = ("is empty", "speed error", "the inverter is off below", "degC is beyond", "has stood still",
           "voltage collapsed", "ran off the course")


def voltlap(*arguments, cwd=None):
    return subprocess.run([VOLTLAP, *map(str, arguments)], capture_output=True, text=True, timeout=300, cwd=cwd)


def motors():
    """Highest DC voltage by name."""
    rows = [line.split() for line in voltlap("list", "motors").stdout.splitlines()[1:]]
    return {row[0]: float(row[6]) for row in rows if not row[0].startswith("amk")}


def settings(source):
    soc, celsius = source.uniform(0.5, 1.0), source.randint(-5, 42)
    out = [f"battery.initial_soc={soc:.2f}", f"battery.initial_temperature_c={celsius}",
           f"environment.ambient_c={source.randint(max(-5, celsius - 15), celsius)}",
           f"master.power_max_kw={source.choice((40, 60, 79))}", f"sensors.noise={source.choice(('true', 'false'))}",
           f"master.pedal_at_half={source.uniform(0.3, 0.6):.2f}"]
    if source.random() < 0.5:
        out.append(f"master.regen_current_max_a={source.choice((30, 60, 100))}")
    return out


def own_car(source, folder):
    name, most_v = source.choice(sorted(motors().items()))
    series = max(14, min(142, int(source.uniform(0.75, 0.97) * most_v / 4.2)))
    parallel = source.randint(2, 8)
    done = voltlap("new", "car", "drawn", "--mass", source.randint(180, 290), "--gear",
                   f"{source.uniform(2.5, 6.0):.2f}", "--motor", name, "--cells", f"{series}x{parallel}", "--cell",
                   source.choice(CELLS), cwd=folder)
    assert done.returncode == 0, done.stderr
    protocol = ["inverter.protocol=pm100"] if source.random() < 0.3 else []
    return ["--vehicle", str(folder / "drawn.toml")], [*settings(source), *protocol]


def four_motors(source):
    series = source.choice((84, 96, 110, 132))
    return ["--vehicle", "amk_4wd"], [
        *settings(source), f"battery.cells_in_series={series}", f"battery.cells_in_parallel={source.randint(3, 5)}",
        f"sensors.temperature_count={series // 5 + 2}", f"powertrain.final_drive={source.uniform(10, 16):.2f}",
        f"powertrain.front_torque_share={source.uniform(0.2, 0.5):.2f}",
        f"vehicle.mass_kg={source.randint(190, 260)}", f"tyres.radius_m={source.uniform(0.19, 0.26):.3f}"]


def firmware_stopped_it(cause):
    """A fault of the firmware in a car without one; what is off says so itself."""
    named = set(re.findall(r"faults ([A-Za-z, ]+)", cause.replace("faults none", "")))
    faults = {fault.strip() for names in named for fault in names.split(",")}
    return bool(faults - {"TemperatureHigh"}) and "the inverter is off below" not in cause


@pytest.mark.parametrize("number", range(CARS))
def test_another_teams_car_is_stopped_by_nothing_but_physics(number, tmp_path):
    print(f"VOLTLAP_TEST_SEED={SEED}")
    source = random.Random(f"{SEED}-{number}")
    car, words = four_motors(source) if source.random() < 0.3 else own_car(source, tmp_path)
    track = source.choice(("michigan_2014", "michigan_2015"))
    arguments = [*car, "--track", track, "--laps", 2, "--json", tmp_path / "run.json", "--seed", number,
                 *(part for word in words for part in ("--set", word))]
    done = voltlap("endurance", *arguments)
    told = f"seed {SEED}, car {number}: {' '.join(map(str, arguments))}\n{done.stdout[-1500:]}{done.stderr}"
    assert done.returncode in (0, 3), told
    run = json.loads((tmp_path / "run.json").read_text())
    if run["status"] != "finished":
        assert any(word in run["failure"]["cause"] for word in PHYSICS), told
        assert not firmware_stopped_it(run["failure"]["cause"]), told
    assert run["max_power_mean_500ms_kw"] <= 80.0, told
    assert abs(run["energy_ledger_error_pct"]) < 1e-6, told
