# SPDX-License-Identifier: Apache-2.0
"""The gateway process between two real interfaces."""
import time

import pytest

from voltlap_hil.bus import Bus
from voltlap_hil.errors import HilError
from voltlap_hil.faults import Fault
from voltlap_hil.frame import Frame
from voltlap_hil.gateway import GatewayProcess

PEDALS = 0xB1
MARK = Frame(0x555, b"")
HANG_S = 300.0  # only a hang takes as long, however busy the machine


@pytest.fixture
def sides(dbc):
    with Bus("vcan0", dbc=dbc) as plant, Bus("vcan1", dbc=dbc) as ecus:
        yield plant, ecus


@pytest.fixture
def gateway(dbc, sides):
    with GatewayProcess("vcan0", "vcan1", dbc) as process:
        yield process


def passed_on(frames, sender, receiver):
    """What comes out on the other side: all of it, when a mark that was sent behind the frames is there."""
    sender.send([*frames, MARK])
    heard = []
    while MARK not in heard:
        batch = receiver.receive(HANG_S)
        assert batch, "the mark never came"
        heard += batch
    assert heard[-1] == MARK
    return heard[:-1]


def test_frames_pass_both_ways_once(gateway, sides):
    plant, ecus = sides
    there, back = [Frame(i, bytes([1])) for i in range(100, 200)], [Frame(i, bytes([2])) for i in range(300, 400)]
    assert passed_on(there, plant, ecus) == there
    assert passed_on(back, ecus, plant) == back


def test_a_fault_is_in_force_when_install_returns(gateway, sides):
    plant, ecus = sides
    gateway.install(Fault("drop", frozenset([PEDALS])))
    assert passed_on([Frame(PEDALS, bytes(8)), Frame(0xB2, bytes(8))], plant, ecus) == [Frame(0xB2, bytes(8))]
    gateway.clear()
    assert passed_on([Frame(PEDALS, bytes(8))], plant, ecus) == [Frame(PEDALS, bytes(8))]


def test_a_channel_that_does_not_exist_is_told(dbc):
    with pytest.raises(HilError, match="gateway: cannot open CAN interface 'vcan8'"):
        GatewayProcess("vcan0", "vcan8", dbc)


def test_without_lockstep_a_delay_is_of_the_wall_clock(dbc, sides):
    plant, ecus = sides
    with GatewayProcess("vcan0", "vcan1", dbc, lockstep=False) as gateway:
        gateway.install(Fault("delay", frozenset([PEDALS]), delay_ticks=20))
        begin = time.monotonic()
        plant.send([Frame(PEDALS, bytes(8))])
        assert ecus.receive(HANG_S) == [Frame(PEDALS, bytes(8))]
        assert time.monotonic() - begin > 0.15


def test_a_closed_gateway_forwards_nothing_and_its_process_serves_the_next(dbc, sides):
    plant, ecus = sides
    with GatewayProcess("vcan0", "vcan1", dbc) as first:
        first.install(Fault("drop", frozenset([PEDALS])))
    plant.send([Frame(PEDALS, bytes(8))])
    assert ecus.receive(0.1) == []
    with GatewayProcess("vcan0", "vcan1", dbc) as second:
        assert second._worker is first._worker
        assert passed_on([Frame(PEDALS, bytes(8))], plant, ecus) == [Frame(PEDALS, bytes(8))]


def test_a_gateway_that_dies_is_told(dbc, sides):
    gateway = GatewayProcess("vcan0", "vcan1", dbc)
    gateway._worker.process.kill()
    gateway._worker.process.join()
    with pytest.raises(HilError, match="gateway: it has died"):
        gateway.check_alive()
    gateway.close()
