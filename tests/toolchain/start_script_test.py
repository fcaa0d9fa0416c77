# SPDX-License-Identifier: Apache-2.0
"""The start script on machines of every kind."""
import os
import pty
import re
import signal
import subprocess
import threading
import time

import pytest
from copies import HANG_S, PROJECT, hear_interruptions
from machine import Machine

SCRIPT = PROJECT / "voltlap"
NOBODY = 65534
# name and how it runs, from the table of the script
COMMANDS = dict(re.findall(r"^  row ([a-z-]+) +'([^']*)'", SCRIPT.read_text(), re.MULTILINE))


@pytest.fixture
def machine(tmp_path):
    return Machine(tmp_path)


# ---- commands and help ----

def test_no_argument_lists_the_commands():
    run = subprocess.run([SCRIPT], capture_output=True, text=True)
    assert run.returncode == 0
    assert {"endurance", "lap", "list", "test", "build"} <= set(COMMANDS)
    listed = re.findall(r"^  \./voltlap ([a-z-]+) ", run.stdout, re.MULTILINE)
    assert [*dict.fromkeys(listed)] == [*COMMANDS]


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_a_help_that_names_it_and_the_exit_codes(command):
    run = subprocess.run([SCRIPT, command, "--help"], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    assert f"voltlap {command}" in run.stdout and "--yes" in run.stdout and "Exit codes: 0 done" in run.stdout


def test_help_of_a_command_within_a_command_is_its_own():
    run = subprocess.run([SCRIPT, "track", "import", "--help"], capture_output=True, text=True)
    assert run.returncode == 0 and "--unit" in run.stdout and "--yes" in run.stdout


@pytest.mark.parametrize("command", [name for name in COMMANDS if not COMMANDS[name].startswith(("cli", "program"))])
def test_help_of_what_is_not_built_builds_nothing(machine, command):
    assert machine.start(command, "--help").returncode == 0
    assert not (machine.project / "build").exists()


def test_help_of_a_program_builds_it_once_and_says_so(machine):
    first, then = machine.start("lap", "--help", "--yes"), machine.start("lap", "--help")
    assert "program: lap --help" in first.stdout and "is built first" in first.stderr
    assert "program: lap --help" in then.stdout and not then.stderr


def test_version_needs_nothing(machine):
    assert re.fullmatch(r"voltlap \d+\.\d+\.\d+\n", machine.start("--version").stdout)
    assert not (machine.project / "build").exists()


def test_unknown_command_is_refused_before_anything_is_installed(machine):
    run = machine.start("race")
    assert run.returncode == 2
    assert '"race"' in run.stderr and "./voltlap --help" in run.stderr
    assert not (machine.project / "build").exists()


def test_arguments_arrive_as_they_were_given(machine):
    run = machine.start("endurance", "--laps", "2", "--yes", "--json", "a file.json")
    assert run.stdout == "program: endurance --laps 2 --json a file.json\n"


@pytest.mark.parametrize("flags", [["--ecu", "qemu"], ["--laps", "1", "--ecu=qemu"]])
def test_the_image_of_the_emulated_board_is_built_before_it_is_driven(machine, flags):
    run = machine.start("endurance", *flags, "--yes")
    assert run.stdout == f"program: endurance {' '.join(flags)}\n"
    assert [call for call in machine.called("python") if "toolchain/image.py" in call]


@pytest.mark.parametrize("flags", [["--ecu", "process"], ["--ecu", "qemu", "--image", "ours.elf"], ["--set", "qemu"]])
def test_no_image_is_built_that_is_not_needed(machine, flags):
    assert machine.start("endurance", *flags, "--yes").returncode == 0
    assert not [call for call in machine.called("python") if "toolchain/image.py" in call]


@pytest.fixture
def wrapper(machine):
    """Instead of a kernel with CAN interfaces: says that it was called, and runs nothing."""
    (machine.project / "toolchain" / "vcan" / "with_vcan.py").write_text("print('wrapper')\n")


def test_a_command_behind_the_wrapper_is_set_up_before_the_wrapper_starts(machine, wrapper):
    run = machine.start("with-vcan", "--private", "./voltlap", "lap", folder=machine.project, CI="true")
    assert run.stdout == "wrapper\n", run.stderr
    calls = machine.calls.read_text()
    assert 0 < calls.find("ninja") < calls.find("with_vcan.py --private ./voltlap lap")
    assert 0 < calls.find("run.txt") < calls.find("with_vcan.py")


def test_another_command_behind_the_wrapper_sets_up_nothing(machine, wrapper):
    run = machine.start("with-vcan", "echo", "lap", CI="true")
    assert run.stdout == "wrapper\n", run.stderr
    assert not machine.called("ninja")


# ---- packages ----

def test_user_without_root_and_sudo_is_given_the_line_and_code_4(machine):
    machine.is_root(False)
    machine.knows_packages(but=["libcli11-dev", "g++"])
    run = machine.start("endurance", "--yes")
    assert run.returncode == 4
    assert run.stdout.strip() == ("apt-get update && apt-get install -y --no-install-recommends g++ libcli11-dev")
    assert not machine.called("ninja")


def test_user_with_sudo_installs_through_it(machine):
    machine.is_root(False)
    machine.knows_packages(but=["g++"])
    machine.stand_in("sudo", '[ "$1" = -n ] && shift; exec "$@"')
    machine.distributes()
    assert machine.start("lap", "--yes").returncode == 0
    assert [call.split()[:5] for call in machine.called("sudo")] == [
        ["-n", "env", "DEBIAN_FRONTEND=noninteractive", "apt-get", "update"],
        ["-n", "env", "DEBIAN_FRONTEND=noninteractive", "apt-get", "install"]]


def test_run_asks_for_no_package_of_the_tests(machine):
    machine.knows_packages(but=["cpputest", "*arm*", "chromium"])
    assert machine.start("endurance", "--yes").returncode == 0
    assert not [call for call in machine.called("python") if "test.txt" in call]


def test_who_drives_installs_and_builds_nothing_that_learns(machine):
    machine.is_root(False)
    machine.knows_packages(but=["libceres-dev"])
    assert machine.start("endurance", "--yes").returncode == 0
    calls = machine.calls.read_text()
    assert "-DVOLTLAP_LEARN=OFF" in calls and "voltlap-cli" in calls and "voltlap-learn" not in calls
    run = machine.start("identify", "--yes")
    assert run.returncode == 4 and "libceres-dev" in run.stdout


@pytest.mark.parametrize("arguments, target", [(["cells"], "voltlap-cli"), (["causes"], "voltlap-explain")])
def test_a_row_may_be_of_a_command_and_its_first_argument(machine, arguments, target):
    machine.start("list", *arguments, "--yes")
    assert [call.split()[-1] for call in machine.called("ninja")] == [target]


def test_tests_need_the_cross_compiler_too(machine):
    machine.is_root(False)
    machine.knows_packages(but=["*arm*"])
    run = machine.start("test", "--yes")
    assert run.returncode == 4
    assert "gcc-arm-none-eabi" in run.stdout and "cmake" not in run.stdout


def test_nothing_is_installed_without_consent(machine):
    machine.knows_packages(but=["g++"])
    run = machine.start("endurance")
    assert run.returncode == 4
    assert "g++" in run.stderr and "cantools==" in run.stderr and "--yes" in run.stderr
    assert not machine.called("apt-get")
    assert not (machine.project / "build" / "venv").exists()


@pytest.mark.parametrize("answer, code", [("n", 4), ("y", 0), ("", 0)])
def test_one_question_covers_packages_and_python(machine, answer, code):
    machine.knows_packages(but=["g++"])
    machine.distributes()
    ours, terminal = pty.openpty()
    os.write(ours, (answer + "\n").encode())
    run = subprocess.run([machine.project / "voltlap", "lap"], env=machine.environment(), stdin=terminal,
                         capture_output=True, text=True, timeout=HANG_S)
    os.close(ours)
    os.close(terminal)
    assert run.returncode == code
    assert run.stderr.count("[Y/n]") == 1


@pytest.mark.parametrize("is_root", [True, False])
def test_optional_package_that_the_distribution_lacks_is_done_without(machine, is_root):
    machine.knows_packages(but=["libtomlplusplus-dev"])
    machine.distributes(but=["libtomlplusplus-dev"])
    if not is_root:  # an ordinary user, after somebody else's update
        machine.is_root(False)
        subprocess.run([machine.tools / "apt-get", "update"], env=machine.environment(), check=True)
    run = machine.start("lap", "--yes")
    assert run.returncode == 0 and "no libtomlplusplus-dev; done without" in run.stderr
    assert not [call for call in machine.called("apt-get") if call.startswith("install")]
    assert machine.start("lap").stderr == "" and not machine.called("apt-cache")


def test_optional_package_that_the_distribution_has_is_installed(machine):
    machine.knows_packages(but=["libtomlplusplus-dev"])
    machine.distributes()
    assert machine.start("lap", "--yes").returncode == 0
    assert any("libtomlplusplus-dev" in call for call in machine.called("apt-get"))


def test_needed_package_that_the_distribution_lacks_is_an_error(machine):
    machine.knows_packages(but=["g++"])
    machine.distributes(but=["g++"])
    machine.stand_in("apt-get", '[ "$1" = update ]')
    assert machine.start("lap", "--yes").returncode == 4


COUNTED = re.compile(rb"build/venv \([1-9][0-9]* s\)")


def test_seconds_count_up_on_a_terminal_while_one_waits(machine):
    seen = machine.tools / "seen"
    machine.makes_environments(pip=f'until [ -e "{seen}" ]; do sleep 0.1; done')
    ours, terminal = pty.openpty()
    run = subprocess.Popen([machine.project / "voltlap", "lap", "--yes"], env=machine.environment(),
                           stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=terminal, text=True)
    os.close(terminal)
    shown = b""
    try:
        while part := os.read(ours, 4096):
            shown += part
            if COUNTED.search(shown):  # a busy machine may skip a second
                seen.touch()
    except OSError:  # nobody writes any more
        pass
    os.close(ours)
    assert run.communicate(timeout=HANG_S)[0] == "program: lap\n"
    assert b"setting up Python packages in build/venv (0 s)" in shown and COUNTED.search(shown)
    assert b"Terminated" not in shown


def test_failed_installation_says_how_to_do_it_by_hand(machine):
    machine.knows_packages(but=["libtomlplusplus-dev"])
    machine.stand_in("apt-get", 'echo "E: no network"; [ "$1" = update ]')
    run = machine.start("endurance", CI="true")
    assert run.returncode == 4
    calls = machine.called("apt-get")
    assert calls[0].startswith("update") and calls[1].startswith("install -y") and "libtomlplusplus-dev" in calls[1]
    assert "E: no network" in run.stderr and "by hand" in run.stderr and "libtomlplusplus-dev" in run.stdout


def test_python_packages_without_network_end_with_the_remedy(machine):
    machine.makes_environments(pip="echo no index >&2; exit 1")
    run = machine.start("lap", "--yes")
    assert run.returncode == 4
    assert "no index" in run.stderr and "VOLTLAP_CODECS" in run.stderr
    machine.makes_environments()
    assert machine.start("lap", "--yes").returncode == 0


# ---- later starts ----

def test_later_start_installs_and_configures_nothing(machine):
    assert machine.start("lap", "--yes").returncode == 0
    assert machine.called("cmake")
    run = machine.start("lap")
    assert (run.returncode, run.stderr) == (0, "")
    assert not machine.called("cmake") and not machine.called("python3")


def test_start_of_a_built_program_takes_less_than_half_a_second():
    """This very project, with its real tools; time of the CPU, so that a busy machine does not fail."""
    def once():
        before = os.times()
        subprocess.run([SCRIPT, "list", "cells"], check=True, capture_output=True, env={**os.environ, "CI": "true"})
        after = os.times()
        return sum(after[2:4]) - sum(before[2:4])
    once()
    assert min(once() for _ in range(3)) < 0.5


def test_tests_after_a_run_add_their_packages_and_options(machine):
    machine.start("lap", "--yes")
    machine.start("build", "--yes")
    assert [call.split()[1:4] for call in machine.called("cmake")][-1:] == [
        ["default", "-DVOLTLAP_LEARN=ON", "-DVOLTLAP_TESTS=ON"]]
    machine.start("build")
    assert not machine.called("cmake")
    run = machine.start("lap")
    assert (run.returncode, run.stderr) == (0, "")


def test_changed_requirements_make_the_environment_anew(machine):
    machine.start("lap", "--yes")
    with (machine.project / "toolchain" / "requirements" / "run.txt").open("a") as file:
        file.write("bitstruct==8.19.0\n")
    run = machine.start("lap", "--yes")
    assert run.returncode == 0 and "bitstruct==8.19.0" in run.stderr
    assert machine.start("lap").stderr == ""


def test_environment_that_was_broken_off_is_made_anew(machine):
    machine.start("lap", "--yes")
    (machine.project / "build" / "venv" / "voltlap.record").unlink()
    assert "setting up Python" in machine.start("lap", "--yes").stderr


def test_environment_of_another_project_behind_a_link_is_left_alone(machine, tmp_path):
    other = tmp_path / "other"
    other.mkdir()
    (other / "kept").write_text("")
    (machine.project / "build").mkdir(exist_ok=True)
    venv = machine.project / "build" / "venv"
    venv.symlink_to(other)
    machine.start("lap", "--yes")
    assert (other / "kept").exists() and not venv.is_symlink()


def test_moved_project_is_built_anew(machine):
    machine.start("lap", "--yes")
    machine.called("cmake")
    machine.project = machine.project.rename(machine.project.with_name("elsewhere"))
    run = machine.start("lap", "--yes")
    assert run.returncode == 0
    assert "has moved" in run.stderr and "setting up Python" in run.stderr
    assert len(machine.called("cmake")) == 1


def test_start_through_a_link_and_from_elsewhere(machine, tmp_path):
    link = tmp_path / "link"
    link.symlink_to(machine.project / "voltlap")
    run = machine.start("lap", "--yes", script=link, folder="/")
    assert run.stdout == "program: lap\n"
    assert (machine.project / "build" / "venv").exists()


# ---- what goes wrong while building ----

def test_failed_build_shows_the_error_and_ends_with_5(machine):
    machine.builds("echo 'car.cpp:7: error: oops'; exit 1")
    run = machine.start("lap", "--yes")
    assert run.returncode == 5
    assert "car.cpp:7: error: oops" in run.stderr and str(machine.project / "build" / "build.log") in run.stderr


@pytest.mark.parametrize("line, remedy", [("cc1plus: error: No space left on device", "disk is full"),
                                          ("g++: fatal error: Killed signal terminated program", "out of memory")])
def test_machine_that_is_too_small_is_told_so(machine, line, remedy):
    machine.builds(f"echo '{line}'; exit 1")
    run = machine.start("lap", "--yes")
    assert run.returncode == 5 and remedy in run.stderr


def test_first_configuration_that_failed_is_repeated(machine):
    machine.stand_in("cmake", "mkdir -p build/default; : >build/default/CMakeCache.txt; echo CMake Error; exit 1")
    assert machine.start("lap", "--yes").returncode == 5
    machine.configures()
    assert machine.start("lap", "--yes").returncode == 0


def test_interrupted_build_goes_on_at_the_next_start(machine):
    machine.builds("sleep 10000")
    run = subprocess.Popen([machine.project / "voltlap", "lap", "--yes"], env=machine.environment(), text=True,
                           stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, start_new_session=True,
                           preexec_fn=hear_interruptions)
    while "ninja -C" not in machine.calls.read_text():
        assert run.poll() is None
        time.sleep(0.02)
    os.killpg(run.pid, signal.SIGINT)  # as a terminal does
    _, text = run.communicate(timeout=HANG_S)
    assert run.returncode == 130 and "interrupted" in text and "failed" not in text
    machine.builds()
    assert machine.start("lap").returncode == 0


def test_second_start_waits_for_the_first(machine):
    machine.start("lap", "--yes")
    machine.called("ninja")
    machine.builds('[ -f "$2/busy" ] && echo "both build" >>"$2/both"; : >"$2/busy"; sleep 1; rm "$2/busy"')
    starts = [threading.Thread(target=machine.start, args=("lap",)) for _ in range(2)]
    for thread in starts:
        thread.start()
    for thread in starts:
        thread.join()
    assert len(machine.called("ninja")) == 2
    assert not (machine.project / "build" / "default" / "both").exists()


@pytest.mark.skipif(os.getuid() != 0, reason="becoming another user needs root")
def test_folder_of_somebody_else_is_refused_with_the_remedy(machine, tmp_path):
    for folder in (tmp_path, *tmp_path.parents[:2]):  # pytest's folders are closed to others
        folder.chmod(0o755)
    run = machine.start("lap", "--yes", user=NOBODY)
    assert run.returncode == 4
    assert "cannot be written" in run.stderr and "Copy or clone" in run.stderr
