# SPDX-License-Identifier: Apache-2.0
"""voltlap soc-test as its users meet it: the short form with its marks, recordings, messages for bad input."""
import json
import os
import pathlib
import subprocess

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[3]
BUILD = pathlib.Path(os.environ["VOLTLAP_BUILD_DIR"])
CELL = "aesc_e5_2p"


def soc_test(*arguments):
    return subprocess.run([BUILD / "bin" / "voltlap-learn", "soc-test", *map(str, arguments)], capture_output=True,
                          text=True, timeout=600)


@pytest.fixture(scope="module")
def short_form(tmp_path_factory):
    path = tmp_path_factory.mktemp("soc") / "soc.json"
    run = soc_test("--short", "--json", path)
    assert run.returncode == 0, run.stderr
    return run.stdout, json.loads(path.read_text())


def rows_of(result, car):
    return {row["told"]: row for drive in result["drives"] if drive["car"] == car for row in drive["rows"]}


def test_the_short_form_meets_its_marks(short_form):
    text, result = short_form
    assert len(result["drives"]) == 2 and result["marks"] == 23
    assert [row["told"] for drive in result["drives"] for row in drive["rows"] if not row["met"]] == []
    assert "marks met: 23 of 23" in text


def test_counting_alone_fails_where_the_filter_does_not(short_form):
    rows = rows_of(short_form[1], "the cells as believed")
    start = rows["start -20 points"]
    assert start["coulomb"]["pack"]["rms_points"] > 19 and start["ekf"]["pack"]["rms_points"] < 1.5
    for name in ("capacity -10 %", "current offset +1 % of the range"):
        assert rows[name]["coulomb"]["pack"]["max_points"] > 2 * rows[name]["ekf"]["pack"]["max_points"], name


def test_a_recording_is_judged_by_its_own_count(tmp_path):
    """A discharge that a straight line describes: the cell of the file, at 10 A for four hours."""
    lines = ["time_s,current_a,voltage_v"]
    coefficients = [3.00, 5.98, -14.1, 15.2, -6.79, 0.88]  # aesc_e5_2p.toml, ocv
    for second in range(0, 14400, 10):
        soc = 1.0 - 10.0 * max(0, second - 60) / 3600 / 55.2
        current = 10.0 if second >= 60 else 0.0
        volts = sum(c * soc ** k for k, c in enumerate(coefficients)) - 0.0028 * current
        lines.append(f"{second},{current},{volts:.4f}")
    (tmp_path / "discharge.csv").write_text("\n".join(lines) + "\n")
    run = soc_test("--only-data", "--cell", CELL, "--data", tmp_path / "discharge.csv", "--json", tmp_path / "o.json")
    assert run.returncode == 0, run.stderr
    recording, = json.loads((tmp_path / "o.json").read_text())["recordings"]
    assert abs(recording["begin_soc"] - 1.0) < 0.01 and abs(recording["low_soc"] - 0.277) < 0.01
    as_recorded, start_off = recording["rows"]
    assert as_recorded["coulomb"]["max_points"] < 0.5 and start_off["coulomb"]["rms_points"] > 15
    assert as_recorded["ekf"]["max_points"] < 5 and start_off["ekf"]["rms_points"] < 5


def test_a_file_that_is_not_there_is_named():
    run = soc_test("--only-data", "--cell", CELL, "--data", "nowhere.csv")
    assert run.returncode == 2 and "nowhere.csv" in run.stderr and run.stdout == ""


def test_data_needs_a_cell():
    run = soc_test("--data", "x.csv")
    assert run.returncode == 2 and "--cell" in run.stderr


def test_it_explains_itself():
    run = soc_test("--help")
    assert run.returncode == 0
    for word in ("--short", "--data", "--cell", "--json", "Exit code"):
        assert word in run.stdout


@pytest.mark.parametrize("settings, words", [
    (["battery.cells_in_parallel=9"], ["less than a tenth of the charge is drawn", "Leave --short away"]),
    (["battery.initial_soc=0.02"], ["the drive ends before a tenth", "voltlap endurance first"])])
def test_a_drive_in_which_nothing_is_judged_is_refused_and_says_why(tmp_path, settings, words):
    run = soc_test("--short", *[part for each in settings for part in ("--set", each)], "--json", tmp_path / "o.json")
    assert run.returncode == 2 and run.stdout == ""
    for word in (*words, "vtm16e, michigan_2015"):
        assert word in run.stderr
    assert not (tmp_path / "o.json").exists()
