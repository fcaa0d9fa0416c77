# SPDX-License-Identifier: Apache-2.0
"""Loggers as teams have them: rows a tenth to a second apart, in steps, and without some of the columns. A sound drive
is sound in each of them; where only some are gone what is wrong is found. VOLTLAP_TEST_SEED repeats a draw."""
import pytest

from drawn_drives import EFFECTS, Draw, explained, rows_of, write

# Together or not at all. Thermistors stay: without them nobody knows the resistance that a sound cell has.
MAY_BE_MISSING = [("soc", "bms_soc"), ("charge_drawn_ah",), ("dc_link_v",), ("phase_current_a",), ("accelerator",),
                  ("brake",), ("speed_mps",), ("speed_kmh",), ("pack_voltage_v",), ("longitudinal_mps2",)]
CAR = "vtm16e"


def logged(draw, folder, log, thin, missing, cells=True):
    """The same drive as another logger has it."""
    names, rows = rows_of(log)
    digits = {"cell_": draw.random.choice([5, 3, 2]), "pack_voltage_v": draw.random.choice([3, 1]),
              "pack_current_a": draw.random.choice([3, 1, 0])}
    print(f"every {thin} rows, {digits}, without {sorted(missing)}{'' if cells else ' and cells'}")
    columns = [k for k, name in enumerate(names) if name not in missing and
               (cells or not (name.startswith("cell_") and name.endswith("voltage_v")))]

    def field(name, text):
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
    cells = "pack_voltage_v" in missing or draw.random.random() < 0.75
    log = logged(draw, tmp_path, draw.drive(tmp_path, vehicle=CAR), draw.random.choice([1, 2, 5, 10]), missing, cells)
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


def test_a_drive_without_pedals_and_torque_is_explained_from_its_battery(tmp_path):
    draw = Draw("battery")
    missing = {"accelerator", "brake", "phase_current_a", "dc_link_v", "bms_soc", "soc"}
    log = logged(draw, tmp_path, draw.drive(tmp_path, vehicle=CAR), 1, missing)
    answer, said = explained(tmp_path, log, model=CAR)
    assert answer["verdict"] == "no_discrepancy" and "speed" not in said.split("The test")[0], said
