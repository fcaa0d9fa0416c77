# SPDX-License-Identifier: Apache-2.0
"""Batches on a real SocketCAN interface."""
import socket
import time

import can
import pytest

from voltlap_hil.bus import Bus
from voltlap_hil.errors import HilError
from voltlap_hil.frame import EXTENDED, Frame

HANG_S = 300.0  # only a hang takes as long, however busy the machine


@pytest.fixture
def pair(dbc):
    with Bus("vcan0", dbc=dbc) as a, Bus("vcan0", dbc=dbc) as b:
        yield a, b


def drained(bus):
    """Without a gateway between, a frame that was sent has arrived."""
    frames = []
    while batch := bus.receive():
        frames += batch
    return frames


def test_thousands_of_frames_arrive_whole_and_in_order(pair):
    sender, receiver = pair
    sent = [Frame(i % 0x7E0 | (EXTENDED if i % 5 == 0 else 0), i.to_bytes(4, "little")[:i % 5]) for i in range(4000)]
    sender.send(sent)
    assert drained(receiver) == sent


def test_one_batch_holds_what_waits(pair):
    sender, receiver = pair
    sender.send([Frame(i, b"") for i in range(200)])
    assert len(receiver.receive(HANG_S)) == 200


def test_python_can_reads_what_a_batch_sent_and_the_other_way_round(pair, dbc):
    sender, _ = pair
    with can.Bus(channel="vcan0", interface="socketcan") as other:
        sender.send([Frame(0x18FF00 | EXTENDED, b"\x01\x02")])
        message = other.recv(HANG_S)
        assert (message.arbitration_id, message.is_extended_id, bytes(message.data)) == (0x18FF00, True, b"\x01\x02")
        other.send(can.Message(arbitration_id=0x12, is_extended_id=False, data=b"\x03"))
        assert sender.receive(HANG_S) == [Frame(0x12, b"\x03")]


def test_the_kernel_filters_what_is_not_listened_to(pair):
    sender, receiver = pair
    receiver.listen_to([0x101, 0x7E0])
    sender.send([Frame(i, b"") for i in (0x100, 0x101, 0x101 | EXTENDED, 0x7E0)])
    assert [f.id for f in drained(receiver)] == [0x101, 0x7E0]


def test_reading_gives_the_time_of_the_kernel_since_the_first_frame(pair):
    sender, receiver = pair
    begin = time.monotonic()
    sender.send([Frame(1, b"")])
    first = receiver.read(HANG_S)[0].time_ms
    assert receiver.receive(0.05) == []
    sender.send([Frame(2, b"")])
    second = receiver.read(HANG_S)[0].time_ms
    assert first == 0.0 and 45.0 < second < (time.monotonic() - begin) * 1e3 + 5.0


def test_frames_that_the_buffer_could_not_hold_are_told(pair):
    sender, receiver = pair
    receiver._bus.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    with pytest.raises(HilError, match="the receive buffer overflowed and frames are lost"):
        for _ in range(20):
            sender.send([Frame(1, bytes(8))] * 250)
            drained(receiver)
