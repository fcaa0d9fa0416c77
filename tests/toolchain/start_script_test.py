# SPDX-License-Identifier: Apache-2.0
"""The start script on machines that lack something, played by stand-ins for dpkg-query, id and sudo."""
import os
import pathlib
import shutil
import subprocess

import pytest

PROJECT = pathlib.Path(__file__).resolve().parents[2]


@pytest.fixture
def machine(tmp_path):
    """A copy of the script in an empty project, and a PATH whose dpkg knows no package."""
    project, tools = tmp_path / "project", tmp_path / "tools"
    project.mkdir()
    tools.mkdir()
    shutil.copy(PROJECT / "voltlap", project)
    shutil.copytree(PROJECT / "toolchain", project / "toolchain")
    for name in ("bash", "cat", "dirname", "flock", "mkdir", "readlink", "sed", "tr"):
        (tools / name).symlink_to(shutil.which(name))
    (tools / "env").symlink_to(shutil.which("env"))
    stand_in(tools, "dpkg-query", "exit 1")
    return project, tools


def stand_in(tools, name, body):
    path = tools / name
    path.write_text(f"#!{shutil.which('bash')}\n{body}\n")
    path.chmod(0o755)


def start(machine, *arguments, **environment):
    project, tools = machine
    clean = {key: value for key, value in os.environ.items() if key != "CI"}
    return subprocess.run([project / "voltlap", *arguments], env={**clean, "PATH": str(tools), **environment},
                          stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=30)


def test_no_argument_lists_the_commands():
    run = subprocess.run([PROJECT / "voltlap"], capture_output=True, text=True)
    assert run.returncode == 0
    assert all(f"./voltlap {command}" in run.stdout for command in ("endurance", "lap", "list", "test", "build"))


def test_unknown_command_is_refused_before_anything_is_installed(machine):
    run = start(machine, "race")
    assert run.returncode == 2
    assert '"race"' in run.stderr
    assert not (machine[0] / "build").exists()


def test_user_without_root_and_sudo_is_given_the_line_and_code_4(machine):
    stand_in(machine[1], "id", "echo 1000")
    run = start(machine, "endurance", "--yes")
    assert run.returncode == 4
    assert "apt-get install -y --no-install-recommends" in run.stdout and "libcli11-dev" in run.stdout
    assert "gcc-arm-none-eabi" not in run.stdout


def test_tests_need_the_cross_compiler_too(machine):
    stand_in(machine[1], "id", "echo 1000")
    stand_in(machine[1], "dpkg-query",
             'for name in "${@:3}"; do case $name in *arm*|cpputest) ;; *) echo "$name installed";; esac; done')
    run = start(machine, "test", "--yes")
    assert run.returncode == 4
    assert "gcc-arm-none-eabi" in run.stdout and "cmake" not in run.stdout


def test_nothing_is_installed_without_consent(machine):
    stand_in(machine[1], "id", "echo 0")
    stand_in(machine[1], "apt-get", 'echo called >"$0.log"')
    run = start(machine, "endurance")
    assert run.returncode == 4
    assert not (machine[1] / "apt-get.log").exists()


def test_consent_in_advance_installs_what_is_missing(machine):
    stand_in(machine[1], "id", "echo 0")
    stand_in(machine[1], "apt-get", 'echo "$@" >>"$0.log"; [ "$1" = update ]')
    stand_in(machine[1], "tail", "exit 0")
    run = start(machine, "endurance", CI="true")
    assert run.returncode == 4  # the stand-in's installation fails, and the script says how to do it by hand
    log = (machine[1] / "apt-get.log").read_text().splitlines()
    assert log[0].startswith("update") and log[1].startswith("install -y") and "libtomlplusplus-dev" in log[1]
    assert "by hand" in run.stderr
