# SPDX-License-Identifier: Apache-2.0
"""What of a recording was no frame: counted by kind, with the place of the first."""
from __future__ import annotations

import json
from collections import Counter

from .errors import BrokenOff
from .source import Source


def shown(text: str) -> str:
    """What a terminal can be given."""
    return "".join(letter if letter.isprintable() else "?" for letter in text)


class Tally:
    def __init__(self, format: str) -> None:
        self.format = format
        self.frames = 0
        self.skipped: Counter[str] = Counter()
        self.first: dict[str, str] = {}
        self.facts: dict[str, object] = {}  # further things worth telling, such as the numbers that buses were given

    def skip(self, kind: str, where: str = "", count: int = 1) -> None:
        if count:
            self.skipped[kind] += count
            if where:
                self.first.setdefault(kind, where)

    def unreadable(self, source: Source, number: int, text: str) -> None:
        """A line that should have been a frame. The last one without an end is where the recorder was stopped."""
        if not source.last_line_ends:
            raise BrokenOff(f"line {number} is cut: '{shown(text[-60:])}'")
        self.skip("unreadable lines", f"line {number}: '{shown(text[:60])}'")

    def json(self) -> str:
        return json.dumps({"frames": self.frames, "skipped": dict(self.skipped), "format": self.format, **self.facts})
