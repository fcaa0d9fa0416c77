# SPDX-License-Identifier: Apache-2.0
"""The fault matrix of cars that are not the example car: drawn ones, few rows each. VOLTLAP_TEST_SEED draws more."""
import json
import os
import random
import subprocess
import sys
from pathlib import Path

import pytest

from voltlap_hil.nodes import program

FAULTS = Path(__file__).resolve().parents[1] / "faults.py"
SEED = int(os.environ.get("VOLTLAP_TEST_SEED", "1"))
CELLS = ("molicel_p45b", "molicel_p42a", "sony_vtc6", "samsung_30q")
WITH_EVERY_CAR = ("apps1_open", "cell_no_value", "dc_link_stuck_high", "current_high", "limit_falls")
ROWS = ("apps1_short_blip", "brake_and_throttle", "shutdown_opens", "cell_high", "cell_low", "thermistor_hot",
        "cells_no_value", "pack_voltage_short", "pedals_lost", "bms_limits_lost", "cell_voltages_second",
        "apps1_offset_8", "bms_reset_with_trip")


def voltlap_faults(*arguments):
    return subprocess.run([sys.executable, FAULTS, *map(str, arguments)], capture_output=True, text=True, timeout=300)


def new_car(folder, motor, pack, cell, mass=250, gear=4):
    subprocess.run([program(), "new", "car", "drawn", "--mass", str(mass), "--gear", str(gear), "--motor", motor,
                    "--cells", pack, "--cell", cell], cwd=folder, check=True,
                   stdout=subprocess.DEVNULL)
    return folder / "drawn.toml"


def verdicts(tmp_path, *arguments):
    out = tmp_path / "rows.json"
    done = voltlap_faults("--json", out, *arguments)
    rows = json.loads(out.read_text())["rows"] if out.exists() else []
    return done, {row["id"]: row for row in rows}


def chosen(rows):
    return [word for row in rows for word in ("--row", row)]


@pytest.mark.parametrize("number", range(3))
def test_a_drawn_car_passes_the_same_rows(tmp_path, number):
    draw = random.Random(f"{SEED}-{number}")
    motor, series = draw.choice([("emrax_228_mv", (80, 96, 108)), ("emrax_228_hv", (120, 144)),
                                 ("emrax_228_lv", (24, 28))])
    car = new_car(tmp_path, motor, f"{draw.choice(series)}x{draw.randint(5, 8)}", draw.choice(CELLS),
                  draw.randint(200, 260), draw.choice((3.2, 3.6, 4)))
    rows = [*WITH_EVERY_CAR, *draw.sample(ROWS, 5)]
    done, found = verdicts(tmp_path, "--vehicle", car, *chosen(rows))
    assert done.returncode == 0, f"seed {SEED}, car {number}: {done.stdout}{done.stderr}\n{car.read_text()}"
    assert found.keys() == set(rows)


def test_a_drive_that_the_car_does_not_do_is_told_once_and_not_blamed_on_the_fault(tmp_path):
    """So weak a motor does not come to 5 m/s in time."""
    rows = chosen(["wheels_swapped", "wheels_no_value"])
    done, found = verdicts(tmp_path, "--set", "inverter.current_max_a=30", *rows)
    assert done.returncode == 3
    assert {row["verdict"] for row in found.values()} == {"not run"}
    assert done.stdout.count("could not be run: the sound car does not come to where the fault begins") == 1
    assert "2 could not be run" in done.stdout and "stopped by it" not in done.stdout


def test_a_row_takes_the_next_drive_where_the_car_does_not_do_the_first(tmp_path):
    """Full pedal takes it to its top speed before the row ends."""
    car = new_car(tmp_path, "emrax_228_mv", "96x6", "molicel_p45b")
    done, found = verdicts(tmp_path, "--vehicle", car, "--row", "current_zero")
    assert done.returncode == 0, done.stdout
    assert found["current_zero"]["drive"] == "lap"


def test_a_row_about_another_limit_says_so(tmp_path):
    done, _ = verdicts(tmp_path, "--set", "bms.limit_method=ahead", "--set",
                       "bms.soc_method=ekf", "--row", "limit_falls")
    assert done.returncode == 3 and "limit_method equation; this one has ahead" in done.stdout


def test_what_tells_of_a_fault_has_to_come_in_the_drive(tmp_path):
    """The inverter's power is not judged where the pack's voltage ends the motor's speed."""
    car = new_car(tmp_path, "emrax_228_lv", "14x8", "molicel_p45b", 180, 3)
    done, _ = verdicts(tmp_path, "--vehicle", car, "--row", "current_zero")
    assert done.returncode == 3 and "by which the fault is told" in done.stdout
