# SPDX-License-Identifier: Apache-2.0
"""A cell's filter step on a Cortex-M4, and one look ahead: every instruction of their functions, whether it is reached
or not."""
import os
import pathlib
import re
import shutil
import subprocess

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
GENERATED = pathlib.Path(os.environ["VOLTLAP_BUILD_DIR"]) / "can_dbc" / "generated"
FLAGS = ["-std=c++17", "-O2", "-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=soft", "-ffreestanding", "-fno-exceptions",
         "-fno-rtti"]
MOST = 1500        # instructions of a cell's step
WALK = 24          # of the search in the OCV table, beyond the ones counted: two points further
AROUND = 100       # soc_ekf's share of a step: what was drawn, whether there is a reading, the sum
# Called so often in one step; what has another name is in one of these.
CALLS = {"predict_cell": 1, "update_cell": 1, "branch_of": 2, "branches_at": 1, "series_at": 1, "ocv_at": 1}


def counted(tmp_path, source):
    unit = tmp_path / "unit.o"
    subprocess.run(["arm-none-eabi-g++", *FLAGS, f"-I{ROOT / 'firmware'}", f"-I{GENERATED}", "-c", source, "-o", unit],
                   check=True)
    text = subprocess.run(["arm-none-eabi-objdump", "-d", "-C", "--no-show-raw-insn", unit], check=True,
                          capture_output=True, text=True).stdout
    counts, name = {}, None
    for line in text.splitlines():
        if head := re.match(r"[0-9a-f]+ <.*?(\w+)\(.*>:", line):
            name = head[1]
        elif re.match(r"\s+[0-9a-f]+:\t", line) and name:
            counts[name] = counts.get(name, 0) + 1
    return counts


def test_a_cell_step_takes_at_most_1500_instructions(tmp_path):
    if not shutil.which("arm-none-eabi-g++"):
        pytest.skip("arm-none-eabi-g++ is not installed")
    estimate = ROOT / "firmware" / "bms" / "estimate"
    counts = counted(tmp_path, estimate / "cell_filter.cpp") | counted(tmp_path, estimate / "cell_model.cpp")
    assert counts["predict_cell"] > 200 and counts["update_cell"] > 200
    step = sum(times * counts.get(name, 0) for name, times in CALLS.items()) + WALK + AROUND
    print(f"a cell's step: {step} instructions at most (bound {MOST}): {counts}")
    assert step <= MOST


MOST_LOOK = 1000   # instructions of one look at one current, for one horizon and direction; a warm start takes one or
                   # two
LOOK_CALLS = {"cell_end": 1, "branch_end": 2, "branches_at": 1, "series_at": 1, "ocv_at": 1}
STEP_OF_NEWTON = 80   # of current_until, without its two divisions of 64 bits, which only a charge that binds needs


def test_a_look_ahead_takes_at_most_1000_instructions(tmp_path):
    if not shutil.which("arm-none-eabi-g++"):
        pytest.skip("arm-none-eabi-g++ is not installed")
    bms = ROOT / "firmware" / "bms"
    counts = counted(tmp_path, bms / "limits" / "horizon.cpp") | counted(tmp_path, bms / "estimate" / "cell_model.cpp")
    assert counts["cell_end"] > 200
    look = sum(times * counts.get(name, 0) for name, times in LOOK_CALLS.items()) + WALK + STEP_OF_NEWTON
    print(f"a look ahead: {look} instructions at most (bound {MOST_LOOK}): {counts}")
    assert look <= MOST_LOOK
