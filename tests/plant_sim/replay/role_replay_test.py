# SPDX-License-Identifier: Apache-2.0
"""Logs replayed by role: tables that the test makes from a cell that it knows, and what is planted in them is found."""
import pytest
from straight_pack import CELLS, MAP, PACK, RATE, replayed, rows, voltlap


def test_a_sound_log_is_agreed_with(tmp_path):
    run, out = replayed(tmp_path, rows(60))
    assert out["faults"] == [] and out["limit_violations"] == [] and out["over_limits"] == []
    assert out["duration_s"] == pytest.approx(59.98, abs=0.03)
    assert out["soc_start_pct"] == pytest.approx(80.0, abs=0.05)
    assert out["soc_end_pct"] == pytest.approx(out["soc_logged_end_pct"], abs=0.05)
    assert out["soc_end_pct"] < 73.0  # there was something to count
    assert "faults            none" in run.stdout


def test_every_sample_has_a_verdict(tmp_path):
    table = [dict(row, cell_voltage_3_v=6.5) if row["time_s"] == 7.0 else row for row in rows(20)]
    _, out = replayed(tmp_path, table)
    verdicts = out["frames_by_verdict"]
    assert out["frames"] == sum(verdicts.values()) == len(table) * (CELLS + 4)
    assert verdicts["corrupt"] == 1
    assert {"impossible value"} == {defect["kind"] for defect in out["defects"]}


def test_a_weak_cell_is_limited_and_its_stretch_is_named(tmp_path):
    """Cell 5 has 8 points less than the others: its limit is (3.32 V - 3.1 V) / R."""
    def weak(row):
        return dict(row, cell_voltage_5_v=row["cell_voltage_5_v"] - 0.08)

    run, out = replayed(tmp_path, (weak(row) for row in rows(9, soc=0.40)))
    violation = out["limit_violations"][0]
    assert violation["cell"] == 5 and violation["limit_v"] == pytest.approx(3.1)
    assert violation["time_s"] == pytest.approx(5.0, abs=0.03)
    over = out["over_limits"][0]
    assert over["cell"] == 5 and over["reason"] == "CellVoltage"
    assert over["limit_a"] == pytest.approx(220.0 / 3.0, abs=2.0)
    assert "cell 5 falls to" in run.stdout


def test_a_lost_current_trips_and_the_log_goes_on(tmp_path):
    """Nothing is held longer than the firmware's own patience, whatever the rate of the table."""
    table = [dict(row, current_a=None) if 8.0 <= row["time_s"] < 17.0 else row for row in rows(40)]
    _, out = replayed(tmp_path, table)
    lost = [fault for fault in out["faults"] if fault["id"] == "CurrentMeasurementLost"]
    assert len(lost) == 1 and lost[0]["opens"]
    assert lost[0]["time_s"] == pytest.approx(8.5, abs=0.15)
    assert len([fault for fault in out["faults"] if fault["opens"]]) == 1
    assert out["disagreements"][0]["what"].startswith("the firmware opens the contactors at 8.")


def test_a_trip_where_the_car_stands_is_not_said_to_be_driven_through(tmp_path):
    table = [dict(row, current_a=None) if 8.0 <= row["time_s"] < 9.0 else row
             for row in rows(20, current=lambda time: 80.0 if 5.0 <= time < 7.5 else 0.0)]
    _, out = replayed(tmp_path, table)
    assert out["disagreements"][0]["what"].endswith("CurrentMeasurementLost; no current flowed then")


def test_a_logged_soc_that_jumps_is_not_believed(tmp_path):
    table = [dict(row, soc=row["soc"] + 0.24) if 11.0 <= row["time_s"] < 12.0 else row for row in rows(30, soc=0.7)]
    run, out = replayed(tmp_path, table)
    jump = out["soc_jump"]
    assert abs(jump["to_pct"] - jump["from_pct"]) == pytest.approx(24.0, abs=1.0)
    assert 10.9 <= jump["begin_s"] <= jump["end_s"] <= 14.1
    assert "the logged SOC jumps" in run.stdout
    assert out["soc_end_pct"] == pytest.approx(out["soc_logged_end_pct"], abs=0.05)


def test_a_limit_of_the_cars_own_unit_stands_beside(tmp_path):
    run, out = replayed(tmp_path, (dict(row, dcl=120.0) for row in rows(20)))
    what = [entry["what"] for entry in out["disagreements"]]
    assert any(text.startswith("discharge limit 2") and "120 A by the log's own unit" in text for text in what), what


def test_without_a_pack_nothing_is_said_of_soc_and_limits(tmp_path):
    run, out = replayed(tmp_path, rows(20), pack=None)
    assert out["pack"] == "no cell model"
    assert out["soc_start_pct"] is None and out["soc_end_pct"] is None
    assert run.stdout.count("no cell model (--pack)") == 3
    assert out["faults"] == [] and out["over_limits"] == []


def test_cells_that_are_read_slowly_follow_the_pack(tmp_path):
    """A row of cells every two seconds: between them the firmware would call them lost."""
    def slow(row):
        keep = round(row["time_s"] * RATE) % (2 * RATE) == 0
        return {name: value if keep or "cell" not in name else None for name, value in row.items()}

    run, out = replayed(tmp_path, (slow(row) for row in rows(60)))
    assert out["faults"] == []
    assert any("a cell is read every 2 s" in text for text in out["assumptions"])
    assert out["soc_end_pct"] == pytest.approx(out["soc_logged_end_pct"], abs=0.05)


REFUSED = [
    ({"drop": "current_a"}, "no column"),
    ({"pack": PACK.replace(f"cells_in_series = {CELLS}", "cells_in_series = 23")}, "23 cells in series"),
]


@pytest.mark.parametrize("what, words", REFUSED)
def test_what_cannot_be_replayed_is_refused_with_the_reason(tmp_path, what, words):
    log, cut, pack = tmp_path / "log.csv", tmp_path / "map.toml", tmp_path / "pack.toml"
    table = [{name: value for name, value in row.items() if name != what.get("drop")} for row in rows(2)]
    log.write_text("\n".join([",".join(table[0])] + [",".join(map(str, row.values())) for row in table]) + "\n")
    cut.write_text(MAP)
    pack.write_text(what.get("pack", PACK))
    run = voltlap("replay", log, "--map", cut, "--pack", pack)
    assert run.returncode == 2 and words in run.stderr, run.stderr


def test_a_baseline_shows_what_has_changed_and_nothing_else(tmp_path):
    table = list(rows(20))
    replayed(tmp_path, table)
    before = tmp_path / "before.json"
    (tmp_path / "replay.json").rename(before)
    run, _ = replayed(tmp_path, table, "--baseline", before)
    assert "Nothing has changed" in run.stdout
    again = voltlap("replay", tmp_path / "log.csv", "--map", tmp_path / "map.toml", "--pack", tmp_path / "pack.toml",
                    "--baseline", before, "--set", "bms.capacity_ah=8")
    assert again.returncode == 1
    changed = [line.strip() for line in again.stdout.split("Changed since")[1].splitlines()[1:]]
    assert any(line.startswith("soc_end_pct: 78.") for line in changed), changed
    assert not any(line.startswith(("frames", "duration_s", "soc_start_pct")) for line in changed), changed
    cut = tmp_path / "map.toml"
    refused = voltlap("replay", tmp_path / "log.csv", "--map", cut, "--baseline", cut)
    assert refused.returncode == 2 and "no result of a replay" in refused.stderr
