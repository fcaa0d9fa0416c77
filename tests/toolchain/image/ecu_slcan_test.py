# SPDX-License-Identifier: Apache-2.0
"""Both nodes on an emulated Cortex-M4 behind a serial line with SLCAN: python-can talks to it as to any adapter, and
five seconds of driving have the frames of the run in one process, byte for byte."""
import re
import shutil
import subprocess
import sys
import time

import pytest
from image_tools import HOST, ROOT, VOLTLAP, tool

import can
import ecu_slcan
import image_build

pytest.importorskip("serial")
pytestmark = pytest.mark.skipif(shutil.which("qemu-system-arm") is None, reason="qemu-system-arm is not installed")
TICKS = 500
SYNC, DONE_MASTER, READY_BMS, EXTENDED = 0x7E0, 0x7EA, 0x7E1, 0x8000_0000
LINE = re.compile(r"\((\d+)\.(\d{6})\) \w+ ([0-9A-F]+)#([0-9A-F]*)")


@pytest.fixture
def line(image_of):
    """The name of the emulated board's serial line."""
    process, path = ecu_slcan.start(image_of("both_nodes_slcan"))
    yield path
    process.kill()
    process.wait()


@pytest.fixture
def adapter(line):
    with can.Bus(interface="slcan", channel=line, bitrate=500_000, sleep_after_open=1.5) as bus:
        yield bus


def rows_of(*tables):
    """The identifiers of generated tables."""
    text = (HOST / "can_dbc" / "generated" / "can_dbc" / "tables.hpp").read_text()
    bodies = [text.split(f"MessageRow {table}[]", 1)[1].split("};", 1)[0] for table in tables]
    return {int(row, 16) for body in bodies for row in re.findall(r"\{(0x[0-9A-F]+),", body)}


def drive(folder):
    """For each tick what the plant sent, and what the nodes answered, in one process."""
    log, nodes = folder / "lap.log", rows_of("kBmsTx", "kMasterTx")
    subprocess.run([VOLTLAP, "endurance", "--laps", "1", "--candump", log], check=True, stdout=subprocess.DEVNULL)
    ticks = []
    for text in log.read_text().splitlines():
        seconds, micros, name, data = LINE.match(text).groups()
        tick = (int(seconds) * 1_000_000 + int(micros)) // 10_000
        while len(ticks) <= tick:
            if tick >= TICKS:
                return ticks
            ticks.append(([], []))
        can_id = int(name, 16) | (EXTENDED if len(name) == 8 else 0)
        ticks[tick][int(can_id & 0x1FFF_FFFF in nodes)].append((can_id, bytes.fromhex(data)))
    return ticks


def send(bus, can_id, data):
    bus.send(can.Message(arbitration_id=can_id & 0x1FFF_FFFF, is_extended_id=bool(can_id & EXTENDED), data=data))


def heard(bus, last, within_s=10.0):
    """Frames up to that of the identifier `last`."""
    frames, deadline = [], time.monotonic() + within_s
    while time.monotonic() < deadline:
        if (frame := bus.recv(0.5)) is None:
            continue
        can_id = frame.arbitration_id | (EXTENDED if frame.is_extended_id else 0)
        if can_id == last:
            return frames
        frames.append((can_id, bytes(frame.data)))
    raise AssertionError(f"0x{last:03X} did not come; heard {frames}")


def test_five_seconds_of_driving_are_those_of_one_process(adapter, tmp_path):
    ticks = drive(tmp_path)
    assert len(ticks) == TICKS and sum(len(sent) for sent, _ in ticks) > 1000
    begin = time.monotonic()
    heard(adapter, READY_BMS)
    for tick, (sent, answered) in enumerate(ticks):
        for can_id, data in sent:
            send(adapter, can_id, data)
        send(adapter, SYNC, tick.to_bytes(4, "little") + len(sent).to_bytes(2, "little") + b"\0\0")
        got = [(can_id, data) for can_id, data in heard(adapter, DONE_MASTER) if not 0x7E0 <= can_id <= 0x7FF]
        assert got == answered, f"tick {tick}"
    print(f"{TICKS} ticks in {time.monotonic() - begin:.1f} s")


def test_the_adapter_answers_as_one(line):
    import serial
    with serial.Serial(line, timeout=2.0) as port:
        time.sleep(1.5)
        for said, answer in ((b"\rV\r", b"V0100\r"), (b"S5\r", b"\a"), (b"S6\r", b"\r"), (b"t0C10\r", b"\a"),
                             (b"x" * 100 + b"\r", b"\a"), (b"O\r", b"\r")):
            port.write(said)
            assert port.read(len(answer)) == answer, said


@pytest.mark.parametrize(("arguments", "code", "said"), [
    (["--once"], 2, "--once goes with --bus"),
    (["--image", "/nowhere/x.elf"], 2, "/nowhere/x.elf"),
    (["--bus", "nocan7"], 3, "--bus nocan7"),
])
def test_what_cannot_be_is_said(kind_of, arguments, code, said):
    kind_of()
    done = tool("ecu_slcan.py", *arguments, timeout=30)
    assert done.returncode == code and said in done.stderr and "Traceback" not in done.stderr


def test_help_says_how_to_go_on():
    done = tool("ecu_slcan.py", "--help")
    assert "slcand -o -s6" in done.stdout and "voltlap plant --bus" in done.stdout
