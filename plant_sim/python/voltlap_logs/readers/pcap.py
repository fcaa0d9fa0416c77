# SPDX-License-Identifier: Apache-2.0
"""PCAP and PCAPNG of a SocketCAN interface (link type 227), as Wireshark and tcpdump write them. The bus is the name of
the interface where the file has it (PCAPNG), else `can<number of the interface>`, from 0."""
from __future__ import annotations

import struct
from collections.abc import Iterator
from typing import BinaryIO, NamedTuple

from ..candump import ERROR, EXTENDED, FD_LENGTHS, LAST_STANDARD, NS, Frame, line
from ..errors import BrokenOff, LogError
from ..source import Source
from ..tally import Tally

SOCKETCAN = 227
PCAP = {b"\xa1\xb2\xc3\xd4": (">", 1000), b"\xd4\xc3\xb2\xa1": ("<", 1000),
        b"\xa1\xb2\x3c\x4d": (">", 1), b"\x4d\x3c\xb2\xa1": ("<", 1)}  # magic: byte order, nanoseconds a tick
PCAPNG = b"\x0a\x0d\x0d\x0a"
REMOTE, FD = 0x40000000, 0x04
XL = 0x80  # in the length's place: CAN XL


class Interface(NamedTuple):
    link: int
    bus: str
    ticks_s: int  # ticks a second
    offset_s: int


def frame(packet: bytes, time_ns: int, bus: str) -> Frame | None:
    """struct can_frame or canfd_frame, the identifier in network order."""
    if len(packet) < 8 or packet[4] & XL:
        return None
    id, length, flags = struct.unpack_from(">IBB", packet)
    flexible = bool(flags & FD) or len(packet) == 72 or length > 8
    if not id & EXTENDED and not id & ERROR:
        id &= LAST_STANDARD | REMOTE
    if id & REMOTE and not id & ERROR:
        return Frame(time_ns, bus, id & ~REMOTE, b"", None, length)
    data = packet[8:8 + length]
    if len(data) != length or length not in FD_LENGTHS:
        return None
    return Frame(time_ns, bus, id & ~(EXTENDED | REMOTE) if id & ERROR else id, data, flags & 3 if flexible else None)


def told(link: int, path: object) -> LogError:
    return LogError(f"{path}: a capture of link type {link}; expected {SOCKETCAN} (SocketCAN): capture the interface "
                    "itself, e.g. `tcpdump -i can0 -w FILE`")


def exactly(file: BinaryIO, size: int, what: str) -> bytes:
    data = file.read(size)
    if len(data) < size:
        raise BrokenOff(f"{what} is cut: {len(data)} of {size} bytes")
    return data


def read_pcap(source: Source, tally: Tally) -> Iterator[str]:
    file = source.stream()
    magic = file.read(4)
    if magic not in PCAP:
        raise LogError(f"{source.path}: begins with {magic!r}; expected a PCAP file: leave --format out")
    order, tick_ns = PCAP[magic]
    link = struct.unpack(order + "16xI", exactly(file, 20, "the header"))[0] & 0xFFFF
    if link != SOCKETCAN:
        raise told(link, source.path)
    number = 0
    while head := file.read(16):
        number += 1
        if len(head) < 16:
            raise BrokenOff(f"the header of packet {number} is cut")
        seconds, ticks, size, _ = struct.unpack(order + "IIII", head)
        found = frame(exactly(file, size, f"packet {number}"), seconds * NS + ticks * tick_ns, "can0")
        if found:
            yield line(found, 9 if tick_ns == 1 else 6)
        else:
            tally.skip("packets that are no CAN frame", f"packet {number}")


class Section:
    """Interfaces and packets of a PCAPNG file."""

    def __init__(self) -> None:
        self.order = "<"
        self.interfaces: list[Interface] = []

    def options(self, data: bytes) -> Iterator[tuple[int, bytes]]:
        at = 0
        while at + 4 <= len(data):
            code, size = struct.unpack_from(self.order + "HH", data, at)
            if code == 0:
                return
            yield code, data[at + 4:at + 4 + size]
            at += 4 + (size + 3) // 4 * 4

    def describe(self, body: bytes) -> None:
        bus, ticks_s, offset_s = f"can{len(self.interfaces)}", 1_000_000, 0
        for code, value in self.options(body[8:]):
            if code == 2 and value.strip(b"\0 "):
                bus = "_".join(value.rstrip(b"\0").decode("utf-8", "replace").split())
            elif code == 9:
                ticks_s = 2**(value[0] & 0x7F) if value[0] & 0x80 else 10**value[0]
            elif code == 14:
                offset_s = struct.unpack(self.order + "q", value)[0]
        self.interfaces.append(Interface(struct.unpack_from(self.order + "H", body)[0], bus, ticks_s, offset_s))

    def packet(self, body: bytes) -> tuple[Interface, int, bytes]:
        number, high, low, size = struct.unpack_from(self.order + "IIII", body)
        interface = self.interfaces[number]
        time_ns = ((high << 32) + low) * NS // interface.ticks_s + interface.offset_s * NS
        return interface, time_ns, body[20:20 + size]


def blocks(file: BinaryIO, section: Section) -> Iterator[tuple[int, int, bytes]]:
    """(where, type, body)"""
    at = 0
    while head := file.read(8):
        where = f"the block at byte {at}"
        if len(head) < 8:
            raise BrokenOff(f"{where} is cut")
        extra = b""
        if head[:4] == PCAPNG:
            extra = exactly(file, 4, where)
            section.order = "<" if extra == b"\x4d\x3c\x2b\x1a" else ">"
            section.interfaces = []
        kind, size = struct.unpack(section.order + "II", head)
        if size < 12 or size % 4:
            raise BrokenOff(f"{where} says that it has {size} bytes")
        yield at, kind, extra + exactly(file, size - 8 - len(extra), where)[:-4]
        at += size


def read_pcapng(source: Source, tally: Tally) -> Iterator[str]:
    if not source.head(4) == PCAPNG:
        raise LogError(f"{source.path}: begins with {source.head(4)!r}; expected a PCAPNG file: leave --format out")
    section = Section()
    for at, kind, body in blocks(source.stream(), section):
        try:
            if kind == 1:
                section.describe(body)
            packed = section.packet(body) if kind == 6 else None
        except (IndexError, struct.error) as error:
            raise BrokenOff(f"the block at byte {at} is damaged ({error})") from error
        if packed:
            interface, time_ns, packet = packed
            found = frame(packet, time_ns, interface.bus) if interface.link == SOCKETCAN else None
            if found:
                yield line(found, 9 if interface.ticks_s > 1_000_000 else 6)
            else:
                tally.skip("packets that are no CAN frame", f"the block at byte {at}")
        elif kind in (2, 3):
            tally.skip("packets without a stamp or of an old kind", f"the block at byte {at}")
    if section.interfaces and all(interface.link != SOCKETCAN for interface in section.interfaces):
        raise told(section.interfaces[0].link, source.path)
