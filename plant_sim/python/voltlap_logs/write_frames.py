# SPDX-License-Identifier: Apache-2.0
"""Reads candump lines on stdin and writes them as a recording that the field's tools open.

    voltlap run ... | python -m voltlap_logs.write_frames --format blf OUT

Formats: blf, asc, trc (2.1), mf4 (ASAM bus logging), csv (GVRET, for SavvyCAN), db (python-can's SQLite). canN becomes
channel N; where the format counts from 1 and there is a can0, all are moved up by one. The last line on stderr is JSON:
frames written, what the format cannot hold (`skipped`, `changed`) and the number of each bus (`channels`). OUT is
replaced at the end, or left as it was.
"""
from __future__ import annotations

import argparse
import signal
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from .errors import run
from .source import Replacing
from .spool import Spool
from .tally import Tally
from .writers import asc, blf, database, gvret, mf4, trc

PROGRAM = "voltlap_logs.write_frames"
WRITERS: dict[str, tuple[str, Callable[[Path, Spool], None]]] = {
    "blf": ("Vector BLF", blf.write), "asc": ("Vector ASC", asc.write), "trc": ("PEAK TRC 2.1", trc.write),
    "mf4": ("MF4", mf4.write), "csv": ("GVRET CSV", gvret.write), "db": ("python-can SQLite", database.write),
}


def stop_like_ctrl_c() -> None:
    """So that a program that is told to end takes its unfinished file away."""
    def interrupt(number: int, frame: object) -> None:
        raise KeyboardInterrupt
    signal.signal(signal.SIGTERM, interrupt)


def write(path: Path, key: str) -> int:
    name, writer = WRITERS[key]
    tally = Tally(name)
    with Replacing(path) as beside, Spool(sys.stdin.buffer, tally) as spool:
        writer(beside, spool)
        tally.frames = spool.count - sum(tally.skipped.values())
        if spool.changed:
            tally.facts["changed"] = dict(spool.changed)
    print(tally.json(), file=sys.stderr)
    return 0


def main(given: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(PROGRAM, description="Reads candump lines on stdin, writes a recording.")
    parser.add_argument("--format", choices=list(WRITERS), required=True)
    parser.add_argument("out", type=Path)
    options = parser.parse_args(given)
    stop_like_ctrl_c()
    return run(lambda: write(options.out, options.format))


if __name__ == "__main__":
    sys.exit(main())
