# SPDX-License-Identifier: Apache-2.0
"""Rows of the fault matrix with the firmware on boards of its own: the frames of the run in one process, or the first
that differs is named. The rows are drawn; VOLTLAP_TEST_SEED repeats them, and all run with VOLTLAP_TEST_WHOLE=1.
"""
import json
import os
import random
import shutil
import subprocess
import sys

import pytest
from image_tools import HOST, ROOT

SEED = os.environ.get("VOLTLAP_TEST_SEED") or str(random.randrange(2**32))
RESETS = ("--row", "bms_reset_with_trip", "--row", "both_reset", "--row", "bms_killed")
DRAWN = () if os.environ.get("VOLTLAP_TEST_WHOLE") == "1" else ("--draw", "6")
emulated = pytest.mark.skipif(shutil.which("qemu-system-arm") is None, reason="qemu-system-arm is not installed")
# A wire between plant and board that inverts a bit of one byte that goes to the plant.
WIRE = """#!{python}
import os, subprocess, sys
there, back = os.pipe(), os.pipe()
board = subprocess.Popen(["/bin/sh", "-c", f'exec "$0" 3<&{{there[0]}} 4>&{{back[1]}}', "{program}"],
                         pass_fds=(there[0], back[1]))
os.close(there[0]); os.close(back[1])
if os.fork() == 0:
    while data := os.read(3, 4096):
        os.write(there[1], data)
    os._exit(0)
os.close(there[1])
seen = 0
while data := bytearray(os.read(back[0], 4096)):
    if seen <= {bad} < seen + len(data):
        data[{bad} - seen] ^= 1
    seen += len(data)
    os.write(4, data)
sys.exit(board.wait())
"""


def faults(*arguments):
    return subprocess.run([sys.executable, ROOT / "hil" / "faults.py", *map(str, arguments)], capture_output=True,
                          text=True, timeout=900)


def driven(tmp_path, *arguments):
    done = faults(*arguments, "--seed", SEED, "--json", tmp_path / "rows.json")
    print(f"VOLTLAP_TEST_SEED={SEED}\n{done.stdout}{done.stderr}")
    told = json.loads((tmp_path / "rows.json").read_text())
    assert [(row["id"], row["other_frame"], row["error"]) for row in told["rows"]
            if row["other_frame"] or row["error"]] == []
    assert told["same_frames"] == len(told["rows"])
    assert all(len(row["trace_hash"]) == 64 for row in told["rows"])
    return told["rows"]


@emulated
def test_resets_and_a_dead_node_are_those_of_the_run_in_one_process(tmp_path, image_of):
    image_of("driven_by_plant")
    rows = driven(tmp_path, "--ecu", "qemu", *RESETS)
    assert [row["verdict"] for row in rows] == ["passed"] * 3
    assert all(0 < row["ecu"]["stack_used_bytes"] < 4096 for row in rows)


@emulated
def test_drawn_rows_on_emulated_boards(tmp_path, image_of):
    image_of("driven_by_plant")
    driven(tmp_path, "--ecu", "qemu", *DRAWN)


def test_drawn_rows_on_boards_that_are_processes(tmp_path):
    driven(tmp_path, "--ecu", "process", *RESETS)
    driven(tmp_path, "--ecu", "process", *DRAWN)


def test_a_row_whose_frames_differ_fails_and_names_the_first(tmp_path):
    """A bit in the data of one frame of each board."""
    wire = tmp_path / "wire"
    wire.write_text(WIRE.format(python=sys.executable, program=HOST / "bin" / "voltlap-firmware", bad=10_036))
    wire.chmod(0o755)
    done = faults("--ecu", "process", "--image", wire, "--row", "apps1_open")
    assert done.returncode == 1, done.stdout + done.stderr
    assert "another frame than in one process: tick " in done.stdout, done.stdout + done.stderr
    assert "expected 0x" in done.stdout and "0 of 1 with every frame" in done.stdout


@pytest.mark.parametrize(("arguments", "said"), [
    (["--ecu", "process", "--bus", "vcan0"], "--ecu goes without --bus"),
    (["--image", "x"], "--image goes with --ecu"),
    (["--count-instructions"], "--count-instructions goes with --ecu"),
    (["--ecu", "process", "--count-instructions"], "--ecu qemu"),
    (["--ecu", "process", "--image", "/nowhere/x"], "no file /nowhere/x"),
    (["--ecu", "process", "--image", "/bin/true"], "does not start"),
])
def test_what_cannot_be_is_said_once_and_nothing_starts(arguments, said):
    done = faults(*arguments)
    assert done.returncode == 2 and said in done.stderr and done.stderr.count("\n") == 1


@emulated
def test_an_image_with_a_configuration_of_its_own_is_refused(image_of):
    done = faults("--ecu", "qemu", "--image", image_of("both_nodes"))
    assert done.returncode == 2 and "driven_by_plant" in done.stderr
