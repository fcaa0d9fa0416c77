# SPDX-License-Identifier: Apache-2.0
"""Loggers as teams have them: rows a tenth to a second apart, in steps, and without some of the columns. A sound drive
is sound in each of them; where only some are gone what is wrong is found. VOLTLAP_TEST_SEED repeats a draw."""
import pathlib

import pytest

from drawn_drives import EFFECTS, Draw, explained, rows_of, run, write

DBC = pathlib.Path(__file__).parents[3] / "can_dbc" / "car.dbc"
# Together or not at all.
MAY_BE_MISSING = [("soc", "bms_soc"), ("charge_drawn_ah",), ("dc_link_v",), ("phase_current_a",), ("accelerator",),
                  ("brake",), ("speed_mps",), ("speed_kmh",), ("pack_voltage_v",), ("longitudinal_mps2",)]
CAR, CELLS, THERMISTORS = "vtm16e", "cells", "thermistors"
# Time, current, cells, thermistors, as loggers and languages call them; the cells are all that says the voltage.
NAMES = [("Time [s]", "Pack Current [A]", "Cell {} Voltage [V]", "Cell {} Temp [degC]"),
         ("time_s", "current_a", "cell_{}_v", "temp_{}_c"), ("Time", "Current", "Cell{}", "Thermistor{}"),
         ("Zeit (s)", "Strom (A)", "Zelle {} Spannung (V)", "Zelle {} Temperatur (°C)"),
         ("t(s)", "I(A)", "Vcell{} (mV)", "T{} (degC)"), ("Time (ms)", "Amps", "V{}", "Temp{}"),
         ("timestamp_ms", "BMS_Pack_Current_A", "BMS_Cell_Voltage_{:02d}_V", "BMS_Temp_{:02d}_C")]


def logged(draw, folder, log, thin, missing):
    """The same drive as another logger has it: without columns, or all CELLS or THERMISTORS."""
    names, rows = rows_of(log)
    digits = {"cell_": draw.random.choice([5, 3, 2]), "pack_voltage_v": draw.random.choice([3, 1]),
              "pack_current_a": draw.random.choice([3, 1, 0])}
    warm_digits = draw.random.choice([2, 1, 0])
    print(f"every {thin} rows, {digits}, {warm_digits} of temperatures, without {sorted(missing)}")
    columns = [k for k, name in enumerate(names) if name not in missing and
               not (CELLS in missing and name.startswith("cell_") and name.endswith("voltage_v")) and
               not (THERMISTORS in missing and name.endswith("temperature_c"))]

    def field(name, text):
        if name.endswith("temperature_c"):
            return f"{float(text):.{warm_digits}f}"
        for stem, decimals in digits.items():
            if name.startswith(stem) and (stem != "cell_" or name.endswith("voltage_v")):
                return f"{float(text):.{decimals}f}"
        return text
    return write(folder / "logger.csv", [names[k] for k in columns],
                 [[field(names[k], row[k]) for k in columns] for row in rows[::thin]])


def some(draw, share):
    return {name for group in MAY_BE_MISSING if draw.random.random() < share for name in group}


@pytest.mark.parametrize("number", range(6))
def test_a_sound_drive_is_sound_in_any_logger(tmp_path, number):
    draw = Draw(f"logger{number}")
    missing = some(draw, 0.35)
    if "pack_voltage_v" not in missing and draw.random.random() < 0.25:
        missing |= {CELLS}
    if draw.random.random() < 0.4:
        missing |= {THERMISTORS}
    log = logged(draw, tmp_path, draw.drive(tmp_path, vehicle=CAR), draw.random.choice([1, 2, 5, 10]), missing)
    answer, said = explained(tmp_path, log, model=CAR)
    assert answer["verdict"] == "no_discrepancy", said


@pytest.mark.parametrize("number", range(3))
def test_what_is_wrong_is_found_without_some_columns(tmp_path, number):
    draw = Draw(f"wrong{number}")
    key, low, high, name, *_ = draw.random.choice(EFFECTS)
    size = f"{draw.random.uniform(low, high):.4g}"
    missing = some(draw, 0.35) - {"pack_voltage_v"}
    log = logged(draw, tmp_path, draw.drive(tmp_path, key.format(size), vehicle=CAR), 1, missing)
    answer, said = explained(tmp_path, log, model=CAR)
    named = {n for cause in answer["causes"] for n in (cause["name"], *cause["equivalent_to"])}
    assert name in named, (key, size, said)


@pytest.mark.parametrize("hidden", [False, True])
def test_without_a_thermistor_a_cold_or_warm_battery_is_no_defect_and_a_contact_is_one(tmp_path, hidden):
    """Resistances of cells 15 K away are 20 % other; only who says how warm they were can tell them from an error."""
    draw = Draw(f"thermistor{hidden}")
    ohm = draw.random.uniform(2e-3, 5e-3)
    warm = draw.random.uniform(12.0, 42.0)
    keys = [f"battery.contact_resistance_ohm={ohm:.5f}"] if hidden else []
    drive = draw.drive(tmp_path, *keys, f"battery.initial_temperature_c={warm:.1f}", vehicle=CAR)
    log = logged(draw, tmp_path, drive, 1, {THERMISTORS})
    answer, said = explained(tmp_path, log, model=CAR)
    assert [cause["name"] for cause in answer["causes"]] == (["contact_resistance"] if hidden else []), (warm, said)
    assert answer["verdict"] == ("named" if hidden else "no_discrepancy"), (warm, said)
    assert "no thermistor: how warm the battery began the voltage alone tells" in said


@pytest.mark.parametrize("number", range(3))
def test_cells_that_are_rounded_alike_leave_no_rest_without_a_name(tmp_path, number):
    """Two dozen cells in steps of 10 mV: while they stand, their sum is off by up to 120 mV, and the contact beside it
    is all that is wrong."""
    draw = Draw(f"rounded{number}")
    ohm = draw.random.uniform(2e-3, 5e-3)
    drive = draw.drive(tmp_path, f"battery.contact_resistance_ohm={ohm:.5f}", vehicle=CAR)
    names, rows = rows_of(drive)
    digits = [2 if n.startswith("cell_") and n.endswith("voltage_v") else None for n in names]
    log = write(tmp_path / "coarse.csv", names,
                [[x if d is None else f"{float(x):.{d}f}" for x, d in zip(row, digits)] for row in rows])
    answer, said = explained(tmp_path, log, model=CAR)
    assert [cause["name"] for cause in answer["causes"]] == ["contact_resistance"], said
    assert answer["verdict"] == "named", said


def test_a_temperature_that_is_stated_tells_a_small_resistance_without_a_thermistor(tmp_path):
    draw = Draw("stated")
    warm, ohm = f"battery.initial_temperature_c={draw.random.uniform(20.0, 35.0):.1f}", draw.random.uniform(1e-4, 2e-4)
    log = logged(draw, tmp_path, draw.drive(tmp_path, f"cell.effects.series_ohm={ohm:.6f}", warm, vehicle=CAR), 1,
                 {THERMISTORS})
    answer, said = explained(tmp_path, log, "--set", warm, model=CAR)
    assert [cause["name"] for cause in answer["causes"]] == ["series_resistance"], said
    assert answer["causes"][0]["parameters"]["resistance_ohm"]["value"] == pytest.approx(ohm, rel=0.05), said


def test_a_drive_without_pedals_and_torque_is_explained_from_its_battery(tmp_path):
    draw = Draw("battery")
    missing = {"accelerator", "brake", "phase_current_a", "dc_link_v", "bms_soc", "soc"}
    log = logged(draw, tmp_path, draw.drive(tmp_path, vehicle=CAR), 1, missing)
    answer, said = explained(tmp_path, log, model=CAR)
    assert answer["verdict"] == "no_discrepancy" and "speed" not in answer["gain"], said


def renamed(draw, folder, log):
    """Current, cells and thermistors alone, under drawn names, counted from 0 or 1, with either sign of the current."""
    names, rows = rows_of(log)
    time, current, cell, thermistor = draw.random.choice(NAMES)
    first, sign = draw.random.choice([0, 1]), draw.random.choice([1, -1])
    print(f"{time}, {current}, {cell}, {thermistor} from {first}, sign {sign}")
    cells = [k for k, name in enumerate(names) if name.startswith("cell_") and name.endswith("voltage_v")]
    warm = [k for k, name in enumerate(names) if name.startswith("cell_") and name.endswith("temperature_c")]
    at, amperes = names.index("time_s"), names.index("pack_current_a")
    seconds, volts = 1000.0 if "ms" in time else 1.0, 1000.0 if "mV" in cell else 1.0
    header = [time, current, *(cell.format(k + first) for k in range(len(cells))),
              *(thermistor.format(k + first) for k in range(len(warm)))]
    return write(folder / "renamed.csv", header,
                 [[f"{seconds * float(row[at]):.2f}", f"{sign * float(row[amperes]):.2f}",
                   *(f"{volts * float(row[k]):.4f}" for k in cells), *(row[k] for k in warm)] for row in rows])


@pytest.mark.parametrize("hidden", [False, True])
def test_cells_without_a_pack_voltage_are_found_whatever_they_are_called(tmp_path, hidden):
    draw = Draw(f"names{hidden}")
    keys = ["cell.effects.series_ohm=0.0003"] if hidden else []
    answer, said = explained(tmp_path, renamed(draw, tmp_path, draw.drive(tmp_path, *keys, vehicle=CAR)), model=CAR)
    assert [cause["name"] for cause in answer["causes"]] == (["series_resistance"] if hidden else []), said
    assert answer["verdict"] == ("named" if hidden else "no_discrepancy"), said


@pytest.mark.parametrize("number", range(4))
def test_thermistors_that_hardly_tell_the_heat_are_said(tmp_path, number):
    """Of steps that nobody passed twice nothing small can be seen: that is no proof that all is right."""
    draw = Draw(f"heat{number}")
    step = draw.random.choice([0.1, 0.5, 1.0, 2.0])
    names, rows = rows_of(draw.drive(tmp_path, laps=draw.random.choice([1, 2, 4]), vehicle=CAR))
    warm = [n.endswith("temperature_c") and (n.startswith("cell_") or n == "battery_temperature_c") for n in names]
    rows = [[f"{round(float(x) / step) * step:.1f}" if w else x for x, w in zip(row, warm)] for row in rows]
    passed = min(len({row[k] for row in rows}) - 1 for k, w in enumerate(warm) if w)
    answer, said = explained(tmp_path, write(tmp_path / "steps.csv", names, rows), model=CAR)
    assert answer["verdict"] == "no_discrepancy", (step, said)
    assert ("battery's heat" in said) == (step > 0.35 and passed < 2), (step, passed, said)


def test_thermistors_that_never_tell_the_heat_together_are_said(tmp_path):
    """A reading in whole kelvins tells the warmth between two of its changes: of some early, of the others late."""
    draw = Draw("apart")
    names, rows = rows_of(draw.drive(tmp_path, vehicle=CAR))
    for k, name in enumerate(names):
        if name.startswith("cell_") and name.endswith("temperature_c"):
            first = (0.1 if int(name.split("_")[1]) % 2 else 0.6) * len(rows)
            for at, row in enumerate(rows):
                row[k] = str(30 + (at > first) + (at > first + 0.3 * len(rows)))
    answer, said = explained(tmp_path, write(tmp_path / "apart.csv", names, rows), model=CAR)
    assert "nothing of its heat is judged" in said, said


@pytest.mark.parametrize("number", range(2))
def test_what_the_tool_itself_decodes_is_read_as_it_stands(tmp_path, number):
    """Every signal of every frame beside each other, counters and checksums too, a column each."""
    draw = Draw(f"decoded{number}")
    log, table = draw.drive(tmp_path, candump=True), tmp_path / "decoded.csv"
    run("log", "decode", log, "--dbc", DBC, "--every", draw.random.choice(["0.1", "0.2"]), "--out", table)
    answer, said = explained(tmp_path, table)
    assert answer["verdict"] == "no_discrepancy", f"{answer['sentence']}\n{said}"
    assert 'current from "PackCurrent [A]"' in said and "cell_voltage_1 to 24" in said, said


@pytest.mark.parametrize("number", range(3))
def test_heat_that_a_coarse_log_cannot_name_is_not_called_nothing(tmp_path, number):
    draw = Draw(f"heat{number}")
    log, rate = tmp_path / "drive.csv", draw.random.choice([1, 2])
    heat = draw.random.uniform(300.0, 420.0)  # of 747 J/kg/K
    print(f"{heat:.0f} J/kg/K at {rate} Hz")
    run("endurance", "--vehicle", CAR, "--laps", 14, "--seed", draw.random.randrange(2**31), "--csv", log, "--rate",
        rate, "--set", "battery.initial_soc=0.95", "battery.initial_temperature_c=25",
        f"cell.heat_capacity_j_per_kg_k={heat}")
    answer, said = explained(tmp_path, log, "--set", "battery.initial_temperature_c=25")
    names = [cause["name"] for cause in answer["causes"]]
    assert names or "temperature (" in answer["sentence"], said
    assert answer["verdict"] != "no_discrepancy" or "finer log tells" in answer["sentence"], said
