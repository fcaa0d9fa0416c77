# SPDX-License-Identifier: Apache-2.0
"""`voltlap charge`: short charges, their files, and what it refuses."""
import csv
import json
import os
import pathlib
import re
import signal
import subprocess
import time

import pytest

PROGRAM = pathlib.Path(os.environ["VOLTLAP_BUILD_DIR"]) / "bin" / "voltlap"

# Equal cells, nearly full: seconds of computing.
SHORT = ["--from-soc", "96", "--soc-spread", "0", "--capacity-spread", "0", "--resistance-spread", "0"]


def charge(*arguments):
    return subprocess.run([PROGRAM, "charge", *map(str, arguments)], capture_output=True, text=True, timeout=300)


def test_a_short_charge_ends_full_and_leaves_all_its_files(tmp_path):
    files = {flag: tmp_path / f"charge{end}" for flag, end in
             (("--json", ".json"), ("--csv", ".csv"), ("--report", ".html"), ("--candump", ".log"))}
    done = charge(*SHORT, *(word for flag, file in files.items() for word in (flag, file)))
    assert done.returncode == 0, done.stderr
    assert "every cell is full, and all are even" in done.stdout
    result = json.loads(files["--json"].read_text())["result"]
    assert result["full"] and result["phase"] == "Full" and result["highest_cell_v"] < 4.2
    assert result["end_spread_v"] < 0.005 and result["bled_with_shutdown_open_s"] == 0
    rows = list(csv.DictReader(files["--csv"].open()))
    assert {row["phase"] for row in rows} >= {"Charging", "Resting"}
    assert max(float(row["cell_max_v"]) for row in rows) <= result["highest_cell_v"] + 1e-5
    page = files["--report"].read_text()
    assert "every cell is full" in page and "chart-spread" in page
    log = files["--candump"].read_text()
    assert re.search(r" 1806E5F4#[0-9A-F]{16}$", log, re.MULTILINE)  # 29 bits
    assert re.search(r" 18FF50E5#[0-9A-F]{16}$", log, re.MULTILINE)


def test_below_full_the_charger_is_switched_off_there():
    done = charge("--from-soc", "50", "--to-soc", "52")
    assert done.returncode == 0, done.stderr
    assert "the charge that was asked for is reached" in done.stdout


def test_a_charge_that_the_bms_breaks_off_says_why_and_ends_with_3(tmp_path):
    done = charge("--from-soc", "97", "--set", "bms.balancing_time_max_s=1", "--json", tmp_path / "x.json")
    assert done.returncode == 3
    assert "broken off: balancing took longer than bms.balancing_time_max_s" in done.stdout
    assert json.loads((tmp_path / "x.json").read_text())["result"]["reason"] == "BalancingTime"


@pytest.mark.parametrize("cells, words", [
    (-5, "the cells are too cold (coldest -5.0 degC)"),
    (50, "the cells are too hot (hottest 50.0 degC)"),
])
def test_a_pack_that_no_air_brings_back_is_given_up_at_once_and_why_is_named(cells, words, tmp_path):
    stays = ["--set", f"environment.ambient_c={cells}", f"battery.initial_temperature_c={cells}",
             "bms.temperature_max_c=48"]
    done = charge("--from-soc", "50", *stays, "--json", tmp_path / "x.json")
    assert done.returncode == 3
    assert f"not begun: {words}" in done.stdout
    result = json.loads((tmp_path / "x.json").read_text())["result"]
    assert result["time_s"] < 60 and result["temperature_max_c"] == pytest.approx(cells, abs=0.1)


def test_a_cold_pack_in_a_warm_garage_is_waited_for(tmp_path):
    cold = ["--set", "environment.ambient_c=20", "--set", "battery.initial_temperature_c=-2"]
    done = charge("--from-soc", "60", "--to-soc", "65", *cold, "--json", tmp_path / "x.json")
    assert done.returncode == 0, done.stdout
    assert json.loads((tmp_path / "x.json").read_text())["result"]["waiting_s"] > 60


@pytest.mark.parametrize("flags, words", [
    (["--to-soc", "5"], ["--to-soc", "more than --from-soc"]),
    (["--set", "bms.charger_current_max_a=0"], ["bms.charger_current_max_a", "no charger"]),
    (["--set", "bms.charger_current_max_a=0.05"], ["bms.charger_current_max_a", "0.1 A"]),
    (["--set", "bms.charge_current_end_a=40"], ["bms.charge_current_end_a", "bms.charger_current_max_a"]),
    (["--set", "bms.charge_margin_v=0.3"], ["bms.charge_margin_v", "0.2 V"]),
    (["--set", "bms.balancing_time_max_s=900000"], ["bms.balancing_time_max_s", "864000 s"]),
    (["--from-soc", "101"], ["--from-soc", "101"]),
    (["--json", "a.json", "--csv", "a.json"], ["one file for two results"]),
])
def test_what_it_refuses_is_told(flags, words):
    refused = charge(*flags)
    assert refused.returncode == 2
    for word in words:
        assert word in refused.stderr, refused.stderr


def test_an_interrupted_charge_leaves_no_file(tmp_path):
    process = subprocess.Popen([PROGRAM, "charge", "--json", tmp_path / "a.json"], stderr=subprocess.PIPE,
                               stdout=subprocess.PIPE, text=True)
    time.sleep(1.0)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=20)
    assert process.returncode == 130 and "no result file was written" in errors
    assert list(tmp_path.iterdir()) == []
