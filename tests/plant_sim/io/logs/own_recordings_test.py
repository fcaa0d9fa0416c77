# SPDX-License-Identifier: Apache-2.0
"""What `voltlap endurance` writes needs no map: the candump of its bus and its time series are the same channels."""
import bisect
import gzip
import os
import random
import shutil
import subprocess
import tomllib
from pathlib import Path

import pytest

BUILD = Path(os.environ["VOLTLAP_BUILD_DIR"])
STEP_S = 0.01  # of the sensor frames


def drive(folder, *flags):
    candump, series = folder / "run.log", folder / "run.csv"
    subprocess.run([BUILD / "bin/voltlap", "endurance", "--laps", "1", "--candump", candump, "--csv", series, *flags],
                   check=True, capture_output=True)
    return candump, series


def channels_of(recording, roles=()):
    """{role: (times, values)} of the roles asked for, the roles there are, and what was said."""
    result = subprocess.run([BUILD / "tests/bin/show_log", recording, "-", *roles], capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
    samples, there, words = {role: ([], []) for role in roles}, set(), []
    for line in result.stdout.splitlines():
        kind, *rest = line.split(" ")
        if kind == "sample":
            samples[rest[0]][0].append(float(rest[1]))
            samples[rest[0]][1].append(float(rest[2]))
        elif kind == "channel":
            there.add(rest[0])
        else:
            words.append(line)
    return samples, there, words


def apart(bus, series, start_s):
    """Distance of the rows of the series from the range of the bus's samples around each: the worst but for a hundredth
    of them, of slow frames a tenth, in which the value turned back between two frames."""
    times, values = bus
    distances = []
    for time, value in zip(*series):
        at = bisect.bisect_left(times, time + start_s)
        near = [values[k] for k in range(max(0, at - 2), min(len(values), at + 3)) if values[k] == values[k]]
        if near:
            distances.append(max(0.0, min(near) - value, value - max(near)))
    distances.sort()
    slow = times[1] - times[0] > 1.5 * STEP_S
    return distances[int((0.9 if slow else 0.99) * len(distances))]


def start_of(bus, series):
    """Seconds on the bus before the race's clock begins: the car is switched on first."""
    def error(start_s):
        total = 0.0
        for time, value in list(zip(*series))[::7]:
            at = min(bisect.bisect_left(bus[0], time + start_s), len(bus[0]) - 1)
            total += abs(bus[1][at] - value)
        return total

    return min((STEP_S * k for k in range(0, 1000)), key=error)


# Resolution of the frame, half of it rounded, and of the series.
RESOLUTION = {"current": 0.0011, "pack_voltage": 0.0051, "bus_voltage": 0.0051, "cell_voltage_1": 0.000101,
              "cell_voltage_7": 0.000101, "soc": 0.0000115, "temperature_1": 0.051}


@pytest.mark.parametrize("flags", [(), *[("--set", f"battery.cells_in_series={n}") for n in (20, 23)]])
def test_candump_and_series_are_the_same_channels(tmp_path, flags):
    candump, series = drive(tmp_path, *flags)
    cells = int(flags[1].split("=")[1]) if flags else 24
    bus, bus_roles, words = channels_of(candump, RESOLUTION)
    table, table_roles, _ = channels_of(series, RESOLUTION)
    for roles in (bus_roles, table_roles):
        numbered = {role for role in roles if role.startswith("cell_voltage_")}
        assert numbered == {f"cell_voltage_{n + 1}" for n in range(cells)}
    assert {"accelerator", "motor_speed", "wheel_speed_4", "temperature_1"} <= bus_roles
    assert {"accelerator", "brake", "speed", "temperature_1"} <= table_roles
    assert not any("never seen" in line or "checksum" in line or "lost" in line for line in words), words
    start_s = start_of(bus["current"], table["current"])
    for role, resolution in RESOLUTION.items():
        assert apart(bus[role], table[role], start_s) <= resolution, role


def test_packed_files_and_orion_frames_alone_are_read_too(tmp_path):
    candump, series = drive(tmp_path)
    for path in (candump, series):
        with open(path, "rb") as plain, gzip.open(f"{path}.gz", "wb") as packed:
            shutil.copyfileobj(plain, packed)
        assert channels_of(f"{path}.gz")[1] == channels_of(path)[1]
    orion = tmp_path / "orion.log"
    orion.write_text("".join(line for line in candump.read_text().splitlines(True)
                             if line.split(" ")[2][:4] in ("6B0#", "6B1#", "036#")))
    _, roles, _ = channels_of(orion)
    assert {"current", "pack_voltage", "soc", "cell_voltage_24"} <= roles


def test_frames_of_another_car_with_the_same_identifiers_are_refused(tmp_path):
    """Their checksums do not hold."""
    candump, _ = drive(tmp_path)
    rng = random.Random(3)
    other = tmp_path / "other.log"
    lines = candump.read_text().splitlines(True)
    other.write_text("".join(f"{line[:-3]}{rng.randrange(256):02X}\n" for line in lines))
    result = subprocess.run([BUILD / "tests/bin/show_log", other], capture_output=True, text=True)
    assert result.returncode == 1 and "voltlap_car_can fits but for the checksums" in result.stderr


def test_what_is_proposed_from_the_bus_of_the_car_is_the_map_that_ships(tmp_path):
    candump, _ = drive(tmp_path)
    root = Path(__file__).parents[4]
    shipped = tomllib.loads((root / "plant_sim/data/maps/voltlap_car_can.toml").read_text())["roles"]
    result = subprocess.run([BUILD / "tests/bin/show_proposal", candump, root / "can_dbc/car.dbc"], capture_output=True,
                            text=True, check=True)
    verdict, draft = result.stdout.split("\n", 1)
    assert verdict == "complete"
    proposed = tomllib.loads(draft)["roles"]
    needed = {"current", "pack_voltage", "bus_voltage", "cell_voltage_<n>", "temperature_<n>", "motor_speed"}
    assert needed <= proposed.keys()
    for role, source in proposed.items():
        for key in ("frame", "signal", "unit", "first"):
            assert source.get(key) == shipped[role].get(key), role
