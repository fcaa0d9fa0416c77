# SPDX-License-Identifier: Apache-2.0
"""Faults of the bus, planted by a gateway between two channels. Here is what it does to each frame, without sockets.

In lockstep, time is counted in Syncs. A frame of the plant belongs to the tick whose Sync follows it, a frame of an ECU
to the tick of the last Sync; a frame that is held back is released just before its sender's own mark of a later tick
(Sync, DoneBms, DoneMaster). Lockstep frames pass untouched. Without Sync, `release` is called by the clock.
"""
from __future__ import annotations

import random
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field

from .dbc import Dbc, Message, Value
from .errors import InputError, did_you_mean
from .frame import Frame, is_lockstep
from .sensor_faults import MOST_CYCLES, LyingSensors, SensorFault

KINDS = ("drop", "delay", "duplicate", "corrupt", "replay", "stuck_counter", "babble", "second_sender", "silence",
         "sensor")
HISTORY = MOST_CYCLES  # frames of one id that can be replayed
MOST_BABBLE = 1000  # frames a tick on all its ids; a bus of 500 kbit/s carries 45
_RANGES = {"every": (1, 1_000_000), "number of frames or copies": (1, 100), "delay": (0, 8_640_000),
           "counter_ahead": (0, 255)}
_MARKS = {"PLANT": "Sync", "BMS": "DoneBms", "MASTER": "DoneMaster"}


@dataclass(frozen=True)
class Fault:
    """One fault. It acts on frames of `ids` in ticks `from_tick` to `until_tick` (exclusive; None: for good).

    drop           every `every`-th frame, or a drawn `share` of them; silence is drop of all that a node sends
    delay          by `delay_ticks`
    duplicate      each frame `copies` times more
    corrupt        inverts `bit` of the payload (byte * 8 + bit) and leaves the CRC; None: damages the CRC itself
    replay         puts the last `copies` frames before the fault, over and over, in the place of new ones
    stuck_counter  the counter of the last frame before the fault, with a CRC that fits
    babble         `copies` frames a tick with random content on each id
    second_sender  after each frame another one with `signals` changed and a counter `counter_ahead` of its own
    sensor         readings that are wrong in frames that are right: see sensor_faults
    """

    kind: str
    ids: frozenset[int]
    from_tick: int = 0
    until_tick: int | None = None
    every: int = 1
    delay_ticks: int = 0
    copies: int = 1
    bit: int | None = None
    counter_ahead: int = 1
    signals: Mapping[str, Value | None] = field(default_factory=dict)
    share: float = 1.0
    sensor: SensorFault | None = None

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise InputError(f"no fault {self.kind!r}.{did_you_mean(self.kind, KINDS)} Faults: {', '.join(KINDS)}")
        for what, value in (("every", self.every), ("number of frames or copies", self.copies),
                            ("delay", self.delay_ticks), ("counter_ahead", self.counter_ahead)):
            least, most = _RANGES[what]
            if not least <= value <= most:
                raise InputError(f"{self.kind}: found {what} {value}, expected at least {least} and at most {most}")
        if not 0.0 < self.share <= 1.0:
            raise InputError(f"{self.kind}: found a share of {100 * self.share:g} %, expected more than 0 and at most "
                             "100 %")
        if self.bit is not None and self.bit < 0:
            raise InputError(f"{self.kind}: found bit {self.bit}, expected at least 0")
        if self.kind == "replay" and self.copies > HISTORY:
            raise InputError(f"replay: found {self.copies} frames, expected at most the {HISTORY} that are kept")
        if self.until_tick is not None and self.until_tick <= self.from_tick:
            raise InputError(f"{self.kind}: found that it ends before it begins, expected a time above 0")

    def check_fits(self, dbc: Dbc) -> None:
        """Each message that the DBC files know has what the fault is about, and the bus room for it."""
        messages = [dbc.by_id[can_id] for can_id in sorted(self.ids) if can_id in dbc.by_id]
        if self.kind == "babble" and self.copies * len(self.ids) > MOST_BABBLE:
            raise InputError(f"found {self.copies} frames a tick on each of {len(self.ids)} identifiers, expected at "
                             f"most {MOST_BABBLE} in all")
        if self.sensor is not None:
            self.sensor.check_fits(dbc)
        if self.kind == "stuck_counter" and not any(message.counter for message in messages):
            raise InputError("found no message with a rolling counter, which could stand still")
        for message in messages:
            for name, value in self.signals.items():
                message.encode({name: value})
            if self.bit is not None and self.bit >= 8 * message.dlc:
                raise InputError(f"found bit {self.bit}, expected one below {8 * message.dlc}: {message.name} has "
                                 f"{message.dlc} bytes")

    @property
    def repeats(self) -> bool:
        """It sends what was there before it, which is therefore not overwritten."""
        return self.kind in ("replay", "stuck_counter")

    def acts_on(self, can_id: int, tick: int) -> bool:
        return can_id in self.ids and self.active(tick)

    def active(self, tick: int) -> bool:
        return self.from_tick <= tick and (self.until_tick is None or tick < self.until_tick)


class Gateway:
    """What comes in on one side, and what goes out on the other."""

    def __init__(self, dbc: Dbc, seed: int = 1) -> None:
        self._dbc = dbc
        self._sender = {m.id: m.sender for m in dbc.messages.values()}
        self._marks = {dbc.message(mark).id: sender for sender, mark in _MARKS.items()}
        self._sync = dbc.message("Sync").id
        self._tick_signal = dbc.signal("Sync.Tick")  # Done carries its tick at the same place
        self._faults: list[Fault] = []
        self._late: list[tuple[int, str, int, Frame]] = []  # (due tick, sender, side it came from, frame)
        self._history: dict[int, deque[Frame]] = {}
        self._seen: dict[tuple[int, int], int] = {}  # (fault, id): frames since the fault acts
        self._random = random.Random(seed)
        self._sensors = LyingSensors(dbc, self._random)
        self.next_sync = 0

    def install(self, fault: Fault) -> None:
        self._faults.append(fault)

    def clear(self) -> None:
        """Ends every fault. What is held back still comes, late."""
        self._faults.clear()
        self._seen.clear()
        self._sensors.clear()

    @property
    def idle(self) -> bool:
        return not self._faults and not self._late

    def forward(self, frame: Frame, side: int) -> list[Frame]:
        """What leaves on the other side because this frame came in on `side`."""
        if is_lockstep(frame.id):
            return self._mark(frame) + [frame]
        sender = self._sender.get(frame.id, "PLANT")
        tick = self.next_sync if sender == "PLANT" else self.next_sync - 1
        out = [frame]
        for fault in self._faults:
            if fault.acts_on(frame.id, tick):
                out = [changed for one in out for changed in self._apply(fault, one, tick, side)]
        if not any(fault.repeats and fault.acts_on(frame.id, tick) for fault in self._faults):
            self._history.setdefault(frame.id, deque(maxlen=HISTORY)).append(frame)
        return out

    def _mark(self, frame: Frame) -> list[Frame]:
        sender = self._marks.get(frame.id)
        if sender is None:
            return []
        tick = int(self._tick_signal.raw(frame.data))
        out = [late for _, late in self.release(tick, sender)]
        if frame.id == self._sync:
            out += self._babble(tick)
            self.next_sync = tick + 1
        return out

    def release(self, tick: int, sender: str | None = None) -> list[tuple[int, Frame]]:
        """(side it came from, frame) of what was held back until now; of one sender, or of all."""
        due = [row for row in self._late if row[0] <= tick and sender in (None, row[1])]
        self._late = [row for row in self._late if row not in due]
        return [(side, frame) for _, _, side, frame in due]

    def advance(self, tick: int) -> list[tuple[int, Frame]]:
        """A tick of the wall clock, where no Sync says so."""
        self.next_sync = tick + 1
        return self.release(tick) + [(0, frame) for frame in self._babble(tick)]

    def _babble(self, tick: int) -> list[Frame]:
        return [Frame(can_id, self._random.randbytes(8))
                for fault in self._faults if fault.kind == "babble" and fault.active(tick)
                for _ in range(fault.copies) for can_id in sorted(fault.ids)]

    def _apply(self, fault: Fault, frame: Frame, tick: int, side: int) -> list[Frame]:
        count = self._seen.get((id(fault), frame.id), 0)
        self._seen[id(fault), frame.id] = count + 1
        if fault.kind in ("drop", "silence"):
            if fault.share < 1.0:
                return [] if self._random.random() < fault.share else [frame]
            return [] if count % fault.every == 0 else [frame]
        if fault.sensor is not None:
            return [self._sensors.changed(fault.sensor, frame, self._past)]
        if fault.kind == "delay":
            self._late.append((tick + fault.delay_ticks, self._sender.get(frame.id, "PLANT"), side, frame))
            return []
        if fault.kind == "duplicate":
            return [frame] * (1 + fault.copies)
        if fault.kind == "corrupt":
            return [self._corrupted(fault, frame)]
        if fault.kind == "replay":
            return self._replayed(fault, frame, count)
        if fault.kind == "stuck_counter":
            return [self._stuck(frame)]
        if fault.kind == "second_sender":
            return [frame, self._second(fault, frame)]
        return [frame]

    def _corrupted(self, fault: Fault, frame: Frame) -> Frame:
        message = self._dbc.by_id.get(frame.id)
        crc_byte = message.crc_byte() if message else None
        bit = fault.bit if fault.bit is not None else 8 * (crc_byte if crc_byte is not None else len(frame.data) - 1)
        if not 0 <= bit < 8 * len(frame.data):  # somebody else's frame, shorter than the DBC files say
            return frame
        data = bytearray(frame.data)
        data[bit // 8] ^= 1 << bit % 8
        return frame._replace(data=bytes(data))

    def _past(self, can_id: int, frames: int) -> Frame | None:
        old = self._history.get(can_id, ())
        return old[-frames] if len(old) >= frames else None

    def _of_dbc(self, frame: Frame) -> Message | None:
        """None for somebody else's frame: of no message, or of another length than the DBC files say."""
        message = self._dbc.by_id.get(frame.id)
        return message if message and message.dlc == len(frame.data) else None

    def _replayed(self, fault: Fault, frame: Frame, count: int) -> list[Frame]:
        old = list(self._history.get(frame.id, ()))[-fault.copies:]
        return [old[count % len(old)]] if old else [frame]

    def _stuck(self, frame: Frame) -> Frame:
        message, old = self._of_dbc(frame), self._history.get(frame.id)
        if message is None:
            return frame
        counter = message.counter_of(old[-1].data) if old else 0
        return frame._replace(data=message.seal(frame.data, counter))

    def _second(self, fault: Fault, frame: Frame) -> Frame:
        message = self._of_dbc(frame)
        if message is None:
            return frame
        data = message.encode(fault.signals, frame.data)
        return frame._replace(data=message.seal(data, message.counter_of(frame.data) + fault.counter_ahead))
