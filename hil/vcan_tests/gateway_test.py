# SPDX-License-Identifier: Apache-2.0
"""The gateway process between two real interfaces."""
import time

import pytest

from voltlap_hil.bus import Bus
from voltlap_hil.errors import HilError
from voltlap_hil.faults import Rule
from voltlap_hil.frame import Frame
from voltlap_hil.gateway import GatewayProcess

PEDALS = 0xB1


@pytest.fixture
def sides(dbc):
    with Bus("vcan0", dbc=dbc) as plant, Bus("vcan1", dbc=dbc) as ecus:
        yield plant, ecus


@pytest.fixture
def gateway(dbc, sides):
    with GatewayProcess("vcan0", "vcan1", dbc) as process:
        yield process


def drained(bus):
    frames = []
    while batch := bus.receive(0.3):
        frames += batch
    return frames


def test_frames_pass_both_ways_once(gateway, sides):
    plant, ecus = sides
    there, back = [Frame(i, bytes([1])) for i in range(100, 200)], [Frame(i, bytes([2])) for i in range(300, 400)]
    plant.send(there)
    ecus.send(back)
    assert drained(ecus) == there and drained(plant) == back


def test_a_fault_is_in_force_when_install_returns(gateway, sides):
    plant, ecus = sides
    gateway.install(Rule("drop", frozenset([PEDALS])))
    plant.send([Frame(PEDALS, bytes(8)), Frame(0xB2, bytes(8))])
    assert [f.id for f in drained(ecus)] == [0xB2]
    gateway.clear()
    plant.send([Frame(PEDALS, bytes(8))])
    assert [f.id for f in drained(ecus)] == [PEDALS]


def test_a_channel_that_does_not_exist_is_told(dbc):
    with pytest.raises(HilError, match="gateway: cannot open CAN interface 'vcan8'"):
        GatewayProcess("vcan0", "vcan8", dbc)


def test_without_lockstep_a_delay_is_of_the_wall_clock(dbc, sides):
    plant, ecus = sides
    with GatewayProcess("vcan0", "vcan1", dbc, lockstep=False) as gateway:
        gateway.install(Rule("delay", frozenset([PEDALS]), ticks=20))
        begin = time.monotonic()
        plant.send([Frame(PEDALS, bytes(8))])
        assert ecus.receive(5.0) == [Frame(PEDALS, bytes(8))]
        assert 0.15 < time.monotonic() - begin < 1.0


def test_a_closed_gateway_forwards_nothing_and_its_process_serves_the_next(dbc, sides):
    plant, ecus = sides
    with GatewayProcess("vcan0", "vcan1", dbc) as first:
        first.install(Rule("drop", frozenset([PEDALS])))
    plant.send([Frame(PEDALS, bytes(8))])
    assert drained(ecus) == []
    with GatewayProcess("vcan0", "vcan1", dbc) as second:
        assert second._worker is first._worker
        plant.send([Frame(PEDALS, bytes(8))])
        assert drained(ecus) == [Frame(PEDALS, bytes(8))]


def test_a_gateway_that_dies_is_told(dbc, sides):
    gateway = GatewayProcess("vcan0", "vcan1", dbc)
    gateway._worker.process.kill()
    gateway._worker.process.join()
    with pytest.raises(HilError, match="gateway: it has died"):
        gateway.check_alive()
    gateway.close()
