# SPDX-License-Identifier: Apache-2.0
"""Logs of the plant itself for the suites of voltlap explain: drives with usual sensors' noise, and what is planted in
them."""
import csv
import json
import math
import os
import pathlib
import random
import subprocess

VOLTLAP = pathlib.Path(os.environ["VOLTLAP_BUILD_DIR"]) / "bin" / "voltlap"
CELLS, THERMISTORS = 24, (1, 5, 9, 13, 17, 21)


def voltlap(*arguments, code=0, folder=None):
    run = subprocess.run([VOLTLAP, *map(str, arguments)], cwd=folder, capture_output=True, text=True, timeout=120)
    assert run.returncode == code, run.stderr
    return run


# The car and the driver that these tests were written for.
AS_WRITTEN_FOR = ("low_voltage.power_w=575", "driver.grip_use=1", "motor.curve_voltage_v=0")


class Drives:
    """Drives of six laps by what was set in the plant, each made once."""

    def __init__(self, folder):
        self.folder, self.made = folder, {}

    def __call__(self, *settings, laps=6):
        if (settings, laps) not in self.made:
            path = self.folder / f"{len(self.made)}.csv"
            chosen = [x for s in (*AS_WRITTEN_FOR, *settings) for x in ("--set", s)]
            voltlap("endurance", "--laps", laps, "--csv", path, *chosen)
            with open(path, encoding="ascii") as file:
                self.made[settings, laps] = list(csv.DictReader(line for line in file if not line.startswith("#")))
        draw = random.Random(1)
        out = []
        for row in self.made[settings, laps]:
            pick = lambda name, sigma: float(row[name]) + draw.gauss(0.0, sigma)
            out.append({"time_s": float(row["time_s"]), "pack_current_a": pick("pack_current_a", 0.3),
                        "pack_voltage_v": pick("pack_voltage_v", 0.03),
                        **{f"cell_voltage_{n}_v": pick(f"cell_{n}_voltage_v", 0.0015) for n in range(1, CELLS + 1)},
                        **{f"temperature_{k + 1}_c": pick(f"cell_{n}_temperature_c", 0.15)
                           for k, n in enumerate(THERMISTORS)}})
        return out


def write(path, rows, columns=None):
    columns = columns or list(rows[0])
    with open(path, "w", encoding="ascii") as file:
        file.write(",".join(columns) + "\n")
        for row in rows:
            file.write(",".join(f"{row[name]:.5f}" for name in columns) + "\n")
    return path


def one_cell(rows):
    """The same drive as a recording of its first cell."""
    return [{"time_s": row["time_s"], "current_a": row["pack_current_a"], "voltage_v": row["cell_voltage_1_v"],
             "temperature_c": row["temperature_1_c"]} for row in rows]


def explained(folder, rows, *arguments, columns=None, model="vtm16e"):
    log, out = write(folder / "log.csv", rows, columns), folder / "out.json"
    voltlap("explain", log, "--model", model, "--json", out, *arguments)
    return json.loads(out.read_text())


def contact(rows, ohm):
    return [{**row, "pack_voltage_v": row["pack_voltage_v"] - ohm * row["pack_current_a"]} for row in rows]


def stuck(rows, cell=3, first=1000, last=1200):
    held = {f"cell_voltage_{cell}_v": rows[first][f"cell_voltage_{cell}_v"]}
    return [{**row, **held} if first <= k < last else row for k, row in enumerate(rows)]


def lagging(rows, lag_s):
    names = [name for name in rows[0] if name.startswith("temperature_")]
    out, read = [], {name: rows[0][name] for name in names}
    for before, row in zip([rows[0], *rows], rows):
        share = 1.0 - math.exp(-(row["time_s"] - before["time_s"]) / lag_s)
        read = {name: read[name] + share * (row[name] - read[name]) for name in names}
        out.append({**row, **read})
    return out


def comes_and_goes(rows):
    """A resistance of the cells that rises to 0.4 mOhm and falls again, as no cause does; its mean is 0.2 mOhm."""
    last = rows[-1]["time_s"]
    ohm = [4e-4 * (1 - abs(2 * row["time_s"] / last - 1)) for row in rows]
    return [{k: v - r * row["pack_current_a"] * {"cell": 1, "pack": 24}.get(k.split("_voltage")[0], 0)
             for k, v in row.items()} for row, r in zip(rows, ohm)]
