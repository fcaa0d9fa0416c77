# SPDX-License-Identifier: Apache-2.0
"""Recordings of real cells and cars: what toolchain/explain_recordings.py prints for docs/explain.md."""
import os
import pathlib
import sys

import pytest

DATA = os.environ.get("VOLTLAP_DATA")
pytestmark = pytest.mark.skipif(not DATA, reason="VOLTLAP_DATA is not set: no measured recordings on this machine")
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "toolchain"))
import explain_recordings  # noqa: E402

explain_recordings.VOLTLAP = pathlib.Path(os.environ["VOLTLAP_BUILD_DIR"]) / "bin" / "voltlap"
ROWS = {row.name: row for row in explain_recordings.ROWS}


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    folder = tmp_path_factory.mktemp("recordings")
    return lambda name: explain_recordings.answer(ROWS[name], pathlib.Path(DATA), folder, report=False)


@pytest.mark.parametrize("name, most_v, lower", [("ucd", 0.20, 0.6), ("ksu", 0.95, 0.4)])
def test_a_plain_model_of_an_endurance_is_explained_on_minutes_that_it_did_not_see(found, name, most_v, lower):
    answer, _ = found(name)
    # Of 72 cells in series a part remains; of both, the resistance falls with warmth, at 11 and 9 kJ/mol by hand.
    assert answer["verdict"] in ("named", "ambiguous")
    energy = next(c for c in answer["causes"] if c["name"] == "resistance_temperature")["parameters"]
    assert energy["activation_energy_j_per_mol"]["ci95_low"] > 0.0  # the resistance of a lithium cell falls as it warms
    gain = answer["gain"]["pack_voltage"]
    assert 0.5 * most_v < gain["heldout_rms_before"] < most_v
    assert gain["noise_floor"] <= gain["heldout_rms_after"] < (1.0 - lower) * gain["heldout_rms_before"]


def test_what_no_cause_has_the_shape_of_is_unknown_and_not_an_error_of_a_laboratory(found):
    # LFP: a hysteresis that two branches cannot follow, and a lag of a second.
    answer, _ = found("plett")
    assert answer["verdict"] == "unknown" and answer["unknown_in"] == "voltage" and answer["causes"] == []


def test_what_a_battery_unit_adds_to_the_voltage_it_publishes_is_what_least_squares_say(found):
    answer, said = found("uwfe_a")
    assert "pack_voltage rises with the discharge current while bus_voltage falls" in said
    # What the unit makes up says nothing of the battery: negative polarization took 24 V of it to 3.
    assert {cause["name"] for cause in answer["causes"]} == {"reported_voltage_compensation", "dropped_or_late_frames"}
    size = next(c for c in answer["causes"] if c["name"] == "reported_voltage_compensation")["parameters"]
    # By hand, published = V + R L(I) + s (L(V) - V) with the bus as V: 0.70 Ohm, 2 to 3 s, 0.99 to 1.02.
    assert size["resistance_ohm"]["value"] == pytest.approx(0.70, rel=0.1)
    assert 2.0 < size["tau_s"]["value"] < 3.0 and size["filtered_share"]["value"] == pytest.approx(1.0, abs=0.1)
    gain = answer["gain"]["pack_voltage"]
    assert gain["heldout_rms_before"] > 20.0 and gain["heldout_rms_after"] < 1.0
    # The motor charges the bus to 750 V once the contactors have opened, before it falls.
    last = [m for m in answer["masked"] if m["channel"] == "bus_voltage" and "contactors are open" in m["reason"]][-1]
    assert last["start_s"] == pytest.approx(102.6, abs=0.15)


def test_fifty_seconds_are_too_short_and_it_says_what_drive_would_do(found):
    answer, said = found("uwfe_b")
    assert answer["verdict"] == "bad_data" and "too short" in answer["sentence"] and "two laps" in answer["next_test"]
    assert "pack_voltage rises with the discharge current" in said
