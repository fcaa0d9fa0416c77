# SPDX-License-Identifier: Apache-2.0
"""voltlap image as its users meet it."""
import os
import re
import stat
import subprocess
import sys

import pytest
from image_tools import ROOT, VOLTLAP, tool

import image_build
import image_car

PROGRAM = "image.py"


def test_it_builds_and_prints_the_sizes(kind_of):
    kind_of(24)
    result = tool(PROGRAM, "--cells", 24)
    assert result.returncode == 0, result.stderr
    rows = dict(re.findall(r"^(\w+) +(\d+) ", result.stdout, re.MULTILINE))
    assert rows.keys() == set(image_build.EXAMPLES)
    binary = image_build.Kind(cells=24).image("bms_node").with_suffix(".bin")
    assert 0 <= binary.stat().st_size - int(rows["bms_node"]) < 16  # what aligns the sections


@pytest.mark.parametrize("board", image_build.BOARDS)
def test_the_images_of_a_part_are_built_for_its_memory(kind_of, board):
    kind_of()
    result = tool(PROGRAM, "--board", board)
    assert result.returncode == 0, result.stderr
    rows = dict(re.findall(r"^(\w+) +(\d+) ", result.stdout, re.MULTILINE))
    assert rows.keys() == {f"{name}_{board}" for name in image_build.BOARD_EXAMPLES}
    assert all(20_000 < int(flash) < 256 * 1024 for flash in rows.values())


def test_a_part_with_another_processor_is_refused():
    result = tool(PROGRAM, "--board", "stm32g4", "--cpu", "cortex-m7")
    assert result.returncode == 2 and "leave out --cpu" in result.stderr


@pytest.mark.parametrize("cells", ["0", "145", "many"])
def test_cells_that_no_frame_carries_are_refused(cells):
    result = tool(PROGRAM, "--cells", cells)
    assert result.returncode == 2 and "--cells" in result.stderr


def test_a_car_that_does_not_exist_is_said_by_the_program_that_reads_it():
    result = tool(PROGRAM, "--vehicle", "no_such_car")
    assert result.returncode == 2 and "no_such_car" in result.stderr and "expected" in result.stderr
    assert not (ROOT / "build" / "images_of" / "no_such_car").exists()


def test_a_missing_compiler_is_said_with_its_package(tmp_path):
    result = tool(PROGRAM, env={**os.environ, "PATH": str(tmp_path)})
    assert result.returncode == 4 and "apt-get install gcc-arm-none-eabi" in result.stderr


def test_a_build_that_fails_says_why(tmp_path):
    fake = tmp_path / "cmake"
    fake.write_text("#!/bin/sh\necho the reason >&2\nexit 1\n")
    fake.chmod(fake.stat().st_mode | stat.S_IXUSR)
    result = tool(PROGRAM, env={**os.environ, "PATH": f"{tmp_path}:{os.environ['PATH']}"})
    assert result.returncode == 5 and "the reason" in result.stderr


def test_the_shipped_headers_are_those_of_the_example_car(tmp_path):
    """firmware/examples/pack_config.hpp and master_config.hpp; this line makes them again."""
    subprocess.run([VOLTLAP, "firmware-tables", "--out", tmp_path / "pack_config.hpp", "--master-out",
                    tmp_path / "master_config.hpp"], check=True, stdout=subprocess.DEVNULL)
    for name in ("pack_config.hpp", "master_config.hpp"):
        shipped = ROOT / "firmware" / "examples" / name
        assert (tmp_path / name).read_text() == shipped.read_text(), f"{VOLTLAP} firmware-tables makes it again"


def test_a_smaller_capacity_takes_less_memory_and_the_same_flash(kind_of):
    small, all_cells = (image_build.size_of(kind_of(cells).image("bms_node")) for cells in (24, None))
    assert small.ram < all_cells.ram - 30_000
    assert abs(small.flash - all_cells.flash) < 1_000


@pytest.mark.parametrize("value", ["0", "145", "x", "024"])
def test_a_capacity_that_no_frame_carries_is_refused_by_cmake(tmp_path, value):
    done = subprocess.run(["cmake", "-S", ROOT, "-B", tmp_path, "-G", "Ninja",
                           f"--toolchain={ROOT}/toolchain/arm-none-eabi.cmake", "-DVOLTLAP_TESTS=OFF",
                           f"-DVOLTLAP_PYTHON={sys.executable}", f"-DVOLTLAP_CELLS_MAX={value}"],
                          capture_output=True, text=True)
    assert done.returncode != 0 and "1 to 144" in " ".join(done.stderr.split())


def test_two_cars_of_one_name_have_images_in_two_folders(tmp_path):
    kinds = []
    for folder, cells in (("a", 20), ("b", 21)):
        (tmp_path / folder).mkdir()
        car = tmp_path / folder / "car.toml"
        car.write_text(f'base = "vtm16e"\nname = "car"\n[battery]\ncells_in_series = {cells}\n')
        kinds.append(image_car.kind_of(image_car.car_of(str(car), [])))
    assert kinds[0].folder != kinds[1].folder and kinds[0].config != kinds[1].config
    again = image_car.kind_of(image_car.car_of(str(tmp_path / "a" / "car.toml"), []))
    assert again.folder == kinds[0].folder
    other = image_car.kind_of(image_car.car_of(str(tmp_path / "a" / "car.toml"), ["vehicle.mass_kg=260"]))
    assert other.folder != kinds[0].folder


def test_settings_that_read_alike_are_two_cars():
    assert image_car.label_of("vtm16e", ["a.b=1.5"]) != image_car.label_of("vtm16e", ["a_b=1_5"])


def test_too_few_cells_are_told_before_anything_is_built(tmp_path):
    result = tool(PROGRAM, "--cells", 12, env={**os.environ, "PATH": str(tmp_path)})
    assert result.returncode == 2 and not result.stdout
    assert all(word in result.stderr for word in ("--cells 12", "24 in series", "vtm16e"))


def test_the_number_of_a_configuration_is_of_its_values_alone(tmp_path):
    cars = {}
    for name, settings in (("as_it_is", []), ("heavier", ["vehicle.mass_kg=300"]),
                           ("lower", ["bms.cell_voltage_min_v=2.6"]), ("pedal", ["master.pedal_release_level=0.04"])):
        cars[name] = image_car.car_of("vtm16e", settings)
    same, heavier, lower, pedal = cars.values()
    assert (heavier.bms_number, heavier.master_number) == (same.bms_number, same.master_number)
    assert lower.bms_number != same.bms_number and lower.master_number == same.master_number
    assert pedal.bms_number == same.bms_number and pedal.master_number != same.master_number
    example = image_car.car_of(None, [])
    assert (example.bms_number, example.master_number) == (same.bms_number, same.master_number)
