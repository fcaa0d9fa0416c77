# SPDX-License-Identifier: Apache-2.0
"""Runs scenarios on a CAN bus, simulated or real.

Exit codes: 0 all is as it must be, 1 a check failed, 2 usage or input, 3 a scenario could not be run, 130 interrupted.
"""
from __future__ import annotations

import argparse
from pathlib import Path

from .car_flags import add_car


def parser() -> argparse.ArgumentParser:
    out = argparse.ArgumentParser(prog="voltlap hil", description=__doc__,
                                  formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = out.add_subparsers(required=True, metavar="COMMAND")
    runs = commands.add_parser("run", help="run scenario files and say what each check measured")
    runs.add_argument("scenario", nargs="+", type=path, help="a YAML file, or a folder of them")
    runs.add_argument("--channel", default="vcan0", help="the plant's channel (vcan0); process: car and firmware in "
                      "one process, without any interface; with can0 the nodes are not started and times are those of "
                      "the bus")
    runs.add_argument("--far", metavar="CHANNEL", help="channel behind the fault gateway (vcan1 with vcan0)")
    runs.add_argument("--nodes", choices=["started", "running"], help="whether plant and ECUs are started here; "
                      "default: started on a vcan channel")
    runs.add_argument("--without-event", action="store_true", help="leave out `when`; then no check of `then` may hold")
    runs.add_argument("--record", type=path, metavar="FILE", help="all frames: .log (candump -l), .asc or .blf; "
                      "for one scenario")
    runs.add_argument("--report", type=path, metavar="FILE", action="append", default=[],
                      help="results as .xml (JUnit), .md or .html; may be given several times")
    runs.add_argument("--check-only", action="store_true", help="read the files and say whether they are right")
    add_car(runs, "every scenario is driven with it, unless its `arguments` say otherwise")
    out.epilog = "\n" + runs.format_help()  # the help of all is the help of its one command
    return out


def path(text: str) -> Path:
    if not text:
        raise argparse.ArgumentTypeError("found an empty name, expected a file")
    return Path(text)
