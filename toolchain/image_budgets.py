#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measures what the firmware takes of a microcontroller, and holds it against its budgets.

Builds images for 24 and for all cells, drives each pack with the emulated Cortex-M4 counting instructions, with the
filter of every cell and limits that look ahead, and prints a table: flash, RAM, stack (a bound by the calls, and what a
run used), instructions of a step of 10 ms. The pack of 24 cells goes through the fault matrix, too (hil/faults.yaml):
the worst step is one with a fault in it. --write puts the table into a document, between its two marks.
"""
import argparse
import json
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import image_build
from image_build import Kind, Refused
from outputs import marked_document

HOST = Path(os.environ.get("VOLTLAP_BUILD_DIR", image_build.ROOT / "build" / "default"))
METHODS = ("bms.soc_method=ekf", "bms.limit_method=ahead")
FLASH_MOST, RAM_MOST, STACK_MOST = 96 * 1024, 24 * 1024, 4 * 1024   # of a BMS of 24 cells [byte]
STEP_MOST = 40_000                                                  # of its BMS [instructions]
CLOCK_HZ, TICK_S, TICK_SHARE = 168_000_000, 0.010, 0.5              # of 144 cells: half of a tick of an STM32F4 ...
CYCLES_PER_INSTRUCTION = 2.0                                        # ... assumed, see docs/microcontroller.md
STEP_MOST_MANY_CELLS = int(TICK_SHARE * TICK_S * CLOCK_HZ / CYCLES_PER_INSTRUCTION)
BEGIN, END = "<!-- budgets: begin -->", "<!-- budgets: end -->"
EPILOG = """\
Example: ./voltlap image-budgets --laps 1 --rows 20
Exit codes: 0 within all budgets, 1 beyond one, 2 usage or input, 3 a run failed, 4 a program is missing, 5 the build
failed, 130 interrupted"""


@dataclass
class Run:
    """A pack that is driven: of how many cells, in an image for how many, with what else."""
    label: str
    cells: int
    image_cells: int | None
    settings: tuple = ()
    step_most: int = STEP_MOST_MANY_CELLS


MATRIX = Run("24, the fault matrix", 24, 24)
RUNS = (Run("24", 24, 24, step_most=STEP_MOST),
        Run("24, cell voltage limits", 24, 24, ("bms.cell_voltage_min_v=3.7",)),
        Run("96", 96, None, ("sensors.temperature_count=36",)),
        Run("144", 144, None, ("sensors.temperature_count=36",)))


def drive(run, laps):
    """What the board says of itself after the run."""
    image_build.require("qemu-system-arm", "qemu-system-arm")
    image = Kind(cells=run.image_cells).image("driven_by_plant")
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "run.json"
        command = [HOST / "bin" / "voltlap", "endurance", "--ecu", "qemu", "--image", image, "--count-instructions",
                   "--json", out, "--set", f"battery.cells_in_series={run.cells}"]
        for setting in (*METHODS, *run.settings):
            command += ["--set", setting]
        if laps:
            command += ["--laps", laps]
        done = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, text=True)
        if done.returncode != 0:
            raise Refused(3, f"the run with {run.label} cells failed (exit code {done.returncode})\n{done.stdout}")
        return json.loads(out.read_text())


def drive_faults(run, rows):
    """What both boards say of themselves over the rows of the fault matrix, or so many drawn ones."""
    image_build.require("qemu-system-arm", "qemu-system-arm")
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "rows.json"
        command = [sys.executable, image_build.ROOT / "hil" / "faults.py", "--ecu", "qemu", "--count-instructions",
                   "--image", Kind(cells=run.image_cells).image("driven_by_plant"), "--json", out]
        for setting in METHODS:
            command += ["--set", setting]
        if rows:
            command += ["--draw", rows]
        done = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, text=True,
                              env={**os.environ, "VOLTLAP_BUILD_DIR": str(HOST)})
        # With other methods than its own a row may miss its bound (1), or say nothing (3).
        if done.returncode not in (0, 1, 3) or not out.exists():
            raise Refused(3, f"the fault matrix failed (exit code {done.returncode})\n{done.stdout}")
        told = json.loads(out.read_text())
    boards = [row["ecu"] for row in told["rows"] if row["ecu"]]  # a row that says nothing of this car drives none
    if told["same_frames"] != len(boards):
        raise Refused(3, f"the fault matrix: other frames than in one process\n{done.stdout}")
    return {"ecu": {"instructions_per_step": told["instructions_per_step"],
                    "stack_used_bytes": max(board["stack_used_bytes"] for board in boards)}}


def step_row(run, result):
    ecu = result["ecu"]
    bms, master = ecu["instructions_per_step"]["bms"], ecu["instructions_per_step"]["master"]
    cycles = bms["worst"] * CYCLES_PER_INSTRUCTION / (TICK_S * CLOCK_HZ)
    return (f"| {run.label} | {bms['mean']:.0f} | {bms['worst']} | {100 * cycles:.1f} % | {master['worst']} | "
            f"{ecu['stack_used_bytes']} |")


def size_rows(kinds):
    rows = []
    for kind in kinds:
        for name in ("bms_node", "master_node", "both_nodes"):
            size = image_build.size_of(kind.image(name))
            cells = kind.cells or image_build.CELLS_MOST
            rows.append(f"| {kind.cpu} | {cells} | `{name}` | {size.flash} | {size.ram} | {size.stack} |")
    return rows


def broken_sizes():
    """Marks of the 24 cells that are not kept, in words."""
    size = image_build.size_of(Kind(cells=24).image("bms_node"))
    marks = (("flash", size.flash, FLASH_MOST), ("RAM", size.ram, RAM_MOST), ("stack", size.stack, STACK_MOST))
    return [f"bms_node for 24 cells: {found} bytes of {what}; at most {most} are allowed"
            for what, found, most in marks if found > most]


def broken_step(run, result):
    worst = result["ecu"]["instructions_per_step"]["bms"]["worst"]
    if worst <= run.step_most:
        return []
    return [f"{run.label} cells: {worst} instructions in a step of the BMS; at most {run.step_most} are allowed"]


def table(kinds, steps):
    return "\n".join(["| processor | cells at most | image | flash | RAM | stack, bound |", "|---|---|---|---|---|---|",
                      *size_rows(kinds), "",
                      "| cells | BMS, mean | BMS, worst | of a tick at 168 MHz | master, worst | stack used |",
                      "|---|---|---|---|---|---|", *steps])


def write_into(path, text):
    before, _, rest = path.read_text().partition(BEGIN)
    _, _, after = rest.partition(END)
    path.write_text(f"{before}{BEGIN}\n{text}\n{END}{after}")


def arguments():
    parser = argparse.ArgumentParser(prog="voltlap image-budgets", description=__doc__, epilog=EPILOG,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--laps", type=int, metavar="N", help="of each run (default: a whole endurance)")
    parser.add_argument("--rows", type=int, metavar="N", help="of the fault matrix, drawn (default: all)")
    parser.add_argument("--write", type=marked_document(BEGIN, END), metavar="FILE",
                        help="put the table into this document")
    given = parser.parse_args()
    for flag, number in (("--laps", given.laps), ("--rows", given.rows)):
        if number is not None and number < 1:
            parser.error(f"{flag} {number}: 1 or more is expected")
    return given


def measure(given):
    kinds = [Kind(cpu, cells) for cpu in ("cortex-m4", "cortex-m0plus", "cortex-m7") for cells in (24, None)]
    for kind in kinds:
        print(f"building {kind.cpu} for {kind.cells or image_build.CELLS_MOST} cells", file=sys.stderr, flush=True)
        image_build.build(kind)
    bad, steps = broken_sizes(), []
    for run in RUNS:
        print(f"driving {run.label} cells", file=sys.stderr, flush=True)
        result = drive(run, given.laps)
        steps.append(step_row(run, result))
        bad += broken_step(run, result)
    print("driving the fault matrix", file=sys.stderr, flush=True)
    faults = drive_faults(MATRIX, given.rows)
    steps.append(step_row(MATRIX, faults))
    bad += broken_step(MATRIX, faults)
    text = table(kinds, steps)
    print(text)
    if given.write:
        write_into(given.write, text)
    return bad


def main():
    given = arguments()
    try:
        bad = measure(given)
    except Refused as error:
        print(f"voltlap image-budgets: {error}", file=sys.stderr)
        return error.code
    except KeyboardInterrupt:
        return 130
    for text in bad:
        print(f"voltlap image-budgets: {text}", file=sys.stderr)
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
