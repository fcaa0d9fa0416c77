# SPDX-License-Identifier: Apache-2.0
"""On a CAN interface a car does what it does in one process: frame by frame in a scenario with a fault of the bus, and
row by row of a few drawn faults. VOLTLAP_TEST_SEED draws others; `./voltlap faults --bus vcan0` runs all that are
marked.
"""
import json
import os
import random
import subprocess
import sys
from pathlib import Path

import pytest

from voltlap_hil.in_process import PROCESS
from voltlap_hil.rig import Bench, Rig

PROJECT = Path(__file__).resolve().parents[2]
SEED = os.environ.get("VOLTLAP_TEST_SEED") or str(random.randrange(2**32))
DRAWN = 5


def drive(rig):
    rig.start_up("ready_to_drive")
    rig.driver(accelerator=100)
    rig.run("300 ms")
    rig.gateway("delay", ["BmsLimits"], for_ms=300, delay_ticks=2)
    rig.gateway("drop", ["CellVoltages"], share=0.2)
    rig.gateway("second_sender", ["Pedals"], counter_ahead=3, signals={"Apps1": 1.0})
    rig.send("MotorTemperatures", Motor=50.0)
    rig.run("600 ms")
    rig.kill("master")
    rig.run("300 ms")
    return [(f.id, f.data, f.time_ms) for f in rig.trace.frames]


@pytest.mark.parametrize("behind", [["bms", "master"], ["bms"], ["master"]], ids="+".join)
def test_the_frames_are_those_of_one_process(behind, dbc, open_rig):
    on_interface = drive(open_rig(gateway=True, behind=behind, seed=11))
    with Rig(Bench(PROCESS, PROCESS, behind), dbc=dbc, seed=11) as rig:
        in_process = drive(rig)
    assert len(on_interface) > 1000
    by_tick = [{(f[2], f[0], f[1]) for f in frames} for frames in (on_interface, in_process)]
    assert sorted(by_tick[0] ^ by_tick[1])[:5] == []
    assert len(on_interface) == len(in_process)


def test_drawn_rows_of_the_fault_matrix_pass(tmp_path):
    print(f"VOLTLAP_TEST_SEED={SEED}")
    done = subprocess.run([sys.executable, PROJECT / "hil" / "faults.py", "--bus", "vcan0", "--draw", str(DRAWN),
                           "--seed", str(int(SEED) % 2**32), "--json", tmp_path / "rows.json"], timeout=600,
                          capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    assert len(json.loads((tmp_path / "rows.json").read_text())["rows"]) == DRAWN
