# SPDX-License-Identifier: Apache-2.0
"""Frames and signals of any car's DBC files, for decoding what is heard. cantools reads a file statement by statement
(voltlap_logs.dbc_json): a frame that cannot be used is named and hurts none of the others."""
from __future__ import annotations

import struct
import sys
from collections.abc import Iterable
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

from .errors import InputError
from .frame import EXTENDED

Value = float | str
_FLOATS = {16: ("<H", "<e"), 32: ("<I", "<f"), 64: ("<Q", "<d")}


def id_text(can_id: int) -> str:
    return f"0x{can_id & ~EXTENDED:0{8 if can_id & EXTENDED else 3}X}"


class CarSignal:
    def __init__(self, row: dict[str, Any], frame_length: int) -> None:
        self.name: str = row["name"]
        self.unit: str = row["unit"]
        self.scale, self.offset = float(row["scale"]), float(row["offset"])
        self.length: int = row["length"]
        self.float: bool = row["float"]
        self.signed: bool = row["signed"] and not self.float
        self.choices: dict[int, str] = dict(map(tuple, row["choices"]))
        self.invalid: list[list[int]] = row["invalid"]
        # Of named states "Fault" and "Init" are as good as any: they are told, not left out.
        self.states = sum(not self.is_invalid(raw % (1 << self.length)) for raw in self.choices) >= 2
        if self.states:
            self.invalid = []
        self.multiplexer: str | None = row["multiplexer"]
        self.cases: list[list[int]] = row["cases"]
        self.big_endian: bool = row["big_endian"]
        start = row["start"]
        if self.big_endian:  # the most significant bit is named, and counts from the left
            first = 8 * (start // 8) + 7 - start % 8
            self.shift = 8 * frame_length - first - self.length
            self.bytes = (first + self.length + 7) // 8
        else:
            self.shift = start
            self.bytes = (start + self.length + 7) // 8
        self._mask = (1 << self.length) - 1
        self._sign = 1 << self.length - 1

    def bits(self, little: int, big: int) -> int:
        """The raw value without sign, of a payload as a number in either byte order."""
        return (big if self.big_endian else little) >> self.shift & self._mask

    def number(self, bits: int) -> float:
        """What can be ordered and scaled: the raw value with its sign, or the floating-point number."""
        if self.float:
            whole, real = _FLOATS[self.length]
            return float(struct.unpack(real, struct.pack(whole, bits))[0])
        return bits - 2 * self._sign if self.signed and bits & self._sign else bits

    def is_invalid(self, bits: int) -> bool:
        return any(first <= bits <= last for first, last in self.invalid)

    def is_case(self, bits: int) -> bool:
        """Of a multiplexer's value."""
        return any(first <= bits <= last for first, last in self.cases)

    def scaled(self, number: float) -> float:
        if self.scale == 1.0 and self.offset == 0.0:
            return number
        return round(number * self.scale + self.offset, 9)

    def shown(self, number: float) -> Value:
        name = None if self.float else self.choices.get(int(number))
        return self.scaled(number) if name is None else name


class CarMessage:
    def __init__(self, row: dict[str, Any], file: str) -> None:
        self.id: int = row["id"] | (EXTENDED if row["extended"] else 0)
        self.name: str = row["name"]
        self.file = file
        self.length: int = row["length"]
        self.cycle_s: float = (row["cycle_time_ms"] or 0) * 1e-3
        self.sender: str = row["senders"][0] if row["senders"] else ""
        signals = [CarSignal(signal, self.length) for signal in row["signals"]]
        by_name = {signal.name: signal for signal in signals}

        def depth(signal: CarSignal) -> int:
            return 0 if signal.multiplexer is None else 1 + depth(by_name[signal.multiplexer])

        # A multiplexer comes before what depends on it.
        self.signals = sorted(signals, key=depth)
        self.hidden: set[str] = set()
        self.shown = True
        self._above = [None if s.multiplexer is None else self.signals.index(by_name[s.multiplexer])
                       for s in self.signals]

    def decode(self, data: bytes) -> list[int | None]:
        """Raw values without sign, in the order of `signals`; None for one that is not in this frame: beyond its length
        or in another case of its multiplexer."""
        whole = data[:self.length].ljust(self.length, b"\0")
        little, big = int.from_bytes(whole, "little"), int.from_bytes(whole, "big")
        out: list[int | None] = []
        for signal, above in zip(self.signals, self._above, strict=True):
            if len(data) < signal.bytes:
                out.append(None)
            elif above is not None and ((case := out[above]) is None or not signal.is_case(case)):
                out.append(None)
            else:
                out.append(signal.bits(little, big))
        return out

    def show(self, names: set[str]) -> None:
        """Only these signals from now on; the others are decoded as well, for what depends on them."""
        self.hidden = {signal.name for signal in self.signals} - names
        self.shown = bool(names)

    def layout(self) -> list[tuple[Any, ...]]:
        return [(s.name, s.shift, s.length, s.big_endian, s.signed, s.float, s.scale, s.offset) for s in self.signals]


class CarDbc:
    """Every frame of some files by identifier."""

    def __init__(self, paths: Iterable[Path]) -> None:
        self.by_id: dict[int, CarMessage] = {}
        self.refused: dict[int, str] = {}
        self.notes: list[str] = []
        for path in paths:
            self._read(path)

    def _read(self, path: Path) -> None:
        folder = str(Path(__file__).resolve().parents[2] / "plant_sim" / "python")
        if folder not in sys.path:
            sys.path.append(folder)
        try:
            from voltlap_logs import dbc_json  # type: ignore[import-not-found]
        except SystemExit:  # it is a program as well, and has said which package is missing
            raise InputError("the Python package cantools is missing: `pip install -r toolchain/requirements/run.txt` "
                             "installs it") from None
        dbc_json.logging.disable(dbc_json.logging.CRITICAL)  # cantools' hints about what is refused here with a line
        try:
            content = dbc_json.database_json(path, dbc_json.text_of(path))
        except dbc_json.FileRefused as error:
            raise InputError(str(error)) from None
        except Exception as error:  # the parser ends in any of Python's own on text that only looks like a DBC file
            text = " ".join(str(error).split())[:200] or type(error).__name__
            raise InputError(f"{path}: found what is no DBC file that can be read ({text}); expected BO_ and SG_ "
                             "lines") from None
        for row in content["refused"]:
            can_id = row["id"] | (EXTENDED if row["extended"] else 0)
            self.refused.setdefault(can_id, row["name"])
            self.notes.append(f"{path}:{row['line']}: frame {id_text(can_id)} {row['name']} is left out: "
                              f"found {row['found']}; expected {row['expected']}")
        for row in content["messages"]:
            self._add(CarMessage(row, str(path)))

    def _add(self, message: CarMessage) -> None:
        other = self.by_id.setdefault(message.id, message)
        if other is not message and other.layout() != message.layout():
            raise InputError(f"{message.file}: found frame {id_text(message.id)} ({message.name}) as in {other.file} "
                             f"({other.name}), with other signals; expected each frame in one of the files. Leave out "
                             "the file that is not of this car.")

    def keep(self, patterns: list[str]) -> None:
        """Only signals whose name or Frame.Signal fits; frames without one stay known, and are not shown."""
        found = set()
        for message in self.by_id.values():
            wanted = {pattern: {s.name for s in message.signals
                                if fnmatchcase(s.name.lower(), pattern.lower())
                                or fnmatchcase(f"{message.name}.{s.name}".lower(), pattern.lower())}
                      for pattern in patterns}
            found.update(pattern for pattern, names in wanted.items() if names)
            message.show(set().union(*wanted.values()))
        for pattern in patterns:
            if pattern not in found:
                raise InputError(f"--signals: found {pattern!r}, which fits no signal of the DBC files; expected names "
                                 "or patterns such as BmsStatus.PackVoltage, PackVoltage, *Temp*")
