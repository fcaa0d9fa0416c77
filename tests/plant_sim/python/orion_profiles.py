# SPDX-License-Identifier: Apache-2.0
"""Profiles of an Orion BMS as its utility writes them, drawn: which properties, and their values."""
import os
import pathlib
import random
import subprocess
import sys

PROJECT = pathlib.Path(__file__).resolve().parents[3]
SEED = int(os.environ.get("VOLTLAP_TEST_SEED") or random.randrange(2**32))
HEAD = '<?xml version="1.0" encoding="UTF-8"?>\n<java version="1.8.0_202" class="java.beans.XMLDecoder">\n'


def element(kind, value, depth):
    return f"{' ' * depth}<{kind}>{value}</{kind}>\n"


def indexed(name, kind, values):
    rows = "".join(f'   <void index="{index}">\n{element(kind, value, 4)}   </void>\n'
                   for index, value in values.items())
    return f'  <void property="{name}">\n{rows}  </void>\n'


def population(cells):
    rows = "".join(f'   <void index="{cell}">\n    <void property="populated">\n     <boolean>true</boolean>\n'
                   "    </void>\n   </void>\n" for cell in range(cells))
    return f'  <void id="BmsProfile$ProfilePopulationTableArray0" property="populationTable">\n{rows}  </void>\n'


def profile_text(whole, tables=None, cells=0):
    """`whole`: integer properties as recorded; `tables`: of numbers by index; `cells`: marked in populationTable."""
    body = "".join(f'  <void property="{name}">\n{element("int", value, 3)}  </void>\n'
                   for name, value in whole.items())
    body += "".join(indexed(name, "double", values) for name, values in (tables or {}).items())
    body += population(cells) if cells else ""
    return f'{HEAD} <object class="bmsapp.DefaultProfile" id="DefaultProfile0">\n{body} </object>\n</java>\n'


def drawn_profile(random_source):
    """(whole, tables, cells) that give a pack of ours."""
    cells = random_source.randrange(1, 145)
    low = random_source.randrange(18000, 32001)
    top = random_source.randrange(60, 800)
    whole = {"totalCells": cells, "totalAmphours": random_source.randrange(200, 30001),
             "minimumCellVoltage": low, "maximumCellVoltage": random_source.randrange(low + 4000, 42001),
             "maximumDCL": random_source.randrange(50, 1001), "maximumCCL": random_source.randrange(10, 1001),
             "hotPackTemperature": random_source.randrange(45, 61),
             "maxDclTemperature": random_source.randrange(45, 81),
             "derateHighTempDCLStart": random_source.randrange(20, 41),
             "derateHighTempDCLAmperage": random_source.randrange(1, 15),
             "derateLowSOCStart": random_source.randrange(1, 31),
             "minimumBalanceVoltage": random_source.randrange(30000, 41001),
             "balanceDeltaVoltage": random_source.randrange(20, 400), "intresDCMultiplier": 12}
    tables = {"dclTemperatureTable": {k: float(top) for k in range(4, 20)},
              "cclTemperatureTable": {k: float(random_source.randrange(20, 200)) for k in range(5, 20)},
              "resistanceTable": {k: round(3000 * 0.9**k) + random_source.randrange(40) for k in range(25)}}
    return whole, tables, cells if random_source.random() < 0.5 else 0


def orion(*words):
    return subprocess.run([sys.executable, PROJECT / "plant_sim/python/orion.py", *map(str, words)],
                          capture_output=True, text=True, timeout=60)
