# SPDX-License-Identifier: Apache-2.0
"""A channel opened through python-can: SocketCAN read and written in batches, anything else frame by frame."""
from __future__ import annotations

import time
from collections.abc import Iterable, Sequence

import can
from can.typechecking import CanFilter

from .batch_socket import BatchSocket
from .dbc import Dbc
from .errors import HilError
from .frame import EXTENDED, Frame
from .signals import Signals

_CREATE = ("Create it: `ip link add dev {0} type vcan && ip link set up {0}`, or start the command inside "
           "`./voltlap with-vcan`.")


class Bus:
    """An open channel. `signals` follows every car frame that is read.

    >>> with Bus("vcan0") as bus:
    ...     bus.read(timeout_s=1.0)
    ...     bus.signals["BmsLimits.DischargeLimit"].value
    """

    def __init__(self, channel: str, interface: str = "socketcan", dbc: Dbc | None = None,
                 ids: Iterable[int] | None = None, lossy: bool = False) -> None:
        """`lossy`: frames that come faster than they are read are counted, not an error."""
        self.channel = channel
        self.dbc = dbc if dbc is not None else Dbc.of_project()
        self.signals = Signals(self.dbc)
        self._bus = _open(channel, interface, ids)
        raw = getattr(self._bus, "socket", None) if interface == "socketcan" else None
        self._batch = BatchSocket(raw, channel, lossy) if raw is not None else None
        self._first_ms: float | None = None

    def __enter__(self) -> Bus:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        self._bus.shutdown()

    def fileno(self) -> int:
        """For poll(2); only of SocketCAN."""
        if self._batch is None:
            raise HilError(f"{self.channel}: only a SocketCAN channel can be waited for together with others")
        return self._batch.fileno()

    @property
    def error_frames(self) -> int:
        return self._batch.error_frames if self._batch else 0

    @property
    def lost_here(self) -> int:
        """Frames that came faster than they were read, on a lossy channel."""
        return self._batch.lost if self._batch else 0

    def listen_to(self, ids: Iterable[int] | None) -> None:
        """Only these identifiers from now on, by the kernel's filter; None: all."""
        self._bus.set_filters(_filters(ids))

    def receive(self, timeout_s: float = 0.0) -> list[Frame]:
        """Frames as they came, without a time; [] when none came in time."""
        if self._batch is not None:
            return self._batch.receive(timeout_s)
        return [to_frame(m, 0.0) for m in self._messages(timeout_s)]

    def read(self, timeout_s: float = 0.0) -> list[Frame]:
        """Frames with the bus's time since the first frame read; `signals` knows them afterwards."""
        if self._batch is not None:
            frames = self._batch.receive(timeout_s, stamped=True)
        else:
            frames = [to_frame(m, m.timestamp * 1e3) for m in self._messages(timeout_s)]
        if frames and self._first_ms is None:
            self._first_ms = frames[0].time_ms
        frames = [f._replace(time_ms=round(f.time_ms - (self._first_ms or 0.0), 3)) for f in frames]
        for frame in frames:
            self.signals.update(frame)
        return frames

    def send(self, frames: Sequence[Frame]) -> None:
        if self._batch is not None:
            self._batch.send(frames)
            return
        for frame in frames:
            self._bus.send(can.Message(arbitration_id=frame.id & ~EXTENDED, is_extended_id=bool(frame.id & EXTENDED),
                                       data=frame.data))

    def send_signals(self, message: str, **values: float | str | None) -> Frame:
        """Sends a message by the names of its signals, over what was last seen of it, with the next counter and CRC."""
        frame = self.signals.write(message, values)
        self.send([frame])
        return frame

    def _messages(self, timeout_s: float) -> list[can.Message]:
        found, end = [], time.monotonic() + timeout_s
        message = self._bus.recv(timeout_s)
        while message is not None:
            if not message.is_error_frame:
                found.append(message)
            message = self._bus.recv(0.0 if found else max(0.0, end - time.monotonic()))
        return found


def _filters(ids: Iterable[int] | None) -> list[CanFilter] | None:
    if ids is None:
        return None
    return [{"can_id": i & ~EXTENDED, "can_mask": 0x1FFF_FFFF if i & EXTENDED else 0x7FF,
             "extended": bool(i & EXTENDED)} for i in ids]


def _open(channel: str, interface: str, ids: Iterable[int] | None) -> can.BusABC:
    try:
        return can.Bus(channel=channel, interface=interface, can_filters=_filters(ids))
    except OSError as error:
        raise HilError(f"cannot open CAN interface {channel!r}: {error.strerror or error}. "
                       + _CREATE.format(channel)) from None
    except (can.CanError, ValueError) as error:
        raise HilError(f"cannot open {interface} channel {channel!r}: {error}") from None


def to_frame(message: can.Message, time_ms: float) -> Frame:
    can_id = message.arbitration_id | (EXTENDED if message.is_extended_id else 0)
    return Frame(can_id, bytes(message.data), time_ms)
