# SPDX-License-Identifier: Apache-2.0
"""Many CAN frames with one system call: recvmmsg(2) and sendmmsg(2) on a raw CAN socket.

A frame is struct can_frame of linux/can.h, 16 bytes: identifier u32, length u8, 3 bytes of padding, 8 bytes of data.
"""
from __future__ import annotations

import ctypes
import errno
import os
import select
import socket
import struct
import time
from collections.abc import Sequence

from .errors import HilError
from .frame import ERROR, Frame

_FRAME = struct.Struct("=IB3x8s")
_STAMP = struct.Struct("@16xqq")  # struct cmsghdr, struct timespec
_LOST = struct.Struct("@16xI")  # struct cmsghdr, u32
_CAPACITY = 256
_CONTROL_SIZE = 64
_RECEIVE_BUFFER = 16 << 20
_SO_RCVBUFFORCE, _SO_TIMESTAMPNS, _SO_RXQ_OVFL = 33, 35, 40
_SEND_PATIENCE_S = 2.0


class _IoVec(ctypes.Structure):
    _fields_ = [("base", ctypes.c_void_p), ("length", ctypes.c_size_t)]


class _MsgHdr(ctypes.Structure):
    _fields_ = [("name", ctypes.c_void_p), ("name_length", ctypes.c_uint32), ("vectors", ctypes.POINTER(_IoVec)),
                ("vector_count", ctypes.c_size_t), ("control", ctypes.c_void_p), ("control_length", ctypes.c_size_t),
                ("flags", ctypes.c_int)]


class _MMsgHdr(ctypes.Structure):
    _fields_ = [("header", _MsgHdr), ("length", ctypes.c_uint)]


_libc = ctypes.CDLL(None, use_errno=True)


class _Block:
    """Memory of one batch, and the message headers that point into it."""

    def __init__(self, control: bool) -> None:
        self._data = ctypes.create_string_buffer(_FRAME.size * _CAPACITY)
        self._control = ctypes.create_string_buffer(_CONTROL_SIZE * _CAPACITY if control else 1)
        self.data, self.control = memoryview(self._data), memoryview(self._control)
        self._vectors = (_IoVec * _CAPACITY)()
        self.messages = (_MMsgHdr * _CAPACITY)()
        for i in range(_CAPACITY):
            self._vectors[i] = _IoVec(ctypes.addressof(self._data) + _FRAME.size * i, _FRAME.size)
            header = self.messages[i].header
            header.vectors, header.vector_count = ctypes.pointer(self._vectors[i]), 1
            if control:
                header.control = ctypes.addressof(self._control) + _CONTROL_SIZE * i
                header.control_length = _CONTROL_SIZE


class BatchSocket:
    """Reads and writes batches on a bound CAN_RAW socket; owns its buffers, not the socket."""

    def __init__(self, raw: socket.socket, channel: str, lossy: bool = False) -> None:
        self._socket, self._channel = raw, channel
        self._readable, self._writable = select.poll(), select.poll()
        self._readable.register(raw, select.POLLIN)
        self._writable.register(raw, select.POLLOUT)
        self._in, self._out = _Block(control=True), _Block(control=False)
        self.error_frames = 0
        self.lost = 0
        self._lossy = lossy
        try:
            raw.setsockopt(socket.SOL_SOCKET, _SO_RCVBUFFORCE, _RECEIVE_BUFFER)
        except PermissionError:
            raw.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _RECEIVE_BUFFER)
        raw.setsockopt(socket.SOL_SOCKET, _SO_TIMESTAMPNS, 1)
        raw.setsockopt(socket.SOL_SOCKET, _SO_RXQ_OVFL, 1)
        raw.setblocking(False)

    def fileno(self) -> int:
        return self._socket.fileno()

    def receive(self, timeout_s: float, stamped: bool = False) -> list[Frame]:
        """The frames that wait, up to 256; waits for the first. `stamped`: with the kernel's time of reception."""
        if not self._readable.poll(timeout_s * 1000.0):
            return []
        count = _libc.recvmmsg(self.fileno(), self._in.messages, _CAPACITY, socket.MSG_DONTWAIT, None)
        if count < 0:
            return self._nothing(ctypes.get_errno())
        self._check_nothing_lost(count)
        rows = _FRAME.iter_unpack(self._in.data[:_FRAME.size * count])
        frames = [Frame(can_id, data if length == 8 else data[:length]) for can_id, length, data in rows]
        if stamped:
            frames = [frame._replace(time_ms=self._stamp_ms(i)) for i, frame in enumerate(frames)]
        for i in range(count):
            self._in.messages[i].header.control_length = _CONTROL_SIZE
        return self._without_errors(frames)

    def send(self, frames: Sequence[Frame]) -> None:
        for start in range(0, len(frames), _CAPACITY):
            self._send_block(frames[start:start + _CAPACITY])

    def _send_block(self, frames: Sequence[Frame]) -> None:
        for i, frame in enumerate(frames):
            _FRAME.pack_into(self._out.data, _FRAME.size * i, frame.id, len(frame.data), frame.data)
        sent, give_up = 0, time.monotonic() + _SEND_PATIENCE_S
        while sent < len(frames):
            at = ctypes.byref(self._out.messages, sent * ctypes.sizeof(_MMsgHdr))
            count = _libc.sendmmsg(self.fileno(), at, len(frames) - sent, 0)
            if count > 0:
                sent += count
                continue
            code = ctypes.get_errno()
            if code not in (errno.ENOBUFS, errno.EAGAIN, errno.EINTR) or time.monotonic() > give_up:
                raise HilError(f"{self._channel}: cannot send: {os.strerror(code)}")
            self._writable.poll(1.0)

    def _nothing(self, code: int) -> list[Frame]:
        if code in (errno.EAGAIN, errno.EINTR):
            return []
        raise HilError(f"{self._channel}: cannot read: {os.strerror(code)}")

    def _check_nothing_lost(self, count: int) -> None:
        # The kernel adds the count of lost frames behind the time stamp, once it has lost one.
        if self._in.messages[count - 1].header.control_length <= _STAMP.size:
            return
        self.lost = _LOST.unpack_from(self._in.control, _CONTROL_SIZE * (count - 1) + _STAMP.size)[0]
        if not self._lossy:
            raise HilError(f"{self._channel}: the receive buffer overflowed and frames are lost; what was measured is "
                           "worthless. Allow a larger buffer (sysctl net.core.rmem_max) or load the machine less.")

    def _stamp_ms(self, i: int) -> float:
        seconds, nanoseconds = _STAMP.unpack_from(self._in.control, _CONTROL_SIZE * i)
        return float(seconds * 1e3 + nanoseconds * 1e-6)

    def _without_errors(self, frames: list[Frame]) -> list[Frame]:
        good = [f for f in frames if not f.id & ERROR]
        self.error_frames += len(frames) - len(good)
        return good
