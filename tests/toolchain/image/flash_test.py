# SPDX-License-Identifier: Apache-2.0
"""voltlap flash, with programs in place of the ones that write."""
import os
import shlex

import pytest
from image_tools import tool

BOARD = "stm32f407"


def path_with(folder, *programs, code=0):
    """A PATH of the system's folders with programs that note what they are called with, and none that write else."""
    for name in programs:
        path = folder / name
        path.write_text(f'#!/bin/sh\necho "{name} $@" >>{shlex.quote(str(folder / "calls"))}\nexit {code}\n')
        path.chmod(0o755)
    return {**os.environ, "PATH": f"{folder}:{os.environ['PATH']}"}


@pytest.fixture
def image(image_of):
    return image_of("both_nodes_stm32f4")


CALLS = {"openocd": "verify reset exit", "st-flash": "0x08000000", "probe-rs": "--chip STM32F407VGTx"}


@pytest.mark.parametrize("name", CALLS)
def test_the_tool_is_called_with_the_image(tmp_path, image, name):
    result = tool("flash.py", image, "--board", BOARD, "--tool", name, env=path_with(tmp_path, name))
    assert result.returncode == 0, result.stderr
    calls = (tmp_path / "calls").read_text()
    assert CALLS[name] in calls and str(image.with_suffix("")) in calls
    assert "both_nodes_stm32f4" in result.stdout and "at most 144 cells" in result.stdout


def test_the_board_with_the_g4_has_its_image_and_its_chip(tmp_path, image_of):
    for name, words in (("openocd", "target/stm32g4x.cfg"), ("probe-rs", "--chip STM32G474RETx")):
        result = tool("flash.py", image_of("both_nodes_stm32g4"), "--board", "stm32g474", "--tool", name,
                      env=path_with(tmp_path, name))
        assert result.returncode == 0, result.stderr
        assert words in (tmp_path / "calls").read_text() and "both_nodes_stm32g4" in result.stdout


def test_a_dry_run_calls_nothing(tmp_path, image):
    result = tool("flash.py", image, "--dry-run", env=path_with(tmp_path, "openocd", "st-flash", "probe-rs"))
    assert result.returncode == 0 and "openocd" in result.stdout and not (tmp_path / "calls").exists()


def test_a_tool_that_fails_is_told(tmp_path, image):
    result = tool("flash.py", image, "--tool", "openocd", env=path_with(tmp_path, "openocd", code=7))
    assert result.returncode == 3 and "exit code 7" in result.stderr and "probe" in result.stderr


def test_a_missing_tool_is_told_with_its_package(tmp_path, image):
    result = tool("flash.py", image, env={**os.environ, "PATH": str(tmp_path)})
    assert result.returncode == 4
    assert all(word in result.stderr for word in ("apt-get install openocd", "stlink-tools", "probe.rs"))


def test_an_image_of_another_board_is_refused(image_of):
    result = tool("flash.py", image_of("bms_node"), "--board", BOARD, "--dry-run")
    assert result.returncode == 2 and "0x00000000" in result.stderr and "0x08000000" in result.stderr


def test_what_is_no_image_is_refused(tmp_path):
    (tmp_path / "x.elf").write_bytes(b"\x7fELF\x01\x01" + bytes(60))
    (tmp_path / "y.elf").write_text("text")
    for name, words in (("x.elf", "no mark"), ("y.elf", "no 32-bit"), ("z.elf", "cannot be read")):
        result = tool("flash.py", tmp_path / name, "--dry-run")
        assert result.returncode == 2 and words in result.stderr


def test_the_emulated_board_is_run_and_not_written(image_of):
    result = tool("flash.py", image_of("driven_by_plant"), "--board", "mps2-an386")
    assert result.returncode == 0 and "--ecu qemu" in result.stdout


def test_help_names_every_board():
    text = tool("flash.py", "--help").stdout
    assert "stm32f407" in text and "mps2-an386" in text and "Exit codes" in text


OURS = 'base = "vtm16e"\nname = "ours"\n[battery]\ncells_in_series = {}\n'


@pytest.fixture
def ours(tmp_path):
    path = tmp_path / "ours.toml"
    path.write_text(OURS.format(20))
    return path


def test_no_car_is_taken_that_was_not_named():
    result = tool("flash.py", "--board", BOARD, "--dry-run")
    assert result.returncode == 2 and "--vehicle" in result.stderr and not result.stdout


def test_it_says_whose_configuration_it_writes_before_it_writes(tmp_path, ours):
    result = tool("flash.py", "--vehicle", ours, "--cells", 24, "--dry-run")
    assert result.returncode == 0, result.stderr
    told, command = result.stdout.splitlines()[1:]
    assert all(word in told for word in ("of ours", "20 cells in series", "configuration ", str(ours)))
    assert "openocd" in command or "st-flash" in command or "probe-rs" in command


def test_an_image_of_another_car_is_refused(image, ours):
    result = tool("flash.py", image, "--vehicle", ours, "--dry-run")
    assert result.returncode == 2 and not result.stdout
    assert all(word in result.stderr for word in ("of vtm16e, 24 cells", "one of ours", "20 cells"))
    result = tool("flash.py", image, "--vehicle", "vtm16e", "--dry-run")
    assert result.returncode == 0 and "of vtm16e, 24 cells in series" in result.stdout


def test_an_image_with_memory_for_other_cells_is_refused(image):
    result = tool("flash.py", image, "--cells", 24, "--dry-run")
    assert result.returncode == 2 and "144 cells" in result.stderr and "--cells" in result.stderr


def test_an_image_that_does_not_say_whose_it_is_is_refused(tmp_path, image):
    (tmp_path / "x.elf").write_bytes(image.read_bytes().replace(b"VTL2", b"VTL1", 1))
    result = tool("flash.py", tmp_path / "x.elf", "--dry-run")
    assert result.returncode == 2 and "whose configuration" in result.stderr and "./voltlap image" in result.stderr
