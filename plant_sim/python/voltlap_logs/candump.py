# SPDX-License-Identifier: Apache-2.0
"""Frames as lines of `candump -L`, the form in which the native programs take and give them.

    (1436509052.249713) can0 044#2A366C2BBA          11-bit identifier, 3 digits
    (1436509052.449847) can1 1FFFFFF0#01190007       29-bit identifier, 8 digits
    (1436509052.650004) can0 123##311223344          CAN FD; the digit is 1 bit rate switch + 2 error state
    (1436509052.850131) can0 7E0#R8                  remote frame with its length (none: 0)
    (1436509053.049987) can0 20000080#0000000000000000   error frame: class of error, then its eight bytes
"""
from __future__ import annotations

from typing import NamedTuple

NS = 1_000_000_000
EXTENDED, ERROR = 0x80000000, 0x20000000  # flags of an identifier, as SocketCAN has them; an error frame has its class
ID_MASK = 0x1FFFFFFF
LAST_STANDARD = 0x7FF
BRS, ESI = 1, 2  # flags of an FD frame
FD_LENGTHS = (0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64)  # by data length code
BUS_ERROR = 0x80  # SocketCAN's CAN_ERR_BUSERROR: what a recorder that gives no class has seen
PROTOCOL_ERROR = 0x08  # CAN_ERR_PROT: data[2] has the kind
LINE_ERRORS = {1: 0x01, 2: 0x02, 4: 0x04}  # bit, form and stuff error


class Frame(NamedTuple):
    time_ns: int
    bus: str
    id: int  # with EXTENDED or ERROR
    data: bytes
    fd_flags: int | None = None  # None: a classic frame
    remote_length: int | None = None  # None: no remote frame


def fd_code(length: int) -> int:
    """The smallest data length code that carries this many bytes."""
    return next(code for code, size in enumerate(FD_LENGTHS) if size >= length)


def microseconds(time_ns: int) -> int:
    """To the nearest one, by whole numbers: a double has no nanoseconds left since 1970."""
    return (time_ns + 500) // 1000


def stamp(time_ns: int, decimals: int = 9) -> str:
    sign, time_ns = ("-", -time_ns) if time_ns < 0 else ("", time_ns)
    seconds, ns = divmod(time_ns, NS)
    return f"{sign}{seconds}.{ns:09d}" if decimals == 9 else f"{sign}{seconds}.{ns // 1000:06d}"


def identifier(id: int) -> str:
    return f"{id & ~EXTENDED:08X}" if id & (EXTENDED | ERROR) else f"{id:03X}"


def line(frame: Frame, decimals: int = 9) -> str:
    time_ns, bus, id, data, fd_flags, remote_length = frame
    if remote_length is not None:
        payload = f"#R{min(remote_length, 8)}" if remote_length else "#R"
    elif fd_flags is not None:
        payload = f"##{fd_flags:X}{data.hex().upper()}"
    else:
        payload = f"#{data.hex().upper()}"
    return f"({stamp(time_ns, decimals)}) {bus} {identifier(id)}{payload}\n"


def error_line(time_ns: int, bus: str, kind: int | None, decimals: int = 9) -> str:
    """An error frame of a recorder that says at most which error it was: 1 bit, 2 form, 4 stuff, else other."""
    protocol = LINE_ERRORS.get(kind or 0, 0)
    data = bytes((0, 0, protocol, 0, 0, 0, 0, 0))
    return line(Frame(time_ns, bus, ERROR | BUS_ERROR | (PROTOCOL_ERROR if protocol else 0), data), decimals)


def parse_time_ns(text: str) -> int:
    """A decimal number of seconds, exactly."""
    seconds, _, fraction = text.partition(".")
    value = abs(int(seconds)) * NS + (int((fraction + "000000000")[:9]) if fraction else 0)
    return -value if seconds.startswith("-") else value


def parse(text: str) -> Frame | None:
    """The frame of a line; None when it is none."""
    words = text.split(None, 3)
    if len(words) < 3 or words[0][0] != "(" or words[0][-1] != ")":
        return None
    digits, hash, payload = words[2].partition("#")
    try:
        time_ns = parse_time_ns(words[0][1:-1])
        id = int(digits, 16)
        if len(digits) > 3 and not id & ERROR:
            id |= EXTENDED
        if not hash or (id & ID_MASK if id & EXTENDED else id) > (ID_MASK | ERROR if id & ERROR else
                                                                 ID_MASK if id & EXTENDED else LAST_STANDARD):
            return None
        if payload.startswith("#"):
            data = bytes.fromhex(payload[2:])
            return Frame(time_ns, words[1], id, data, int(payload[1], 16) & 3) if len(data) in FD_LENGTHS else None
        if payload.startswith("R"):
            return Frame(time_ns, words[1], id, b"", None, int(payload[1:2] or "0", 16))
        data = bytes.fromhex(payload.partition("_")[0])
        return Frame(time_ns, words[1], id, data) if len(data) <= 8 else None
    except (ValueError, IndexError):
        return None
