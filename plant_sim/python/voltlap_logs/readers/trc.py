# SPDX-License-Identifier: Apache-2.0
"""PEAK TRC 1.0 to 2.1 (PEAK_CAN_TRC_File_Format.pdf). Stamps are milliseconds after the start, which is taken as UTC;
version 1.0 has no start. A file without a bus column has bus `can1`.

Some gateways write a version of their own under the same name: the interface stands where the type should, every
identifier has eight digits, the start is a date and the stamps are seconds. It is told by the interface's name.
"""
from __future__ import annotations

import re
from collections.abc import Iterator
from datetime import datetime, timezone
from decimal import Decimal, InvalidOperation

from ..candump import (BRS, ESI, EXTENDED, FD_LENGTHS, LAST_STANDARD, NS, Frame, error_line, line, parse_time_ns)
from ..errors import LogError
from ..source import Source
from ..tally import Tally

FD_TYPES = {"FD": 0, "FB": BRS, "FE": BRS | ESI, "BI": ESI}
EVENTS = {"ST": "hardware status", "EC": "error counters", "EV": "events", "Warng": "warnings",
          "ChgBR": "bit rate changes", "Event": "events"}
V1_COLUMNS = {"1.0": "NOIL", "1.1": "NOTIL", "1.2": "NOBTIL", "1.3": "NOBTIRL"}  # data follow
DAYS_TO_1970 = 25569
INTERFACE = re.compile(r"\s*\d+\)\s+[\d.]+\s+([A-Za-z]+\d+)\s+[RT]x\s")


def start_ns(text: str) -> int:
    """Days since 1899-12-30, or a date and time."""
    try:
        return round((Decimal(text) - DAYS_TO_1970) * 86400 * 1_000_000) * 1000
    except InvalidOperation:
        moment = datetime.fromisoformat(text.strip()).replace(tzinfo=timezone.utc)
        return int(moment.timestamp()) * NS + moment.microsecond * 1000


def milliseconds(text: str) -> int:
    whole, _, fraction = text.partition(".")
    return int(whole) * 1_000_000 + (int((fraction + "000000")[:6]) if fraction else 0)


def tagged(digits: str) -> int:
    return int(digits, 16) | (EXTENDED if len(digits) > 4 else 0)


def payload(words: list[str], length: int) -> bytes:
    data = bytes.fromhex("".join(words[:length]))
    if len(data) != length:
        raise ValueError(f"{len(data)} bytes instead of {length}")
    return data


class Trc:
    def __init__(self) -> None:
        self.version, self.start_ns, self.columns = "1.0", 0, ""

    def header(self, text: str) -> None:
        key, _, value = text.partition("=")
        if key == ";$FILEVERSION":
            self.version = value.strip()
        elif key == ";$STARTTIME":
            self.start_ns = start_ns(value)
        elif key == ";$COLUMNS":
            self.columns = value.replace(",", "").strip()

    def old(self, words: list[str], tally: Tally) -> str | None:
        """Version 1: fixed columns, then data."""
        names = V1_COLUMNS[self.version]
        field = dict(zip(names, words, strict=False))
        kind, rest = field.get("T", "Rx"), words[len(names):]
        time_ns, bus = self.start_ns + milliseconds(field["O"]), f"can{int(field.get('B', '1'))}"
        if kind == "Error":
            payload(rest, int(field["L"]))  # all of the line is there
            return error_line(time_ns, bus, int(field["I"], 16), 6)
        if kind in EVENTS or field.get("I") == "FFFFFFFF":
            tally.skip(EVENTS.get(kind, "hardware status"))
            return None
        if kind not in ("Rx", "Tx"):
            raise ValueError(kind)
        length = int(field["L"])
        if rest[:1] == ["RTR"]:
            return line(Frame(time_ns, bus, tagged(field["I"]), b"", None, length), 6)
        return line(Frame(time_ns, bus, tagged(field["I"]), payload(rest, min(length, 8))), 6)

    def new(self, words: list[str], tally: Tally) -> str | None:
        """Version 2: columns as the header names them; D is the rest."""
        names = self.columns.split("D")[0]
        field, rest = dict(zip(names, words, strict=False)), words[len(names):]
        kind = field["T"]
        if kind in EVENTS:
            tally.skip(EVENTS[kind])
            return None
        time_ns, bus = self.start_ns + milliseconds(field["O"]), f"can{int(field.get('B', '1'))}"
        if kind == "ER":
            told = payload(rest, int(field.get("L") or field["l"]))
            return error_line(time_ns, bus, told[0] if told else None, 6)
        code = int(field["L"]) if "L" in names else None
        if kind == "RR":
            length = int(field["l"]) if code is None else code
            return line(Frame(time_ns, bus, tagged(field["I"]), b"", None, length), 6)
        if kind in FD_TYPES:
            length = FD_LENGTHS[code] if code is not None else int(field["l"])
            return line(Frame(time_ns, bus, tagged(field["I"]), payload(rest, length), FD_TYPES[kind]), 6)
        if kind != "DT":
            raise ValueError(kind)
        length = min(code if code is not None else int(field["l"]), 8)
        return line(Frame(time_ns, bus, tagged(field["I"]), payload(rest, length)), 6)

    def gateway(self, words: list[str], tally: Tally) -> str | None:
        """N) seconds interface Rx identifier length, and bytes filled up with --."""
        _, seconds, bus, _, digits, length = words[:6]
        id = int(digits, 16)
        return line(Frame(self.start_ns + parse_time_ns(seconds), bus, id | (EXTENDED if id > LAST_STANDARD else 0),
                          payload(words[6:], int(length))), 6)


def read(source: Source, tally: Tally) -> Iterator[str]:
    trc, decode = Trc(), None
    for number, text in source.lines():
        if text.startswith(";"):
            try:
                trc.header(text)
            except ValueError as error:
                raise LogError(f"{source.path}: line {number}: '{text}' is no start: expected days such as "
                               "45982.6797149306 or a date") from error
            continue
        if not text.strip():
            continue
        if decode is None:
            tally.format = f"PEAK TRC {trc.version}"
            decode = trc.gateway if INTERFACE.match(text) else trc.old if trc.version in V1_COLUMNS else trc.new
            if decode == trc.new and not {"O", "T", "I", "D"} <= set(trc.columns):
                raise LogError(f"{source.path}: TRC version {trc.version} with columns '{trc.columns}'; known are 1.0 "
                               "to 1.3, and 2.x with ;$COLUMNS that has O, T, I and D: save it again with PCAN-View")
        try:
            found = decode(text.split(), tally)
        except (ValueError, KeyError, IndexError):
            tally.unreadable(source, number, text)
            continue
        if found:
            yield found
