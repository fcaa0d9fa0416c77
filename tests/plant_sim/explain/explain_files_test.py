# SPDX-License-Identifier: Apache-2.0
"""What voltlap explain writes: the race in --json, models that other commands take, and nothing half-written."""
import json
import os
import random
import re
import secrets
import signal
import subprocess
import time

import pytest
from drives import VOLTLAP, Drives, contact, explained, one_cell, voltlap, write

PACK = """[battery]
cell = "aesc_e5_2p"
cells_in_series = 24
cells_in_parallel = 1
lookup_current_floor_a = 5.0
"""


@pytest.fixture(scope="module")
def drive(tmp_path_factory):
    return Drives(tmp_path_factory.mktemp("drives"))


@pytest.fixture
def pack(tmp_path):
    path = tmp_path / "pack.toml"
    path.write_text(PACK)
    return path


def endurance(folder, *arguments):
    out = folder / "endurance.json"
    voltlap("endurance", *arguments, "--json", out)
    return json.loads(out.read_text())


def bms_resistance(folder, cell):
    """uOhm at half charge in the tables that a BMS image is built with."""
    header = folder / "pack.hpp"
    voltlap("firmware-tables", cell, "--out", header)
    numbers = re.search(r"kResistance\[\] = \{.*?\n(.*?)\};", header.read_text(), re.DOTALL)[1]
    return int(re.findall(r"\d+", numbers)[10])


def test_the_race_is_driven_with_a_report_and_is_what_endurance_drives(tmp_path, drive):
    rows, extended = drive("cell.effects.series_ohm=0.0003"), tmp_path / "extended.toml"
    assert explained(tmp_path, rows)["prediction"] is None
    race = explained(tmp_path, rows, "--report", tmp_path / "r.html", "--write-model", extended)["prediction"]
    assert race["laps"] == 27 and race["left_out"] == [] and race["impossible"] is None
    for when, car in (("before", "vtm16e"), ("after", extended)):
        driven = endurance(tmp_path, "--vehicle", car)
        assert race[when]["end_soc"] == pytest.approx(driven["end_soc_pct"] / 100, abs=1e-9)
        assert race[when]["temperature_max_c"] == pytest.approx(driven["max_battery_temp_c"], abs=1e-9)
        assert race[when]["cell_voltage_min_v"] == pytest.approx(driven["min_cell_voltage_v"], abs=1e-9)
        assert race[when]["bms_soc_error_max"] == pytest.approx(driven["bms_soc_error_pct"] / 100, abs=1e-9)
    assert race["after"]["temperature_max_c"] > race["before"]["temperature_max_c"] + 1


def test_a_bms_with_old_tables_errs_in_its_soc_and_one_with_the_new_ones_does_not(tmp_path, drive):
    race = explained(tmp_path, drive("battery.capacity_ah=48", laps=12), "--report", tmp_path / "r.html")["prediction"]
    assert abs(race["after"]["bms_soc_error_end"]) < 0.01
    assert race["after_with_given_bms"]["bms_soc_error_end"] > 0.05  # it believes in charge that is not there


def test_an_extended_pack_file_drives_the_standard_car(tmp_path, drive, pack):
    extended = tmp_path / "elsewhere" / "extended.toml"
    extended.parent.mkdir()
    answer = explained(tmp_path, drive("cell.effects.series_ohm=0.0003"), "--write-model", extended, model=pack)
    assert answer["extended_model"] == str(extended)
    as_given, driven = (endurance(tmp_path, "--vehicle", car, "--laps", 2) for car in (pack, extended))
    assert as_given["max_battery_temp_c"] < driven["max_battery_temp_c"]
    assert as_given["min_pack_voltage_v"] > driven["min_pack_voltage_v"] + 1


def test_an_extended_cell_file_drives_and_is_validated(tmp_path, drive):
    rows, extended = one_cell(drive("cell.effects.series_ohm=0.0003")), tmp_path / "extended.toml"
    explained(tmp_path, rows, "--write-model", extended, model="aesc_e5_2p")
    log = tmp_path / "log.csv"
    assert bms_resistance(tmp_path, extended) == pytest.approx(bms_resistance(tmp_path, "aesc_e5_2p") + 300, abs=30)
    errors = []
    for cell in ("aesc_e5_2p", extended):
        voltlap("validate", cell, log, "--json", tmp_path / "v.json")
        errors.append(json.loads((tmp_path / "v.json").read_text())["files"][0]["rms_v"])
    assert errors[1] < 0.5 * errors[0]
    driven = endurance(tmp_path, "--set", f"battery.cell={extended}", "--laps", 2)
    assert driven["min_cell_voltage_v"] < endurance(tmp_path, "--laps", 2)["min_cell_voltage_v"] - 0.02


@pytest.mark.parametrize("setting", ["battery.cells.7.resistance_scale=1.25", "battery.contact_resistance_ohm=0.006"])
def test_a_weak_cell_and_a_contact_stand_in_the_extended_model(tmp_path, drive, setting):
    rows, extended = drive(setting), tmp_path / "extended.toml"
    if "contact" in setting:
        rows = contact(drive(), 0.006)
    assert explained(tmp_path, rows, "--write-model", extended)["verdict"] == "named"
    key, value = setting.split("=")
    driven = {when: endurance(tmp_path, "--laps", 2, "--vehicle", car, *more)["min_pack_voltage_v"]
              for when, car, more in (("found", extended, ()), ("true", "vtm16e", ("--set", setting)),
                                      ("given", "vtm16e", ()))}
    assert driven["found"] == pytest.approx(driven["true"], abs=0.1 * abs(driven["true"] - driven["given"]))


def test_a_cause_in_a_sensor_changes_no_model_and_none_is_written(tmp_path, drive):
    rows, extended = contact(drive(), -0.006), tmp_path / "extended.toml"
    log = write(tmp_path / "log.csv", rows)
    run = voltlap("explain", log, "--model", "vtm16e", "--write-model", extended)
    assert "No extended model: the cause is in a sensor" in run.stdout and not extended.exists()


def test_gain_is_measured_on_a_second_log_when_there_is_one(tmp_path, drive):
    second = write(tmp_path / "second.csv", contact(drive(), 0.012))
    answer = explained(tmp_path, contact(drive(), 0.006), "--holdout", second)
    gain = answer["gain"]["pack_voltage"]
    # The second log has twice the contact: what the first one says takes half of it away.
    assert gain["heldout_rms_after"] / gain["heldout_rms_before"] == pytest.approx(0.5, abs=0.03)


# ---- errors ----

def refused(*arguments, folder, code=2):
    before = sorted(path.name for path in folder.iterdir())
    run = voltlap("explain", *arguments, code=code)
    assert sorted(path.name for path in folder.iterdir()) == before
    return run.stderr


@pytest.mark.parametrize("flags, words", [
    (["--model", "ghost"], ["--model", "ghost", "neither a known name nor a file"]),
    (["--model", "amk_4wd"], ["--model amk_4wd", "a car with 4 motors", "one motor on the rear axle"]),
    (["--model", "vtm16e", "--map", "ghost"], ["ghost"]),
    (["--model", "vtm16e", "--json", "no_folder/x.json"], ["no_folder/x.json", "existing folder"]),
    (["--model", "vtm16e", "--json", "x", "--report", "x"], ["--json, --report", "one file for both"]),
    (["--model", "vtm16e", "--reference", "ghost.csv"], ["ghost.csv"]),
])
def test_what_cannot_be_read_or_written_is_refused_with_a_way_out(tmp_path, drive, flags, words):
    log = write(tmp_path / "log.csv", drive())
    said = refused(log, *flags, folder=tmp_path)
    assert all(word in said for word in words), said


@pytest.mark.parametrize("draw", range(6))
def test_a_pack_of_another_number_of_cells_is_refused_and_its_own_is_not(tmp_path, draw):
    seed = secrets.randbits(32)
    drawn = random.Random(seed)
    cells = drawn.randrange(12, 140)
    wrong = drawn.choice([round(cells * drawn.uniform(0.5, 0.96)), round(cells * drawn.uniform(1.04, 2.0)) + 1])
    rows = []
    for second in range(600):
        current = 0.0 if second // 20 % 2 else 60.0
        volts = [3.9 - 0.002 * current - 1e-5 * second + drawn.gauss(0, 5e-4) for _ in range(cells)]
        rows.append({"time_s": second, "current_a": current,
                     "pack_voltage_v": sum(volts) * drawn.gauss(1.005, 2e-4),
                     **{f"cell_voltage_{i + 1}_v": round(v, 4) for i, v in enumerate(volts)}})
    log = write(tmp_path / "log.csv", rows)
    model = ("--model", "aesc_e5_2p", "--set")
    said = refused(log, *model, f"battery.cells_in_series={wrong}", folder=tmp_path)
    assert f"{cells} cell" in said and f"model's {wrong} cells" in said, f"seed {seed}: {said}"
    voltlap("explain", log, *model, f"battery.cells_in_series={cells}", code=0)
    # A sound log with a reference of another pack.
    other = write(tmp_path / "other.csv", [{**row, "pack_voltage_v": 0.5 * row["pack_voltage_v"]} for row in rows])
    said = refused(log, *model, f"battery.cells_in_series={cells}", "--reference", other, folder=tmp_path)
    assert "other.csv" in said and "times its mean cell" in said, f"seed {seed}: {said}"


def test_a_log_too_calm_says_so_and_what_drive_would_tell(tmp_path):
    rows = [{"time_s": 0.1 * k, "current_a": 5.0, "voltage_v": 4.1} for k in range(3000)]
    answer = explained(tmp_path, rows, "--report", tmp_path / "r.html", model="aesc_e5_2p")
    assert answer["verdict"] == "bad_data" and "too calm" in answer["sentence"] and "hard pulls" in answer["next_test"]
    assert answer["prediction"] is None and "hard pulls" in (tmp_path / "r.html").read_text()


def test_no_output_takes_the_place_of_an_input(tmp_path, drive, pack):
    log = write(tmp_path / "log.csv", drive()[:600])
    text = log.read_text()
    for flag, path, model in (("--report", log, "vtm16e"), ("--write-model", pack, pack)):
        assert "left as it is" in refused(log, "--model", model, flag, path, folder=tmp_path)
    assert log.read_text() == text and pack.read_text() == PACK


def test_an_interrupt_leaves_nothing_behind(tmp_path, drive):
    log = write(tmp_path / "log.csv", drive("cell.effects.series_ohm=0.0003"))
    before = sorted(os.listdir(tmp_path))
    run = subprocess.Popen([VOLTLAP, "explain", log, "--model", "vtm16e", "--report", tmp_path / "r.html", "--json",
                            tmp_path / "r.json", "--write-model", tmp_path / "m.toml"],
                           stderr=subprocess.PIPE, text=True)
    deadline = time.monotonic() + 20
    while len(os.listdir(tmp_path)) < len(before) + 3 and time.monotonic() < deadline:
        time.sleep(0.005)
    run.send_signal(signal.SIGINT)
    assert run.wait(timeout=20) == 130 and "no result file was written" in run.stderr.read()
    assert sorted(os.listdir(tmp_path)) == before


def test_candump_csv_and_mf4_of_one_run_get_one_answer(tmp_path):
    seed = int(os.environ.get("VOLTLAP_TEST_SEED", secrets.randbelow(2**32)))
    print(f"VOLTLAP_TEST_SEED={seed}")
    ohms = random.Random(seed).uniform(1.5e-4, 6e-4)
    log, table, mf4 = (tmp_path / f"run.{suffix}" for suffix in ("log", "csv", "mf4"))
    effect = f"cell.effects.series_ohm={ohms:.6f}"
    voltlap("endurance", "--laps", "3", "--set", effect, "--candump", log, "--csv", table)
    voltlap("log", "convert", log, "--out", mf4)
    answers = []
    for recording in (log, table, mf4):
        out = tmp_path / "answer.json"
        voltlap("explain", recording, "--model", "vtm16e", "--seed", "1", "--json", out)
        answers.append(json.loads(out.read_text()))
    assert [(answer["verdict"], [cause["name"] for cause in answer["causes"]]) for answer in answers] == [
        ("named", ["series_resistance"])] * 3
    by_log, by_table, by_mf4 = (answer["causes"][0]["parameters"]["resistance_ohm"]["value"] for answer in answers)
    assert by_mf4 == by_log and by_table == pytest.approx(by_log, rel=0.01) and by_log == pytest.approx(ohms, rel=0.01)
