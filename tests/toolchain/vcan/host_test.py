# SPDX-License-Identifier: Apache-2.0
"""The runner on a kernel that has virtual CAN interfaces itself. This suite runs on such a kernel."""
import os
import pwd
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from readable_runner import readable_runner
from waiting import HANG_S, until_heard, wait_until

RUNNER = [sys.executable, str(Path(__file__).resolve().parents[3] / "toolchain" / "vcan" / "with_vcan.py")]
only_root = pytest.mark.skipif(os.getuid() != 0, reason="only root makes interfaces for everybody")


def run(*words, runner=RUNNER, **how):
    return subprocess.run([*runner, *words], capture_output=True, text=True, timeout=HANG_S, **how)


def interfaces():
    return {name for name in os.listdir("/sys/class/net") if "can" in name}


def test_interfaces_that_exist_are_used_and_stay():
    before = interfaces()
    assert {"vcan0", "vcan1"} <= before
    done = run("sh", "-c", "ip -br link show type vcan; exit 6")
    assert {line.split()[0] for line in done.stdout.splitlines()} == before
    assert done.returncode == 6 and interfaces() == before


@only_root
def test_missing_interfaces_are_made_and_removed_again():
    before = interfaces()
    done = run("--force", "host", "--interfaces", "vcan0,vcan7,vcan8", "sh", "-c",
               "ls /sys/class/net; cansend vcan7 123#11 && echo sent")
    assert {"vcan0", "vcan7", "vcan8", "sent"} <= set(done.stdout.split()), done.stderr
    assert interfaces() == before


@only_root
def test_interface_that_was_down_is_down_again():
    subprocess.run(["ip", "link", "add", "vcan9", "type", "vcan"], check=True)
    try:
        assert run("--force", "host", "--interfaces", "vcan9", "cansend", "vcan9", "123#11").returncode == 0
        assert int(Path("/sys/class/net/vcan9/flags").read_text(), 16) & 1 == 0
    finally:
        subprocess.run(["ip", "link", "del", "vcan9"], check=True)


@only_root
@pytest.mark.parametrize("number, code", [(signal.SIGINT, 9), (signal.SIGTERM, 128 + signal.SIGTERM)])
def test_signals_reach_the_command_and_interfaces_are_removed(number, code):
    before = interfaces()
    script = "trap 'exit 9' INT; echo up; while :; do sleep 0.1; done"
    runner = subprocess.Popen([*RUNNER, "--force", "host", "--interfaces", "vcan7", "sh", "-c", script],
                              stdout=subprocess.PIPE, text=True)
    assert runner.stdout.readline() == "up\n"
    assert "vcan7" in interfaces()
    runner.send_signal(number)
    assert runner.wait(HANG_S) == code
    assert interfaces() == before


@only_root
def test_command_that_does_not_exist_leaves_nothing():
    before = interfaces()
    done = run("--force", "host", "--interfaces", "vcan7", "no-such-program")
    assert done.returncode == 127 and "no-such-program: command not found" in done.stderr
    assert interfaces() == before


def test_what_cannot_be_made_is_told():
    nobody = {} if os.getuid() else {"user": pwd.getpwnam("nobody").pw_uid, "extra_groups": []}
    done = run("--force", "host", "--interfaces", "vcan7", "true", runner=readable_runner(), cwd="/", **nobody)
    assert done.returncode == 3
    assert "has no vcan7" in done.stderr and "module vcan" in done.stderr


@pytest.mark.parametrize("user", [pytest.param("root", marks=only_root), pytest.param("nobody", marks=only_root),
                                  "oneself"])
def test_private_interfaces_are_seen_by_the_command_alone(user):
    owner = {} if user == "oneself" else {"user": pwd.getpwnam(user).pw_uid, "group": pwd.getpwnam(user).pw_gid,
                                          "extra_groups": []}
    listener = subprocess.Popen(["candump", "-L", "-n", "1", "vcan0"], stdout=subprocess.PIPE, text=True)
    try:
        wait_until(lambda: " vcan0 " in Path("/proc/net/can/rcvlist_all").read_text())
        before = interfaces()
        done = run("--force", "host", "--private", "--interfaces", "vcan0,vcan5", "sh", "-c",
                   "id -u; ls /sys/class/net; cansend vcan0 123#11 && echo sent", runner=readable_runner(), cwd="/",
                   **owner)
        assert done.stdout.split() == [str(owner.get("user", os.getuid())), "lo", "vcan0", "vcan5", "sent"], done.stderr
        assert interfaces() == before
        subprocess.run(["cansend", "vcan0", "7FF#"], check=True)
        assert listener.communicate(timeout=HANG_S)[0].split()[-1] == "7FF#"  # the first that it heard
    finally:
        listener.kill()


def test_private_names_do_not_meet():
    """Two at once, each with a vcan0 of its own: what one sends the other does not hear."""
    script = (f"candump -L -n 2 vcan0 >&2 & {until_heard('vcan0')}; echo listens; read go; cansend vcan0 {{0}}#;"
              "echo sent; read go; cansend vcan0 7FF#; wait")
    both = [subprocess.Popen([*RUNNER, "--force", "host", "--private", "sh", "-c", script.format(i)], text=True,
                             stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
            for i in ("111", "222")]
    for word in ("listens\n", "sent\n"):
        assert [one.stdout.readline() for one in both] == [word, word]
        for one in both:
            one.stdin.write("go\n")
            one.stdin.flush()
    heard = [one.communicate(timeout=HANG_S)[1].split() for one in both]
    assert [words[2::3] for words in heard] == [["111#", "7FF#"], ["222#", "7FF#"]]
