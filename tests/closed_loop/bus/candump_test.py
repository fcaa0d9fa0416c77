# SPDX-License-Identifier: Apache-2.0
"""can-utils' candump beside a run hears every frame that the kernel counted as sent, lockstep frames included."""
import re
import signal
import subprocess
from collections import Counter
from pathlib import Path

import pytest
from conftest import BUS, FIRST_LOCKSTEP_ID, HANG_S, Bus, result, run, wait_for

LINE = re.compile(r"^\(\d+\.\d+\) vcan0 ([0-9A-F]{3})#([0-9A-F]{0,16})$")
SENT = Path(f"/sys/class/net/{BUS}/statistics/tx_packets")
LARGE, SMALL = 64 << 20, 4 << 10  # bytes; a tick's batch of frames does not fit into the small one
SYNC, DONE_BMS, DONE_MASTER = 0x7E0, 0x7E9, 0x7EA
MARK = 0x555  # of nobody


class Candump:
    """A candump that writes to a file; `heard` ends it and counts its frames by identifier."""

    def __init__(self, path, buffer_bytes):
        self.path = path
        self.others = Path("/proc/net/can/rcvlist_all").read_text().count(f" {BUS} ")
        with open(path, "wb") as file:
            self.process = subprocess.Popen(["candump", "-L", "-r", str(buffer_bytes), BUS], stdout=file)
        wait_for(self._listens)

    def _listens(self):
        """Of several candumps each is an entry of the list."""
        return Path("/proc/net/can/rcvlist_all").read_text().count(f" {BUS} ") > self.others

    def heard(self):
        wait_for(self._is_at_the_mark)
        self.process.send_signal(signal.SIGINT)
        self.process.wait(HANG_S)
        lines = self.path.read_text().splitlines()
        count = Counter(int(LINE.match(line)[1], 16) for line in lines)
        del count[MARK]
        return count

    def _is_at_the_mark(self):
        """A frame behind all others is written, and so are they. A full buffer loses the mark too: it is sent again."""
        with Bus([]) as bus:
            bus.send(MARK, b"")
        return f"{MARK:03X}#" in self.path.read_text()


@pytest.fixture
def candump(tmp_path):
    made = []

    def start(buffer_bytes):
        made.append(Candump(tmp_path / f"candump{len(made)}.log", buffer_bytes))
        return made[-1]
    yield start
    for one in made:
        one.process.kill()
        one.process.wait()


def drive(folder, *more):
    """(frames the kernel counted, the run's result) of a short drive."""
    (folder / "drive.csv").write_text("time_s,speed_mps\n0,0\n2,4\n4,4\n")
    before = int(SENT.read_text())
    done = run("endurance", "--bus", BUS, "--drive", folder / "drive.csv", "--json", folder / "r.json", *more)
    assert done.returncode == 0, done.stderr
    return int(SENT.read_text()) - before, result(folder / "r.json")


def test_candump_hears_as_many_frames_as_were_sent(candump, tmp_path):
    listener = candump(LARGE)
    sent, summary = drive(tmp_path, "--pace", 2)
    heard = listener.heard()
    assert heard.total() == sent
    assert sum(n for i, n in heard.items() if i < FIRST_LOCKSTEP_ID) == summary["frames"] > 5000
    ticks = heard[SYNC]
    assert ticks > 400 and heard[DONE_BMS] == heard[DONE_MASTER]
    assert abs(heard[DONE_BMS] - ticks) <= 1  # a last Sync may carry Stop


def test_a_listener_that_loses_frames_is_seen_to(candump, tmp_path):
    """The control: what is counted above must notice a loss."""
    listener = candump(SMALL)
    sent, _ = drive(tmp_path)
    assert 0 < listener.heard().total() < sent


def test_two_listeners_do_not_change_the_run(candump, tmp_path):
    _, alone = drive(tmp_path)
    first, second = candump(LARGE), candump(LARGE)
    sent, heard = drive(tmp_path)
    assert heard["trace_hash"] == alone["trace_hash"]
    assert first.heard().total() == second.heard().total() == sent
