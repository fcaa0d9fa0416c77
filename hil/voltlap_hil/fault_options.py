# SPDX-License-Identifier: Apache-2.0
"""The fault matrix: every row of hil/faults.yaml is driven with plant and firmware in the loop, and measured.

With --ecu qemu BMS and master controller run as images of a Cortex-M4, an emulated board each, with --ecu process as
processes on pipes. Each row is then driven in one process, too, and fails where one frame differs.

Exit codes: 0 every row passed, 1 a row failed or is a known failure, 2 usage or input, 3 a row could not be run,
130 interrupted.
"""
from __future__ import annotations

import argparse
import os
from functools import partial
from pathlib import Path

from .car_flags import add_car
from .errors import InputError
from .quantity import whole

SEEDS, MOST_JOBS = 2**32 - 1, 64  # this module needs no package: help is printed without any


def number(low: int, high: int, text: str) -> int:
    try:
        return whole(text, low, high)
    except InputError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def parser() -> argparse.ArgumentParser:
    out = argparse.ArgumentParser(prog="voltlap faults", description=__doc__,
                                  formatter_class=argparse.RawDescriptionHelpFormatter)
    out.add_argument("--row", action="append", default=[], metavar="ID", help="only this row; may be repeated")
    out.add_argument("--group", action="append", default=[], metavar="NAME",
                        help="only the rows of this group; may be repeated")
    out.add_argument("--draw", type=partial(number, 1, 10_000), metavar="N",
                        help="only so many of them, drawn by --seed")
    out.add_argument("--list", action="store_true", help="say which rows there are, and run nothing")
    out.add_argument("--table", type=Path, metavar="FILE",
                        help="another table (hil/faults.yaml and that of the car's inverter beside it)")
    out.add_argument("--json", type=Path, metavar="FILE", help="everything that was measured")
    out.add_argument("--report", type=Path, metavar="FILE",
                        help="one page with the curves of each row (.html), or the table (.md), which takes the place "
                        "of the one between its marks in a file such as docs/fault_matrix.md")
    out.add_argument("--jobs", type=partial(number, 1, MOST_JOBS), default=os.cpu_count() or 1, metavar="N",
                        help="rows at a time; one on a CAN interface (all processors)")
    out.add_argument("--ecu", choices=("inside", "qemu", "process"), default="inside",
                        help="where the firmware runs; qemu: ./voltlap image builds the image (inside)")
    out.add_argument("--image", metavar="FILE", help="with --ecu: an ELF or a program instead of the built one")
    out.add_argument("--count-instructions", action="store_true",
                        help="with --ecu qemu: the worst step of each row, in --json and at the end")
    add_car(out, "what the rows name of it, such as {full_current}, is this car's")
    out.add_argument("--bus", metavar="IF", help="on this CAN interface, with processes for plant and ECUs, the "
                        "rows that say vcan: true; without it in one process")
    out.add_argument("--far", metavar="IF", help="the interface behind the gateway (vcan1 with --bus vcan0)")
    out.add_argument("--seed", type=partial(number, 0, SEEDS), default=1, metavar="N",
                        help="of losses, noise and --draw; the same seed gives the same run (1)")
    return out
