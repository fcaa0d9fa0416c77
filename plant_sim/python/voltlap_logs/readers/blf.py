# SPDX-License-Identifier: Apache-2.0
"""Vector BLF: objects in zlib containers (layout: Toby Lorenz' vector_blf and python-can's reader, which drops what it
does not know). Stamps are whole nanoseconds or tens of microseconds after the start, which is taken as UTC.

Channel N of the file becomes bus `canN`; Vector counts from 1.
"""
from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Iterator
from datetime import datetime, timezone
from typing import BinaryIO

from ..candump import BUS_ERROR, ERROR, EXTENDED, FD_LENGTHS, ID_MASK, Frame, error_line, line
from ..errors import BrokenOff, LogError
from ..source import Source
from ..tally import Tally

MAGIC = b"LOGG"
FILE_HEADER = struct.Struct("<4sLBBBBBBBBQQLL8H8H")
BASE = struct.Struct("<4sHHLL")  # "LOBJ", size of the header, its version, size of the object, type
HEADER = struct.Struct("<LHHQ")  # flags, client, version, stamp
CONTAINER = struct.Struct("<H6xL4x")
MESSAGE = struct.Struct("<HBBL8s")
FD_MESSAGE = struct.Struct("<HBBLLBBB5x64s")
FD_MESSAGE_64 = struct.Struct("<BBBBLLLLLLLHBBL")
ERROR_EXT = struct.Struct("<HHLBBBxLLH2x8s")
PYTHON_CAN = 5  # application that writes SocketCAN's class of error as identifier; Vector: that of the disturbed frame
TEN_MICROSECONDS = 1
REMOTE, DIRECTION, TRANSMIT_REQUEST = 0x80, 0x0F, 2

OTHERS = {4: "bus statistics", 5: "triggers", 6: "environment variables", 7: "environment variables",
          8: "environment variables", 9: "environment variables", 3: "overload frames", 31: "driver errors",
          65: "text", 72: "system variables", 92: "text", 96: "markers", 115: "padding", 10: "containers"}
LIN, FLEXRAY, ETHERNET = range(11, 30), (29, 40, 41, 50, 66), (71, 102, 103, 113, 114, 120)

Decoder = Callable[[bytes, int, int, int, int], "str | None"]  # (data, position, header size, object size, time)


def other(kind: int) -> str:
    if kind in OTHERS:
        return OTHERS[kind]
    for numbers, name in ((FLEXRAY, "FlexRay objects"), (ETHERNET, "Ethernet objects"), (LIN, "LIN objects")):
        if kind in numbers:
            return name
    return f"objects of type {kind}"


def tagged(id: int) -> int:
    return id & (EXTENDED | ID_MASK)


def classic(data: bytes, at: int, head: int, size: int, time_ns: int) -> str | None:
    channel, flags, length, id, payload = MESSAGE.unpack_from(data, at)
    if flags & DIRECTION == TRANSMIT_REQUEST:
        return None
    remote = length if flags & REMOTE else None
    return line(Frame(time_ns, f"can{channel}", tagged(id), payload[:min(length, 8)], None, remote))


def flexible(data: bytes, at: int, head: int, size: int, time_ns: int) -> str | None:
    channel, flags, code, id, _, _, fd, valid, payload = FD_MESSAGE.unpack_from(data, at)
    if flags & DIRECTION == TRANSMIT_REQUEST:
        return None
    if not fd & 1:
        remote = code if flags & REMOTE else None
        return line(Frame(time_ns, f"can{channel}", tagged(id), payload[:min(valid, 8)], None, remote))
    return line(Frame(time_ns, f"can{channel}", tagged(id), payload[:FD_LENGTHS[code & 15]], fd >> 1 & 3))


def flexible_64(data: bytes, at: int, head: int, size: int, time_ns: int) -> str | None:
    (channel, code, valid, _, id, _, flags, _, _, _, _, _, direction, offset, _) = FD_MESSAGE_64.unpack_from(data, at)
    if direction == TRANSMIT_REQUEST:
        return None
    begin = at + FD_MESSAGE_64.size
    stored = min(valid, max((offset or size) - head - FD_MESSAGE_64.size, 0))  # binlog.dll leaves zeros out
    payload = data[begin:begin + stored].ljust(valid, b"\0")
    if not flags & 0x1000:
        remote = code if flags & 0x10 else None
        return line(Frame(time_ns, f"can{channel}", tagged(id), payload[:8], None, remote))
    length = FD_LENGTHS[code & 15]
    return line(Frame(time_ns, f"can{channel}", tagged(id), payload[:length].ljust(length, b"\0"), flags >> 13 & 3))


def error(data: bytes, at: int, head: int, size: int, time_ns: int) -> str | None:
    return error_line(time_ns, f"can{struct.unpack_from('<H', data, at)[0]}", None)


def error_64(data: bytes, at: int, head: int, size: int, time_ns: int) -> str | None:
    return error_line(time_ns, f"can{data[at]}", None)


def error_of_python_can(data: bytes, at: int, head: int, size: int, time_ns: int) -> str | None:
    channel, _, _, _, _, length, _, id, _, payload = ERROR_EXT.unpack_from(data, at)
    return line(Frame(time_ns, f"can{channel}", ERROR | (id & ID_MASK or BUS_ERROR), payload[:min(length, 8)]))


class Objects:
    """The stream of objects that the containers hold, one after another and across their borders."""

    def __init__(self, application: int, start_ns: int, tally: Tally) -> None:
        self._start_ns, self._tally, self._rest = start_ns, tally, b""
        self._decoders: dict[int, Decoder] = {
            1: classic, 86: classic, 100: flexible, 101: flexible_64, 2: error, 104: error_64,
            73: error_of_python_can if application == PYTHON_CAN else error}

    def feed(self, data: bytes, where: str) -> Iterator[str]:
        data = self._rest + data
        at = 0
        while True:
            found = data.find(b"LOBJ", at, at + 8)  # padding depends on the kind of object
            if found < 0:
                if at + 8 <= len(data):
                    raise BrokenOff(f"{where} has no object where one should begin")
                break
            if found + BASE.size > len(data):
                at = found
                break
            _, head, version, size, kind = BASE.unpack_from(data, found)
            if found + size > len(data):
                at = found
                break
            if size < max(head, BASE.size):
                raise BrokenOff(f"{where} has an object of {size} bytes with a header of {head}")
            at = found + size
            text = self._decode(data, found, (head, version, size, kind))
            if text:
                yield text
        self._rest = data[at:]

    def _decode(self, data: bytes, found: int, header: tuple[int, int, int, int]) -> str | None:
        head, version, size, kind = header
        decode = self._decoders.get(kind)
        if not decode or version not in (1, 2):
            self._tally.skip(other(kind))
            return None
        flags, _, _, ticks = HEADER.unpack_from(data, found + BASE.size)
        time_ns = self._start_ns + ticks * (10_000 if flags == TEN_MICROSECONDS else 1)
        try:
            text = decode(data, found + head, head, size, time_ns)
        except struct.error:
            self._tally.skip("damaged objects")
            return None
        if text is None:
            self._tally.skip("requests to transmit")
        return text

    @property
    def unfinished(self) -> bool:
        return len(self._rest.strip(b"\0")) > 0


def start_of(header: tuple[int, ...]) -> int:
    year, month, _, day, hour, minute, second, millisecond = header
    try:
        start = datetime(year, month, day, hour, minute, second, tzinfo=timezone.utc)
        return (int(start.timestamp()) * 1000 + millisecond) * 1_000_000
    except ValueError:
        return 0  # the recorder had no clock


def unpacked(body: bytes, at: int) -> bytes:
    method, _ = CONTAINER.unpack_from(body)
    if method == 0:
        return body[CONTAINER.size:]
    if method != 2:
        raise BrokenOff(f"the container at byte {at} is packed by method {method}; expected 0 (not) or 2 (zlib)")
    return zlib.decompressobj().decompress(body[CONTAINER.size:])


def top_level(file: BinaryIO, at: int) -> Iterator[tuple[int, int, bytes, bytes]]:
    """(where, type, the object without its base header, the base header)"""
    while base := file.read(BASE.size):
        if not base.strip(b"\0"):
            break  # padding at the end
        lead = base.find(b"LOBJ")
        if 0 < lead <= 4:  # padding before the object
            base = base[lead:] + file.read(lead)
            at += lead
        if len(base) < BASE.size or lead < 0 or lead > 4:
            raise BrokenOff(f"no object begins at byte {at}")
        _, _, _, size, kind = BASE.unpack(base)
        body = file.read(size - BASE.size) if size >= BASE.size else b""
        if len(body) < size - BASE.size or size < BASE.size:
            raise BrokenOff(f"the object of {size} bytes at byte {at} is cut after {BASE.size + len(body)}")
        yield at, kind, body, base
        at += size + len(file.read(size % 4) if kind == 10 else b"")


def read(source: Source, tally: Tally) -> Iterator[str]:
    file = source.stream()
    raw = file.read(FILE_HEADER.size)
    if len(raw) < FILE_HEADER.size:
        raise LogError(f"{source.path}: a BLF file of {len(raw)} bytes; its header alone has 144: record it again")
    header = FILE_HEADER.unpack(raw)
    if header[0] != MAGIC:
        raise LogError(f"{source.path}: begins with {raw[:4]!r}; expected a BLF file (LOGG): leave --format out")
    file.read(max(header[1] - FILE_HEADER.size, 0))
    end = header[1]
    objects = Objects(header[2], start_of(header[14:22]), tally)
    for at, kind, body, base in top_level(file, header[1]):
        try:
            data = unpacked(body, at) if kind == 10 else base + body
        except (zlib.error, struct.error) as error:
            raise BrokenOff(f"the container at byte {at} is damaged ({error})") from error
        yield from objects.feed(data, f"the container at byte {at}")
        end = at + len(base) + len(body)
    if header[10] > end + 4:  # 0 or the header's size where the recorder did not close the file
        raise BrokenOff(f"it says that it has {header[10]} bytes and has {end}")
    if objects.unfinished:
        raise BrokenOff("the last object continues in a container that is not there")
