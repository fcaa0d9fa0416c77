# SPDX-License-Identifier: Apache-2.0
"""voltlap firmware-tables as its users meet it: a header that compiles where it will run, messages for bad cells."""
import os
import pathlib
import re
import shutil
import subprocess

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[3]
BUILD = pathlib.Path(os.environ["VOLTLAP_BUILD_DIR"])
CELL = ROOT / "plant_sim/data/cells/aesc_e5_2p.toml"
IMAGE = """#include "pack_config.hpp"
extern const voltlap::bms::Config pack;
const voltlap::bms::Config pack = voltlap::bms::kPackConfig;
"""
COMPILERS = {"host": ["c++"],
             "Cortex-M4": ["arm-none-eabi-g++", "-mcpu=cortex-m4", "-mthumb", "-ffreestanding", "-fno-exceptions",
                           "-fno-rtti"]}


def tables(*arguments, folder=None):
    return subprocess.run([BUILD / "bin" / "voltlap", "firmware-tables", *map(str, arguments)], cwd=folder,
                          capture_output=True, text=True, timeout=300)


def changed(folder, old, new, count=1):
    text = CELL.read_text()
    assert old in text
    (folder / "cell.toml").write_text(text.replace(old, new, count))
    return folder / "cell.toml"


@pytest.mark.parametrize("where", COMPILERS)
def test_header_is_a_constant_of_an_image(where, tmp_path):
    compiler = COMPILERS[where]
    if not shutil.which(compiler[0]):
        pytest.skip(f"{compiler[0]} is not installed")
    assert tables(CELL, "--out", tmp_path / "pack_config.hpp").returncode == 0
    (tmp_path / "image.cpp").write_text(IMAGE)
    codecs = BUILD / "can_dbc" / "generated"
    run = subprocess.run([*compiler, "-std=c++17", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O2", "-c",
                          "image.cpp", "-I", ".", "-I", ROOT / "firmware", "-I", codecs],
                         cwd=tmp_path, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    sections = subprocess.run(["objdump" if where == "host" else "arm-none-eabi-objdump", "-h", "image.o"],
                              cwd=tmp_path, capture_output=True, text=True).stdout
    size = {name: int(digits, 16) for name, digits in re.findall(r"\d+ (\.[\w.]+) +([0-9a-f]{8})", sections)}
    assert size.get(".text", 0) == 0 and ".init_array" not in size  # no code runs to build it
    assert any(name.startswith(".rodata") and length > 500 for name, length in size.items())


def test_same_cell_same_bytes_and_numbers_with_their_units(tmp_path):
    for name in ("a.hpp", "b.hpp"):
        assert tables(CELL, "--out", name, folder=tmp_path).returncode == 0
    text = (tmp_path / "a.hpp").read_text()
    assert text == (tmp_path / "b.hpp").read_text()
    assert str(tmp_path) not in text and "// 0.1 mV" in text and "// 55200" not in text
    assert "c.capacity_mah = 55200;" in text and "mAh of a parallel group" in text


def test_rounding_is_printed(tmp_path):
    run = tables(CELL)
    assert run.returncode == 0
    assert "rounded by at most 0.0" in run.stdout and "mV from the cell's curve" in run.stdout
    assert "nothing was written" in run.stdout


def test_header_may_go_to_standard_output():
    run = tables(CELL, "--out", "-")
    assert run.stdout.startswith("// The BMS's configuration") and "rounded" in run.stderr


def test_vehicle_and_settings_shape_the_pack(tmp_path):
    tables(CELL, "--set", "battery.cells_in_parallel=2", "--out", "two.hpp", folder=tmp_path)
    text = (tmp_path / "two.hpp").read_text()
    assert "c.capacity_mah = 110400;" in text
    assert "voltlap firmware-tables aesc_e5_2p.toml --set battery.cells_in_parallel=2 --out" in text


BAD = {
    "OCV that falls": (("polynomial_v = [3.00, 5.98", "polynomial_v = [3.00, -5.98"), "a voltage that falls"),
    "OCV that is flat": (("polynomial_v = [3.00, 5.98, -14.1, 15.2, -6.79, 0.88]", "polynomial_v = [3.6]"),
                         "so flat at SOC"),
    "capacity beyond the count": (("capacity_ah = 55.2 ", "capacity_ah = 5000"), "capacity_ah"),
    "resistance in kiloohm": (("value = [0.0012", "value = [120.0"), "r0.value"),
    "voltage limits crossed": (("voltage_min_v = 2.5 ", "voltage_min_v = 4.3"), "voltage_min_v"),
    "point missing": (("value = [0.0004, 0.0004", "value = [0.0004"), "r1.value"),
}


@pytest.mark.parametrize("bad", BAD)
def test_cell_that_does_not_fit_is_refused_by_name(bad, tmp_path):
    (old, new), words = BAD[bad]
    run = tables(changed(tmp_path, old, new), "--out", "x.hpp", folder=tmp_path)
    assert run.returncode == 2, run.stdout
    assert words in run.stderr and "expected" in run.stderr
    assert not (tmp_path / "x.hpp").exists()


def test_missing_cell_is_named():
    run = tables("nowhere.toml")
    assert run.returncode == 2 and "nowhere.toml" in run.stderr
