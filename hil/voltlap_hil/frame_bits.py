# SPDX-License-Identifier: Apache-2.0
"""Bits of a classic CAN data frame on the wire, with the stuff bits that it really has; by tables, a byte at a time.

ISO 11898-1: SOF, arbitration and control field, data and CRC-15 (0x4599) are stuffed after five equal bits; 13 bits
follow that are not: delimiters, acknowledgement, end of frame, and the pause of 3 bits.
"""
from __future__ import annotations

from functools import cache

from .frame import EXTENDED

BIT_RATE = 500_000
_UNSTUFFED = 13
_State = tuple[int, int]  # last bit, length of its run


def _step(state: _State, value: int, width: int) -> tuple[_State, int]:
    last, run = state
    stuffed = 0
    for i in range(width - 1, -1, -1):
        bit = value >> i & 1
        last, run = (bit, run + 1) if bit == last else (bit, 1)
        if run == 5:
            last, run, stuffed = 1 - bit, 1, stuffed + 1
    return (last, run), stuffed


def _crc(crc: int, value: int, width: int) -> int:
    for i in range(width - 1, -1, -1):
        crc <<= 1
        if (crc >> 15) ^ (value >> i & 1):
            crc ^= 0x4599
        crc &= 0x7FFF
    return crc


_STATES = [(last, run) for last in (0, 1) for run in range(1, 5)]
_STUFFING = {width: {state: [_step(state, value, width) for value in range(1 << width)] for state in _STATES}
             for width in (7, 8)}
# The CRC register after one byte: the table of its upper 8 bits.
_CRC = [_crc(value << 7, 0, 8) for value in range(256)]


@cache
def _head(can_id: int, length: int) -> tuple[int, _State, int, int]:
    """Bits, state of the stuffing, stuff bits and CRC register of all before the data."""
    if can_id & EXTENDED:
        value, width = ((can_id >> 18 & 0x7FF) << 2 | 3) << 21 | (can_id & 0x3FFFF) << 3, 35
    else:
        value, width = (can_id & 0x7FF) << 3, 15
    value, width = value << 4 | length, width + 4  # SOF is the 0 above it
    state, stuffed = _step((1, 1), value, width)
    return width, state, stuffed, _crc(0, value, width)


def frame_bits(can_id: int, data: bytes) -> int:
    bits, state, stuffed, crc = _head(can_id, len(data))
    table = _STUFFING[8]
    for byte in data:
        state, more = table[state][byte]
        stuffed += more
        crc = crc << 8 & 0x7FFF ^ _CRC[crc >> 7 ^ byte]
    state, more = table[state][crc >> 7]
    return bits + 8 * len(data) + 15 + stuffed + more + _STUFFING[7][state][crc & 0x7F][1] + _UNSTUFFED
