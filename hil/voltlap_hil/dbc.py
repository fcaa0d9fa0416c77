# SPDX-License-Identifier: Apache-2.0
"""Messages and signals of the DBC files: found by name, decoded and encoded with units, sealed as the files say.

A frame with roles `counter` and `crc` carries a rolling counter and CRC-8 SAE J1850 (0x1D, start 0xFF, final xor 0xFF)
over the identifier, high byte first, and every byte but the CRC. Role `checksum`: (identifier + 8 + bytes) modulo 256.
"""
from __future__ import annotations

import math
import os
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Literal

import cantools

from .errors import InputError, did_you_mean
from .frame import EXTENDED

Value = float | str
INVALID = "invalid"  # the VAL_ entry of a code that says: no measurement
LOCKSTEP_FILE = "lockstep.dbc"
FILES = ("car.dbc", "orion.dbc", "charger.dbc", "pm100.dbc", "amk.dbc", LOCKSTEP_FILE)


def _crc8_of_byte(byte: int) -> int:
    for _ in range(8):
        byte = (byte << 1) ^ 0x1D if byte & 0x80 else byte << 1
    return byte & 0xFF


_CRC8 = [_crc8_of_byte(byte) for byte in range(256)]


def crc8_j1850(data: Iterable[int]) -> int:
    crc = 0xFF
    for byte in data:
        crc = _CRC8[crc ^ byte]
    return crc ^ 0xFF


def _attribute(owner: Any, name: str, default: Any) -> Any:
    attributes = owner.dbc.attributes if owner.dbc else {}
    return attributes[name].value if name in attributes else default


class Signal:
    """One signal: `read` gives its value in its unit, the name of its state, or None for "no measurement"."""

    def __init__(self, message: Message, signal: Any) -> None:
        self.message = message
        self.name = f"{message.name}.{signal.name}"
        self.short_name: str = signal.name
        self.unit: str = signal.unit or ""
        self.minimum, self.maximum = signal.minimum, signal.maximum
        self.scale, self.offset = float(signal.scale), float(signal.offset)
        self.role: str = _attribute(signal, "VL_Role", "")
        names = _attribute(signal, "VL_Bits", "")
        self.bits: list[str] = names.split(",") if names else []
        choices = {int(raw): str(name) for raw, name in (signal.choices or {}).items()}
        self.invalid_raw = next((raw for raw, name in choices.items() if name == INVALID), None)
        self.states = {raw: name for raw, name in choices.items() if name != INVALID}
        self.length: int = signal.length
        self._order: Literal["little", "big"] = "little" if signal.byte_order == "little_endian" else "big"
        self._signed: bool = signal.is_signed
        if self._order == "little":
            self._shift: int = signal.start
        else:  # the most significant bit is named, and counts from the left
            first = 8 * (signal.start // 8) + 7 - signal.start % 8
            self._shift = 8 * message.dlc - first - signal.length
        if not 0 <= self._shift <= 8 * message.dlc - self.length:
            raise InputError(f"{message.file}: {self.name} has bits outside of the {message.dlc} bytes of its message")
        if not (math.isfinite(self.scale) and math.isfinite(self.offset) and self.scale):
            raise InputError(f"{message.file}: {self.name} has the factor {self.scale:g} and the offset "
                             f"{self.offset:g}, expected numbers, and a factor that is not 0")

    def raw(self, data: bytes) -> int:
        value = int.from_bytes(data, self._order) >> self._shift & ((1 << self.length) - 1)
        return value - (1 << self.length) if self._signed and value >> self.length - 1 else value

    def read(self, data: bytes) -> Value | None:
        raw = self.raw(data)
        if raw == self.invalid_raw:
            return None
        if self.states:
            return self.states.get(raw, f"{raw} (no name)")
        return raw if self.scale == 1.0 and self.offset == 0.0 else round(raw * self.scale + self.offset, 9)

    @property
    def range(self) -> tuple[float, float]:
        """What its bits can carry, and the DBC file allows."""
        lowest = -(1 << self.length - 1) if self._signed else 0
        low, high = sorted(raw * self.scale + self.offset for raw in (lowest, lowest + (1 << self.length) - 1))
        return (low if self.minimum is None else max(low, float(self.minimum)),
                high if self.maximum is None else min(high, float(self.maximum)))

    def bit(self, name: str) -> int:
        """Position of a named bit."""
        if name not in self.bits:
            raise InputError(f"{self.name} has no bit {name!r}.{did_you_mean(name, self.bits)} "
                             f"Bits: {', '.join(self.bits) or 'none are named'}")
        return self.bits.index(name)


class Message:
    def __init__(self, message: Any, file: str) -> None:
        self._message = message
        self.name: str = message.name
        self.file = file
        self.id: int = message.frame_id | (EXTENDED if message.is_extended_frame else 0)
        self.dlc: int = message.length
        self.sender: str = message.senders[0] if message.senders else ""
        self.receivers = frozenset(name for signal in message.signals for name in signal.receivers)
        self.cycle_ms: int = _attribute(message, "GenMsgCycleTime", 0)
        self.timeout_ms: int = _attribute(message, "VL_TimeoutMs", 0)
        self.signals = {s.name: Signal(self, s) for s in message.signals}
        self.counter = self._of_role("counter")
        self.counter_round = 1 << self.counter.length if self.counter is not None else 1
        self._crc = self._of_role("crc")
        self._checksum = self._of_role("checksum")
        self._orion_offset: int = self.id + 8
        for seal in filter(None, (self.counter, self._crc, self._checksum)):
            if seal._shift % 8 + seal.length > 8:
                raise InputError(f"{file}: {seal.name} crosses a byte; a counter, CRC or checksum lies inside one")

    def _of_role(self, role: str) -> Signal | None:
        return next((s for s in self.signals.values() if s.role == role), None)

    def read(self, data: bytes) -> dict[str, Value | None]:
        return {name: signal.read(data) for name, signal in self.signals.items()}

    def encode(self, values: Mapping[str, Value | None], base: bytes | None = None) -> bytes:
        """Payload with `values` in their units over `base`; None is "no measurement". Counter and CRC: see seal."""
        content: dict[str, Any] = dict.fromkeys(self.signals, 0)
        if base is not None:
            content = {name: signal.raw(base) for name, signal in self.signals.items()}
        for name, value in values.items():
            content[name] = self._to_raw(name, value)
        return bytes(self._message.encode(content, scaling=False, strict=False))

    def _to_raw(self, name: str, value: Value | None) -> int:
        if name not in self.signals:
            raise InputError(f"{self.name} has no signal {name!r}.{did_you_mean(name, self.signals)} "
                             f"Signals: {', '.join(self.signals)}")
        signal = self.signals[name]
        if value is None:
            if signal.invalid_raw is None:
                raise InputError(f"{signal.name} has no code for 'no measurement' (no VAL_ entry named {INVALID})")
            return signal.invalid_raw
        if isinstance(value, str):
            named = next((raw for raw, state in signal.states.items() if state == value), None)
            if named is None:
                raise InputError(f"{signal.name} cannot be {value!r}.{did_you_mean(value, signal.states.values())} "
                                 f"Values: {', '.join(signal.states.values()) or 'numbers only'}")
            return named
        raw = round((float(value) - signal.offset) / signal.scale)
        low = -(1 << signal.length - 1) if signal._signed else 0
        if not low <= raw < low + (1 << signal.length):
            raise InputError(f"{signal.name} cannot carry {value:g} {signal.unit}: it has {signal.length} bits of "
                             f"{signal.scale:g} {signal.unit}")
        return raw

    @property
    def sealable(self) -> bool:
        return self._crc is not None or self._checksum is not None

    def seal(self, data: bytes, counter: int = 0) -> bytes:
        """The payload with this counter and the CRC or checksum that goes with it."""
        if self.counter is not None:
            data = self._put(data, self.counter, counter % self.counter_round)
        if self._crc is not None:
            data = self._put(data, self._crc, self._crc_of(data, self._crc))
        elif self._checksum is not None:
            data = self._put(data, self._checksum, self._sum_of(data, self._checksum))
        return data

    def sealed_ok(self, data: bytes) -> bool:
        if self._crc is not None:
            return self._crc.raw(data) == self._crc_of(data, self._crc)
        return self._checksum is None or self._checksum.raw(data) == self._sum_of(data, self._checksum)

    def counter_of(self, data: bytes) -> int:
        return self.counter.raw(data) if self.counter is not None else 0

    def crc_byte(self) -> int | None:
        signal = self._crc or self._checksum
        return None if signal is None else self._byte_of(signal)

    def _byte_of(self, signal: Signal) -> int:
        at = signal._shift // 8
        return at if signal._order == "little" else self.dlc - 1 - at

    def _put(self, data: bytes, signal: Signal, raw: int) -> bytes:
        at, low = self._byte_of(signal), signal._shift % 8
        mask = (1 << signal.length) - 1 << low
        return data[:at] + bytes([data[at] & ~mask & 0xFF | raw << low & mask]) + data[at + 1:]

    def _crc_of(self, data: bytes, signal: Signal) -> int:
        at = self._byte_of(signal)
        return crc8_j1850([self.id >> 8 & 0xFF, self.id & 0xFF, *data[:at], *data[at + 1:]])

    def _sum_of(self, data: bytes, signal: Signal) -> int:
        at = self._byte_of(signal)
        return (self._orion_offset + sum(data[:at]) + sum(data[at + 1:])) & 0xFF


class Dbc:
    """Every message of some DBC files, by name and by identifier."""

    def __init__(self, paths: Iterable[Path]) -> None:
        self.messages: dict[str, Message] = {}
        self.by_id: dict[int, Message] = {}
        # Names that mean frames of another message in a car: inverter_names.py.
        self.other_signals: dict[str, Signal] = {}
        self.other_messages: dict[str, list[Message]] = {}
        for path in paths:
            for message in _messages(path):
                self._add(message)
        self.nodes = sorted({m.sender for m in self.messages.values() if m.sender})

    @classmethod
    def of_project(cls) -> Dbc:
        folder = can_dbc_folder()
        return cls(folder / name for name in FILES if (folder / name).exists())

    def _add(self, message: Message) -> None:
        if message.name in self.messages or message.id in self.by_id:
            raise InputError(f"{message.file}: message {message.name} (0x{message.id & ~EXTENDED:X}) is there twice")
        self.messages[message.name] = message
        self.by_id[message.id] = message

    def message(self, name: str) -> Message:
        if name in self.other_messages:
            return self.other_messages[name][0]
        if name not in self.messages:
            raise InputError(f"no message {name!r} in the DBC files.{did_you_mean(name, self.messages)}")
        return self.messages[name]

    def signal(self, name: str) -> Signal:
        if name in self.other_signals:
            return self.other_signals[name]
        message, dot, short = name.partition(".")
        if message in self.other_messages:
            known = [other for other in self.other_signals if other.startswith(f"{message}.")]
            raise InputError(f"{name!r}: this car's inverter says no such thing; expected {' or '.join(known)}")
        if not dot:
            raise InputError(f"{name!r} is no signal; expected Message.Signal, for example BmsStatus.State")
        signals = self.message(message).signals
        if short not in signals:
            raise InputError(f"{message} has no signal {short!r}.{did_you_mean(short, signals)} "
                             f"Signals: {', '.join(signals)}")
        return signals[short]

    def select(self, names: Iterable[str]) -> list[Message]:
        """Messages of a list of names; a node's name is all it sends, CellVoltages is all of CellVoltages_00 and on."""
        found: dict[str, Message] = {}
        for name in names:
            if name in self.other_messages:
                found.update((m.name, m) for m in self.other_messages[name])
                continue
            group = re.compile(re.escape(name) + r"_\d\d")
            some = [m for m in self.messages.values()
                    if m.file != LOCKSTEP_FILE and (name in (m.name, m.sender) or group.fullmatch(m.name))]
            if not some:
                near = did_you_mean(name, self.messages)
                raise InputError(f"{name!r} is no message, group of messages or node.{near} "
                                 f"Nodes: {', '.join(self.nodes)}")
            found.update((m.name, m) for m in some)
        return list(found.values())


# A message of a thousand bytes or a signal of a thousand bits, for which the parser would take all memory there is.
_HUGE = re.compile(r"^\s*(?:BO_\s+\d+\s+\w+\s*:\s*|SG_[^:\n]*:\s*(?:\d+\|)?)(\d{4,})", re.MULTILINE)


def _messages(path: Path) -> list[Message]:
    try:
        text = Path(path).read_text(encoding="cp1252", errors="replace")
        if huge := _HUGE.search(text):
            line = text.count("\n", 0, huge.start(1)) + 1
            raise InputError(f"{path}:{line}: found the length or place {huge[1]}, expected that of a CAN frame's bits")
        database = cantools.database.load_file(str(path), database_format="dbc")
        return [Message(raw, Path(path).name) for raw in database.messages]  # type: ignore[union-attr]
    except InputError:
        raise
    except OSError as error:
        raise InputError(f"{path}: {error.strerror or error}") from None
    except Exception as error:  # the parser ends in any of Python's own on text that only looks like a DBC file
        text = " ".join(str(error).split())[:300] or type(error).__name__
        raise InputError(f"{path}: found what is no DBC file that can be read ({text}); expected BO_ and SG_ lines as "
                         "`can_dbc/car.dbc` has them") from None


def can_dbc_folder() -> Path:
    """$VOLTLAP_CAN_DBC, else can_dbc of the project that this package stands in."""
    named = os.environ.get("VOLTLAP_CAN_DBC")
    folder = Path(named) if named else Path(__file__).resolve().parents[2] / "can_dbc"
    if not (folder / "car.dbc").exists():
        raise InputError(f"no car.dbc in {folder}. Set VOLTLAP_CAN_DBC to the folder of the DBC files.")
    return folder
