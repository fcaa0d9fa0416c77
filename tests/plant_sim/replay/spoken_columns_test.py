# SPDX-License-Identifier: Apache-2.0
"""Tables of teams that nobody has written a map for: what their columns say is used, in whatever words, and what no
role takes is named. Spellings are drawn; the seed is printed."""
import json
import os
import random

import pytest
from straight_pack import CELLS, PACK, rows, voltlap

SEED = int(os.environ.get("VOLTLAP_TEST_SEED", "20261127"))
DRAWN = int(os.environ.get("VOLTLAP_TEST_TABLES", "12"))

TIME = [("time_s", 1), ("Time [s]", 1), ("t [ms]", 1000), ("Zeit [s]", 1), ("Timestamp (s)", 1), ("time_ms", 1000)]
CURRENT = [("current_a", 1), ("Pack Current [A]", 1), ("Batteriestrom [A]", 1), ("HV_Current (A)", -1),
           ("i_pack [mA]", 1000)]
PACK_VOLTAGE = [("pack_voltage_v", 1), ("Pack Voltage [V]", 1), ("voltage_v", 1), ("Batteriespannung [V]", 1),
                ("Voltage [V]", 1), ("HV Voltage (mV)", 1000)]
CELL = [("cell_{n}_v", 1), ("Cell {n}", 1), ("Zellspannung {n} [V]", 1), ("cell{n}_voltage [mV]", 1000),
        ("V_cell_{n}", 1),
        ("Cell{n:02d} (V)", 1), ("cell_voltage_{n}", 1), ("Cell {n} Voltage (V)", 1), ("tension_cellule_{n} [V]", 1)]
TEMPERATURE = [("temp_1", 1), ("Temp {n}", 1), ("Zelltemperatur {n} [°C]", 1), ("cell_temp_{n}_c", 1),
               ("T{n} [degC]", 1), ("thermistor_{n} (°C)", 1)]
SOC = [("SOC", 1), ("soc_pct", 100), ("SoC [%]", 100), ("Ladezustand [%]", 100), ("pack_soc", 1), ("SOC (%)", 100),
       ("State of Charge (%)", 100), ("StateOfCharge", 1), ("stato_di_carica", 1)]


def drawn_table(rng, folder):
    """24 cells of which the fifth is weak, in names that are drawn; the names beside the file."""
    names = {"time": rng.choice(TIME), "current": rng.choice(CURRENT), "pack": rng.choice(PACK_VOLTAGE),
             "cell": rng.choice(CELL), "temperature": rng.choice(TEMPERATURE), "soc": rng.choice(SOC)}
    separator = rng.choice([",", ";", "\t"])
    first = rng.choice([0, 1])
    comma = separator != "," and rng.random() < 0.3
    extra = rng.random() < 0.5

    def put(text, n=1):
        return text.replace("{n:02d}", f"{n:02d}").replace("{n}", str(n))

    header = [names["time"][0], names["current"][0], names["pack"][0], names["soc"][0]]
    header += [put(names["temperature"][0], n) for n in (1, 2)][:2 if "{" in names["temperature"][0] else 1]
    header += [put(names["cell"][0], n - 1 + first) for n in range(1, CELLS + 1)] + (["gear lever"] if extra else [])
    lines = [separator.join(header)]
    for row in rows(9, soc=0.40):
        weak = [row[f"cell_voltage_{n}_v"] - (0.08 if n == 5 else 0.0) for n in range(1, CELLS + 1)]
        values = [row["time_s"] * names["time"][1], row["current_a"] * names["current"][1],
                  sum(weak) * names["pack"][1], row["soc"] * names["soc"][1]]
        values += [30.0, 31.0][:2 if "{" in names["temperature"][0] else 1]
        values += [volts * names["cell"][1] for volts in weak] + ([rng.random()] if extra else [])
        fields = [f"{value:.5f}" for value in values]
        lines.append(separator.join(field.replace(".", ",") if comma else field for field in fields))
    log = folder / "log.csv"
    log.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return log, names, extra


@pytest.mark.parametrize("case", range(DRAWN))
def test_a_table_in_any_words_gives_all_that_it_says(tmp_path, case):
    rng = random.Random(f"{SEED} {case}")
    log, names, extra = drawn_table(rng, tmp_path)
    about = f"seed {SEED}, case {case}: {names}"
    (tmp_path / "pack.toml").write_text(PACK)
    run = voltlap("replay", log, "--pack", tmp_path / "pack.toml", "--json", tmp_path / "out.json")
    assert run.returncode == 0, f"{about}\n{run.stderr}"
    out = json.loads((tmp_path / "out.json").read_text())
    assumed = " ".join(out["assumptions"])
    assert not [word for word in ("no cell", "have no reading", "no temperature", "no pack") if word in assumed], \
        f"{about}\n{assumed}"
    assert out["soc_logged_end_pct"] == pytest.approx(100 * list(rows(9, soc=0.40))[-1]["soc"], abs=0.01), about
    assert [violation["cell"] for violation in out["limit_violations"]] == [5], about
    assert out["soc_start_pct"] == pytest.approx(40.0, abs=0.6), about
    assert not extra or "gear lever" in run.stdout, f"{about}\n{run.stdout}"


@pytest.mark.parametrize("pack", [*(name for name, _ in PACK_VOLTAGE), "Akkuspannung (V)", "Total voltage [V]", "vbat"])
def test_a_pack_voltage_in_any_words_is_found_beside_plain_columns(tmp_path, pack):
    """Time, current and cells that are called as we call them were enough: what else they had was not looked at."""
    scale = 1000 if "mV" in pack else 1
    lines = [",".join(["time_s", "current_a", pack, *(f"cell_voltage_{n}_v" for n in range(1, CELLS + 1))])]
    for row in rows(9, soc=0.40):
        cells = [row[f"cell_voltage_{n}_v"] for n in range(1, CELLS + 1)]
        values = (row["time_s"], row["current_a"], scale * sum(cells), *cells)
        lines.append(",".join(f"{value:.5f}" for value in values))
    log = tmp_path / "log.csv"
    log.write_text("\n".join(lines) + "\n", encoding="utf-8")
    (tmp_path / "pack.toml").write_text(PACK)
    run = voltlap("replay", log, "--pack", tmp_path / "pack.toml")
    assert run.returncode == 0 and "no pack voltage" not in run.stdout, run.stdout + run.stderr
