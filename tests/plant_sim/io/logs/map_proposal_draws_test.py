# SPDX-License-Identifier: Apache-2.0
"""Recordings of the own simulator under drawn names, units, orders, noise and decoys: what is proposed for them is
right, or the choice is refused; nothing is ever wrong. VOLTLAP_DRAWS=500 draws more, VOLTLAP_SEED others."""
import csv
import math
import os
import random
import subprocess
import tomllib
from collections import Counter
from pathlib import Path

import pytest

BUILD = Path(os.environ["VOLTLAP_BUILD_DIR"])
DRAWS = int(os.environ.get("VOLTLAP_DRAWS", "30"))
SEED = int(os.environ.get("VOLTLAP_SEED", "1"))

NAMES = {
    "english": {"time": ["Time", "Test Time", "t"], "current": ["Current", "Pack Current", "I", "Battery Current"],
                "voltage": ["Voltage", "Pack Voltage", "U_Batt"], "bus": ["DC Bus Voltage", "Inverter Bus Voltage"],
                "filtered": ["Current filtered", "I_filt"], "set": ["Current set point", "I_target"],
                "power": ["Power", "Battery Power"], "temperature": ["Cell Temperature", "Temp 1"],
                "soc": ["SOC"], "speed": ["Vehicle Speed"], "torque": ["Motor Torque"]},
    "german": {"time": ["Zeit"], "current": ["Strom", "Batteriestrom"], "voltage": ["Spannung", "Packspannung"],
               "bus": ["Zwischenkreisspannung"], "filtered": ["Strom gefiltert"], "set": ["Strom Soll"],
               "power": ["Leistung"], "temperature": ["Temperatur"], "soc": ["Ladezustand"],
               "speed": ["Geschwindigkeit"], "torque": ["Drehmoment"]},
    "french": {"time": ["temps"], "current": ["courant"], "voltage": ["tension"], "bus": ["tension bus"],
               "filtered": ["courant filtre"], "set": ["courant consigne"], "power": ["puissance"],
               "temperature": ["temperature"], "soc": ["soc"], "speed": ["vitesse"], "torque": ["couple"]},
    "spanish": {"time": ["tiempo"], "current": ["corriente"], "voltage": ["voltaje"], "bus": ["voltaje bus"],
                "filtered": ["corriente filtered"], "set": ["corriente consigna"], "power": ["potencia"],
                "temperature": ["temperatura"], "soc": ["soc"], "speed": ["velocidad"], "torque": ["par"]},
    "chinese": {"time": ["时间"], "current": ["电流", "总电流"], "voltage": ["电压", "总电压"], "bus": ["母线电压"],
                "filtered": ["电流 filtered"], "set": ["设定电流"], "power": ["功率"], "temperature": ["温度"],
                "soc": ["SOC"], "speed": ["车速"], "torque": ["扭矩"]},
    "letters": {}, "numbered": {}}
UNITS = {"time": [("s", 1.0, 0.0), ("ms", 1e3, 0.0), ("min", 1 / 60, 0.0)],
         "current": [("A", 1.0, 0.0), ("mA", 1e3, 0.0)],
         "voltage": [("V", 1.0, 0.0), ("mV", 1e3, 0.0)], "temperature": [("degC", 1.0, 0.0), ("K", 1.0, 273.15)],
         "power": [("kW", 1e-3, 0.0), ("W", 1.0, 0.0)], "soc": [("%", 100.0, 0.0), ("", 1.0, 0.0)],
         "speed": [("m/s", 1.0, 0.0), ("km/h", 3.6, 0.0)], "torque": [("Nm", 1.0, 0.0)]}
SAME_UNIT = {"filtered": "current", "set": "current", "bus": "voltage"}
DECOYS = ["bus", "filtered", "set", "power", "temperature", "soc", "speed", "torque"]


@pytest.fixture(scope="session")
def runs(tmp_path_factory):
    """SI columns of three races: a lap from rest, a longer one, another battery."""
    folder = tmp_path_factory.mktemp("runs")
    out = []
    for name, flags in (("lap", ["--laps", "1"]), ("laps", ["--laps", "3", "--rate", "5"]),
                        ("cells", ["--laps", "1", "--set", "battery.cells_in_series=20"])):
        path = folder / f"{name}.csv"
        subprocess.run([BUILD / "bin/voltlap", "endurance", *flags, "--csv", path], check=True, capture_output=True)
        rows = list(csv.DictReader(line for line in path.read_text().splitlines() if line[0] != "#"))
        column = lambda key, rows=rows: [float(row[key]) for row in rows]
        current, voltage = column("pack_current_a"), column("pack_voltage_v")
        step = float(rows[1]["time_s"]) - float(rows[0]["time_s"])
        filtered, target, low = [], [], current[0]
        for k, value in enumerate(current):
            low += (value - low) * min(1.0, step / 0.4)
            filtered.append(low)
            target.append(round(current[min(k + 1, len(current) - 1)] / 5) * 5)  # a step ahead and coarse
        out.append({"time": column("time_s"), "current": current, "voltage": voltage, "bus": column("dc_link_v"),
                    "filtered": filtered, "set": target, "power": [i * u for i, u in zip(current, voltage)],
                    "temperature": column("battery_temperature_c"), "soc": column("soc"), "speed": column("speed_mps"),
                    "torque": [0.4 * i for i in column("phase_current_a")]})
    return out


def drawn_names(rng, keys):
    style = rng.choice(list(NAMES))
    if style == "letters":
        names = dict(zip(keys, rng.sample("abcdefghijklmnopqrsuvwxyz", len(keys))))
    elif style == "numbered":
        names = {key: f"ch{n}" for n, key in enumerate(rng.sample(keys, len(keys)))}
    else:
        names = {key: rng.choice(NAMES[style][key]) for key in keys}
    return style, names


def drawn_table(rng, run, path):
    """Writes a table; {role: (column, scale, offset to SI, sign)} and how it was drawn."""
    keys = ["time", "current", "voltage", *rng.sample(DECOYS, rng.randint(0, len(DECOYS)))]
    style, names = drawn_names(rng, keys)
    told = rng.choice(["brackets", "slash", "none"])
    noise, sign = rng.choice([0.0, 0.0, 0.001, 0.005]), rng.choice([1, -1])
    columns, truth = [], {}
    for key in keys:
        unit, scale, offset = rng.choice(UNITS[SAME_UNIT.get(key, key)])
        name = names[key]
        if unit and told == "brackets":
            name = f"{name} [{unit}]"
        if unit and told == "slash":
            name = f"{name}/{unit}"
        turned = sign if key in ("current", "filtered", "set", "power") else 1
        spread = 0.0 if key in ("time", "set") else noise * max(abs(v) for v in run[key])
        values = [turned * (value + rng.gauss(0.0, spread)) * scale + offset for value in run[key]]
        columns.append((name, values))
        truth[key] = (name, 1 / scale, -offset / scale)
    rng.shuffle(columns)
    digits = rng.choice([5, 6, 8])
    with open(path, "w", encoding="utf-8") as file:
        file.write(",".join(name for name, _ in columns) + "\n")
        for row in zip(*(values for _, values in columns)):
            file.write(",".join(f"{value:.{digits + 2}g}" for value in row) + "\n")
    kind = style if style in ("letters", "numbered") else "named"
    return truth, sign, (kind, "unit untold" if told == "none" else "unit told")


UNIT_SCALE = {"s": (1, 0), "ms": (1e-3, 0), "min": (60, 0), "h": (3600, 0), "A": (1, 0), "mA": (1e-3, 0), "V": (1, 0),
              "mV": (1e-3, 0), "degC": (1, 0), "K": (1, -273.15), "%": (0.01, 0), "m/s": (1, 0), "km/h": (1 / 3.6, 0),
              "Nm": (1, 0), "rpm": (1, 0), "1": (1, 0)}
ROLE_OF = {"time": "time", "current": "current", "voltage": "pack_voltage", "bus": "bus_voltage", "soc": "soc",
           "temperature": "temperature_1", "speed": "speed", "torque": "motor_torque"}


def mistakes(roles, truth, sign):
    key_of = {role: key for key, role in ROLE_OF.items()}
    for role, entry in roles.items():
        key = key_of.get(role)
        if key is None or key not in truth:
            yield f"{role} = {entry}"
            continue
        column, scale, offset = truth[key]
        unit_scale, unit_offset = UNIT_SCALE[entry.get("unit", "1")]
        found = (entry.get("scale", 1) * unit_scale, entry.get("offset", 0) * unit_scale + unit_offset)
        same_unit = math.isclose(found[0], scale, rel_tol=1e-6) and abs(found[1] - offset) < 1e-6
        if entry["column"] != column or not same_unit:
            yield f"{role} = {entry} instead of {truth[key]}"
        if role == "current" and entry["discharge"] != "auto" and entry["discharge"] != ("+" if sign > 0 else "-"):
            yield f"discharge {entry['discharge']}"


def test_what_is_proposed_is_right_or_refused(runs, tmp_path):
    counts, wrong = Counter(), []
    for draw in range(DRAWS):
        rng = random.Random(1000 * SEED + draw)
        path = tmp_path / f"draw{draw}.csv"
        truth, sign, kind = drawn_table(rng, rng.choice(runs), path)
        result = subprocess.run([BUILD / "tests/bin/show_proposal", path], capture_output=True, text=True)
        assert result.returncode == 0, f"seed {SEED}, draw {draw}: {result.stderr}"
        verdict, draft = result.stdout.split("\n", 1)
        found = list(mistakes(tomllib.loads(draft).get("roles", {}), truth, sign))
        if found:
            header = path.read_text().splitlines()[0]
            wrong.append(f"seed {SEED}, draw {draw} {kind}: {found}\n{header}\n{result.stdout}")
        counts[kind, "wrong" if found else "right" if verdict == "complete" else "refused"] += 1
    for key in sorted(counts):
        print(*key[0], key[1], counts[key])
    assert not wrong, "\n".join(wrong[:5])
    assert DRAWS < 30 or sum(n for (_, verdict), n in counts.items() if verdict == "right") >= DRAWS / 4
