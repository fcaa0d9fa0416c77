# SPDX-License-Identifier: Apache-2.0
"""Runs of several processes on vcan0, and what a test asks of them."""
import json
import os
import signal
import socket
import struct
import subprocess
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
PROGRAM = Path(os.environ["VOLTLAP_BUILD_DIR"]) / "bin" / "voltlap"
BUS = "vcan0"
FIRST_LOCKSTEP_ID = 0x7E0
HANG_S = 300.0  # only a hang takes as long, however busy the machine


class Bus:
    """A plain CAN socket: what a listener hears, in the order of the bus."""

    def __init__(self, ids=None, interface=BUS, buffer_bytes=1 << 26):
        self.socket = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, buffer_bytes)
        if ids is not None:
            filters = b"".join(struct.pack("=II", i, 0x7FF) for i in ids)
            self.socket.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_FILTER, filters)
        self.socket.bind((interface,))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.socket.close()

    def send(self, identifier, data):
        self.socket.send(struct.pack("=IB3x8s", identifier, len(data), data))

    def receive(self, timeout_s):
        """(identifier, data), or None."""
        self.socket.settimeout(timeout_s)
        try:
            return self._unpack(self.socket.recv(16))
        except TimeoutError:
            return None

    def drain(self):
        out = []
        while True:
            try:
                out.append(self._unpack(self.socket.recv(16, socket.MSG_DONTWAIT)))
            except BlockingIOError:
                return out

    @staticmethod
    def _unpack(raw):
        identifier, length, data = struct.unpack("=IB3x8s", raw)
        return identifier, data[:length]


def start(*arguments, **options):
    return subprocess.Popen([PROGRAM, *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                            **options)


def run(*arguments, timeout_s=HANG_S):
    return subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, timeout=timeout_s,
                          check=False)


def children(pid):
    """name of the command -> process, of every child of `pid`."""
    out = {}
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            fields = (entry / "stat").read_text().rsplit(")", 1)[1].split()
            words = (entry / "cmdline").read_bytes().split(b"\0")
        except OSError:
            continue
        if int(fields[1]) == pid and fields[0] != "Z" and len(words) > 2:
            role = words[2] if words[1] == b"ecu" else words[1]
            out[role.decode()] = int(entry.name)
    return out


def wait_for(condition):
    end = time.monotonic() + HANG_S
    while time.monotonic() < end:
        if value := condition():
            return value
        time.sleep(0.02)
    raise AssertionError("waited in vain")


def wait_for_listener(interface=BUS):
    """Until somebody listens to every frame of the interface."""
    wait_for(lambda: f" {interface} " in Path("/proc/net/can/rcvlist_all").read_text())


def wait_for_tick(tick, interface=BUS):
    """Until the plant has begun that tick."""
    with Bus([FIRST_LOCKSTEP_ID], interface) as bus:
        while True:
            frame = bus.receive(HANG_S)
            assert frame is not None, "no SYNC"
            if struct.unpack_from("<I", frame[1])[0] >= tick:
                return


def kill_at(run_, role, tick, number=signal.SIGKILL):
    """Kills a process of the run when the plant has begun that tick."""
    wait_for_tick(tick)
    pid = children(run_.pid)[role]
    os.kill(pid, number)
    return pid


def is_gone(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] == "Z"
    except OSError:
        return True


def result(path):
    return json.loads(Path(path).read_text())


@pytest.fixture(autouse=True)
def quiet_bus():
    """Nobody of a test is left on the bus when it ends."""
    yield
    with Bus() as bus:
        time.sleep(0.25)
        assert bus.drain() == [], "somebody still sends"
