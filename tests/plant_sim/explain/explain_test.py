# SPDX-License-Identifier: Apache-2.0
"""voltlap explain on logs of the plant itself: what was changed is named with its size, what was not is left alone, and
the same log in other clothes gets the same answer."""
import math
import pathlib
import random
import shlex
import subprocess

import pytest
from drives import VOLTLAP, Drives, comes_and_goes, contact, explained, lagging, stuck, voltlap, write


@pytest.fixture(scope="module")
def drive(tmp_path_factory):
    return Drives(tmp_path_factory.mktemp("drives"))


def only_cause(answer):
    assert answer["verdict"] == "named", answer["sentence"]
    assert len(answer["causes"]) == 1
    return answer["causes"][0]


def value(cause, name):
    return cause["parameters"][name]["value"]


def test_a_drive_as_the_model_has_it_shows_no_discrepancy(tmp_path, drive):
    answer = explained(tmp_path, drive())
    assert answer["verdict"] == "no_discrepancy"
    assert answer["causes"] == [] and answer["masked"] == [] and answer["mode"] == "absolute"


@pytest.mark.parametrize("ohm", [3e-4, 1.5e-4, -1.5e-4])
def test_a_series_resistance_is_named_with_its_size_and_sign(tmp_path, drive, ohm):
    cause = only_cause(explained(tmp_path, drive(f"cell.effects.series_ohm={ohm}")))
    assert cause["name"] == "series_resistance" or "series_resistance" in cause["equivalent_to"]
    assert value(cause, "resistance_ohm") == pytest.approx(ohm, rel=0.1)


def test_the_example_of_the_page_finds_what_it_hid(tmp_path):
    page = (pathlib.Path(__file__).resolve().parents[3] / "docs" / "explain.md").read_text(encoding="utf-8")
    commands = page.split("```sh\n")[1].split("```")[0].replace("./voltlap", shlex.quote(str(VOLTLAP)))
    run = subprocess.run(["bash", "-e", "-c", commands], cwd=tmp_path, capture_output=True, text=True, timeout=300)
    assert run.returncode == 0, run.stderr
    assert "named: Every cell's series resistance is +0.150 " in run.stdout, run.stdout


def test_the_extended_model_drives_and_leaves_nothing_to_explain(tmp_path, drive):
    rows = drive("cell.effects.series_ohm=0.00015")
    extended = tmp_path / "extended.toml"
    explained(tmp_path, rows, "--write-model", extended)
    assert "series_ohm" in extended.read_text()
    voltlap("endurance", "--vehicle", extended, "--laps", 1)
    assert explained(tmp_path, rows, model=extended)["verdict"] == "no_discrepancy"


def test_a_weak_cell_is_named_by_its_number(tmp_path, drive):
    cause = only_cause(explained(tmp_path, drive("battery.cells.7.resistance_scale=1.25")))
    assert cause["name"] == "weak_cell" and value(cause, "cell") == 7
    assert value(cause, "resistance_change") == pytest.approx(0.25, rel=0.1)


@pytest.mark.parametrize("scale", [0.9, 0.55])
def test_a_cell_of_much_less_capacity_bends_and_is_named_with_its_size(tmp_path, drive, scale):
    """Of 45 % that are missing the straight signature says 53, of 10 it says 10.5."""
    cause = only_cause(explained(tmp_path, drive(f"battery.cells.7.capacity_scale={scale}", laps=12)))
    assert cause["name"] == "weak_cell" and value(cause, "cell") == 7
    change = cause["parameters"]["capacity_change"]
    assert change["value"] == pytest.approx(scale - 1.0, rel=0.02)
    assert change["ci95_low"] < scale - 1.0 < change["ci95_high"]
    # No interval is narrower than what is allowed for another physics than the model's.
    assert change["ci95_high"] - change["ci95_low"] > 2 * 1.95 * 0.05 * abs(change["value"])


def test_a_cell_that_holds_more_than_the_others_is_named_with_its_size(tmp_path, drive):
    answer = explained(tmp_path, drive("battery.cells.3.capacity_scale=1.25", laps=12))
    cause = only_cause(answer)
    assert cause["name"] == "weak_cell" and value(cause, "cell") == 3
    assert value(cause, "capacity_change") == pytest.approx(0.25, rel=0.05) and "is weak" not in answer["sentence"]


def test_a_drive_that_begins_under_way_with_another_charge_than_the_model_names_its_cause(tmp_path, drive):
    answer = explained(tmp_path, drive("cell.effects.series_ohm=0.00015", "battery.initial_soc=0.96"))
    cause = only_cause(answer)
    assert cause["name"] == "series_resistance" or "series_resistance" in cause["equivalent_to"]
    assert value(cause, "resistance_ohm") == pytest.approx(1.5e-4, rel=0.1)
    assert answer["gain"]["voltage"]["heldout_rms_before"] < 0.015  # the charge is no error of the model's


def test_a_contact_is_named_and_a_compensating_bms_is_not_taken_for_one(tmp_path, drive):
    cause = only_cause(explained(tmp_path, contact(drive(), 0.006)))
    assert cause["name"] == "contact_resistance" and value(cause, "resistance_ohm") == pytest.approx(0.006, rel=0.05)
    cause = only_cause(explained(tmp_path, contact(drive(), -0.006)))
    assert cause["name"] == "reported_voltage_compensation"


def test_columns_in_another_order_and_other_units_change_nothing(tmp_path, drive):
    rows = [{("pack_current_ma" if k == "pack_current_a" else k): (-1e3 * v if k == "pack_current_a" else v)
             for k, v in row.items()} for row in contact(drive(), 0.006)]
    cause = only_cause(explained(tmp_path, rows, columns=list(reversed(rows[0]))))
    assert cause["name"] == "contact_resistance" and value(cause, "resistance_ohm") == pytest.approx(0.006, rel=0.05)


def test_a_late_current_is_named_with_its_delay(tmp_path, drive):
    rows = drive()
    late = [{**row, "pack_current_a": before["pack_current_a"]} for before, row in zip(rows, rows[1:])]
    cause = only_cause(explained(tmp_path, late))
    assert cause["name"] == "time_skew" and value(cause, "channel") == "current"
    assert value(cause, "delay_s") == pytest.approx(0.1, abs=0.01)


def test_surfaces_that_follow_late_are_a_cause_and_none_for_a_model_that_says_so(tmp_path, drive):
    rows = lagging(drive(), 150.0)  # of 60 s the starts take all but 0.08 K on such a drive: nothing to speak of
    extended = tmp_path / "extended.toml"
    answer = explained(tmp_path, rows, "--write-model", extended)
    # On seven minutes the resistances of cells that are warmer than they read look much like it.
    names = {c["name"] for c in answer["causes"]} | {n for rival in answer.get("alternatives", []) for n in rival}
    assert "thermistor_lag" in names, answer["sentence"]
    assert explained(tmp_path, rows, "--set", "cell.surface_lag_s=150")["verdict"] == "no_discrepancy"


def saturated(rows, limit):
    draw = random.Random(2)
    end = lambda amps: amps if abs(amps) <= limit else math.copysign(limit, amps) + draw.gauss(0.0, 0.3)
    return [{**row, "pack_current_a": end(row["pack_current_a"])} for row in rows]


def test_a_current_sensor_that_ends_at_a_limit_is_named_with_it_and_its_rows_are_not_used(tmp_path, drive):
    cause = only_cause(answer := explained(tmp_path, saturated(drive(), 120.0)))
    assert cause["name"] == "current_saturation"
    limit = cause["parameters"]["limit_a"]
    assert limit["value"] == pytest.approx(120.0, abs=0.2) and limit["ci95_low"] < 120.0 < limit["ci95_high"]
    assert any(m["channel"] == "current" and "reads its limit" in m["reason"] for m in answer["masked"])
    gain = answer["gain"]["voltage"]  # of the rows below the limit
    assert gain["heldout_rms_after"] < 0.1 * gain["heldout_rms_before"]


def test_what_else_is_wrong_is_found_beside_a_saturation_with_its_size(tmp_path, drive):
    answer = explained(tmp_path, saturated(contact(drive(), 0.006), 120.0))
    assert answer["verdict"] == "named", answer["sentence"]
    assert {c["name"] for c in answer["causes"]} == {"current_saturation", "contact_resistance"}
    size = next(c for c in answer["causes"] if c["name"] == "contact_resistance")["parameters"]["resistance_ohm"]
    assert size["value"] == pytest.approx(0.006, rel=0.05)


def test_a_current_that_the_bms_holds_at_a_limit_is_no_saturation(tmp_path, drive):
    rows = drive("bms.discharge_current_max_a=150")
    most = max(row["pack_current_a"] for row in rows)
    assert sum(row["pack_current_a"] > 0.98 * most for row in rows) > 200
    assert explained(tmp_path, rows)["verdict"] == "no_discrepancy"


def test_what_follows_a_saturation_that_is_taken_out_of_the_catalogue_is_a_part(tmp_path, drive):
    answer = explained(tmp_path, saturated(drive(), 120.0), "--set", "explain.without=current_saturation")
    assert answer["verdict"] in ("unknown", "ambiguous") and answer["unknown_in"] == "voltage"
    assert "none of the known causes explains" in answer["sentence"]


def test_a_cause_that_is_not_in_the_catalogue_is_not_called_by_another_name(tmp_path, drive):
    answer = explained(tmp_path, contact(drive(), 0.006), "--set", "explain.without=contact_resistance")
    assert answer["verdict"] in ("unknown", "ambiguous")
    if answer["verdict"] == "unknown":
        assert answer["unknown_in"] == "voltage"


def test_of_an_error_without_a_name_the_part_that_a_cause_explains_is_offered_with_what_it_gains(tmp_path, drive):
    answer = explained(tmp_path, comes_and_goes(drive()))
    assert answer["verdict"] == "ambiguous" and answer["unknown_in"] == "voltage" and answer["next_test"]
    assert answer["sentence"].startswith("A part of it: ") and "none of the known causes explains" in answer["sentence"]
    part = answer["causes"][0]
    assert "series_resistance" in (part["name"], *part["equivalent_to"])
    if part["name"] == "series_resistance":
        size = part["parameters"]["resistance_ohm"]
        assert size["ci95_low"] < 2e-4 < size["ci95_high"]
    gain = answer["gain"]["voltage"]
    assert gain["heldout_rms_after"] < 0.75 * gain["heldout_rms_before"]


def test_an_answer_with_which_another_log_is_worse_is_not_offered(tmp_path, drive):
    other = write(tmp_path / "other.csv", contact(drive(), -0.006))
    answer = explained(tmp_path, contact(drive(), 0.006), "--holdout", other)
    assert answer["verdict"] == "unknown" and answer["causes"] == [] and answer["unknown_in"] == "voltage"
    gain = answer["gain"]["pack_voltage"]
    assert gain["heldout_rms_after"] == gain["heldout_rms_before"]


def test_a_log_too_short_to_tell_anything_says_what_drive_would(tmp_path, drive):
    answer = explained(tmp_path, drive()[:300])
    assert answer["verdict"] == "bad_data" and "short" in answer["sentence"] and answer["next_test"]


def test_a_frozen_cell_is_masked_and_reported(tmp_path, drive):
    answer = explained(tmp_path, stuck(drive()))
    assert any(m["channel"] == "cell_voltage_3" and "frozen" in m["reason"] for m in answer["masked"])
    assert "frozen_signal" in [cause["name"] for cause in answer["causes"]]


def test_a_reference_of_the_same_model_is_learned_from(tmp_path, drive):
    good = write(tmp_path / "good.csv", drive())
    answer = explained(tmp_path, contact(drive(), 0.006), "--reference", good)
    assert answer["mode"] == "reference"
    assert only_cause(answer)["name"] == "contact_resistance"


def test_an_error_far_beyond_that_of_any_reference_is_never_passed_over_in_silence(tmp_path, drive):
    at = lambda degrees: f"battery.initial_temperature_c={degrees}"
    good = [write(tmp_path / f"good_{k}.csv", drive(at(k))) for k in (20, 25, 30)]
    references = [x for path in good for x in ("--reference", path)]
    answer = explained(tmp_path, drive(at(36), "cell.effects.series_ohm=0.00015"), *references)
    if answer["verdict"] == "no_discrepancy":
        assert "times that of any reference" in answer["sentence"] and "good log" in answer["next_test"]
    sound = explained(tmp_path, drive(at(36)), *references)
    assert sound["verdict"] == "no_discrepancy" and sound["next_test"] is None
    # References that miss next to nothing leave no room for forty times as much where nobody has driven.
    told = explained(tmp_path, drive(at(36), "cell.effects.series_ohm=0.0003"), *references)
    resistance = told["causes"][0]["parameters"]["resistance_ohm"]
    assert told["causes"][0]["name"] == "series_resistance"
    assert resistance["ci95_low"] < 3e-4 < resistance["ci95_high"]


def test_an_unknown_cause_in_without_is_refused(tmp_path, drive):
    log = write(tmp_path / "log.csv", drive())
    run = subprocess.run([VOLTLAP, "explain", log, "--model", "vtm16e", "--set", "explain.without=ghost"],
                         capture_output=True, text=True)
    assert run.returncode == 2 and "ghost" in run.stderr


def test_voltage_behind_open_contactors_is_masked_not_explained(tmp_path, drive):
    rows = [dict(row) for row in drive()]
    for k, row in enumerate(rows[-21:]):
        row["pack_current_a"] = 0.0
        row["pack_voltage_v"] *= 0.8**k
    for k, row in enumerate(rows[:5]):
        row["pack_current_a"] = 0.0
        row["pack_voltage_v"] *= 0.7 + 0.05 * k
    answer = explained(tmp_path, rows)
    masked = [m for m in answer["masked"] if "contactors are open" in m["reason"]]
    assert [m["start_s"] for m in masked] == [pytest.approx(rows[0]["time_s"]), pytest.approx(rows[-20]["time_s"])]
    assert answer["verdict"] == "no_discrepancy", answer["sentence"]
