# SPDX-License-Identifier: Apache-2.0
"""A pack voltage as a battery unit publishes it, and the bus behind the contactors beside it."""
import pytest
from drawn_drives import Draw, explained, rows_of, write


CELL_COLD_OHM = 3.5e-3  # R0 and both branches of vtm16e's cells 20 K below their tables: 2.4 mOhm there, 1.4 to 1.9 %/K


class Filter:
    """First order, as a unit runs it: a hundred times a second, whatever its bus or its log has of that."""

    def __init__(self, tau_s):
        self.part, self.before, self.value = min(1.0, 0.01 / tau_s), None, None

    def __call__(self, value):
        if self.value is None:
            self.before = self.value = value
        for step in range(1, 11):
            self.value += (self.before + (value - self.before) * step / 10 - self.value) * self.part
        self.before = value
        return self.value


def with_bus(draw, folder, published, bus_ohm=0.0):
    """A drive of which pack and bus voltage are logged; `published(volts, current)` is in the place of the pack's."""
    names, rows = rows_of(draw.drive(folder))
    time, current, volts, bus = (names.index(n) for n in ("time_s", "pack_current_a", "pack_voltage_v", "dc_link_v"))
    out = [[row[time], row[current], f"{published(float(row[volts]), float(row[current])):.3f}",
            f"{float(row[bus]) - bus_ohm * float(row[current]):.3f}"] for row in rows]
    return write(folder / "log.csv", ["time_s", "pack_current_a", "pack_voltage_v", "bus_voltage_v"], out)


@pytest.mark.parametrize("filters", ["nothing", "current", "all"])
def test_what_a_battery_unit_adds_to_what_it_publishes_is_told_beside_a_bus(tmp_path, filters):
    """Of the battery it would be a negative resistance: -9.7 mOhm of a cell that has 2.4 was an answer."""
    draw = Draw(f"made up {filters}")
    ohm, tau_s = draw.random.uniform(0.03, 0.25), draw.random.uniform(0.3, 3.0)
    passes = Filter(tau_s)

    def published(volts, current):
        if filters == "nothing":
            return volts + ohm * current
        return passes(volts + ohm * current) if filters == "all" else volts + passes(ohm * current)

    log = with_bus(draw, tmp_path, published)
    answer, said = explained(tmp_path, log, "--set", f"battery.initial_temperature_c={draw.began_c}")
    drawn = (filters, ohm, tau_s, said)
    cause = next((c for c in answer["causes"] if c["name"] == "reported_voltage_compensation"), None)
    assert answer["verdict"] in ("named", "ambiguous") and cause, drawn
    found = cause["parameters"]
    assert found["resistance_ohm"]["value"] == pytest.approx(ohm, rel=0.15), drawn
    if filters == "nothing":
        assert "tau_s" not in found and "filter" not in answer["sentence"], drawn
    else:
        assert found["tau_s"]["value"] == pytest.approx(tau_s, rel=0.25, abs=0.15), drawn
    battery = {"series_resistance", "polarization_resistance", "resistance_current", "slow_relaxation", "hysteresis",
               "ocv_shape", "capacity"}
    wrong = [c for c in answer["causes"] if c["name"] in battery and abs(c["share_of_residual"]) > 0.05]
    assert not wrong, drawn


@pytest.mark.parametrize("number", range(2))
def test_no_cell_loses_more_resistance_than_it_has(tmp_path, number):
    """The same without a bus, which nothing tells from the cells' own: polarization of -7.4 of 2.4 mOhm was `named`."""
    draw = Draw(f"too little{number}")
    ohm, tau_s = draw.random.uniform(0.15, 0.25), draw.random.uniform(1.0, 3.0)
    passes = Filter(tau_s)
    log = with_bus(draw, tmp_path, lambda volts, current: volts + passes(ohm * current))
    rows = [line.split(",")[:3] for line in log.read_text().splitlines()]
    answer, said = explained(tmp_path, write(log, rows[0], rows[1:]))
    sizes = [c["parameters"]["resistance_ohm"]["value"] for c in answer["causes"] if c["name"].endswith("_resistance")]
    assert answer["verdict"] != "no_discrepancy" and all(s > -CELL_COLD_OHM for s in sizes), (ohm, tau_s, said)


def test_a_bus_that_a_turning_motor_charges_behind_open_contactors_is_masked(tmp_path):
    draw = Draw("charged bus")
    log = with_bus(draw, tmp_path, lambda volts, current: volts)
    lines = [line.split(",") for line in log.read_text().splitlines()]
    stopped = lines[-draw.random.randrange(15, 60):]
    opened = stopped[2:]
    highest = draw.random.uniform(1.05, 1.7)
    for row in stopped:
        row[1:] = ["0", *stopped[0][2:]]
    for k, row in enumerate(opened):
        row[3] = f"{float(row[3]) * (highest - 0.3 * k / len(opened)):.3f}"
    write(log, lines[0], lines[1:])
    answer, said = explained(tmp_path, log)
    masked = [m for m in answer["masked"] if m["channel"] == "bus_voltage" and "contactors are open" in m["reason"]]
    assert {c["name"] for c in answer["causes"]} <= {"frozen_signal"}, (highest, said)  # the current stands still
    if highest > 1.2:  # beyond all that a current ever showed; a full pack is a seventh above a loaded one
        assert masked and masked[0]["start_s"] == pytest.approx(float(opened[0][0]), abs=0.11), (highest, said)


@pytest.mark.parametrize("number", range(2))
def test_a_contact_behind_the_pack_voltage_is_named(tmp_path, number):
    draw = Draw(f"bus{number}")
    ohm = draw.random.uniform(0.005, 0.06)
    answer, said = explained(tmp_path, with_bus(draw, tmp_path, lambda volts, current: volts, ohm))
    assert [c["name"] for c in answer["causes"]] == ["contact_resistance"], (ohm, said)
    assert answer["causes"][0]["parameters"]["resistance_ohm"]["value"] == pytest.approx(ohm, rel=0.05), said
    assert "between the pack voltage and the bus" in said
