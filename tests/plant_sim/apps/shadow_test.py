# SPDX-License-Identifier: Apache-2.0
"""voltlap shadow on vcan0 beside a played log of an Orion unit: it sends nothing, its result is that of a replay."""
import json
import os
import re
import resource
import signal
import socket
import struct
import subprocess
import time
from pathlib import Path

import pytest
from orion_log import PACK, candump, frames

BUILD = Path(os.environ["VOLTLAP_BUILD_DIR"])
BUS, OTHER = "vcan0", "vcan1"
SECONDS, HANG_S = 5.0, 300.0
LOST_S = 0.04  # from 50 ms without a current on the firmware calls it lost
NUMBER = re.compile(r"-?\d+\.?\d*")
VARIES = [(re.compile(r"computed in [\d.]+ s: \d+ times"), "computed"),
          (re.compile(r'(Faster than the log.{0,120}?)[\d.]+'), r"\1N")]


def voltlap(*arguments, **options):
    return subprocess.run([BUILD / "bin/voltlap", *map(str, arguments)], capture_output=True, text=True,
                          timeout=HANG_S, check=False, **options)


def sent_on(interface):
    """Frames that anybody sent, by the kernel's count."""
    return int(Path(f"/sys/class/net/{interface}/statistics/tx_packets").read_text())


def send(interface, identifier, data=b""):
    with socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW) as bus:
        bus.bind((interface,))
        bus.send(struct.pack("=IB3x8s", identifier, len(data), data))


class Shadow:
    """One that listens; `end` gives (exit code, standard output, standard error)."""

    def __init__(self, folder, *arguments, interface=BUS, **options):
        listeners = self.listeners(interface)
        self.output, self.errors = folder / "shadow.out", folder / "shadow.err"
        with open(self.output, "w", encoding="utf-8") as output, open(self.errors, "w", encoding="ascii") as errors:
            self.process = subprocess.Popen([BUILD / "bin/voltlap", "shadow", "--bus", interface, *map(str, arguments)],
                                            stdout=output, stderr=errors, text=True, **options)
        limit = time.monotonic() + HANG_S
        while self.listeners(interface) == listeners and self.process.poll() is None and time.monotonic() < limit:
            time.sleep(0.02)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.wait()

    @staticmethod
    def listeners(interface):
        return Path("/proc/net/can/rcvlist_all").read_text().count(f" {interface} ")

    def end(self, number=signal.SIGINT):
        if number is not None:
            self.process.send_signal(number)
        self.process.wait(timeout=HANG_S)
        return self.process.returncode, self.output.read_text(), self.errors.read_text()

    def says(self, words, most_s=60.0):
        """Waits for them: a machine with other work has little left for a shadow, which takes a quarter of a core."""
        limit = time.monotonic() + most_s
        while words not in self.output.read_text() and time.monotonic() < limit:
            time.sleep(0.1)
        return words in self.output.read_text()


@pytest.fixture(name="pack")
def pack_file(tmp_path):
    (tmp_path / "pack.toml").write_text(PACK)
    return tmp_path / "pack.toml"


def settled(text):
    for varying, name in VARIES:
        text = varying.sub(name, text)
    return text


def outputs(folder, name):
    return {flag: folder / f"{name}.{flag}" for flag in ("json", "csv", "report")}


def flags(files):
    return [word for flag, path in files.items() for word in (f"--{flag}", path)]


def test_shadow_beside_a_played_log_sends_nothing_and_says_what_replay_says(tmp_path, pack):
    original, heard = candump(tmp_path / "original.log", SECONDS), tmp_path / "heard.log"
    own, again, first = (outputs(tmp_path, name) for name in ("shadow", "again", "original"))
    before = sent_on(BUS)
    with Shadow(tmp_path, "--pack", pack, "--log", heard, *flags(own)) as shadow:
        player = voltlap("play", original, "--bus", BUS)
        assert player.returncode == 0
        assert shadow.says("the logged SOC jumps"), shadow.output.read_text()  # while the bus is heard
        time.sleep(0.3)
        code, out, said = shadow.end()
    assert code == 0, said
    played = list(frames(SECONDS))
    assert sent_on(BUS) - before == len(played)  # the player's, and none besides
    lines = [line.split()[2] for line in heard.read_text().splitlines()]
    assert lines == [f"{identifier:03X}#{data.hex().upper()}" for _, identifier, data in played]

    summary = out.split(f"{heard}: ")[1]
    assert "shadow 0 s, 0 frames | listens" in said and " | replayed " in said

    replayed = voltlap("replay", heard, "--pack", pack, *flags(again))
    assert settled(f"{heard}: {summary}") == settled(replayed.stdout)
    for flag in own:
        assert settled(own[flag].read_text()) == settled(again[flag].read_text()), flag

    hole_s = longest_hole(heard)
    print(f"{1e3 * hole_s:.0f} ms without the pack's current in what was heard")
    if hole_s > LOST_S:  # a disagreement of its own
        return
    assert voltlap("replay", original, "--pack", pack, *flags(first)).returncode == 0
    same_disagreements(json.loads(own["json"].read_text()), json.loads(first["json"].read_text()))


def longest_hole(log):
    """The pack's current comes every 10 ms: the longest time without it."""
    at = [float(line.split()[0].strip("()")) for line in log.read_text().splitlines() if " 6B0#" in line]
    return max(later - earlier for earlier, later in zip(at, at[1:]))


def same_disagreements(one, other):
    """The same kinds in the same order; times to half a second, values to a twentieth: by the jitter of the bus a
    reading falls into another tick."""
    assert len(one["disagreements"]) == len(other["disagreements"]) >= 4
    for mine, theirs in zip(one["disagreements"], other["disagreements"], strict=True):
        assert NUMBER.sub("N", mine["what"]) == NUMBER.sub("N", theirs["what"])
        numbers = [list(map(float, NUMBER.findall(entry["what"]))) for entry in (mine, theirs)]
        assert numbers[0] == pytest.approx(numbers[1], abs=0.5, rel=0.05), (mine["what"], theirs["what"])


def test_it_says_what_it_waits_for_and_ends_by_itself(tmp_path, pack):
    """A cell alone is no current. Live it is told as what is not there yet, at the end as the refusal of a replay."""
    with Shadow(tmp_path, "--pack", pack, "--log", tmp_path / "heard.log", "--for", 3.5) as shadow:
        for _, identifier, data in list(frames(1.0))[:1]:
            send(BUS, identifier, data)
        code, out, said = shadow.end(None)
    assert code == 2 and out == ""
    assert "1 frames | not yet: a CAN recording with 1 identifiers that no shipped map fits" in said
    assert "no shipped map fits; expected" in said  # the refusal
    assert len((tmp_path / "heard.log").read_text().splitlines()) == 1


def test_a_bus_that_is_silent_is_an_error(tmp_path):
    with Shadow(tmp_path, "--for", 0.5) as shadow:
        code, _, said = shadow.end(None)
    assert code == 2 and "vcan0: found no frame in all that time" in said


def test_an_interface_that_goes_down_ends_it_behind_the_result(tmp_path, pack):
    with Shadow(tmp_path, "--pack", pack, "--log", tmp_path / "heard.log", interface=OTHER) as shadow:
        for _, identifier, data in frames(3.0):
            send(OTHER, identifier, data)
        subprocess.run(["ip", "link", "set", OTHER, "down"], check=True)
        try:
            code, out, said = shadow.end(None)
        finally:
            subprocess.run(["ip", "link", "set", OTHER, "up"], check=True)
    assert code == 3 and 'CAN interface "vcan1" went down or was removed' in said
    assert f"{tmp_path}/heard.log: " in out and "630 frames: " in out


def test_a_log_that_takes_no_more_is_said_and_what_it_holds_is_replayed(tmp_path, pack):
    def small_files():
        resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))

    with Shadow(tmp_path, "--pack", pack, "--log", tmp_path / "heard.log", preexec_fn=small_files) as shadow:
        for k, (_, identifier, data) in enumerate(frames(3.0)):
            send(BUS, identifier, data)
            if k % 100 == 99:
                time.sleep(0.25)  # some are written before the limit is met
        code, out, said = shadow.end(None)
    assert code == 2 and "cannot write to this recording any more" in said and "File too large" in said
    text = (tmp_path / "heard.log").read_text()
    assert 0 < len(text) <= 20_000 and text.endswith("\n")
    assert f"{tmp_path}/heard.log: " in out


def test_a_recording_never_takes_the_place_of_an_input(tmp_path, pack):
    (tmp_path / "bus.dbc").write_text("VERSION \"\"\n")
    for flag, path in (("--pack", pack), ("--dbc", tmp_path / "bus.dbc")):
        before = path.read_text()
        done = voltlap("shadow", "--bus", BUS, flag, path, "--log", path, "--for", 1)
        assert done.returncode == 2 and path.read_text() == before, done.stderr


@pytest.mark.parametrize("arguments, words", [
    (["--bus", "vcan7"], "no such interface"), (["--bus", "lo"], "no CAN interface"),
    (["--bus", BUS, "--log", "/absent/heard.log"], "cannot open this file for the recording"),
    (["--bus", BUS, "--log", "/"], "Is a directory"),
    (["--bus", BUS, "--log", "-"], "expected a plain file"), (["--bus", BUS, "--log", "a.log.gz"], "compressed"),
    (["--bus", BUS, "--map", "no_such_map"], "no_such_map"), (["--bus", BUS, "--pack", "no_such_pack"], "no_such_pack"),
    (["--bus", BUS, "--json", "a", "--csv", "a"], "one file for two"), (["--bus", BUS, "--for", "0"], "--for"),
    ([], "--bus"),
])
def test_what_cannot_be_done_is_refused_before_anything_is_heard(tmp_path, arguments, words):
    before = sent_on(BUS)
    done = voltlap("shadow", *arguments, cwd=tmp_path)
    assert done.returncode == 2 and words in done.stderr, done.stderr
    assert sent_on(BUS) == before and list(tmp_path.iterdir()) == []
