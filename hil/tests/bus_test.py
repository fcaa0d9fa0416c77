# SPDX-License-Identifier: Apache-2.0
import pytest

from voltlap_hil.bus import Bus
from voltlap_hil.errors import HilError
from voltlap_hil.frame import EXTENDED, Frame


@pytest.fixture
def pair(dbc, request):
    with Bus(request.node.name, "virtual", dbc) as a, Bus(request.node.name, "virtual", dbc) as b:
        yield a, b


def test_frames_arrive_in_order_and_in_one_batch(pair):
    sender, receiver = pair
    sent = [Frame(0x100 + i, bytes([i % 256])) for i in range(300)]
    sender.send(sent)
    assert receiver.receive(1.0) == sent
    assert receiver.receive() == []


def test_signals_follow_what_is_read(pair):
    sender, receiver = pair
    sender.send_signals("BmsLimits", DischargeLimit=200.0)
    receiver.read(1.0)
    assert receiver.signals["BmsLimits.DischargeLimit"].value == 200.0


def test_time_starts_with_the_first_frame_read(pair):
    sender, receiver = pair
    sender.send([Frame(1, b""), Frame(2, b"")])
    frames = receiver.read(1.0)
    assert frames[0].time_ms == 0.0 and frames[1].time_ms >= 0.0


def test_an_extended_identifier_keeps_its_flag(pair):
    sender, receiver = pair
    sender.send([Frame(0x18FF00 | EXTENDED, b"x")])
    assert receiver.receive(1.0)[0].id == 0x18FF00 | EXTENDED


def test_only_what_is_listened_to_arrives(pair):
    sender, receiver = pair
    receiver.listen_to([0x101])
    sender.send([Frame(0x100, b""), Frame(0x101, b"")])
    assert [f.id for f in receiver.receive(1.0)] == [0x101]


def test_a_channel_that_does_not_exist_is_told_with_what_to_do(dbc):
    with pytest.raises(HilError, match="vcan77.*ip link add dev vcan77 type vcan"):
        Bus("vcan77", dbc=dbc)


def test_an_interface_that_python_can_does_not_know_is_told(dbc):
    with pytest.raises(HilError, match="cannot open nonsense channel"):
        Bus("x", "nonsense", dbc)
