# SPDX-License-Identifier: Apache-2.0
"""What loggers do to a sound drive: units and clocks that nobody names, stamps coarser than rows, readings that are
written again, sensors that break, cells named by module. The truth stays what it was; the draw's seed is printed."""
import functools
import json
import math
import os
import random

import pytest
from straight_pack import CELLS, MAP, PACK, RATE, rows, voltlap

SEED = int(os.environ.get("VOLTLAP_TEST_SEED", "20261127"))
SECONDS = 60
STEPS = [random.Random(f"{SEED} {second}").uniform(0.0, 120.0) for second in range(SECONDS)]


@pytest.fixture
def rng(request):
    return random.Random(f"{SEED} {request.node.name}")


def race_current(time):
    """No pulse like the next: steps of a second between 0 and 120 A behind a rest."""
    return STEPS[int(time)] if time >= 5.0 else 0.0


@functools.cache
def drive():
    return list(drawn_rows())


def drawn_rows():
    for k, row in enumerate(rows(SECONDS, soc=0.8, current=race_current)):
        yield {"Time": row["time_s"], "Pack Current": row["current_a"], "Pack Voltage": row["pack_voltage_v"],
               **{f"Temp {n}": 30.0 + n + 0.001 * k for n in range(1, 5)},
               **{f"Cell {n}": row[f"cell_voltage_{n}_v"] for n in range(1, CELLS + 1)}}


def replay(folder, table, *arguments, code=0):
    table = list(table)
    text = [",".join(table[0])]
    text += [",".join("" if value is None else f"{value:.6f}" if isinstance(value, float) else str(value)
                      for value in row.values()) for row in table]
    (folder / "log.csv").write_text("\n".join(text) + "\n")
    (folder / "pack.toml").write_text(PACK)
    run = voltlap("replay", folder / "log.csv", "--pack", folder / "pack.toml", "--json", folder / "o.json", *arguments)
    assert run.returncode == code, run.stderr
    return run, json.loads((folder / "o.json").read_text()) if code == 0 else None


def truth_pct():
    charge = sum(race_current(k / RATE) for k in range(SECONDS * RATE)) / RATE / 3600.0
    return 100.0 * (0.8 - charge / 9.0)


UNITS = {
    "as_they_are": {}, "time_ms": {"Time": 1e3}, "current_ma": {"Pack Current": 1e3}, "pack_mv": {"Pack Voltage": 1e3},
    "time_ms_current_ma": {"Time": 1e3, "Pack Current": 1e3},
    "cells_mv": {f"Cell {n}": 1e3 for n in range(1, CELLS + 1)},
}


@pytest.mark.parametrize("habit", UNITS)
def test_a_unit_that_nobody_names_is_found(tmp_path, habit):
    run, out = replay(tmp_path, ({name: value * UNITS[habit].get(name, 1.0) for name, value in row.items()}
                                 for row in drive()))
    assert out["duration_s"] == pytest.approx(SECONDS, abs=0.1), (SEED, run.stdout)
    assert out["soc_end_pct"] == pytest.approx(truth_pct(), abs=0.1), (SEED, run.stdout)
    assert out["faults"] == [] and out["cells"] == CELLS
    assert habit in ("as_they_are", "cells_mv") or "which nobody says" in run.stdout


def any_drive(rng):
    """Rows of any cell, from a cold one of 100 mV at one C to LFP whose curve hardly falls, any rate, any length."""
    slope_v = 10 ** rng.uniform(-1.7, -1.0) if rng.random() < 0.5 else rng.uniform(0.5, 1.2)
    # R over the slope is a time; below 25 s (10 mV at one C of a steep cell) milliseconds cannot be told for sure
    capacity, at_one_c_v = 10 ** rng.uniform(0.5, 2.3), max(10 ** rng.uniform(-2.3, -1.0), 25.0 / 3600.0 * slope_v)
    most_a = min(1500.0, capacity * 10 ** rng.uniform(-0.5, 1.0))
    step_s, held_s = rng.choice([0.1, 0.5, 1, 2, 5, 10]), rng.choice([0, 0, 1, 5])
    amps, soc, seen_v, seen_s = 0.0, rng.uniform(0.5, 0.9), None, -1e9
    for k in range(max(200, min(3000, int(10 ** rng.uniform(-1.5, 0.7) * 3600.0 / step_s)))):
        time = k * step_s
        if time >= 5.0 * max(1.0, step_s) and rng.random() < min(1.0, step_s):
            amps = rng.uniform(-0.3, 1.0) * most_a
        soc -= amps * step_s / 3600.0 / capacity
        if soc < 0.05:
            return
        volts = 3.3 + slope_v * (soc - 0.5) - at_one_c_v / capacity * amps
        if time - seen_s >= held_s - 1e-6:
            seen_v, seen_s = round(volts, 3), time
        yield {"Time": time, "Pack Current": amps, "Pack Voltage": round(6 * volts, 2),
               **{f"Cell {n}": seen_v for n in range(1, 7)}}


@pytest.mark.parametrize("case", range(16))
def test_no_unit_is_invented_and_none_is_missed(tmp_path, rng, case):
    """In seconds and amperes nothing is changed; nor are milliseconds and milliamperes overlooked."""
    table = []
    while len(table) < 200:
        table = list(any_drive(rng))
    scale = {"Time": rng.choice([1.0, 1.0, 1e3]), "Pack Current": rng.choice([1.0, 1.0, 1e3])}
    text = [",".join(table[0])] + [",".join(f"{value * scale.get(name, 1.0):.3f}" for name, value in row.items())
                                   for row in table]
    (tmp_path / "log.csv").write_text("\n".join(text) + "\n")
    run = voltlap("replay", tmp_path / "log.csv", "--json", tmp_path / "o.json")
    assert run.returncode == 0, run.stderr
    said = " ".join(json.loads((tmp_path / "o.json").read_text())["notes"])
    for name, unit in (("Time", "ms"), ("Pack Current", "mA")):
        assert (f'"{name}" is in {unit}' in said) == (scale[name] != 1.0), (SEED, case, scale, said)
        assert scale[name] != 1.0 or f'"{name}" is in' not in said, (SEED, case, said)


def test_a_pack_of_many_amperes_keeps_them(tmp_path):
    """1400 A of a truck: more than a racing car has, and the cells' resistance says that they are true."""
    table = []
    for k, row in enumerate(drive()):
        amps = 14.0 * row["Pack Current"]
        volts = 3.8 - 0.0002 * amps
        table.append({"Time": row["Time"], "Pack Current": amps, "Pack Voltage": round(CELLS * volts, 2),
                      **{f"Cell {n}": round(volts, 3) for n in range(1, CELLS + 1)}})
    run, _ = replay(tmp_path, table)
    assert "is in mA" not in run.stdout, run.stdout


def test_another_family_does_not_replace_the_cells_temperature(tmp_path):
    table = ({**{name: value for name, value in row.items() if not name.startswith("Temp")},
              "Cell Temperature [C]": 31.0, **{f"Coolant Temp {n} [C]": 60.0 + n for n in range(1, 4)}}
             for row in drive())
    run, _ = replay(tmp_path, table)
    assert 'temperature_1 from "Cell Temperature [C]"' in run.stdout and "TemperatureHigh" not in run.stdout
    assert '"Coolant Temp 1 [C]"' in run.stdout.split("no role takes")[1]


def test_rows_of_one_moment_are_not_spread(tmp_path):
    """A channel in each row: the rows of one stamp are one moment."""
    (tmp_path / "m.toml").write_text("""[roles]
time = {column = "t", unit = "s"}
current = {column = "i", unit = "A", discharge = "+"}
"cell_voltage_<n>" = {column = "v", index = "n", unit = "V"}
""")
    lines = ["t,i,n,v"]
    for row in rows(20, soc=0.8):
        if round(row["time_s"] * RATE) % 5:
            continue
        lines.append(f"{row['time_s']:.2f},{row['current_a']:.2f},,")
        lines += [f"{row['time_s']:.2f},,{n},{row[f'cell_voltage_{n}_v']:.4f}" for n in range(1, CELLS + 1)]
    (tmp_path / "log.csv").write_text("\n".join(lines) + "\n")
    (tmp_path / "pack.toml").write_text(PACK)
    run = voltlap("replay", tmp_path / "log.csv", "--map", tmp_path / "m.toml", "--pack", tmp_path / "pack.toml")
    assert run.returncode == 0 and "spread" not in run.stdout, run.stdout + run.stderr
    assert "faults            none" in run.stdout


CLOCKS = {
    "epoch_ms": lambda t: 1781443507000.0 + 1e3 * t, "epoch_us": lambda t: 1781443507e6 + 1e6 * t,
    "spreadsheet_days": lambda t: f"{46187.5 + t / 86400.0:.9f}", "whole_seconds": lambda t: float(math.floor(t)),
    "tenths": lambda t: math.floor(t * 10.0) / 10.0,
}


@pytest.mark.parametrize("habit", CLOCKS)
def test_a_clock_of_any_origin_and_step(tmp_path, habit):
    run, out = replay(tmp_path, ({**row, "Time": CLOCKS[habit](row["Time"])} for row in drive()))
    assert out["duration_s"] == pytest.approx(SECONDS, abs=0.1), (SEED, run.stdout)
    assert out["soc_end_pct"] == pytest.approx(truth_pct(), abs=0.2), (SEED, run.stdout)
    assert out["faults"] == []
    spread = {"whole_seconds": RATE, "tenths": RATE // 10}.get(habit)
    assert (f"some {spread} rows have one stamp" in run.stdout) if spread else "one stamp" not in run.stdout


def test_a_date_written_as_one_number_is_refused(tmp_path):
    run, _ = replay(tmp_path, ({**row, "Time": f"202606141159{row['Time'] % 60:05.2f}"} for row in drive()), code=2)
    assert "a date and time written as one number" in run.stderr


@pytest.mark.parametrize("broken", [6.5535, 0.0])
def test_a_cell_whose_wire_breaks_is_judged_until_then(tmp_path, rng, broken):
    weak, low = rng.randrange(1, CELLS + 1), rng.uniform(8.0, 30.0)
    end = rng.uniform(40.0, 58.0)

    def planted(row):
        volts = broken if row["Time"] > end else 2.7 if low < row["Time"] < low + 2.0 else row[f"Cell {weak}"]
        return {**row, f"Cell {weak}": volts}

    _, out = replay(tmp_path, map(planted, drive()))
    about = f"seed {SEED}: cell {weak}, low at {low:.1f} s, broken at {end:.1f} s"
    assert [violation["cell"] for violation in out["limit_violations"]] == [weak], about
    trips = [(fault["id"], fault["about"]) for fault in out["faults"] if fault["opens"]]
    assert trips[0][0] == "CellVoltageLow", (about, trips)
    assert any(fault["about"] == f"cell_voltage_{weak}" for fault in out["faults"]), (about, out["faults"])


NAMES = {"M{m}C{n:02d} [V]": 1, "Module {m} Cell {n}": 1, "Segment{m0} Cell{n0} Voltage [V]": 1, "{letter}{n} [V]": 1}


@pytest.mark.parametrize("name", NAMES)
def test_cells_named_by_module_are_one_pack(tmp_path, rng, name):
    per = rng.choice([4, 6, 8, 12])

    def of(n):
        module, cell = divmod(n - 1, per)
        return name.format(m=module + 1, m0=module, n=cell + 1, n0=cell, letter="ABCDEFGH"[module])

    def renamed(row):
        return {of(int(key[5:])) if key.startswith("Cell ") else key: value for key, value in row.items()}

    def weak(row):
        return {**row, "Cell 7": row["Cell 7"] - 0.75 if row["Time"] > 30.0 else row["Cell 7"]}

    run, out = replay(tmp_path, (renamed(weak(row)) for row in drive()))
    assert out["cells"] == CELLS and "no cell voltages" not in run.stdout, run.stdout
    assert {violation["cell"] for violation in out["limit_violations"]} == {7}, (SEED, per)


@pytest.mark.parametrize("case", range(3))
def test_a_slow_cell_that_is_written_again_is_read_once(tmp_path, rng, case):
    every, held, table = rng.uniform(1.0, 6.0), {}, []
    for row in drive():
        for key in row:
            if key.startswith("Cell ") and (key not in held or row["Time"] >= held[key][0] + every - 1e-6):
                held[key] = (row["Time"], round(row[key], 3))
        table.append({**row, **{key: value for key, (_, value) in held.items()}})
    run, out = replay(tmp_path, table)
    assert [fault for fault in out["faults"] if fault["opens"]] == [], (SEED, every, run.stdout)
    assert "taken once" in run.stdout
    assert out["soc_end_pct"] == pytest.approx(truth_pct(), abs=0.2), (SEED, every)


@pytest.mark.parametrize("none, word, value", [("NONE", "OVERTEMP", 1), ("0x0000", "0x0004", 4), ("FALSE", "TRUE", 1),
                                               ("0", "5", 5)])
def test_a_fault_word_of_any_form_is_read(tmp_path, rng, none, word, value):
    at = rng.uniform(10.0, 50.0)
    (tmp_path / "m.toml").write_text(MAP.split("[roles]")[0] + """[roles]
time = {column = "Time", unit = "s"}
current = {column = "Pack Current", unit = "A", discharge = "+"}
pack_voltage = {column = "Pack Voltage", unit = "V"}
"cell_voltage_<n>" = {column = "Cell <n>", unit = "V"}
fault_1 = {column = "DTC"}
""")
    table = ({**row, "DTC": word if at < row["Time"] < at + 2.0 else none} for row in drive())
    _, out = replay(tmp_path, table, "--map", tmp_path / "m.toml")
    faults = out["logged_faults"]
    assert len(faults) == 1 and faults[0]["time_s"] == pytest.approx(at, abs=0.03), (SEED, at, faults)
    assert faults[0]["value"] == value or none in ("NONE", "FALSE")
