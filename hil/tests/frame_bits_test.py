# SPDX-License-Identifier: Apache-2.0
import random

import pytest

from voltlap_hil.frame import EXTENDED
from voltlap_hil.frame_bits import frame_bits


def bits_one_by_one(can_id, data):
    def binary(value, width):
        return [value >> i & 1 for i in range(width - 1, -1, -1)]

    if can_id & EXTENDED:
        bits = [0, *binary(can_id >> 18 & 0x7FF, 11), 1, 1, *binary(can_id & 0x3FFFF, 18), 0, 0, 0]
    else:
        bits = [0, *binary(can_id, 11), 0, 0, 0]
    bits += binary(len(data), 4)
    for byte in data:
        bits += binary(byte, 8)
    crc = 0
    for bit in bits:
        crc = crc << 1 & 0x7FFF ^ (0x4599 if bit ^ crc >> 14 else 0)
    sent, run = [], 0
    for bit in [*bits, *binary(crc, 15)]:
        run = run + 1 if sent and sent[-1] == bit else 1
        sent.append(bit)
        if run == 5:
            sent.append(1 - bit)
            run = 1
    return len(sent) + 13


def test_frame_of_zeros_has_a_stuff_bit_after_each_five():
    assert frame_bits(0, b"") == 34 + 6 + 13


@pytest.mark.parametrize("extended", [0, EXTENDED])
def test_random_frames_have_the_bits_counted_one_by_one(extended):
    rng = random.Random(3)
    for _ in range(2000):
        data = bytes(rng.choice((0, 0xFF, 0x0F, rng.randrange(256))) for _ in range(rng.randrange(9)))
        can_id = rng.randrange(1 << 29) | EXTENDED if extended else rng.randrange(1 << 11)
        assert frame_bits(can_id, data) == bits_one_by_one(can_id, data)
