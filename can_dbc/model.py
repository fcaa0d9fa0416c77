# SPDX-License-Identifier: Apache-2.0
"""What the generator and the check know about a bus: messages, signals and the attributes of this project."""
from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from fractions import Fraction

import cantools

INVALID = "invalid"          # name of the VAL_ entry that marks "no measurement"
CELLS_PER_FRAME = 3
EXTENDED = 0x80000000         # marks an identifier of 29 bits
CELL_GROUP_NAME = "CellVoltages"
UNITLESS_ROLES = ("counter", "crc", "checksum", "index", "bits", "raw")  # raw: of a unit, but as its code


@dataclass
class Signal:
    name: str
    start: int
    length: int
    big_endian: bool
    signed: bool
    scale: Fraction
    offset: Fraction
    minimum: Fraction | None
    maximum: Fraction | None
    unit: str
    role: str
    enum: str
    choices: dict[int, str]
    bit_names: list[str]
    receivers: list[str]
    comment: str

    @property
    def invalid_code(self) -> int | None:
        return next((raw for raw, name in self.choices.items() if name == INVALID), None)

    @property
    def is_enum(self) -> bool:
        return any(name != INVALID for name in self.choices.values())

    @property
    def is_bit(self) -> bool:
        return self.length == 1 and not self.is_enum

    @property
    def needs_unit(self) -> bool:
        return not (self.is_bit or self.is_enum or self.role in UNITLESS_ROLES)

    def bits(self) -> list[int]:
        """Positions in the payload, byte * 8 + bit, most significant last for Intel and first for Motorola."""
        if not self.big_endian:
            return list(range(self.start, self.start + self.length))
        position = 8 * (self.start // 8) + (7 - self.start % 8)  # counted from the first bit sent
        return [8 * (p // 8) + (7 - p % 8) for p in range(position, position + self.length)]


@dataclass
class Message:
    id: int
    name: str
    dlc: int
    sender: str
    cycle_ms: int
    cycle_many_cells_ms: int
    delay_ms: int
    timeout_ms: int
    signals: list[Signal]
    comment: str
    file: str
    unsealed: bool = False  # by its maker's protocol: neither counter nor CRC

    @property
    def receivers(self) -> set[str]:
        return {r for s in self.signals for r in s.receivers}

    @property
    def protection(self) -> str:
        roles = {s.role for s in self.signals}
        if self.unsealed:
            return "kAge"
        if {"counter", "crc"} <= roles:
            return "kCounterCrc"
        return "kOrionSum" if "checksum" in roles else "kNone"

    def signal_of_role(self, role: str) -> Signal | None:
        return next((s for s in self.signals if s.role == role), None)

    @property
    def group(self) -> tuple[str, int] | None:
        """('CellVoltages', 7) for CellVoltages_07: messages of one shape with consecutive identifiers."""
        match = re.fullmatch(r"(.+)_(\d\d)", self.name)
        return (match.group(1), int(match.group(2))) if match else None


@dataclass
class Bus:
    messages: list[Message] = field(default_factory=list)
    bit_rate: int = 500_000
    fast_cells: int = 48
    comment: str = ""
    instead_of: dict[str, set[str]] = field(default_factory=dict)  # file -> names that its messages take the place of

    def variants(self) -> list[Bus]:
        """The buses of real cars: without the files that stand instead of messages, and with each of them."""
        out = []
        for chosen in [None, *self.instead_of]:
            gone = self.instead_of.get(chosen, set())
            kept = [m for m in self.messages
                    if m.name not in gone and (m.file not in self.instead_of or m.file == chosen)]
            out.append(Bus(kept, self.bit_rate, self.fast_cells, self.comment))
        return out

    def sent_with(self, cells: int) -> list[tuple[Message, int]]:
        """(message, cycle in ms) of a pack with `cells` cells; groups beyond the last cell are not sent."""
        out = []
        for m in self.messages:
            cycle = m.cycle_ms
            if m.group and m.group[0] == CELL_GROUP_NAME:
                if m.group[1] * CELLS_PER_FRAME >= cells:
                    continue
                if cells > self.fast_cells:
                    cycle = m.cycle_many_cells_ms
            out.append((m, cycle))
        return out


def exact(value) -> Fraction | None:
    """The decimal that stands in the file: 0.0001 is 1/10000, not the binary number nearest to it."""
    return None if value is None else Fraction(str(value))


def worst_case_bits(dlc: int, extended: bool = False) -> int:
    """Bits of a classic CAN frame with every stuff bit that can occur, and the 3 bits between frames.

    g + 8 n + 13 + floor((g + 8 n - 1) / 4), g = 34 (11-bit identifier) or 54 (29-bit): Davis et al. 2007, Eq. 1.
    """
    g = 54 if extended else 34
    return g + 8 * dlc + 13 + (g + 8 * dlc - 1) // 4


def _attribute(owner, name, default):
    attributes = owner.dbc.attributes if owner.dbc else {}
    return attributes[name].value if name in attributes else default


def _signal(s) -> Signal:
    bit_names = _attribute(s, "VL_Bits", "")
    return Signal(
        name=s.name, start=s.start, length=s.length, big_endian=s.byte_order == "big_endian", signed=s.is_signed,
        scale=exact(s.scale), offset=exact(s.offset), minimum=exact(s.minimum), maximum=exact(s.maximum),
        unit=s.unit or "", role=_attribute(s, "VL_Role", ""), enum=_attribute(s, "VL_Enum", ""),
        choices={int(k): str(v) for k, v in (s.choices or {}).items()},
        bit_names=bit_names.split(",") if bit_names else [], receivers=list(s.receivers), comment=s.comment or "")


def load(paths) -> Bus:
    """One bus from several DBC files. Overlaps are left in, for the check to name."""
    bus = Bus()
    for path in paths:
        try:
            database = cantools.database.load_file(str(path), strict=False)
        except (cantools.database.Error, OSError) as error:
            raise SystemExit(f"can_dbc: {path}: {error}") from None
        bus.bit_rate = _attribute(database, "VL_BitRate", bus.bit_rate)
        bus.fast_cells = _attribute(database, "VL_FastCells", bus.fast_cells)
        bus.comment = " ".join(b.comment for b in database.buses if b.comment)
        instead_of = _attribute(database, "VL_InsteadOf", "")
        if instead_of:
            bus.instead_of[str(path)] = set(instead_of.split(","))
        for m in database.messages:
            cycle = _attribute(m, "GenMsgCycleTime", 0)
            bus.messages.append(Message(
                id=m.frame_id | (EXTENDED if m.is_extended_frame else 0), name=m.name, dlc=m.length,
                sender=m.senders[0] if m.senders else "", cycle_ms=cycle,
                cycle_many_cells_ms=_attribute(m, "VL_CycleManyCellsMs", 0) or cycle,
                delay_ms=_attribute(m, "GenMsgStartDelayTime", 0), timeout_ms=_attribute(m, "VL_TimeoutMs", 0),
                signals=[_signal(s) for s in sorted(m.signals, key=lambda s: s.start)],
                comment=m.comment or "", file=str(path), unsealed=bool(_attribute(m, "VL_Unsealed", 0))))
    bus.messages.sort(key=lambda m: m.id)
    return bus


def ticks_of_schedule(sent: list[tuple[Message, int]], tick_ms: int) -> int:
    """Ticks after which the pattern of all cycles repeats."""
    return math.lcm(*(max(cycle, tick_ms) for _, cycle in sent)) // tick_ms


def due(message: Message, cycle_ms: int, tick: int, tick_ms: int) -> bool:
    """The rule of sending: a message is due when (now - start delay) is a whole number of cycles."""
    return (tick * tick_ms - message.delay_ms) % cycle_ms < tick_ms
