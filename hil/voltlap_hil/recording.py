# SPDX-License-Identifier: Apache-2.0
"""The frames of a recording of a CAN bus in any format of the field, plain, gzip or zstd, one after the other.

Text that is candump, ASC, SLCAN or raw hex is read here; every other format by plant_sim/python/voltlap_logs. Time
counts from the first frame and never runs back. What is no frame is counted by its kind.
"""
from __future__ import annotations

import sys
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from .errors import InputError
from .recording_lines import LogFrame, UNREADABLE, candump, parser_of

_BACK_S, _AHEAD_S = 5.0, 86400.0  # a step of the stamps beyond: the clock was set
_EXPECTED = "expected candump, ASC, SLCAN, BLF, TRC, MF4, GVRET CSV or another format of `voltlap log`"
_LOOK = 1000  # lines that decide whether it is a recording at all


def logs_package() -> Any:
    """voltlap_logs, the project's readers of recordings."""
    folder = str(Path(__file__).resolve().parents[2] / "plant_sim" / "python")
    if folder not in sys.path:
        sys.path.append(folder)
    try:
        import voltlap_logs.frames as frames  # type: ignore[import-not-found]
    except ModuleNotFoundError as error:
        raise InputError(f"the Python package {error.name} is missing: `./voltlap log` installs it, or `pip install "
                         "-r toolchain/requirements/logs.txt`") from None
    return frames


class Recording:
    """Iterate over it once: (seconds since the first frame, bus, identifier, data)."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.format = ""
        self.frames = 0
        self.skipped: Counter[str] = Counter()
        self.notes: list[str] = []
        self.untimed = False
        self._shift_s: float | None = None
        self._latest_s = 0.0
        self._set = 0

    def __iter__(self) -> Iterator[LogFrame]:
        frames = logs_package()
        from voltlap_logs.errors import LogError  # type: ignore[import-not-found]
        try:
            with self.path.open("rb"):
                pass
            with frames.Source(self.path) as source:
                for frame in self._timed(self._frames(frames, source)):
                    self.frames += 1
                    yield frame
                if source.broken:
                    self.notes.append(f"the recording breaks off: {source.broken}")
        except OSError as error:
            raise InputError(f"{self.path}: {error.strerror or error}") from None
        except LogError as error:
            raise InputError(str(error)) from None
        except InputError:
            raise
        except Exception as error:  # a reader ends in any of Python's own on bytes that only look like its format
            text = " ".join(str(error).split())[:200] or type(error).__name__
            if not self.frames:
                raise InputError(f"{self.path}: not a recording that can be read ({text}); {_EXPECTED}") from None
            self.notes.append(f"damaged behind frame {self.frames}: {text}")
        if self.untimed:
            self.notes.append("the frames have no stamps: ages, rates and bus load are not known")
        if self._set:
            self.notes.append(f"the clock was set {self._set} times while recording; the parts are joined")

    def _frames(self, frames: Any, source: Any) -> Iterator[LogFrame]:
        if not source.size:
            return
        found = frames.sniff(source)
        if found is not None and found.how == "native":
            self.format = found.name
            yield from self._text(source, found.key)
            return
        if found is None and b"\0" not in source.head():
            raise InputError(f"{self.path}: not a recording that is known; {_EXPECTED}")
        chosen = frames.chosen(source, None)
        self.format = chosen.name
        from voltlap_logs.errors import BrokenOff
        from voltlap_logs.tally import Tally  # type: ignore[import-not-found]
        tally = Tally(chosen.name)
        try:
            for text in frames.READERS[chosen.key](source, tally):
                for line in text.splitlines():
                    yield from self._taken(candump(line))
        except BrokenOff as at:
            self.notes.append(f"the recording breaks off: {at}")
        self.skipped.update(tally.skipped)

    def _text(self, source: Any, key: str) -> Iterator[LogFrame]:
        parse = parser_of(key, source.head().decode("utf-8", "replace"))
        for number, text in source.lines():
            yield from self._taken(parse(text))
            if number == _LOOK and self.skipped[UNREADABLE] > _LOOK // 2:
                raise InputError(f"{self.path}: {self.skipped[UNREADABLE]} of the first {_LOOK} lines are no frames; "
                                 f"expected a {self.format}")

    def _taken(self, line: LogFrame | str | None) -> Iterator[LogFrame]:
        if isinstance(line, LogFrame):
            yield line
        elif line is not None:
            self.skipped[line] += 1

    def _timed(self, frames: Iterator[LogFrame]) -> Iterator[LogFrame]:
        for frame in frames:
            if frame.time_s is None:
                self.untimed = True
                yield frame._replace(time_s=self._latest_s)
                continue
            if self._shift_s is None:
                self._shift_s = -frame.time_s
            now_s = frame.time_s + self._shift_s
            if not -_BACK_S <= now_s - self._latest_s <= _AHEAD_S:
                self._shift_s, now_s = self._latest_s - frame.time_s, self._latest_s
                self._set += 1
            self._latest_s = max(now_s, self._latest_s)
            yield frame._replace(time_s=self._latest_s)


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
