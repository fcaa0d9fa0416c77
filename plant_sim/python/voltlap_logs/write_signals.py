# SPDX-License-Identifier: Apache-2.0
"""Writes decoded signals as a file of the field's own formats.

    python -m voltlap_logs.write_signals --format parquet|mf4|mcap FOLDER OUT

FOLDER is what the native programs decode into (signal_folder.py). OUT is replaced at the end, or left as it was.
"""
from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from .errors import run
from .signal_folder import Signals, load
from .source import Replacing
from .write_frames import stop_like_ctrl_c
from .writers import signals_mcap, signals_mf4, signals_parquet

PROGRAM = "voltlap_logs.write_signals"
WRITERS: dict[str, Callable[[Path, Signals], None]] = {
    "parquet": signals_parquet.write, "mf4": signals_mf4.write, "mcap": signals_mcap.write}


def write(folder: Path, out: Path, key: str) -> int:
    signals = load(folder)
    with Replacing(out) as beside:
        WRITERS[key](beside, signals)
    print(json.dumps({"groups": len(signals.groups), "rows": signals.rows, "format": key}), file=sys.stderr)
    return 0


def main(given: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(PROGRAM, description="Writes decoded signals as Parquet, MF4 or MCAP.")
    parser.add_argument("--format", choices=list(WRITERS), required=True)
    parser.add_argument("folder", type=Path)
    parser.add_argument("out", type=Path)
    options = parser.parse_args(given)
    stop_like_ctrl_c()
    return run(lambda: write(options.folder, options.out, options.format))


if __name__ == "__main__":
    sys.exit(main())
