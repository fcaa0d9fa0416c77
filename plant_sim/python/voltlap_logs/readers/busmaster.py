# SPDX-License-Identifier: Apache-2.0
"""BUSMASTER .log: sessions that each say how times and numbers are written.

    ***START DATE AND TIME 17:4:2017 15:36:20:384***   ***HEX*** or ***DEC***
    ***SYSTEM MODE*** (clock time), ***ABSOLUTE MODE*** (since the start) or ***RELATIVE MODE*** (since the line before)
    15:36:41:0180 Rx 1 0x000000C5 s 8 23 00 00 00 00 00 00 00       the last four digits are tenths of milliseconds

Kinds: s 11 bits, x 29 bits, sr and xr remote. The clock is taken as UTC; channel N becomes `canN`.
"""
from __future__ import annotations

import re
from collections.abc import Iterator
from datetime import datetime, timezone

from ..candump import EXTENDED, ID_MASK, LAST_STANDARD, NS, Frame, line
from ..errors import LogError
from ..source import Source
from ..tally import Tally

MAGIC = "***BUSMASTER"
START = re.compile(r"\*\*\*START DATE AND TIME (\d+):(\d+):(\d+) (\d+):(\d+):(\d+):(\d+)")
MODE = re.compile(r"\*\*\*(SYSTEM|ABSOLUTE|RELATIVE) MODE")
DAY_NS = 86400 * NS


class Session:
    def __init__(self) -> None:
        self.start_ns, self.midnight_ns, self.mode, self.base, self.protocol = 0, 0, "ABSOLUTE", 16, "CAN"
        self._last_ns: int | None = None

    def header(self, text: str) -> None:
        if found := START.match(text):
            day, month, year, hour, minute, second, millisecond = (int(number) for number in found.groups())
            midnight = datetime(year, month, day, tzinfo=timezone.utc)
            self.midnight_ns = int(midnight.timestamp()) * NS
            self.start_ns = self.midnight_ns + (hour * 3600 + minute * 60 + second) * NS + millisecond * 1_000_000
            self._last_ns = None
        elif mode := MODE.match(text):
            self.mode = mode[1]
        elif text.startswith("***PROTOCOL "):
            self.protocol = text.strip("* \t").split()[-1]
        elif text.startswith(("***HEX", "***DEC")):
            self.base = 16 if text.startswith("***HEX") else 10

    def time(self, text: str) -> int:
        hour, minute, second, tenths = text.split(":")
        since = (int(hour) * 3600 + int(minute) * 60 + int(second)) * NS + int((tenths + "00000000")[:9])
        if self.mode == "SYSTEM":
            now = self.midnight_ns + since
            while self._last_ns is not None and now < self._last_ns - DAY_NS // 2:  # past midnight
                now += DAY_NS
        elif self.mode == "ABSOLUTE":
            now = self.start_ns + since
        else:
            now = (self.start_ns if self._last_ns is None else self._last_ns) + since
        self._last_ns = now
        return now

    def frame(self, words: list[str]) -> Frame:
        stamp, direction, channel, digits, kind, length = words[:6]
        if direction not in ("Rx", "Tx") or kind not in ("s", "x", "sr", "xr"):
            raise ValueError(kind)
        id, size = int(digits, self.base), int(length)
        extended = kind.startswith("x")
        if id > (ID_MASK if extended else LAST_STANDARD) or size > 8:
            raise ValueError(digits)
        id |= EXTENDED if extended else 0
        if kind.endswith("r"):
            return Frame(self.time(stamp), f"can{int(channel)}", id, b"", None, size)
        data = bytes(int(word, self.base) for word in words[6:6 + size])
        if len(data) != size:
            raise ValueError(length)
        return Frame(self.time(stamp), f"can{int(channel)}", id, data)


def read(source: Source, tally: Tally) -> Iterator[str]:
    session = Session()
    for number, text in source.lines():
        if text.startswith("***"):
            try:
                session.header(text)
            except ValueError as error:
                raise LogError(f"{source.path}: line {number}: '{text}': {error}; expected a date and a time such as "
                               "17:4:2017 15:36:20:384") from error
        elif text.strip():
            words = text.split()
            if session.protocol != "CAN":
                tally.skip(f"{session.protocol} messages", f"line {number}")
                continue
            try:
                frame = session.frame(words)
                if not source.last_line_ends and frame.data and len(words[-1]) == 1:
                    raise ValueError("half a byte")
            except ValueError:
                tally.unreadable(source, number, text)
                continue
            yield line(frame, 6)
