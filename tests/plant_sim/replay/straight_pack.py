# SPDX-License-Identifier: Apache-2.0
"""A pack whose cells are known, what it would log, and its replay."""
import json
import os
import subprocess
from pathlib import Path

BUILD = Path(os.environ["VOLTLAP_BUILD_DIR"])
CELLS, RATE = 24, 50  # in series; rows a second
CAPACITY, RESISTANCE = 9.0, 0.003  # Ah, ohm
OCV = [(0.0, 3.0), (1.0, 4.0)]  # V, straight: SOC = V - 3

PACK = f"""
name = "straight"
[battery]
cell = "molicel_p42a"
cells_in_series = {CELLS}
cells_in_parallel = 2
[bms]
capacity_ah = {CAPACITY}
ocv_soc = [{OCV[0][0]}, {OCV[1][0]}]
ocv_v = [{OCV[0][1]}, {OCV[1][1]}]
resistance_ohm = {RESISTANCE}
cell_voltage_min_v = 3.1
cell_voltage_max_v = 4.1
cell_voltage_trip_low_v = 2.9
discharge_current_max_a = 300
charge_current_max_a = 100
"""


def voltlap(*arguments):
    return subprocess.run([BUILD / "bin/voltlap", *map(str, arguments)], capture_output=True, text=True, timeout=300)


def current_at(time):
    """Five seconds of rest, then pulses with a rest between them."""
    return 0.0 if time < 5.0 or time % 10.0 > 6.0 else 80.0


def rows(seconds, soc=0.8, current=current_at):
    charge = 0.0
    for k in range(int(seconds * RATE)):
        time, amps = k / RATE, current(k / RATE)
        charge += amps / RATE / 3600.0
        volts = OCV[0][1] + soc - charge / CAPACITY - RESISTANCE * amps
        row = {"time_s": time, "current_a": amps, "pack_voltage_v": CELLS * volts, "soc": soc - charge / CAPACITY,
               "temperature_1_c": 30.0}
        row.update({f"cell_voltage_{n}_v": volts for n in range(1, CELLS + 1)})
        yield row


MAP = """
[roles]
time = {column = "time_s", unit = "s"}
current = {column = "current_a", unit = "A", discharge = "+"}
pack_voltage = {column = "pack_voltage_v", unit = "V"}
soc = {column = "soc", unit = "1"}
discharge_limit = {column = "dcl", unit = "A", optional = true}
temperature_1 = {column = "temperature_1_c", unit = "degC"}
"cell_voltage_<n>" = {column = "cell_voltage_<n>_v", unit = "V"}
"""


def replayed(folder, table, *arguments, pack=PACK, map_text=MAP, map_text_more=""):
    table = list(table)
    log, cut, out = folder / "log.csv", folder / "map.toml", folder / "replay.json"
    names = list(table[0])
    lines = [",".join("" if row[name] is None else f"{row[name]:.5f}" for name in names) for row in table]
    log.write_text("\n".join([",".join(names)] + lines) + "\n")
    cut.write_text(map_text + map_text_more)
    if pack:
        (folder / "pack.toml").write_text(pack)
        arguments += ("--pack", folder / "pack.toml")
    run = voltlap("replay", log, "--map", cut, "--json", out, *arguments)
    assert run.returncode == 0, run.stderr
    return run, json.loads(out.read_text())
