# SPDX-License-Identifier: Apache-2.0
"""The frames of a recording of a CAN bus in any format of the field, plain, gzip or zstd, one after the other.

`voltlap log` reads it, as every other command does: formats, clocks and defects are judged in one place. Time counts
from the first frame and never runs back; what is no frame is counted by its kind.
"""
from __future__ import annotations

import json
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from .errors import InputError
from .frame import EXTENDED
from .nodes import program


class LogFrame(NamedTuple):
    time_s: float
    bus: str
    id: int  # bit 31 set: 29 bits
    data: bytes


def _frame(line: str) -> LogFrame:
    """A line of candump -l as `voltlap log convert` writes it."""
    stamp, bus, text = line.split()
    digits, _, payload = text.partition("#")
    data = payload[2:] if payload.startswith("#") else payload
    return LogFrame(float(stamp[1:-1]), bus, int(digits, 16) | (EXTENDED if len(digits) > 3 else 0),
                    bytes.fromhex(data))


class Recording:
    """Iterate over it once. The DBC files say how often a frame comes where the recording has no stamps."""

    def __init__(self, path: Path, dbc: Sequence[Path] = ()) -> None:
        self.path = path
        self.format = ""
        self.frames = 0
        self.skipped: Counter[str] = Counter()
        self.notes: list[str] = []
        self._dbc = [f"--dbc={file}" for file in dbc]

    def __iter__(self) -> Iterator[LogFrame]:
        self._look_through()
        begin_s: float | None = None
        with subprocess.Popen(self._command("convert", "--out=-"), stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                              text=True, errors="replace") as process:
            assert process.stdout is not None
            try:
                for line in process.stdout:
                    frame = _frame(line)
                    begin_s = frame.time_s if begin_s is None else begin_s
                    self.frames += 1
                    yield frame._replace(time_s=frame.time_s - begin_s)
            finally:
                process.terminate()  # who reads may have seen enough

    def _command(self, what: str, *flags: str) -> list[str]:
        return [str(program()), "log", what, *flags, *self._dbc, "--", str(self.path)]

    def _look_through(self) -> None:
        """What the recording is and what is wrong with it, before its first frame is given."""
        found = subprocess.run(self._command("info", "--json=-"), capture_output=True, text=True,
                               errors="replace")
        if not found.stdout:
            raise InputError(found.stderr.strip().removeprefix("voltlap: ").removesuffix("."))
        said = json.loads(found.stdout)
        self.format = said["format"]
        self.skipped.update(said["frames_left_out"])
        self.notes += said["notes"] + [f"{count} x {kind}" for kind, count in said["frames_mended"].items()]
        if said["broken"]:
            self.notes.append(f"the recording breaks off: {said['broken']}")


class Progress:
    """A line on a terminal that says how far the reading is, from two seconds on."""

    def __init__(self, what: str) -> None:
        self._what, self._begin, self._last, self._shown = what, time.monotonic(), 0.0, False

    def tell(self, frames: int, at_s: float) -> None:
        now = time.monotonic()
        if not sys.stderr.isatty() or now - self._begin < 2.0 or now - self._last < 0.3:
            return
        self._last, self._shown = now, True
        sys.stderr.write(f"\r\x1b[K{self._what}: {frames} frames, {at_s:.0f} s")
        sys.stderr.flush()

    def done(self) -> None:
        if self._shown:
            sys.stderr.write("\r\x1b[K")
