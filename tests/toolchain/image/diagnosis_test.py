# SPDX-License-Identifier: Apache-2.0
"""A workshop's tester (udsoncan over can-isotp) at an emulated Cortex-M4 behind SLCAN that runs both nodes: who each of
them is, what faults it has, what it refuses. DIA-001, DIA-002, DIA-003, DIA-006 on the image."""
import queue
import shutil
import threading

import pytest
from ecu_slcan_test import DONE_MASTER, EXTENDED, READY_BMS, SYNC, adapter, heard, line, send  # noqa: F401 fixtures

import isotp
import udsoncan
from udsoncan.client import Client
from udsoncan.connections import PythonIsoTpConnection
from udsoncan.exceptions import NegativeResponseException

pytest.importorskip("serial")
pytestmark = pytest.mark.skipif(shutil.which("qemu-system-arm") is None, reason="qemu-system-arm is not installed")
TESTER, BMS, MASTER = 0xF1, 0xB0, 0xB1
VERSION, IMAGE = 0xF189, 0xF195
# bits of BmsStatus.Faults and MasterStatus.Faults of nodes that hear no sensor
LOST_BMS = {"CellMeasurementLost": 3, "TemperatureMeasurementLost": 4, "CurrentMeasurementLost": 5}
LOST_MASTER = {"PedalsLost": 4, "InverterLost": 6, "VehicleIoLost": 7}


class Ticks:
    """Steps the board as a car does, and carries the tester's frames in between."""

    def __init__(self, bus):
        self._bus, self._out, self._over = bus, queue.Queue(), threading.Event()
        self.heard = {BMS: queue.Queue(), MASTER: queue.Queue()}
        self._tick = 0
        self.failure = None
        heard(bus, READY_BMS)
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self):
        try:
            while not self._over.is_set():
                self._step()
        except AssertionError as failure:
            self.failure = failure

    def _step(self):
        frames = [self._out.get() for _ in range(self._out.qsize())]
        for can_id, data in frames:
            send(self._bus, can_id, data)
        send(self._bus, SYNC, self._tick.to_bytes(4, "little") + len(frames).to_bytes(2, "little") + b"\0\0")
        self._tick += 1
        for can_id, data in heard(self._bus, DONE_MASTER):
            for node, told in self.heard.items():
                if can_id == EXTENDED | 0x18DA0000 | TESTER << 8 | node:
                    told.put(isotp.CanMessage(arbitration_id=can_id & ~EXTENDED, data=data, extended_id=True))

    def send(self, message):
        self._out.put((message.arbitration_id | EXTENDED, bytes(message.data)))

    def receive(self, node, timeout):
        try:
            return self.heard[node].get(timeout=timeout)
        except queue.Empty:
            return None

    def close(self):
        self._over.set()
        self._thread.join()
        assert self.failure is None, self.failure


@pytest.fixture
def ticks(adapter):  # noqa: F811
    out = Ticks(adapter)
    yield out
    out.close()


def client_of(ticks, node):
    address = isotp.Address(isotp.AddressingMode.NormalFixed_29bits, source_address=TESTER, target_address=node)
    stack = isotp.TransportLayer(lambda timeout: ticks.receive(node, timeout), ticks.send, address)
    config = {**udsoncan.configs.default_client_config, "data_identifiers": {VERSION: Text, IMAGE: Text, 0x1234: Text},
              "request_timeout": 20, "p2_timeout": 20}
    return Client(PythonIsoTpConnection(stack), config=config)


class Text(udsoncan.DidCodec):
    def decode(self, payload):
        return payload.decode("ascii")

    def __len__(self):
        raise udsoncan.DidCodec.ReadAllRemainingData


def test_each_node_says_who_it_is_and_what_it_lacks(ticks):
    for node, group, lost in ((BMS, 0x1A, LOST_BMS), (MASTER, 0x1B, LOST_MASTER)):
        with client_of(ticks, node) as client:
            version, image = client.read_data_by_identifier_first(VERSION), client.read_data_by_identifier_first(IMAGE)
            assert version[0].isdigit() and image == "both_nodes_slcan"
            while not set(lost.values()) <= {dtc.id >> 8 & 0xFF for dtc in faults(client)}:
                assert ticks.failure is None, ticks.failure
            assert {dtc.id >> 16 for dtc in faults(client)} == {group}
            assert client.get_number_of_dtc_by_status_mask(0xFF).service_data.dtc_count == len(faults(client))


def faults(client):
    return client.get_dtc_by_status_mask(0xFF).service_data.dtcs


@pytest.mark.parametrize("node", [BMS, MASTER])
def test_what_a_node_has_not_is_refused_with_its_code(ticks, node):
    with client_of(ticks, node) as client:
        for ask, code in ((lambda: client.read_data_by_identifier_first(0x1234), 0x31),
                          (lambda: client.change_session(3), 0x12), (client.clear_dtc, 0x11),
                          (lambda: client.ecu_reset(1), 0x22)):  # this board has no restart
            with pytest.raises(NegativeResponseException) as refused:
                ask()
            assert refused.value.response.code == code
