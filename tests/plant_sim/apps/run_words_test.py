# SPDX-License-Identifier: Apache-2.0
"""What a run says of itself beside its numbers: what stopped the torque, what the BMS does not know."""
import csv
import json
import os
import pathlib
import random
import re
import subprocess

import pytest

BUILD = pathlib.Path(os.environ["VOLTLAP_BUILD_DIR"])
SEED = int(os.environ.get("VOLTLAP_TEST_SEED", "1"))


def voltlap(*arguments):
    return subprocess.run([BUILD / "bin" / "voltlap", *map(str, arguments)], capture_output=True, text=True,
                          timeout=300)


def rows_of(path):
    lines = [line for line in path.read_text().splitlines() if not line.startswith("#")]
    return list(csv.DictReader(lines))


def test_torque_that_ends_with_the_dc_link_is_said(tmp_path):
    """The inverter is off below its least voltage, which no limit knows: drawn voltages just below the pack's."""
    draw = random.Random(SEED)
    least = draw.uniform(91.0, 93.0)
    run = voltlap("endurance", "--laps", 2, "--set", f"inverter.dc_voltage_min_v={least:.2f}", "--json",
                  tmp_path / "o.json")
    told = json.loads((tmp_path / "o.json").read_text())
    case = f"VOLTLAP_TEST_SEED={SEED}, {least:.2f} V: {run.stdout}"
    assert (told["dc_link_below_inverter"] > 0) == ("fell below inverter.dc_voltage_min_v" in run.stdout), case
    assert told["dc_link_below_inverter"] > 0, case
    sound = voltlap("endurance", "--laps", 1, "--json", tmp_path / "sound.json")
    assert json.loads((tmp_path / "sound.json").read_text())["dc_link_below_inverter"] == 0
    assert "dc_voltage_min_v" not in sound.stdout


def test_a_bms_without_a_charge_writes_none(tmp_path):
    run = voltlap("endurance", "--laps", 1, "--set", "bms.soc_method=none", "--json", tmp_path / "o.json", "--csv",
                  tmp_path / "o.csv", "--report", tmp_path / "o.html")
    assert run.returncode == 0, run.stderr
    assert json.loads((tmp_path / "o.json").read_text())["bms_soc_error_pct"] is None
    assert {row["bms_soc"] for row in rows_of(tmp_path / "o.csv")} == {""}
    page = (tmp_path / "o.html").read_text()
    assert "keeps no count" in page and "estimate off by" not in page


@pytest.mark.parametrize("key, value", [("bms.soc_derating_start", 0.5), ("bms.energy_to_go_km", 22)])
def test_what_needs_a_charge_is_refused_without_one(key, value):
    run = voltlap("endurance", "--laps", 1, "--set", "bms.soc_method=none", f"{key}={value}")
    assert run.returncode == 2 and key in run.stderr and "coulomb" in run.stderr and run.stdout == ""


def test_the_current_of_a_power_is_that_of_the_voltage_that_it_leaves():
    """Drawn packs: I (V - R I) = P with what the same page says of V and P, so that I is more than P / V."""
    draw = random.Random(SEED)
    for _ in range(6):
        series, parallel = draw.randint(60, 130), draw.randint(1, 8)
        cell = draw.choice(["molicel_p45b", "samsung_30q", "sony_vtc6", "lg_m50lt"])
        run = voltlap("list", "car", "--set", f"battery.cell={cell}", f"battery.cells_in_series={series}",
                      f"battery.cells_in_parallel={parallel}", f"sensors.temperature_count={min(36, series)}")
        case = f"VOLTLAP_TEST_SEED={SEED}, {series} x {parallel} {cell}: {run.stdout}{run.stderr}"
        assert run.returncode == 0, case
        half = float(re.search(r"V full, (\d+) V at half", run.stdout).group(1))
        allowed, power, current = map(float, re.search(r"(\d+) A allowed; (\d+) kW take (\d+) A", run.stdout).groups())
        assert current >= 1000 * (power - 0.5) / half - 1, case
        assert current <= allowed + 1 and current * half / 2 <= 1000 * (power + 0.5) + half, case
