#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Puts the value behind a linked image by which it checks itself at the start (firmware/port/image_check.hpp).

usage: image_crc.py [--check] IMAGE.elf ...

The last eight bytes that the image puts into flash are the mark "VLCR" and the CRC-32 (IEEE 802.3) of all bytes before
the CRC. Placing it twice changes nothing. --check writes nothing. Exit code: 0, 1 no place for it, or with --check a
value that is not there or does not hold, 2 usage.
"""
import argparse
import struct
import sys
import zlib
from pathlib import Path

MARK, EMPTY = b"VLCR", bytes(4)
VALUE_BYTES = 8
LOAD = 1


class NoImage(Exception):
    """Why it cannot be, as a clause."""


def load_parts(data):
    """[(address in flash, place in the file, bytes)] of an ELF, by address."""
    offset, size, count = struct.unpack_from("<I", data, 28)[0], *struct.unpack_from("<HH", data, 42)
    parts = []
    for k in range(count):
        kind, at, _, address, length = struct.unpack_from("<5I", data, offset + k * size)
        if kind == LOAD and length:
            parts.append((address, at, data[at:at + length]))
    return sorted(parts)


def bytes_of(parts):
    """All that goes into flash, in one piece."""
    end = parts[0][0] if parts else 0
    for address, _, piece in parts:
        if address != end:
            raise NoImage(f"there is a gap before 0x{address:08x}, and nobody knows what a programmer leaves in it")
        end = address + len(piece)
    return b"".join(piece for _, _, piece in parts)


def fault_of(data):
    """None, or what is wrong with the value of the image, as a clause."""
    try:
        image = bytes_of(load_parts(data))
    except NoImage as fault:
        return str(fault)
    mark, value = image[-VALUE_BYTES:-4], image[-4:]
    if mark != MARK:
        return "there is no value behind it by which it checks itself at the start"
    if struct.unpack("<I", value)[0] != zlib.crc32(image[:-4]):
        return "its bytes are not those that it was linked with: the CRC behind them is of others"
    return None


def placed(data):
    parts = load_parts(data)
    image = bytes_of(parts)
    if image[-VALUE_BYTES:-4] not in (MARK, EMPTY):
        raise NoImage("no place for the value is behind it: sections.ld makes one")
    sealed = image[:-VALUE_BYTES] + MARK
    _, at, piece = parts[-1]
    end = at + len(piece)
    return data[:end - VALUE_BYTES] + MARK + struct.pack("<I", zlib.crc32(sealed)) + data[end:]


def main():
    parser = argparse.ArgumentParser(prog="image_crc.py", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="write nothing, say whether the value holds")
    parser.add_argument("images", nargs="+", type=Path, metavar="IMAGE.elf")
    given = parser.parse_args()
    bad = 0
    for path in given.images:
        data = path.read_bytes()
        try:
            fault = fault_of(data) if given.check else None
            if not given.check:
                path.write_bytes(placed(data))
        except NoImage as why:
            fault = str(why)
        if fault:
            bad += 1
            print(f"{path}: {fault}", file=sys.stderr)
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
