#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What the lockstep costs: a lap as three processes, against the bare exchange of the same frames by three processes.

Both use the same batched calls and filters on the same interface, in turns; the fastest of each counts. The lap has
everything: car, driver, firmware, hashes over what was read back. Goal: 20 times real time with nobody listening.
"""
import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
RATIO_MAX = 2.0
REAL_TIME_GOAL = 20.0


def measure(build, interface, rounds):
    """(seconds of the lap in lockstep, seconds of the bare exchange, simulated seconds)."""
    program, bare = build / "bin" / "voltlap", build / "tests" / "bin" / "bare_exchange"
    lockstep_s, bare_s = [], []
    with tempfile.TemporaryDirectory() as folder:
        log, report = f"{folder}/lap.log", f"{folder}/lap.json"
        lap = [program, "endurance", "--laps", "1"]
        subprocess.run([*lap, "--candump", log], check=True, stdout=subprocess.DEVNULL)
        for _ in range(rounds):
            done = subprocess.run([bare, interface, log], check=True, stdout=subprocess.PIPE, text=True)
            told = re.fullmatch(r"(\d+) ticks ([\d.]+) s\n", done.stdout)
            if told is None:
                raise RuntimeError(f"{bare}: found {done.stdout!r}, expected its ticks and seconds")
            ticks, seconds = told.groups()
            bare_s.append(float(seconds))
            subprocess.run([*lap, "--bus", interface, "--json", report], check=True, stdout=subprocess.DEVNULL)
            lockstep_s.append(json.loads(Path(report).read_text())["wall_s"])
    return min(lockstep_s), min(bare_s), int(ticks) * 0.01


def main():
    parser = argparse.ArgumentParser(prog="voltlap benchmark-bus", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    build = Path(os.environ.get("VOLTLAP_BUILD_DIR", ROOT / "build" / "default"))
    parser.add_argument("--build", type=Path, default=build, help=argparse.SUPPRESS)
    parser.add_argument("--bus", default="vcan0", metavar="IF", help="CAN interface (vcan0)")
    parser.add_argument("--rounds", type=int, default=3, metavar="N", help="runs of each, in turns (3)")
    arguments = parser.parse_args()
    lockstep_s, bare_s, simulated_s = measure(arguments.build, arguments.bus, arguments.rounds)
    ratio = lockstep_s / bare_s
    print(f"bare exchange     {bare_s:7.3f} s   {simulated_s / bare_s:6.1f} times real time")
    print(f"lap in lockstep   {lockstep_s:7.3f} s   {simulated_s / lockstep_s:6.1f} times real time "
          f"(goal {REAL_TIME_GOAL:.0f})")
    print(f"ratio             {ratio:7.2f}     at most {RATIO_MAX:.0f}")
    return 0 if ratio <= RATIO_MAX else 1


if __name__ == "__main__":
    sys.exit(main())
