# SPDX-License-Identifier: Apache-2.0
"""Car and firmware in one process behind two pipes: no CAN interface, no privilege, and several runs side by side.

The clock of such a run is its gateway, too. What a node hears, and what the trace holds, is what it would be with
plant and gateway on one CAN interface and the ECUs behind it on another; a test holds the two together.
"""
from __future__ import annotations

import json
import struct
import subprocess
import tempfile
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .dbc import Dbc, Value
from .errors import HilError, InputError
from .faults import Fault, Gateway
from .frame import Frame, is_lockstep
from .lockstep import MEMBERS
from .nodes import ECUS, program
from .quantity import TICK_MS
from .tape import Tape

PROCESS = "process"  # the name of this kind of bench, where others are named by their CAN interface
_HEAD, _RECORD, _MARK = struct.Struct("<II"), struct.Struct("<IBBH8s"), struct.Struct("<IHBx")
_SENDERS = ("plant", *ECUS)
_MARKS = ("Sync", "DoneBms", "DoneMaster")
_NEAR, _FAR = 0, 1
_GATEWAY_FLAG = 1
_END_S = 5.0


@dataclass(frozen=True)
class EcuPlace:
    """Where the firmware of the process runs: inside of it, or on a board each ("qemu": emulated, "process").

    image   the firmware for it, None for the one that the project builds
    count   count the instructions of each step
    taped   keep the frames of a run inside, for a comparison; those of boards are kept always
    """

    where: str = "inside"
    image: str | None = None
    count: bool = False
    taped: bool = False

    @property
    def outside(self) -> bool:
        return self.where != "inside"

    def flags(self) -> list[str]:
        image = ["--image", self.image] if self.image else []
        return ["--ecu", self.where, *image, *(["--count-instructions"] if self.count else [])]

    def check(self) -> None:
        """InputError for what is not built or installed: a run that ends before its first tick."""
        done = subprocess.run([str(program()), "rig", *self.flags()], stdin=subprocess.DEVNULL, capture_output=True,
                              text=True)
        if done.returncode != 0:
            raise InputError(done.stderr.strip().removeprefix("voltlap: ") or f"exit code {done.returncode}")


class CarProcess:
    """`behind`: the ECUs behind the gateway, None for a run without one. `tape` takes every frame that was sent.

    After close() `ecu_account` is what boards outside of the process said of themselves.
    """

    def __init__(self, dbc: Dbc, listen_to: Iterable[int] | None, behind: Sequence[str] | None,
                 arguments: Sequence[str] = (), seed: int = 1, ecu: EcuPlace = EcuPlace()) -> None:
        self.tape: Tape | None = Tape() if ecu.outside or ecu.taped else None
        self.ecu_account: dict[str, Any] | None = None
        self._dbc, self._ids = dbc, None if listen_to is None else frozenset(listen_to)
        self._gateway = None if behind is None else Gateway(dbc, seed)
        self._side = [_FAR if name in (behind or ()) else _NEAR for name in _SENDERS]
        self._marks = [dbc.message(name).id for name in _MARKS]
        self._pending: list[Frame] = []
        self.tick = -1
        self._said = tempfile.TemporaryFile()
        self._folder = tempfile.TemporaryDirectory(prefix="voltlap-hil-") if ecu.outside else None
        if self._folder:
            arguments = [*ecu.flags(), "--json", str(self._account_file()), *arguments]
        self._process = subprocess.Popen([str(program()), "rig", *arguments], stdin=subprocess.PIPE,
                                         stdout=subprocess.PIPE, stderr=self._said)
        assert self._process.stdin and self._process.stdout
        self._to, self._from = self._process.stdin, self._process.stdout

    @property
    def now_ms(self) -> float:
        return float(max(0, self.tick) * TICK_MS)

    # The clock

    def advance(self) -> list[Frame]:
        own = sum(not is_lockstep(f.id) for f in self._pending)
        self._write(self._pending, 0, 0 if self._gateway is None else _GATEWAY_FLAG)
        self._pending = []
        self.tick += 1
        if self._gateway is None:
            return [frame for frame, _ in self._read()]
        heard: list[Frame] = []
        for sender in range(len(_SENDERS)):
            heard += self._turn(sender, own if sender == 0 else 0)
        return heard

    def _turn(self, sender: int, own: int) -> list[Frame]:
        """The frames of one sender through the gateway; what is on the plant's side of it."""
        assert self._gateway is not None
        side, answers, heard = self._side[sender], [], []
        same = sum(1 << i for i, s in enumerate(self._side) if s == side)
        other = sum(1 << i for i, s in enumerate(self._side) if s != side)
        mark = Frame(self._marks[sender], _MARK.pack(self.tick, 0, 0), self.now_ms)
        frames = [frame for frame, _ in self._read(every=True)]
        for i, frame in enumerate([*frames, mark]):
            passed = [f for f in self._gateway.forward(frame, side) if not is_lockstep(f.id)]
            answers += [(f, other) for f in passed]
            if frame is mark:
                here = []
            else:
                here = [frame]
                answers.append((frame, same if i < own else same & ~(1 << sender)))
            heard += here if side == _NEAR else passed
        self._write([f for f, _ in answers], [mask for _, mask in answers], _GATEWAY_FLAG)
        if self._ids is not None:
            heard = [f for f in heard if f.id in self._ids]
        return [f._replace(time_ms=self.now_ms) for f in heard]

    def tell(self, message: str, **values: Value | None) -> None:
        row = self._dbc.message(message)
        if "Tick" in row.signals:
            values["Tick"] = self.tick + 1
        self._pending.append(Frame(row.id, row.encode(values)))

    def send(self, frames: list[Frame]) -> None:
        self._pending += frames

    def lost(self, node: str) -> None:
        self.tell("MemberLost", Member=MEMBERS[node])

    def reset(self, node: str, off_ms: int) -> None:
        self.tell("MemberReset", Member=MEMBERS[node], OffMs=off_ms)

    def stop(self) -> None:
        """The end of its input is the end of the run."""
        try:
            self._to.close()
        except BrokenPipeError:
            pass

    def close(self) -> None:
        self.stop()
        self._from.close()
        try:
            self._process.wait(_END_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._said.close()
        if self._folder and self.ecu_account is None and self._account_file().exists():
            self.ecu_account = json.loads(self._account_file().read_text())
            self._folder.cleanup()

    def _account_file(self) -> Path:
        assert self._folder
        return Path(self._folder.name) / "ecu.json"

    # The gateway

    def install(self, fault: Fault) -> None:
        assert self._gateway is not None
        self._gateway.install(fault)

    def clear(self) -> None:
        assert self._gateway is not None
        self._gateway.clear()

    def check_alive(self) -> None:
        if self._process.poll() is not None:
            raise self._ended()

    # The pipes

    def _write(self, frames: Sequence[Frame], who: int | Sequence[int], flag: int) -> None:
        whos = [who] * len(frames) if isinstance(who, int) else who
        parts = [_HEAD.pack(len(frames), flag)]
        parts += [_RECORD.pack(f.id, len(f.data), w, 0, f.data) for f, w in zip(frames, whos, strict=True)]
        try:
            self._to.write(b"".join(parts))
            self._to.flush()
        except (BrokenPipeError, ValueError):
            raise self._ended() from None

    def _read(self, every: bool = False) -> list[tuple[Frame, int]]:
        count, _ = _HEAD.unpack(self._read_bytes(_HEAD.size))
        records = self._read_bytes(count * _RECORD.size)
        if self.tape is not None:
            self.tape.add(self.tick, records)
        now, ids = self.now_ms, None if every else self._ids
        return [(Frame(can_id, data[:dlc], now), who)
                for can_id, dlc, who, _, data in _RECORD.iter_unpack(records)
                if ids is None or can_id in ids]

    def _read_bytes(self, count: int) -> bytes:
        data = self._from.read(count)
        if len(data) < count:
            raise self._ended()
        return data

    def _ended(self) -> HilError:
        code = self._process.wait(_END_S)
        self._said.seek(0)
        text = self._said.read().decode(errors="replace").strip()[-2000:]
        return HilError(f"the car's process ended at {self.now_ms:g} ms with exit code {code}: "
                        f"{text or 'it wrote nothing'}")
