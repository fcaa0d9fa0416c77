# SPDX-License-Identifier: Apache-2.0
"""Candump lines of a pipe, kept until all of them are there: what a format writes first (its start, the numbers of its
channels) is known only then."""
from __future__ import annotations

import re
import tempfile
from collections import Counter
from collections.abc import Iterable, Iterator
from types import TracebackType

from .candump import Frame, parse, parse_time_ns
from .errors import LogError
from .source import Progress
from .tally import Tally

NUMBERED = re.compile(r"(?:v?s?l?can|CAN|channel)_?(\d+)$")


class Spool:
    """All frames of one recording, as often as they are wanted."""

    def __init__(self, lines: Iterable[bytes], tally: Tally) -> None:
        self.tally = tally
        self.changed: Counter[str] = Counter()  # frames that the format holds only in part
        self._file = tempfile.TemporaryFile(prefix="voltlap-frames-")
        self.buses: list[str] = []
        self.first_ns, self.count = 0, 0
        self._take(lines)

    def __enter__(self) -> Spool:
        return self

    def __exit__(self, kind: type[BaseException] | None, value: BaseException | None, at: TracebackType | None) -> None:
        self._file.close()

    def _take(self, lines: Iterable[bytes]) -> None:
        first, buses = None, dict[bytes, None]()
        for number, text in enumerate(lines, 1):
            words = text.split(None, 2)
            if not words or words[0].startswith(b"#"):
                continue
            try:
                time_ns = parse_time_ns(words[0][1:-1].decode())
                buses[words[1]] = None
            except (ValueError, IndexError):
                told = text.decode("utf-8", "replace").strip()[:60]
                raise LogError(f"line {number} of the input is '{told}'; expected lines of `candump -L` such as "
                               "'(1436509052.249713) can0 044#2A36'") from None
            first = time_ns if first is None or time_ns < first else first
            self._file.write(text if text.endswith(b"\n") else text + b"\n")
        self.first_ns = first or 0
        self.buses = sorted(bus.decode("utf-8", "replace") for bus in buses)

    def frames(self) -> Iterator[Frame]:
        self._file.seek(0)
        progress = Progress("writing")
        self.count = 0
        for number, raw in enumerate(self._file, 1):
            frame = parse(raw.decode("utf-8", "replace"))
            if frame is None:
                told = raw.decode("utf-8", "replace").strip()[:60]
                raise LogError(f"line {number} of the input is '{told}', which is no frame; expected e.g. "
                               "'(1436509052.249713) can0 044#2A36'")
            self.count += 1
            if number % 4096 == 0:
                progress.tell(f"{number} frames")
            yield frame
        progress.done()

    def channels(self, lowest: int) -> dict[str, int]:
        """A number for each bus: canN keeps N, all are moved up where one lies below `lowest`; other names get the
        lowest free ones."""
        own = {bus: int(found[1]) for bus in self.buses if (found := NUMBERED.match(bus))}
        taken: dict[int, str] = {}
        for bus, number in own.items():
            if taken.setdefault(number, bus) != bus:  # can0 and vcan0
                own[bus] = -1
        numbers = {bus: number for bus, number in own.items() if number >= 0}
        up = max(lowest - min(numbers.values(), default=lowest), 0)
        numbers = {bus: number + up for bus, number in numbers.items()}
        for bus in self.buses:
            if bus not in numbers:
                numbers[bus] = next(k for k in range(lowest, 256) if k not in numbers.values())
        self.tally.facts["channels"] = numbers
        if max(numbers.values(), default=0) > 255:
            raise LogError(f"the bus {max(numbers, key=lambda bus: numbers[bus])} has a number beyond 255, which the "
                           "format cannot hold; rename it in the candump file")
        return numbers
