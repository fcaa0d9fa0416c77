# SPDX-License-Identifier: Apache-2.0
"""An emulated Cortex-M4 drives a lap with the frames of the run in one process, and what goes wrong is said."""
import json
import os
import pathlib
import shutil
import signal
import subprocess
import time

import pytest
from image_tools import VOLTLAP, tool

pytestmark = pytest.mark.skipif(shutil.which("qemu-system-arm") is None, reason="qemu-system-arm is not installed")
FILTERED = ("--set", "bms.soc_method=ekf", "--set", "bms.limit_method=ahead")
MANY = ("--set", "battery.cells_in_series=96", "--set", "sensors.temperature_count=36")
COURSE = "time_s,speed_mps\n0,0\n2,8\n4,12\n5,3\n6,0\n"  # 6 s behind the start-up


def endurance(*arguments, **settings):
    return subprocess.run([VOLTLAP, "endurance", *map(str, arguments)], capture_output=True, text=True, **settings)


def run(tmp_path, *arguments):
    out = tmp_path / "run.json"
    result = endurance(*arguments, "--json", out)
    assert result.returncode == 0, result.stdout + result.stderr
    return json.loads(out.read_text()), result.stdout


@pytest.fixture
def course(tmp_path):
    path = tmp_path / "course.csv"
    path.write_text(COURSE)
    return path


def test_a_lap_on_the_emulated_board_is_the_lap_in_one_process(tmp_path, image_of):
    image_of("driven_by_plant")  # where `--ecu qemu` looks for it
    inside, _ = run(tmp_path, "--laps", 1, *FILTERED)
    emulated, text = run(tmp_path, "--laps", 1, *FILTERED, "--ecu", "qemu")
    assert emulated["trace_hash"] == inside["trace_hash"]
    assert emulated["ecu"]["where"] == "qemu" and inside["ecu"] is None
    assert "on an emulated Cortex-M4 (mps2-an386)" in text
    assert 0 < emulated["ecu"]["stack_used_bytes"] < emulated["ecu"]["stack_size_bytes"] == 4096


def test_any_car_runs_on_the_same_image(tmp_path, course, image_of):
    image = image_of("driven_by_plant")
    for settings in (MANY, ("--vehicle", "vtm17e"), ("--set", "bms.soc_method=none")):
        inside, _ = run(tmp_path, "--drive", course, *settings)
        emulated, _ = run(tmp_path, "--drive", course, *settings, "--ecu", "qemu", "--image", image)
        assert emulated["trace_hash"] == inside["trace_hash"], settings


@pytest.mark.parametrize("name, cells", [("bms_node", 24), ("master_node", 24), ("both_nodes", None),
                                         ("both_nodes", 24)])
def test_each_example_sends_the_frames_of_the_run_in_one_process(tmp_path, course, image_of, name, cells):
    """With the configuration in its flash; a node that it does not have is stepped beside it."""
    inside, _ = run(tmp_path, "--drive", course)
    emulated, text = run(tmp_path, "--drive", course, "--ecu", "qemu", "--image", image_of(name, cells))
    assert emulated["trace_hash"] == inside["trace_hash"]
    assert "with the configuration it was built with" in text


def test_an_image_with_the_configuration_of_another_car_is_refused(course, image_of):
    for name in ("bms_node", "master_node", "both_nodes"):
        result = endurance("--drive", course, "--ecu", "qemu", "--image", image_of(name),
                           *MANY, "--set", "master.pedal_release_level=0.04")
        assert result.returncode == 2, name
        assert "configuration of 'vtm16e'" in result.stderr and "./voltlap image" in result.stderr
    result = endurance("--drive", course, "--ecu", "qemu", "--image", image_of("bms_node"),
                       "--set", "battery.cells_in_series=20")
    assert "24 cells in series" in result.stderr and "20 cells in series" in result.stderr


def test_counting_instructions_changes_no_frame_and_is_repeatable(tmp_path, course, image_of):
    image = image_of("driven_by_plant", 24)
    counted = [run(tmp_path, "--drive", course, *FILTERED, "--ecu", "qemu", "--image", image, "--count-instructions")[0]
               for _ in range(2)]
    inside, _ = run(tmp_path, "--drive", course, *FILTERED)
    assert counted[0]["trace_hash"] == inside["trace_hash"]
    assert counted[0]["ecu"] == counted[1]["ecu"]
    costs = counted[0]["ecu"]["instructions_per_step"]
    assert 5_000 < costs["bms"]["mean"] < costs["bms"]["worst"] and costs["both"]["worst"] > costs["bms"]["worst"]


def test_more_cells_than_the_image_has_memory_for_are_refused(course, image_of):
    result = endurance("--drive", course, *MANY, "--ecu", "qemu", "--image", image_of("driven_by_plant", 24))
    assert result.returncode == 2
    assert "memory for 24 cells" in result.stderr and "./voltlap image --cells 96" in result.stderr


def test_an_image_of_other_sources_is_refused(tmp_path, course, image_of):
    image = image_of("driven_by_plant")
    data = image.read_bytes()
    at = data.index(b"VTL2")
    (tmp_path / "other.elf").write_bytes(data[:at + 8] + b"\0\0\0\0" + data[at + 12:])
    result = endurance("--drive", course, "--ecu", "qemu", "--image", tmp_path / "other.elf")
    assert result.returncode == 2 and "layout" in result.stderr and "./voltlap image" in result.stderr


def test_an_image_of_other_firmware_is_noted(tmp_path, course, image_of):
    """The built one is refused then (`--ecu qemu` promises the same frames); a named one may be an earlier one."""
    data = image_of("driven_by_plant").read_bytes()
    at = data.index(b"VTL2")
    (tmp_path / "other.elf").write_bytes(data[:at + 12] + b"\0\0\0\0" + data[at + 16:])
    assert tool("image_crc.py", tmp_path / "other.elf").returncode == 0  # its value is its own
    _, text = run(tmp_path, "--drive", course, "--ecu", "qemu", "--image", tmp_path / "other.elf")
    assert "of other firmware than this program's" in text


def test_what_is_no_image_is_refused(tmp_path, course):
    (tmp_path / "x.elf").write_text("no image")
    (tmp_path / "z.elf").write_bytes(b"\x7fELF\x01\x01" + bytes(60))
    for name in ("x.elf", "z.elf"):
        result = endurance("--drive", course, "--ecu", "qemu", "--image", tmp_path / name)
        assert result.returncode == 2 and "no ELF for a Cortex-M" in result.stderr and name in result.stderr
        assert "R00=" not in result.stderr and len(result.stderr.splitlines()) < 5
    result = endurance("--drive", course, "--ecu", "qemu", "--image", tmp_path / "y.elf")
    assert result.returncode == 2 and "no file" in result.stderr and "y.elf" in result.stderr


def test_without_qemu_the_package_is_named(tmp_path, course, image_of):
    image_of("driven_by_plant")
    result = endurance("--drive", course, "--ecu", "qemu", env={**os.environ, "PATH": str(tmp_path)})
    assert result.returncode == 2 and "apt-get install qemu-system-arm" in result.stderr


def test_flags_that_contradict_each_other_are_refused(course):
    assert endurance("--drive", course, "--count-instructions").returncode == 2
    result = endurance("--drive", course, "--ecu", "process", "--count-instructions")
    assert result.returncode == 2 and "--ecu qemu" in result.stderr
    assert endurance("--drive", course, "--ecu", "qemu", "--bus", "vcan0").returncode == 2


def emulators_of(process):
    """Process numbers of the emulators that it has started."""
    children = pathlib.Path(f"/proc/{process.pid}/task/{process.pid}/children")
    try:
        return [int(word) for word in children.read_text().split()]
    except FileNotFoundError:
        return []


def started(image, *arguments):
    process = subprocess.Popen([VOLTLAP, "endurance", "--ecu", "qemu", "--image", str(image), *map(str, arguments)],
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    deadline = time.monotonic() + 20.0
    while not emulators_of(process) and time.monotonic() < deadline:
        time.sleep(0.01)
    time.sleep(0.3)
    emulator = emulators_of(process)
    assert len(emulator) == 1
    return process, emulator[0]


def is_gone(number):
    for _ in range(200):
        if not pathlib.Path(f"/proc/{number}").exists():
            return True
        time.sleep(0.02)
    return False


@pytest.mark.parametrize("number, code", [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_an_interrupt_leaves_no_emulator_and_no_file(tmp_path, image_of, number, code):
    process, emulator = started(image_of("driven_by_plant"), "--json", tmp_path / "run.json")
    process.send_signal(number)
    _, errors = process.communicate(timeout=20)
    assert process.returncode == code and "no result file was written" in errors
    assert is_gone(emulator) and not (tmp_path / "run.json").exists()


def test_a_parent_that_is_killed_leaves_no_emulator(image_of):
    process, emulator = started(image_of("driven_by_plant"))
    process.kill()
    process.communicate(timeout=20)
    assert is_gone(emulator)


def test_an_emulator_that_dies_is_told_with_the_time(tmp_path, image_of):
    process, emulator = started(image_of("driven_by_plant"), "--json", tmp_path / "run.json")
    os.kill(emulator, signal.SIGKILL)
    output, _ = process.communicate(timeout=20)
    assert process.returncode == 3
    assert "was killed by signal 9" in output and "after power-on" in output


def test_an_emulator_that_hangs_is_told(tmp_path, image_of):
    process, emulator = started(image_of("driven_by_plant"), "--laps", 27)
    os.kill(emulator, signal.SIGSTOP)
    output, _ = process.communicate(timeout=40)
    assert process.returncode == 3 and "has not answered for 10 s" in output and is_gone(emulator)
