# SPDX-License-Identifier: Apache-2.0
"""The short form of toolchain/bare_root_test.sh: it passes, it fails on planted errors, and it cleans up."""
import os
import signal
import subprocess
import time

import pytest
from copies import BUILT_FROM, HANG_S, PROJECT, copy_project, hear_interruptions

CANNOT = 77
LOG = "bare_root.log"


@pytest.fixture
def folder(tmp_path):
    folder = tmp_path / "roots"
    folder.mkdir()
    return folder


def command(folder, project):
    return [project / "toolchain" / "bare_root_test.sh", "--short", "--folder", folder, "--log", folder.parent / LOG]


def start(folder, project=PROJECT):
    run = subprocess.run(command(folder, project), capture_output=True, text=True, timeout=HANG_S)
    if run.returncode == CANNOT:
        pytest.skip(run.stderr.strip())
    assert not list(folder.iterdir())
    return run


def commit(project):
    git = ["git", "-C", project, "-c", "user.name=test", "-c", "user.email=test@localhost"]
    for words in (["init", "-q"], ["add", "-A"], ["commit", "-q", "-m", "copy"]):
        subprocess.run([*git, *words], check=True)


def test_ordinary_user_is_given_the_line_and_root_installs_only_what_a_run_needs(folder, tmp_path):
    project = copy_project(tmp_path / "project", without=BUILT_FROM)
    commit(project)
    run = start(folder, project)
    assert run.returncode == 0, run.stdout + run.stderr
    assert "ordinary user without sudo: the apt-get line, exit code 4" in run.stdout
    assert "all shown" in run.stdout


@pytest.mark.parametrize("file, old, new, not_shown", [
    ("voltlap", "packages_run=(", "packages_run=(gcc-arm-none-eabi ", "holds nothing that only tests need"),
    ("voltlap", " gcc-arm-none-eabi ", " ", "the line for the tests holds the cross compiler"),
    ("toolchain/setup/commands.sh", "exit_missing=4", "exit_missing=1", "ends with 4, but it was 1"),
    ("toolchain/setup/packages.sh", "if [ -t 0 ]; then", "return 0\n  if [ -t 0 ]; then", "without consent"),
    ("toolchain/setup/packages.sh", 'apt_get update ||', 'true ||', "apt-get update is called"),
])
def test_planted_error_is_found(folder, tmp_path, file, old, new, not_shown):
    project = copy_project(tmp_path / "project", without=BUILT_FROM)
    text = (project / file).read_text()
    assert old in text
    (project / file).write_text(text.replace(old, new, 1))
    commit(project)
    run = start(folder, project)
    assert run.returncode == 1
    assert "NOT SHOWN" in run.stdout and not_shown in run.stdout


@pytest.mark.parametrize("delay_s", [0, 0.2])
@pytest.mark.parametrize("how, to", [(signal.SIGINT, os.killpg), (signal.SIGTERM, os.kill)])
def test_interruption_leaves_nothing_behind(folder, how, to, delay_s):
    start(folder)  # skips where it cannot be done
    log = folder.parent / LOG
    log.unlink()
    run = subprocess.Popen(command(folder, PROJECT), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                           start_new_session=True, preexec_fn=hear_interruptions)
    while not log.exists():  # written first thing inside
        assert run.poll() is None
        time.sleep(0.01)
    time.sleep(delay_s)
    to(run.pid, how)
    assert run.wait(timeout=HANG_S) == 130
    assert not list(folder.iterdir())


def test_folder_with_a_mount_in_it_is_not_deleted(tmp_path):
    """The function that deletes, taken from the script and tried on a folder that holds a mount."""
    if subprocess.run(["unshare", "--mount", "true"], capture_output=True).returncode != 0:
        pytest.skip("mounting needs root")
    (tmp_path / "scratch" / "dev").mkdir(parents=True)
    text = (PROJECT / "toolchain" / "bare_root_test.sh").read_text()
    functions = text[text.index("mounts_below()"):text.index("outside()")]
    run = subprocess.run(["unshare", "--mount", "bash", "-c", f"""{functions}
        scratch={tmp_path}/scratch
        mount -t tmpfs tmpfs $scratch/dev && touch $scratch/dev/node && ! clean_up && [ -e $scratch/dev/node ] &&
        umount $scratch/dev && clean_up && [ ! -e $scratch ]"""], capture_output=True, text=True)
    assert run.returncode == 0 and "still mounted" in run.stderr, run.stderr
