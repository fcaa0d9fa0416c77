# SPDX-License-Identifier: Apache-2.0
"""voltlap validate as its users meet it, and the whole way from a test on the bench to the car."""
import csv
import gzip
import json
import os
import pathlib
import re
import subprocess

import pytest

BINARY = pathlib.Path(os.environ["VOLTLAP_BUILD_DIR"]) / "bin" / "voltlap"
CELL = "aesc_e5_2p"
# Four cells as the file says them, instruments that only have noise and steps.
IDEAL = ("--set", "cells.capacity_scale=[1.0, 1.0, 1.0, 1.0]", "cells.resistance_scale=[1.0, 1.0, 1.0, 1.0]",
         "cells.soc_offset=[0.0, 0.0, 0.0, 0.0]", "instruments.systematic=false")


def voltlap(command, *arguments, code=0, folder=None):
    run = subprocess.run([BINARY, command, *map(str, arguments)], cwd=folder, capture_output=True, text=True,
                         timeout=300)
    assert run.returncode == code, run.stderr
    return run


@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    """Recordings of the virtual bench: random resistors with the temperature held and free, and pulses."""
    folder = tmp_path_factory.mktemp("bench")
    for plan in ("random_resistors", "random_resistors_free"):
        voltlap("bench-test", plan, "--cell", CELL, *IDEAL, "--out", folder / plan)
    voltlap("bench-test", "pulse_15", "--cell", CELL, *IDEAL, "--set", "test.temperature_c=30", "--set",
            "test.current_a=200", "--out", folder / "pulse")
    return folder


def table(folder):
    return next(folder.glob("*_cell1.csv"))


def validated(folder, *arguments):
    run = voltlap("validate", CELL, *arguments, "--json", folder / "v.json")
    return run.stdout, json.loads((folder / "v.json").read_text())


def test_true_cell_is_met_down_to_the_instruments(bench, tmp_path):
    _, found = validated(tmp_path, table(bench / "random_resistors"), table(bench / "random_resistors_free"))
    held, free = found["files"]
    assert held["rms_v"] < 5e-3 and free["rms_v"] < 5e-3
    assert held["temperature"] == "held" and free["temperature"] == "free"
    assert not held["constant_current"] and set(found["kinds"]) == {"variable_current", "variable_temperature"}
    assert abs(held["capacity_adjustment_ah"]) < 0.3


def test_numbers_of_the_study_stand_beside(bench, tmp_path):
    text, found = validated(tmp_path, table(bench / "random_resistors_free"), "--full")
    for number in ("64.6 mV", "19.2 mV", "60.1 mV", "-0.00099", "-1.4", "(192.8)", "747", "-0.27 mV", "706",
                   "0.0014 %"):
        assert number in text, number
    assert set(found) >= {"files", "kinds", "reductions", "sensitivity", "thermal", "pack"}
    # The bench knows this cell: per_ampere -0.00034/A about 200 A over breakpoints whose mean is 207 A.
    assert found["sensitivity"]["tables"]["r0"]["pct_per_ampere"] == pytest.approx(-0.034 / (1 - 0.00034 * 7), rel=1e-6)
    assert found["sensitivity"]["tables"]["r0"]["pct_per_kelvin"] == pytest.approx(-1.4 / (1 - 0.014 * 2 / 3), rel=1e-6)


def test_thermal_model_of_the_bench_comes_back(bench, tmp_path):
    _, found = validated(tmp_path, table(bench / "random_resistors_free"), "--thermal")
    thermal = found["thermal"]
    assert thermal["capacity_j_per_k"] == pytest.approx(1.9 * 747, rel=0.10)
    assert thermal["files"][0]["rms_fitted_c"] < 0.6  # thermistors in whole degrees
    assert {"capacity_told", "conductance_told", "entropy_told", "entropy_ci95_v_per_k",
            "not_told_apart"} <= set(thermal)
    assert thermal["files"][0]["air_from"] in ("recorded", "start after a rest", "fitted")


def test_printed_lines_in_the_cell_file_reproduce_what_was_printed(bench, tmp_path):
    recording = table(bench / "random_resistors_free")
    text, found = validated(tmp_path, recording, "--thermal")
    lines = found["thermal"]["cell_file_lines"]
    assert all(f"    {line}\n" in text for line in lines)
    source = pathlib.Path(__file__).resolve().parents[4] / "plant_sim/data/cells/aesc_e5_2p.toml"
    cell = source.read_text()
    assert "[effects]" not in cell and lines[3] == "[effects]" and lines[4].startswith("entropy_v_per_k = ")
    for line in lines[:3]:
        key = line.split(" = ")[0]
        cell, count = re.subn(rf"^{key} = .*$", line, cell, flags=re.MULTILINE)
        if count == 0:  # a number that the file leaves at its default stands above its tables
            cell = line + "\n" + cell
    (tmp_path / "pasted.toml").write_text(cell + "\n" + "\n".join(lines[3:]) + "\n")
    voltlap("validate", tmp_path / "pasted.toml", recording, "--thermal", "--json", tmp_path / "again.json")
    (again,) = json.loads((tmp_path / "again.json").read_text())["thermal"]["files"]
    assert again["rms_as_given_c"] == pytest.approx(found["thermal"]["files"][0]["rms_fitted_c"], abs=5e-3)
    assert again["rms_fitted_c"] == pytest.approx(again["rms_as_given_c"], abs=5e-3)


def test_reductions_cost_what_the_tables_hold(bench, tmp_path):
    _, found = validated(tmp_path, table(bench / "random_resistors"), "--reductions")
    rms = {row["name"]: row["rms_v"] for row in found["reductions"]}
    assert rms["r0 without current"] > rms["whole model"]
    assert "r2 without temperature" in rms and "em without current" not in rms


def test_each_map_holds_for_the_files_after_it(bench, tmp_path):
    plain = table(bench / "random_resistors")
    for name, column in (("one", "temperature_c"), ("two", "ambient_c")):
        (tmp_path / f"{name}.toml").write_text(f'''[roles]
time = {{column = "time_s", unit = "s"}}
current = {{column = "current_a", unit = "A", discharge = "+"}}
voltage = {{column = "voltage_v", unit = "V"}}
temperature_1 = {{column = "{column}", unit = "degC"}}
''')
    maps = tmp_path / "one.toml", tmp_path / "two.toml"
    _, found = validated(tmp_path, "--map", maps[0], plain, "--map", maps[1], plain)
    cell, air = (file["temperature_rms_c"] for file in found["files"])
    assert cell != air
    for arguments, expected in (((plain, plain, "--map", maps[1]), [air, air]), (("--map", maps[0], plain), [cell])):
        _, found = validated(tmp_path, *arguments)
        assert [file["temperature_rms_c"] for file in found["files"]] == expected


def test_error_over_time_is_a_table(bench, tmp_path):
    recording = table(bench / "random_resistors")
    voltlap("validate", CELL, recording, "--csv", tmp_path / "e.csv.gz")
    with gzip.open(tmp_path / "e.csv.gz", "rt") as lines:
        rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    with open(recording) as lines:
        assert len(rows) == sum(not line.startswith("#") for line in lines) - 1
    assert float(rows[5]["error_v"]) == pytest.approx(float(rows[5]["model_v"]) - float(rows[5]["voltage_v"]), abs=2e-6)
    assert rows[0]["file"] == "1" and {row["counts"] for row in rows} == {"0", "1"}


def test_json_may_take_standard_output(bench):
    run = voltlap("validate", CELL, table(bench / "random_resistors"), "--json", "-")
    assert json.loads(run.stdout)["files"] and "RMS" in run.stderr


def test_from_the_bench_to_the_car(bench, tmp_path):
    """bench-test, identify, validate on a test that was not fitted, endurance and the firmware's tables."""
    cell = tmp_path / "own_cell.toml"
    voltlap("identify", table(bench / "pulse"), "--rc", 2, "--out", cell)
    voltlap("validate", cell, table(bench / "random_resistors"), "--json", tmp_path / "v.json")
    (file,) = json.loads((tmp_path / "v.json").read_text())["files"]
    assert file["rms_v_above_10_soc"] < 12e-3
    voltlap("endurance", "--laps", 1, "--set", f"battery.cell={cell}", "--json", tmp_path / "own.json")
    voltlap("endurance", "--laps", 1, "--json", tmp_path / "true.json")
    own, true = (json.loads((tmp_path / name).read_text()) for name in ("own.json", "true.json"))
    assert own["energy_ledger_error_pct"] < 1e-3
    assert own["min_pack_voltage_v"] == pytest.approx(true["min_pack_voltage_v"], rel=0.01)
    voltlap("firmware-tables", cell, "--out", tmp_path / "pack.hpp")
    assert "cell own_cell" in (tmp_path / "pack.hpp").read_text()


ERRORS = {
    "no such cell": (("nowhere.toml", "RECORDING"), "nowhere.toml"),
    "no recording": ((CELL,), "data"),
    "one file for two": ((CELL, "RECORDING", "--json", "x", "--csv", "x"), "one file for two"),
    "pack of no cells": ((CELL, "RECORDING", "--pack", "0"), "--pack"),
    "no temperature to fit": ((CELL, "BARE", "--thermal"), "no recording with a temperature"),
    "charge alone": ((CELL, "CHARGE"), "no discharge stroke"),
}


@pytest.mark.parametrize("case", ERRORS)
def test_what_cannot_be_done_is_said(case, bench, tmp_path):
    loads = [20 if 60 <= t < 900 else 0 for t in range(1200)]
    rows = [f"{t},{i},{4.1 - 1e-4 * max(0, min(t, 900) - 60) - 0.001 * i}" for t, i in enumerate(loads)]
    (tmp_path / "bare.csv").write_text("\n".join(["time_s,current_a,voltage_v", *rows, ""]))
    rows = [f"{t},{-20 if t >= 60 else 0},{3.7 + 1e-4 * max(0, t - 60) + (t >= 60) * 0.02}" for t in range(1200)]
    (tmp_path / "charge.csv").write_text("\n".join(["time_s,current_a,voltage_v", *rows, ""]))
    places = {"RECORDING": table(bench / "random_resistors"), "BARE": "bare.csv", "CHARGE": "charge.csv"}
    arguments, words = ERRORS[case]
    run = voltlap("validate", *(places.get(word, word) for word in arguments), code=2, folder=tmp_path)
    assert words in run.stderr and "expected" in run.stderr
    assert run.stdout == ""


BROKEN_CELLS = {
    "point missing": (lambda text: text.replace("value = [0.0004, 0.0004", "value = [0.0004", 1), "r1.value"),
    "breakpoints out of order": (lambda text: text.replace("soc = [0.001, 0.05", "soc = [0.05, 0.001"),
                                 "breakpoints.soc"),
    "OCV of another size": (lambda text: text.replace("[ocv]\n", "[ocv]\ntable = [3.0, 4.0]\n"), "ocv.table"),
    "no TOML": (lambda text: text.replace("[ocv]", "[ocv"), "cell.toml"),
}


@pytest.mark.parametrize("case", BROKEN_CELLS)
def test_broken_cell_file_is_refused_with_its_place(case, bench, tmp_path):
    source = pathlib.Path(__file__).resolve().parents[4] / "plant_sim/data/cells/aesc_e5_2p.toml"
    change, words = BROKEN_CELLS[case]
    broken = change(source.read_text())
    assert broken != source.read_text()
    (tmp_path / "cell.toml").write_text(broken)
    run = voltlap("validate", "cell.toml", table(bench / "random_resistors"), code=2, folder=tmp_path)
    assert words in run.stderr and "cell.toml" in run.stderr
