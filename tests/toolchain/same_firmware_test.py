# SPDX-License-Identifier: Apache-2.0
"""The comparison of two versions of the firmware: equal is equal, and what is planted is found and shown."""
import os
import re
import shutil
import signal
import subprocess
import sys
import time

import pytest
from copies import PROJECT, hear_interruptions

sys.path.insert(0, str(PROJECT / "toolchain"))
import same_firmware as same_firmware_tool  # noqa: E402

GIT = ["git", "-c", "user.name=test", "-c", "user.email=test@example.org", "-c", "commit.gpgsign=false"]


@pytest.fixture(scope="module")
def project(tmp_path_factory):
    """A checkout of its own, whose only commit is the firmware as it stands here."""
    root = tmp_path_factory.mktemp("checkout")
    for part in ("firmware", "can_dbc", "toolchain/same_firmware"):
        shutil.copytree(PROJECT / part, root / part, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(PROJECT / "toolchain" / "same_firmware.py", root / "toolchain")
    for command in (["init", "-q"], ["add", "-A"], ["commit", "-q", "-m", "as it stands"]):
        subprocess.run([*GIT, "-C", root, *command], check=True)
    return root


def planted(project, folder, file, old, new):
    """A copy of the project with one text changed."""
    for part in ("firmware", "can_dbc"):
        shutil.copytree(project / part, folder / part)
    text = (folder / file).read_text()
    assert text.count(old) == 1
    (folder / file).write_text(text.replace(old, new))
    return folder


def same_firmware(project, *arguments):
    return subprocess.run([sys.executable, project / "toolchain" / "same_firmware.py", *arguments], capture_output=True,
                          text=True)


def left_behind(project):
    return sorted(path.name for path in (project / "build" / "same_firmware").iterdir())


def test_firmware_that_did_not_change_is_equal_and_got_into_its_states(project):
    done = same_firmware(project, "HEAD", "--calls", "300000")
    assert done.returncode == 0, done.stdout + done.stderr
    assert re.fullmatch(r"equal: 300000 node calls in \d+ runs, seed 1, [^\n]*\n", done.stdout)
    reached = dict(re.findall(r"(\w+) (\d+)", done.stdout.split("entered:")[1]))
    for state in ("LvOn", "TsRequested", "TsActive", "ReadyToDrive", "Fault", "Idle", "Precharge", "Open"):
        assert int(reached[state]) >= 50, state
    assert int(re.search(r"torque in (\d+) ticks", done.stdout)[1]) > 10_000
    assert left_behind(project) == []


# One tick, one unit of the rise, one step of the counter: what a slip of the hand would do.
PLANTED = {
    "a contactor's time": ("BMS", "firmware/bms/config.hpp", "contactor_time = Duration::from_ms(200)",
                           "contactor_time = Duration::from_ms(210)"),
    "a pedal's time": ("master", "firmware/master/config.hpp", "apps_implausible_time = Duration::from_ms(100)",
                       "apps_implausible_time = Duration::from_ms(90)"),
    "one unit of a rise": ("BMS", "firmware/base/ramp.hpp", "elapsed.ms() / 1'000;", "elapsed.ms() / 1'000 + 1;"),
}


@pytest.mark.parametrize("what", PLANTED)
def test_a_small_change_is_found_and_shown(project, tmp_path, what):
    node, *change = PLANTED[what]
    done = same_firmware(project, "HEAD", "--present", planted(project, tmp_path, *change))
    assert done.returncode == 1, done.stdout + done.stderr
    assert re.match(rf"different: seed 1, run \d+, tick \d+, {node} node, ", done.stdout)
    # At least one signal in words, and an input that is much shorter than the run.
    assert re.search(r"^    \w+: .+ old, .+ present$", done.stdout, re.MULTILINE)
    short, whole = map(int, re.search(r"shortest input found: (\d+) steps of (\d+)", done.stdout).groups())
    assert 0 < short < whole
    assert left_behind(project) == ["difference.txt"]
    (project / "build" / "same_firmware" / "difference.txt").unlink()


def test_a_version_without_the_interface_is_refused_in_words(project, tmp_path):
    other = planted(project, tmp_path, "firmware/app/bms_node.hpp", "void tick(Instant", "void step_once(Instant")
    done = same_firmware(project, "HEAD", "--calls", "1000", "--present", other)
    assert done.returncode == 5
    assert "no longer has the interface" in done.stderr and "bms_node" in done.stderr
    assert left_behind(project) == []


@pytest.mark.parametrize("arguments, words", [
    (["no-such-commit"], "there is no commit 'no-such-commit'"),
    (["HEAD", "--calls", "0"], "--calls 0: 1 or more"),
    (["HEAD", "--seed", "-1"], "--seed -1: 0 to"),
    (["HEAD", "--present", "/nowhere"], "there is no folder firmware in it"),
])
def test_what_cannot_be_compared_is_refused(project, arguments, words):
    done = same_firmware(project, *arguments)
    assert done.returncode == 2
    assert words in done.stderr


def test_an_interrupted_comparison_leaves_nothing_behind(project):
    endless = [sys.executable, project / "toolchain" / "same_firmware.py", "HEAD", "--calls", str(10**12)]
    process = subprocess.Popen(endless, stderr=subprocess.PIPE, text=True, preexec_fn=hear_interruptions)
    place = project / "build" / "same_firmware"
    deadline = time.monotonic() + 60
    while not list(place.glob("*/same_firmware")):  # the comparison is built and about to run
        assert process.poll() is None and time.monotonic() < deadline
        time.sleep(0.05)
    os.kill(process.pid, signal.SIGINT)
    _, errors = process.communicate(timeout=20)
    assert process.returncode == 130, errors
    assert "interrupted; nothing is kept" in errors
    assert left_behind(project) == []


def test_an_interruption_amid_the_start_of_a_program_ends_that_program(monkeypatch):
    started = []

    class InterruptedStart(subprocess.Popen):
        def __init__(self, *arguments, **settings):
            super().__init__(*arguments, **settings)
            started.append(self)
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(subprocess, "Popen", InterruptedStart)
    with pytest.raises(KeyboardInterrupt):
        same_firmware_tool.run(["sleep", "600"])
    assert started[0].poll() == -signal.SIGTERM


def test_a_program_that_is_not_there_leaves_interruptions_heard():
    with pytest.raises(FileNotFoundError):
        same_firmware_tool.run(["/nowhere/program"])
    assert signal.pthread_sigmask(signal.SIG_BLOCK, ()) == set()
