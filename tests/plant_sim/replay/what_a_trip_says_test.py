# SPDX-License-Identifier: Apache-2.0
"""A trip of a drive, of a car that stands, of the recorder and of the replay are different things, and are said and
ranked as what they are; so are another pack's file, a fault of the car's own unit, what was learned of each cell."""
import os
import random
import re

import pytest
from straight_pack import CAPACITY, CELLS, MAP, PACK, replayed, rows

SEED = int(os.environ.get("VOLTLAP_TEST_SEED", "20261127"))
RNG = random.Random(SEED)


def whats(out):
    return [entry["what"] for entry in out["disagreements"]]


@pytest.mark.parametrize("length", [RNG.uniform(1.2, 8.0) for _ in range(3)])
def test_a_hole_of_the_recorder_is_no_fault_of_the_car(tmp_path, length):
    """In the hole the current flows on; a cell's limit that is passed elsewhere ranks before it."""
    table = [row for row in rows(40) if not 21.0 <= row["time_s"] < 21.0 + length]
    low = {"cell_voltage_7_v": 3.05}
    table = [{**row, **low} if 33.0 < row["time_s"] < 33.5 else row for row in table]
    _, out = replayed(tmp_path, table)
    assert "cell 7 falls to 3.050 V" in whats(out)[0], whats(out)
    hole = [what for what in whats(out) if "the recording has a hole there" in what]
    said = [float(re.search(r"hole there, ([\d.]+) s", what).group(1)) for what in hole]
    assert said and said == pytest.approx([length] * len(said), abs=0.11), (SEED, whats(out))  # in tenths, between rows


def test_a_trip_of_a_car_that_stands_ranks_behind_a_cell_beyond_its_limit(tmp_path):
    def row_of(row):
        lost = {"current_a": None} if 28.0 <= row["time_s"] < 29.0 else {}
        return {**row, **lost, **({"cell_voltage_7_v": 3.05} if 13.0 < row["time_s"] < 13.5 else {})}

    _, out = replayed(tmp_path, map(row_of, rows(40, current=lambda time: 60.0 if 5.0 <= time < 20.0 else 0.0)))
    assert "cell 7 falls to" in whats(out)[0] and "no current flowed then" in " ".join(whats(out)[1:]), whats(out)


def test_a_car_that_is_switched_off_has_no_low_cell(tmp_path):
    """The last ten seconds: no current, the bus at nothing."""
    off = {f"cell_voltage_{n}_v": None for n in range(1, CELLS + 1)}
    off |= {"pack_voltage_v": 0.4, "current_a": 0.0}
    table = [{**row, **off} if row["time_s"] >= 30.5 else row for row in rows(40)]
    _, out = replayed(tmp_path, table)
    assert out["faults"] == [] and out["duration_s"] == pytest.approx(30.5, abs=0.1)
    assert any("high voltage is off there" in text for text in out["assumptions"])


def test_a_pack_voltage_that_is_lost_under_current_is_no_car_switched_off(tmp_path):
    table = [{**row, "pack_voltage_v": 0.4} if row["time_s"] >= 30.5 else row
             for row in rows(40, current=lambda time: 0.0 if time < 5 else 40.0)]
    _, out = replayed(tmp_path, table)
    assert out["duration_s"] == pytest.approx(40.0, abs=0.1) and out["faults"] != []


def test_a_fault_right_after_the_replay_closed_under_load_is_its_own(tmp_path):
    """Load without a pause: the firmware is started again under it, whether it trips at once or not."""
    table = [dict(row, current_a=None) if 8.0 <= row["time_s"] < 9.0 else row
             for row in rows(30, current=lambda time: 0.0 if time < 5 else 60.0)]
    _, out = replayed(tmp_path, table)
    assert "CurrentMeasurementLost; current flowed on" in whats(out)[0]
    for what in whats(out)[1:]:
        assert "opens the contactors" not in what or "which no car does" in what, whats(out)


@pytest.mark.parametrize("n", RNG.sample([1, 2, 3, 4], 2))
def test_a_lost_thermistor_has_a_name(tmp_path, n):
    def hot(row):
        warm = {f"temperature_{k}_c": 30.0 for k in range(1, 5)}
        if row["time_s"] > 12.0:
            warm[f"temperature_{n}_c"] = None
        return {**row, **warm}

    table = [hot(row) for row in rows(40)]
    four = MAP.replace('temperature_1 = {column = "temperature_1_c", unit = "degC"}',
                       '"temperature_<n>" = {column = "temperature_<n>_c", unit = "degC"}')
    _, out = replayed(tmp_path, table, map_text=four)
    lost = [fault for fault in out["faults"] if fault["id"] == "TemperatureMeasurementLost"]
    assert lost and lost[0]["about"] == f"temperature_{n}", (SEED, out["faults"])


@pytest.mark.parametrize("factor, found", [(1.0, False), (0.95, False), (2.2, True), (0.4, True)])
def test_a_pack_of_another_capacity_is_doubted(tmp_path, factor, found):
    pack = PACK.replace(f"capacity_ah = {CAPACITY}", f"capacity_ah = {CAPACITY * factor:.3f}")
    _, out = replayed(tmp_path, rows(240, soc=0.9), pack=pack)
    assert any("another cell or capacity" in what for what in whats(out)) == found, whats(out)


@pytest.mark.parametrize("climbs_v", [0.0, RNG.uniform(0.15, 0.4)])
def test_cells_that_climb_while_charge_is_drawn_are_said_and_do_not_lead_the_soc(tmp_path, climbs_v):
    """Cells that climb under discharge, as those of another chemistry seem to beside the wrong curve."""
    pack = PACK.replace("[bms]", '[bms]\nsoc_method = "ekf"')

    def climbing(row):
        added = climbs_v * row["time_s"] / 120.0
        weight = {name: 1.0 for name in row if name.startswith("cell_")} | {"pack_voltage_v": CELLS}
        return {name: value + added * weight.get(name, 0.0) for name, value in row.items()}

    _, out = replayed(tmp_path, map(climbing, rows(120, soc=0.5)), pack=pack)
    assert any("mV from the open-circuit voltage of" in what for what in whats(out)) == (climbs_v > 0.0), whats(out)
    if climbs_v > 0.0:
        pairs = re.findall(r"SOC ([\d.]+) % by the firmware, ([\d.]+) % by the log", " ".join(whats(out)))
        firmware, log = map(float, pairs[0])
        assert log - 1.0 < firmware < 45.0, (SEED, whats(out))  # 50 at the start


def test_a_fault_of_the_cars_own_unit_stands_beside_those_of_the_firmware(tmp_path):
    table = [dict(row, dtc=4.0 if 12.0 <= row["time_s"] < 15.0 else 0.0) for row in rows(30)]
    run, out = replayed(tmp_path, table, map_text_more='fault_1 = {column = "dtc"}\n')
    assert [(fault["role"], fault["value"]) for fault in out["logged_faults"]] == [("fault_1", 4.0)]
    assert out["logged_faults"][0]["time_s"] == pytest.approx(12.0)
    assert any("the log's own unit says fault_1 = 4" in what for what in whats(out)), whats(out)


def test_each_cell_has_the_resistance_and_the_capacity_that_were_learned(tmp_path):
    """One cell resists by half more; drives of two minutes tell it."""
    weak = RNG.randrange(1, CELLS + 1)
    pack = PACK.replace("[bms]", '[bms]\nsoc_method = "ekf"')

    def row_of(row):
        volts = row[f"cell_voltage_{weak}_v"] - 0.0015 * row["current_a"]
        return {**row, f"cell_voltage_{weak}_v": volts}

    run, out = replayed(tmp_path, (row_of(row) for row in rows(150, soc=0.95)), pack=pack)
    cells = out["cells_end"]
    assert [cell["cell"] for cell in cells] == list(range(1, CELLS + 1))
    highest = max(cells, key=lambda cell: cell["resistance_of_pack_file"])
    assert highest["cell"] == weak, (SEED, weak)
    others = [cell["resistance_of_pack_file"] for cell in cells if cell["cell"] != weak]
    ratio = highest["resistance_of_pack_file"] / (sum(others) / len(others))
    assert ratio == pytest.approx(1.5, abs=0.1), (SEED, ratio)
    assert f"highest: cell {weak}" in run.stdout
    assert all(cell["capacity_sd_ah"] > 0.0 and cell["resistance_sd"] > 0.0 for cell in cells)


def test_what_the_log_has_no_cell_of_is_not_said_to_be_within_limits(tmp_path):
    bare = [{name: value for name, value in row.items() if not name.startswith("cell_")} for row in rows(20)]
    run, _ = replayed(tmp_path, bare, map_text=MAP.replace('"cell_voltage_<n>"', '# "cell_voltage_<n>"'))
    assert "the log has no reading of a cell" in run.stdout and "throughout" not in run.stdout
