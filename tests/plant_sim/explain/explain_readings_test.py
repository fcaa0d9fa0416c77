# SPDX-License-Identifier: Apache-2.0
"""The engine that holds each reading against the model at its own time, on the simulator's own logs as they are: drawn
drives, drawn sizes. VOLTLAP_TEST_SEED repeats a draw."""
import math

import pytest

from drawn_drives import EFFECTS, SEED, Draw, explained, rows_of, run, write

HEAT_CAPACITY = 747.0  # J/kg/K of vtm16e's cells


@pytest.mark.parametrize("candump", [False, True])
def test_a_drive_as_the_model_has_it_shows_no_discrepancy(tmp_path, candump):
    draw = Draw(f"sound{candump}")
    answer, said = explained(tmp_path, draw.drive(tmp_path, candump=candump))
    assert answer["verdict"] == "no_discrepancy" and answer["causes"] == [], said


@pytest.mark.parametrize("number", range(4))
def test_a_sound_drive_of_another_car_shows_no_discrepancy(tmp_path, number):
    """Its sensors' noise and steps, and no reference: a pair of small errors of tyres and mass was named so."""
    draw = Draw(f"another{number}")
    car = tmp_path / "car.toml"
    car.write_text(f'name = "another"\nbase = "{draw.random.choice(("vtm16e", "vtm17e"))}"\n'
                   f"[vehicle]\nmass_kg = {draw.random.uniform(170.0, 270.0):.0f}\n"
                   f"[powertrain]\nfinal_drive = {draw.random.uniform(3.0, 5.0):.2f}\n")
    answer, said = explained(tmp_path, draw.drive(tmp_path, candump=True, vehicle=car), model=car)
    assert answer["verdict"] == "no_discrepancy", (car.read_text(), said)


@pytest.mark.parametrize("effect", EFFECTS, ids=[f"{e[3]}{e[1]}" for e in EFFECTS])
def test_what_was_hidden_is_named_with_its_size(tmp_path, effect):
    key, low, high, name, parameter, says = effect
    draw = Draw(f"{name}{low}")
    size = float(f"{draw.random.uniform(low, high):.4g}")
    answer, said = explained(tmp_path, draw.drive(tmp_path, key.format(size)))
    assert answer["verdict"] == "named" and len(answer["causes"]) == 1, (size, said)
    cause = answer["causes"][0]
    assert name in (cause["name"], *cause["equivalent_to"]), (size, said)
    if cause["name"] == name:
        assert cause["parameters"][parameter]["value"] == pytest.approx(says(size), rel=0.06), (size, said)


def test_a_cell_that_is_not_read_for_a_while_changes_no_size_of_another(tmp_path):
    draw = Draw("missing")
    scale = float(f"{draw.random.uniform(1.15, 1.6):.4g}")
    names, rows = rows_of(draw.drive(tmp_path, f"battery.cells.7.resistance_scale={scale}"))
    missing, first = names.index("cell_3_voltage_v"), draw.random.randrange(len(rows) // 2)
    for row in rows[first:first + len(rows) // 3]:
        row[missing] = ""
    answer, said = explained(tmp_path, write(tmp_path / "missing.csv", names, rows))
    weak = [c for c in answer["causes"] if c["name"] == "weak_cell"]
    assert len(weak) == 1 and weak[0]["parameters"]["cell"]["value"] == 7, (scale, first, said)
    assert weak[0]["parameters"]["resistance_change"]["value"] == pytest.approx(scale - 1, rel=0.1), (scale, said)


def test_a_cell_that_is_wrong_in_no_known_way_is_not_nothing(tmp_path):
    draw = Draw("odd")
    names, rows = rows_of(draw.drive(tmp_path))
    cell, size, period = draw.random.randint(1, 24), draw.random.uniform(0.006, 0.02), draw.random.uniform(15.0, 40.0)
    column, time = names.index(f"cell_{cell}_voltage_v"), names.index("time_s")
    for row in rows:
        row[column] = f"{float(row[column]) + size * math.sin(2 * math.pi * float(row[time]) / period):.5f}"
    answer, said = explained(tmp_path, write(tmp_path / "odd.csv", names, rows))
    assert answer["verdict"] == "unknown", (cell, size, period, said)
    assert f"cell {cell}." in answer["sentence"], (cell, size, period, said)


def test_what_a_thermistor_gains_is_said_in_kelvin(tmp_path):
    draw = Draw("thermistor")
    by = draw.random.uniform(3.0, 8.0)
    names, rows = rows_of(draw.drive(tmp_path))
    warm = names.index("cell_5_temperature_c")
    for row in rows:
        row[warm] = f"{float(row[warm]) + by:.3f}"
    answer, said = explained(tmp_path, write(tmp_path / "warm.csv", names, rows))
    assert [c["name"] for c in answer["causes"]] == ["thermistor_offset"], said
    assert answer["causes"][0]["parameters"]["temperature_k"]["value"] == pytest.approx(by, rel=0.05), said
    assert " K of thermistor 5 error" in answer["sentence"], said


def test_air_that_no_log_says_is_found_where_it_is_far_off(tmp_path):
    draw = Draw("air")
    air = draw.random.choice((draw.random.uniform(8.0, 14.0), draw.random.uniform(36.0, 42.0)))
    answer, said = explained(tmp_path, draw.drive(tmp_path, f"environment.ambient_c={air:.1f}"))
    names = {n for c in answer["causes"] for n in (c["name"], *c["equivalent_to"])}
    assert "ambient" in names | {n for rival in answer.get("alternatives", []) for n in rival}, (air, said)


def test_air_a_little_off_is_no_discrepancy(tmp_path):
    draw = Draw("little")
    air = draw.random.choice((draw.random.uniform(23.0, 23.5), draw.random.uniform(26.5, 27.0)))  # the model's is 25
    reference = draw.drive(tmp_path)
    log = draw.drive(tmp_path, f"environment.ambient_c={air:.1f}")
    answer, said = explained(tmp_path, log, "--reference", reference)
    assert answer["verdict"] == "no_discrepancy", (air, said)


def test_what_the_car_draws_is_no_offset_of_the_current(tmp_path):
    """An offset beside what undoes its drift of the voltage explains the power as well: one cause goes first."""
    draw = Draw("draws")
    base = 670.0  # of the vehicle file
    more = draw.random.uniform(200.0, 500.0)
    reference = draw.drive(tmp_path, candump=True)
    log = draw.drive(tmp_path, f"low_voltage.power_w={base + more:.1f}", candump=True)
    answer, said = explained(tmp_path, log, "--reference", reference)
    assert [c["name"] for c in answer["causes"]] == ["auxiliary_load"], (more, said)
    assert answer["causes"][0]["parameters"]["power_w"]["value"] == pytest.approx(more, rel=0.05), (more, said)


def test_coarse_thermistors_show_that_heat_is_missing(tmp_path):
    """Thermistors in steps of 1 K, with noise: a reference of another drive tells what they show anyway. Which cause of
    the heat balance it is four laps cannot always tell, nor always that there is one (one drive in four, of
    eight tried). Known to be wrong: beside it may stand a capacity or resistances, which follow what a reversible heat
    that is a tenth off leaves of the voltage; of thermistors that pass few steps the lag of one may be called a part
    of it (seed 178299705). One of five may be so."""
    draw = Draw("coarse")
    found, of_others = [], []
    for _ in range(5):
        size = float(f"{draw.random.uniform(4e-4, 6e-4) * draw.random.choice((-1, 1)):.3g}")
        reference = draw.drive(tmp_path, candump=True)
        log = draw.drive(tmp_path, f"cell.effects.entropy_v_per_k={size}", candump=True)
        answer, said = explained(tmp_path, log, "--reference", reference)
        if answer["verdict"] not in ("named", "ambiguous"):
            continue
        found.append(size)
        names = {n for c in answer["causes"] for n in (c["name"], *c["equivalent_to"])}
        rivals = {n for rival in answer.get("alternatives", []) for n in rival}
        of_heat = {"entropic_heat", "ambient", "cooling", "heat_capacity", "cooling_at_stop"}
        if not (names | rivals) & of_heat:
            of_others.append((size, said))
            continue
        gain = answer["gain"]["temperature"]  # of the first of the alternatives
        if names & of_heat:
            assert gain["heldout_rms_after"] < gain["heldout_rms_before"], (size, said)
    assert len(found) >= 2, found
    assert len(of_others) <= 1, of_others


def test_little_heat_capacity_behind_coarse_thermistors_is_told(tmp_path):
    """Each lap warms the cells and the air cools them, between two steps of 1 K unseen; no sound drive tells the air.
    As a straight line it is much less than it is. How many drives pass steps enough to tell is a matter of the draw:
    of 28 it was told in 19, and one of 44 was called a capacity. So the draw is kept here."""
    draw = Draw("heat capacity", 12)
    for _ in range(4):
        share = draw.random.uniform(0.35, 0.5)
        log = draw.drive(tmp_path, f"cell.heat_capacity_j_per_kg_k={HEAT_CAPACITY * share:.1f}", candump=True, laps=6)
        answer, said = explained(tmp_path, log)
        names = {n for c in answer["causes"] for n in (c["name"], *c["equivalent_to"])}
        names |= {n for rival in answer.get("alternatives", []) for n in rival}
        assert not names - {"heat_capacity", "ambient", "entropic_heat", "cooling", "cooling_at_stop"}, (share, said)
        assert "heat_capacity" in names, (share, said)
        for cause in answer["causes"]:
            if cause["name"] == "heat_capacity":
                assert abs(cause["parameters"]["change"]["value"] - (share - 1.0)) < 0.1, (share, said)


def test_a_log_of_a_day_is_explained_as_fast_as_a_drive(tmp_path):
    """Blocks, bins and memory do not grow with the hours between: a rest of a night in the middle."""
    draw = Draw("night")
    names, rows = rows_of(draw.drive(tmp_path, "cell.effects.series_ohm=0.0004"))
    half, time = len(rows) // 2, names.index("time_s")
    for row in rows[half:]:
        row[time] = f"{float(row[time]) + 3600 * draw.random.randrange(8, 9):.2f}"
    answer, said = explained(tmp_path, write(tmp_path / "night.csv", names, rows))
    assert "series_resistance" in [n for c in answer["causes"] for n in (c["name"], *c["equivalent_to"])], said


def test_the_extended_model_leaves_nothing_and_keeps_what_was_promised(tmp_path):
    draw = Draw("extended")
    size = float(f"{draw.random.uniform(1.5e-4, 5e-4):.4g}")
    key = f"cell.effects.series_ohm={size}"
    extended, page = tmp_path / "extended.toml", tmp_path / "page.html"
    answer, said = explained(tmp_path, draw.drive(tmp_path, key), "--write-model", extended, "--report", page)
    promised = answer["gain"]["voltage"]
    other = draw.drive(tmp_path, key)
    before, _ = explained(tmp_path, other)
    after, told = explained(tmp_path, other, model=extended)
    assert after["verdict"] == "no_discrepancy", (size, said, told)
    real = 1 - (after["gain"]["voltage"]["heldout_rms_before"] / before["gain"]["voltage"]["heldout_rms_before"]) ** 2
    assert real == pytest.approx(1 - (promised["heldout_rms_after"] / promised["heldout_rms_before"]) ** 2, abs=0.1)
    assert "<html" in page.read_text(encoding="utf-8").lower()


def test_a_good_reference_changes_no_right_answer(tmp_path):
    draw = Draw("reference")
    size = float(f"{draw.random.uniform(1.5e-4, 5e-4):.4g}")
    log = draw.drive(tmp_path, f"cell.effects.series_ohm={size}")
    alone, _ = explained(tmp_path, log)
    beside, said = explained(tmp_path, log, "--reference", draw.drive(tmp_path))
    assert [c["name"] for c in beside["causes"]] == [c["name"] for c in alone["causes"]] != [], (size, said)


def names_in(answer):
    return {n for c in answer["causes"] for n in (c["name"], *c["equivalent_to"])}


@pytest.mark.parametrize("number", range(3))
def test_what_comes_with_the_first_charge_is_no_drive_before_the_log(tmp_path, number):
    """A hysteresis that settles in the first minutes looks like branches that an earlier drive has charged; where these
    leave less than is worth a word nobody can tell."""
    draw = Draw(f"settles{number}")
    amplitude = float(f"{draw.random.uniform(0.012, 0.035):.3g}")
    references = [draw.drive(tmp_path) for _ in range(2)]
    answer, said = explained(tmp_path, draw.drive(tmp_path, f"cell.effects.hysteresis_v={amplitude}"), "--reference",
                             *references)
    offered = names_in(answer) | {n for names in answer.get("alternatives") or [] for n in names}
    nobody_can_tell = answer["gain"]["voltage"]["heldout_rms_before"] < 0.8e-3  # V, with nothing found
    assert "hysteresis" in offered or nobody_can_tell, (amplitude, said)


# Of the cells of vtm16e, as a BMS may have it in flash whatever the cells do: reference study, 2016, Eq. 6.7.
OCV_V = [3.00, 5.98, -14.1, 15.2, -6.79, 0.88]


def test_a_bms_that_began_by_the_model_s_curve_does_not_know_the_true_one(tmp_path):
    """What it reports is as far off as its curve, and contradicts nobody. Without that the capacity was 28 % off."""
    car = tmp_path / "car.toml"
    car.write_text('name = "car"\nbase = "vtm17e"\n[battery]\ncell = "aesc_e5_2p"\ncells_in_series = 22\n'
                   "cells_in_parallel = 1\ncapacity_ah = 53.283\n[environment]\nambient_c = 20.3\n[vehicle]\n"
                   "mass_kg = 214.2\n[inverter]\nefficiency = 0.934\n[low_voltage]\npower_w = 170\n")

    def drive(name, seed, *keys):
        log = tmp_path / f"{name}.log"
        run("endurance", "--vehicle", car, "--laps", 6, "--track", "michigan_2015", "--seed", seed, "--candump", log,
            "--set", *keys)
        return log

    soc = [k / 20 for k in range(21)]
    volts = [sum(a * x**k for k, a in enumerate(OCV_V)) for x in soc]
    reference = drive("reference", 546278301, "battery.initial_soc=0.724", "battery.initial_temperature_c=25.11")
    log = drive("log", 7, "battery.initial_soc=0.9",
                "cell.effects.ocv_change_v=[0.004,0.008,0.012,0.016,0.02,0.024,0.022,0.02,0.018,0.016,0.01]",
                f"bms.ocv_soc=[{','.join(f'{x:.2f}' for x in soc)}]",
                f"bms.ocv_v=[{','.join(f'{v:.4f}' for v in volts)}]")
    answer, said = explained(tmp_path, log, "--reference", reference, model=car)
    assert "ocv_shape" in names_in(answer), said
    size = next(cause["parameters"]["rms_v"] for cause in answer["causes"] if cause["name"] == "ocv_shape")
    # Its level and the charge that the log began with are nearly one: 17.6 to 20.9 mV by how idles are looked up.
    assert size["value"] == pytest.approx(0.018, rel=0.2), said
    assert answer["gain"]["voltage"]["heldout_rms_after"] < 0.35e-3, said


def test_an_error_that_sound_logs_do_not_have_is_never_nothing(tmp_path):
    """A drawn case, kept: two fifths of the resistance relax for minutes; no set foresaw the minutes beside it, nor did
    a smooth shape, and 5 mV that the reference did not have were nothing."""
    car = tmp_path / "car.toml"
    car.write_text('name = "small cells"\nbase = "vtm16e"\n[battery]\ncell = "sony_vtc6"\ncells_in_series = 108\n'
                   "cells_in_parallel = 4\n[sensors]\ntemperature_count = 22\n[vehicle]\nmass_kg = 193.2\n"
                   "[powertrain]\nfinal_drive = 3.73\n")

    def drive(name, seed, track, *keys):
        log = tmp_path / f"{name}.csv"
        run("endurance", "--vehicle", car, "--laps", 6, "--seed", seed, "--track", track, "--csv", log, "--set", *keys)
        return log

    reference = drive("reference", 40606280, "michigan_2015", "battery.initial_soc=0.597",
                      "battery.initial_temperature_c=31.67", "driver.grip_use=0.88")
    log = drive("log", 2050299270, "michigan_2014", "battery.initial_soc=0.559", "battery.initial_temperature_c=25.38",
                "driver.grip_use=0.88", "cell.effects.slow_relaxation_ohm=0.008249",
                "cell.effects.slow_relaxation_tau_s=400")
    answer, said = explained(tmp_path, log, "--reference", reference, model=car)
    assert answer["verdict"] != "no_discrepancy", said


def test_one_cause_is_said_rather_than_two_that_follow_it_a_little_better(tmp_path):
    draw = Draw("radius")
    change = draw.random.choice((-1, 1)) * float(f"{draw.random.uniform(0.05, 0.09):.3g}")
    log = draw.drive(tmp_path, f"tyres.radius_m={0.22225 * (1 + change):.6g}")
    answer, said = explained(tmp_path, log, "--reference", draw.drive(tmp_path))
    assert len(answer["causes"]) == 1 and "tyre_radius" in names_in(answer), (change, said)
    if answer["causes"][0]["name"] == "tyre_radius":
        assert answer["causes"][0]["parameters"]["change"]["value"] == pytest.approx(change, rel=0.15), (change, said)


def test_a_heavier_car_is_found_in_ten_rows_a_second_without_a_reference(tmp_path):
    draw = Draw("mass")
    change = float(f"{draw.random.uniform(0.15, 0.3):.3g}")
    answer, said = explained(tmp_path, draw.drive(tmp_path, f"vehicle.mass_kg={243 + change * (243 + 72):.5g}"))
    assert "mass" in names_in(answer), (change, said)


def test_what_is_wrong_in_four_places_is_said_in_four_places(tmp_path):
    """Three causes are sought at once; what is wrong elsewhere is asked for beside them."""
    draw = Draw("four")
    keys = (f"cell.effects.series_ohm={draw.random.uniform(2e-4, 5e-4):.4g}",
            f"battery.contact_resistance_ohm={draw.random.uniform(2e-3, 5e-3):.4g}",
            f"environment.ambient_c={draw.random.uniform(38.0, 42.0):.1f}",
            f"low_voltage.power_w={draw.random.uniform(1000.0, 1300.0):.0f}")
    answer, said = explained(tmp_path, draw.drive(tmp_path, *keys, candump=True))
    found = names_in(answer)
    assert {"series_resistance", "contact_resistance", "auxiliary_load"} <= found, (keys, said)
    assert found & {"ambient", "cooling", "entropic_heat", "heat_capacity", "cooling_at_stop"}, (keys, said)


def test_parts_that_undo_each_other_on_average_are_both_named(tmp_path):
    """What a fit makes of a car that warms: right on average, with too little of its law and too much of the rest."""
    draw = Draw("law")
    law = [f"cell.effects.activation_energy_j_per_mol={draw.random.uniform(14000.0, 20000.0):.0f}",
           f"battery.initial_temperature_c={draw.random.uniform(31.0, 34.0):.2f}"]
    log = draw.drive(tmp_path, *law, laps=8)
    answer, said = explained(tmp_path, log, "--set", "explain.without=resistance_temperature",
                             "explain.without=resistance_soc", "explain.without=resistance_current")
    mean = next((c for c in answer["causes"] if c["name"] == "series_resistance"), None)
    assert mean is not None, (law, said)
    back = -mean["parameters"]["resistance_ohm"]["value"]
    answer, said = explained(tmp_path, draw.drive(tmp_path, *law, f"cell.effects.series_ohm={back:.4g}", laps=8))
    found = {c["name"]: c["parameters"] for c in answer["causes"]}
    assert {"resistance_temperature", "series_resistance"} <= set(found), (law, back, said)
    energy = found["resistance_temperature"]["activation_energy_j_per_mol"]["value"]
    assert energy == pytest.approx(float(law[0].split("=")[1]), rel=0.15), (law, back, said)


def with_more_in_odd_minutes(folder, draw, ohm):
    """A drive whose cells have more resistance in every other minute."""
    names, rows = rows_of(draw.drive(folder))
    current, time, pack = (names.index(name) for name in ("pack_current_a", "time_s", "pack_voltage_v"))
    cells = [k for k, name in enumerate(names) if name.startswith("cell_") and name.endswith("_voltage_v")]
    first = float(rows[0][time])
    for row in rows:
        drop = ohm * float(row[current]) if int((float(row[time]) - first) // 60) % 2 else 0.0
        for k in cells:
            row[k] = f"{float(row[k]) - drop:.5f}"
        row[pack] = f"{float(row[pack]) - len(cells) * drop:.5f}"
    return write(folder / "minutes.csv", names, rows)


def test_the_other_minutes_measure_the_gain(tmp_path):
    draw = Draw("minutes")
    size = draw.random.uniform(2e-4, 5e-4)
    log = draw.drive(tmp_path, f"cell.effects.series_ohm={size:.4g}")
    answer, said = explained(tmp_path, log, "--set", "explain.fit_blocks=even")
    assert answer["verdict"] == "named" and "series_resistance" in names_in(answer), (size, said)
    gain = answer["gain"]["voltage"]
    assert gain["heldout_rms_after"] < 0.1 * gain["heldout_rms_before"], (size, said)


def test_minutes_that_are_not_looked_at_say_nothing_but_that_an_answer_does_not_hold(tmp_path):
    draw = Draw("apart")
    log = with_more_in_odd_minutes(tmp_path, draw, draw.random.uniform(3e-4, 6e-4))
    even, said = explained(tmp_path, log, "--set", "explain.fit_blocks=even")
    assert even["verdict"] == "no_discrepancy", said
    assert even["gain"]["voltage"]["heldout_rms_before"] > 0.01, said
    odd, said = explained(tmp_path, log, "--set", "explain.fit_blocks=odd")
    assert odd["verdict"] == "unknown" and odd["unknown_in"] == "voltage", said
    gain = odd["gain"]["voltage"]
    assert gain["heldout_rms_after"] == gain["heldout_rms_before"], said


def wander(draw, times, size, stay_s):
    """A walk that comes back, of mean 0 and this RMS as it was drawn: a short one can be far from its expectation."""
    out, last = [draw.random.gauss(0.0, 1.0)], times[0]
    for time in times[1:]:
        keeps = math.exp(-(time - last) / stay_s)
        out.append(keeps * out[-1] + math.sqrt(1.0 - keeps * keeps) * draw.random.gauss(0.0, 1.0))
        last = time
    mean = sum(out) / len(out)
    rms = math.sqrt(sum((x - mean) ** 2 for x in out) / len(out))
    return [size * (x - mean) / rms for x in out]


@pytest.mark.parametrize("channel", ["cells", "pack"])
def test_an_error_of_no_known_shape_is_never_nothing(tmp_path, channel):
    draw = Draw(f"wander{channel}")
    size, stay_s = draw.random.uniform(0.014, 0.03), draw.random.uniform(20.0, 80.0)
    names, rows = rows_of(draw.drive(tmp_path))
    cells = [k for k, n in enumerate(names) if n.startswith("cell_") and n.endswith("_voltage_v")]
    pack = names.index("pack_voltage_v")
    for row, off in zip(rows, wander(draw, [float(row[names.index("time_s")]) for row in rows], size, stay_s)):
        if channel == "cells":
            for k in cells:
                row[k] = f"{float(row[k]) + off:.5f}"
        row[pack] = f"{float(row[pack]) + (len(cells) if channel == 'cells' else 40.0) * off:.5f}"
    answer, said = explained(tmp_path, write(tmp_path / "wander.csv", names, rows))
    # A cause may take a part of a walk; it warms the model's cells then, and the largest rest may stand in the heat.
    assert answer["verdict"] in ("unknown", "ambiguous"), (size, stay_s, said)
    # The power is reckoned with the pack's voltage.
    assert answer["unknown_in"] in ("voltage", "heat", *(["power"] if channel == "pack" else [])), (size, stay_s, said)
