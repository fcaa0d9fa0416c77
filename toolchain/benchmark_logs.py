#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Recordings: how fast frames are read and decoded, beside python-can with cantools on the same file.

The recording is an endurance of our own simulator, 22 laps, some three million frames. Decoding is `voltlap log info`
with every signal of car.dbc and orion.dbc, by processor time of one core; the rival reads the first frames of the same
file with can.LogReader and decodes them with cantools. Writing is `voltlap log decode`, by wall time with its helpers,
and the largest memory of any process. MF4 and MCAP are read back by asammdf and the mcap package.
"""
import argparse
import json
import os
import resource
import subprocess
import tempfile
import time
from pathlib import Path

from outputs import output_file

ROOT = Path(__file__).resolve().parents[1]
BUILD = Path(os.environ.get("VOLTLAP_BUILD_DIR", ROOT / "build" / "default"))
DBC = [ROOT / "can_dbc/car.dbc", ROOT / "can_dbc/orion.dbc"]
RIVAL_FRAMES = 200_000
GOAL_PER_S, GOAL_S, GOAL_MB = 2e6, 60.0, 2000.0


def voltlap(*arguments):
    """Runs it; processor time and wall time [s] with its children's, largest memory of any of them [MB]."""
    before, begin = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    subprocess.run([BUILD / "bin/voltlap", *map(str, arguments)], check=True, stdout=subprocess.DEVNULL,
                   stderr=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return (after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, time.monotonic() - begin,
            after.ru_maxrss / 1024)


def rival(log):
    import can
    import cantools
    database = cantools.database.load_file(DBC[0])
    database.add_dbc_file(DBC[1])
    begin = time.process_time()
    for count, message in enumerate(can.LogReader(str(log)), 1):
        database.decode_message(message.arbitration_id, message.data, decode_choices=False)
        if count == RIVAL_FRAMES:
            break
    return count / (time.process_time() - begin)


def read_back(path):
    """Messages or samples that the format's own package finds."""
    if path.suffix == ".mcap":
        from mcap.reader import make_reader
        with path.open("rb") as file:
            return make_reader(file).get_summary().statistics.message_count
    import asammdf
    with asammdf.MDF(path) as mdf:
        return sum(group.channel_group.cycles_nr for group in mdf.groups)


def main():
    parser = argparse.ArgumentParser(prog="voltlap benchmark-logs", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter,
                                     epilog="Exit code: 0 the marks are met; 1 not; 2 usage.")
    parser.add_argument("--laps", type=int, default=22, help="laps of the recording (22)")
    parser.add_argument("--json", type=output_file, help="write the numbers")
    arguments = parser.parse_args()
    dbc = [word for path in DBC for word in ("--dbc", path)]
    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder) / "run.log"
        voltlap("endurance", "--laps", arguments.laps, "--candump", log)
        with log.open("rb") as lines:
            frames = sum(1 for _ in lines)
        voltlap("log", "info", log, *dbc)  # the DBC files are read once for ever
        cpu_s, _, memory = voltlap("log", "info", log, *dbc)
        ours, theirs = frames / cpu_s, rival(log)
        print(f"{frames} frames, every signal of {' and '.join(path.name for path in DBC)}\n\n"
              f"{'voltlap log info':<28}{ours / 1e6:>8.2f} million frames/s{memory:>8.0f} MB\n"
              f"{'python-can with cantools':<28}{theirs / 1e6:>8.2f} million frames/s\n"
              f"{'':<28}{ours / theirs:>8.1f} times as fast\n")
        numbers = {"frames": frames, "frames_per_s": ours, "rival_frames_per_s": theirs}
        met = ours >= GOAL_PER_S
        for suffix in ("csv", "mf4", "mcap", "parquet"):
            out = Path(folder) / f"run.{suffix}"
            _, wall_s, memory = voltlap("log", "decode", log, *dbc, "--out", out)
            found = read_back(out) if suffix in ("mf4", "mcap") else None
            print(f"to {suffix:<25}{wall_s:>8.1f} s{out.stat().st_size / 1e6:>12.0f} MB written"
                  f"{memory:>10.0f} MB of memory" + (f", {found} read back" if found else ""))
            numbers[suffix] = {"wall_s": wall_s, "memory_mb": memory, "read_back": found}
            met = met and wall_s <= GOAL_S and memory <= GOAL_MB and found in (None, frames)
    if arguments.json:
        arguments.json.write_text(json.dumps(numbers, indent=1) + "\n")
    return 0 if met else 1


if __name__ == "__main__":
    raise SystemExit(main())
