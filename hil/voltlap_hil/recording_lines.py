# SPDX-License-Identifier: Apache-2.0
"""Lines of recordings that are text: candump (-l, -L and on the screen), Vector ASC, SLCAN, raw hex. What a line is not
able to say is said as one of the words below, and counted by who reads them."""
from __future__ import annotations

import re
from collections.abc import Callable
from typing import NamedTuple

from .frame import EXTENDED

LAST_STANDARD, LAST_EXTENDED = 0x7FF, 0x1FFFFFFF
UNREADABLE, REMOTE, ERROR = "lines that are no frames", "remote frames", "error frames"
BEYOND, NAMED = "identifiers beyond 29 bits", "frames by name, without an identifier"
_FD_LENGTHS = (0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64)


class LogFrame(NamedTuple):
    time_s: float | None  # None: without a stamp
    bus: str
    id: int  # bit 31 set: 29 bits
    data: bytes


Line = LogFrame | str | None  # a frame; what it is in place of one; None: a header, an empty line
Parser = Callable[[str], Line]


def _identified(time_s: float | None, bus: str, id: int, extended: bool, data: bytes) -> Line:
    if id > (LAST_EXTENDED if extended else LAST_STANDARD):
        return BEYOND
    return LogFrame(time_s, bus, id | EXTENDED if extended else id, data)


_CANDUMP = re.compile(r"\((-?[\d.]+)\) +(\S+) +([0-9A-Fa-f]{1,8})(#{1,2})([0-9A-Fa-fRr_.]*)(?:\s.*)?$")


def candump(text: str) -> Line:
    found = _CANDUMP.match(text)
    if found is None:
        return UNREADABLE if text.strip() else None
    stamp, bus, digits, marks, payload = found.groups()
    id, extended = int(digits, 16), len(digits) > 3
    if extended and id & 0x20000000 and id > LAST_EXTENDED:
        return ERROR
    if payload[:1] in ("R", "r"):
        return REMOTE
    payload = (payload[1:] if marks == "##" else payload.partition("_")[0]).replace(".", "")
    try:
        return _identified(float(stamp), bus, id, extended, bytes.fromhex(payload))
    except ValueError:
        return UNREADABLE


_SCREEN = re.compile(r"\s*(?:\((\S+?)\))?\s*(\S+)\s+(?:R?X\s+[-BE]+\s+)?([0-9A-Fa-f]{3,8})\s+\[(\d+)\]\s*(.*)$")


def screen(text: str) -> Line:
    found = _SCREEN.match(text)
    if found is None:
        return UNREADABLE if text.strip() else None
    stamp, bus, digits, length, rest = found.groups()
    if rest.startswith("remote"):
        return REMOTE
    try:
        data = bytes.fromhex("".join(rest.split()[:int(length)]))
        time_s = float(stamp) if stamp else None
        if len(data) != int(length):
            return UNREADABLE
        return _identified(time_s, bus, int(digits, 16), len(digits) > 3, data)
    except ValueError:
        return UNREADABLE


class Asc:
    """Vector ASC; its header says in which base numbers are and what stamps count from."""

    _HEADERS = ("date", "no", "internal", "begin", "end", "//", "%")

    def __init__(self) -> None:
        self._base, self._relative, self._clock_s = 16, False, 0.0

    def __call__(self, text: str) -> Line:
        words = text.split()
        if not words:
            return None
        if words[0] == "base":
            self._base, self._relative = 10 if words[1:2] == ["dec"] else 16, "relative" in words
            return None
        try:
            stamp = float(words[0])
        except ValueError:
            return None if words[0].lower().startswith(self._HEADERS) else UNREADABLE
        self._clock_s = self._clock_s + stamp if self._relative else stamp
        flexible = words[1:2] == ["CANFD"]
        words = words[2:] if flexible else words[1:]
        if not words or not words[0].isdigit():
            return None  # an event such as "Start of measurement"
        try:
            return self._flexible(words) if flexible else self._classic(words)
        except (ValueError, IndexError):
            return UNREADABLE

    def _classic(self, words: list[str]) -> Line:
        channel, name = words[:2]
        if name == "ErrorFrame":
            return ERROR
        if len(words) < 4 or words[2] not in ("Rx", "Tx", "RX", "TX"):
            return None  # statistics, a request to send
        if words[3] == "r":
            return REMOTE
        length = min(int(words[4], 16), 8)
        return self._frame(channel, name, words[5:5 + length], length)

    def _flexible(self, words: list[str]) -> Line:
        channel, direction, name = words[:3]
        if "ErrorFrame" in (direction, name):
            return ERROR
        at = 3 if words[3] in ("0", "1") else 4  # a name may stand before BRS
        length = int(words[at + 3])
        return self._frame(channel, name, words[at + 4:at + 4 + length], length)

    def _frame(self, channel: str, name: str, words: list[str], length: int) -> Line:
        extended = name[-1] in "xX"
        digits = name[:-1] if extended else name
        try:
            id = int(digits, self._base)
        except ValueError:
            return NAMED
        data = bytes(int(word, self._base) for word in words)
        if len(data) != length:
            return UNREADABLE
        return _identified(self._clock_s, f"can{int(channel)}", id, extended, data)


class Slcan:
    """SLCAN; a stamp of 16 bits counts milliseconds and begins again after a minute."""

    _LINE = re.compile(r"([tTdDbBx])([0-9A-Fa-f]{3}|[0-9A-Fa-f]{8})([0-9A-Fa-f])((?:[0-9A-Fa-f]{2})*)$")
    _TURN_S = 60.0

    def __init__(self) -> None:
        self._turns, self._last_s = 0, 0.0

    def __call__(self, text: str) -> Line:
        text = text.strip()
        if not text or text in ("z", "Z", "\a") or text[0] in "VNF":
            return None
        if text[0] in "rR":
            return REMOTE
        digits = 8 if text[0] in "TxDB" else 3
        flexible = text[0] in "dDbB"
        try:
            id, code = int(text[1:1 + digits], 16), int(text[1 + digits], 16)
            length = _FD_LENGTHS[code]
            rest = text[2 + digits:]
            data, stamp = bytes.fromhex(rest[:2 * length]), rest[2 * length:]
            if text[0] not in "tTxdDbB" or len(data) != length or (code > 8 and not flexible):
                return UNREADABLE
            return _identified(self._time_of(stamp), "slcan", id, digits == 8, data)
        except (ValueError, IndexError):
            return UNREADABLE

    def _time_of(self, stamp: str) -> float | None:
        if not stamp:
            return None
        if len(stamp) not in (4, 8):
            raise ValueError(stamp)
        time_s = int(stamp, 16) * (1e-3 if len(stamp) == 4 else 1e-6)
        if len(stamp) == 8:
            return time_s
        if time_s < self._last_s - self._TURN_S / 2:
            self._turns += 1
        self._last_s = time_s
        return time_s + self._turns * self._TURN_S


_HEX = re.compile(r"([0-9A-Fa-f]{8})x([0-9A-Fa-f]{8})([0-9A-Fa-f]{16})$")


def raw_hex(text: str) -> Line:
    found = _HEX.match(text.strip())
    if found is None:
        return UNREADABLE if text.strip() else None
    id, data = int(found[2], 16), bytes.fromhex(found[3])
    if id == 0 and not any(data):
        return "empty slots"
    return _identified(1e-3 * int(found[1], 16), "bus", id, id > LAST_STANDARD, data)


def parser_of(format: str, head: str) -> Parser:
    """For a format by its short name, and the beginning of the file."""
    if format == "candump":
        return candump if any(_CANDUMP.match(line) for line in head.splitlines()) else screen
    return {"asc": Asc, "slcan": Slcan}.get(format, lambda: raw_hex)()
