# SPDX-License-Identifier: Apache-2.0
"""The monitor on a real SocketCAN interface."""
import json
import os
import pty
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from voltlap_hil.bus import Bus
from voltlap_hil.frame import Frame

HANG_S = 300.0  # only a hang takes as long, however busy the machine
MONITOR = [sys.executable, str(Path(__file__).parents[1] / "monitor.py"), "--bus", "vcan0"]


@pytest.fixture
def traffic(dbc):
    """BmsLimits every 10 ms, or as often as a busy machine lets it, until the test ends: the times when it was sent."""
    stop = threading.Event()
    sent = []
    row = dbc.message("BmsLimits")

    def send():
        with Bus("vcan0", dbc=dbc, ids=[]) as bus:
            counter = 0
            while not stop.wait(0.01):
                data = row.encode({"DischargeLimit": 123.4, "DischargeReason": "PackVoltage"})
                bus.send([Frame(row.id, row.seal(data, counter))])
                sent.append(time.monotonic())
                counter += 1

    thread = threading.Thread(target=send)
    thread.start()
    yield sent
    stop.set()
    thread.join()


def test_once_prints_what_the_bus_says(traffic):
    run = subprocess.run([*MONITOR, "--once", "--json", "--wait", "1"], capture_output=True, text=True, timeout=HANG_S)
    assert run.returncode == 0, run.stderr
    snapshot = json.loads(run.stdout)
    assert snapshot["limits"][0]["value"] == 123.4 and snapshot["limits"][0]["reason"] == "PackVoltage"
    assert snapshot["messages"]["BmsLimits"]["bad_seals"] == snapshot["messages"]["BmsLimits"]["counter_gaps"] == 0
    assert 0 < snapshot["frames_per_s"] <= 105 and snapshot["lost_here"] == 0
    assert snapshot["clock"] == "bus"


def test_any_cars_bus_is_shown_by_its_own_file(traffic):
    car = Path(__file__).parents[2] / "can_dbc" / "car.dbc"
    run = subprocess.run([*MONITOR, "--dbc", car, "--once", "--json"], capture_output=True, text=True, timeout=HANG_S)
    assert run.returncode == 0, run.stderr
    snapshot = json.loads(run.stdout)
    row = next(row for row in snapshot["messages"] if row["message"] == "BmsLimits")
    assert row["signals"]["DischargeLimit"]["value"] == 123.4 and row["state"] == "fresh"
    each_s = [sum(t <= at < t + 1.0 for at in traffic) for t in traffic if t + 1.0 < traffic[-1]]
    assert 0.8 * min(each_s) <= snapshot["buses"]["vcan0"]["per_s"] <= 1.2 * max(each_s) <= 1.2 * 101


def test_silent_bus_is_told_with_what_to_do():
    run = subprocess.run([*MONITOR, "--once", "--wait", "0.5"], capture_output=True, text=True, timeout=HANG_S)
    assert run.returncode == 3
    assert "no frame within 0.5 s" in run.stderr and "--wait" in run.stderr


def test_live_view_follows_the_bus_and_ctrl_c_leaves_a_clean_terminal(traffic):
    ours, theirs = pty.openpty()
    process = subprocess.Popen(MONITOR, stdin=theirs, stdout=theirs, stderr=theirs, env={**os.environ, "TERM": "xterm"})
    os.close(theirs)
    shown, limit = b"", time.monotonic() + HANG_S
    while b"PackVoltage" not in shown and time.monotonic() < limit:
        shown += os.read(ours, 65536)
    process.send_signal(signal.SIGINT)
    try:
        while more := os.read(ours, 65536):
            shown += more
    except OSError:  # the terminal's last user has gone
        pass
    assert process.wait(timeout=HANG_S) == 0
    assert b"123.4 A" in shown
    assert shown.rfind(b"\x1b[?1049l") > shown.rfind(b"\x1b[?1049h") >= 0  # back from the other screen
    assert b"Traceback" not in shown


def test_interface_that_does_not_exist_is_told_with_what_makes_it():
    run = subprocess.run([*MONITOR[:-1], "vcan7", "--once"], capture_output=True, text=True, timeout=HANG_S)
    assert run.returncode == 3
    assert "cannot open CAN interface 'vcan7'" in run.stderr and "with-vcan" in run.stderr
