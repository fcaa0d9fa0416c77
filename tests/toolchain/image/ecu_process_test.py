# SPDX-License-Identifier: Apache-2.0
"""The firmware as a process of its own sends the same frames whichever compiler made it, how hard that tried, and how
wide a pointer is.

Of the compilers three are tried; all with VOLTLAP_TEST_WHOLE=1.
"""
import json
import os
import shutil
import subprocess

import pytest
from image_tools import HOST, ROOT, VOLTLAP

COURSE = "time_s,speed_mps\n0,0\n2,8\n4,12\n5,3\n6,0\n"  # 6 s behind the start-up
SETTINGS = ("--set", "bms.soc_method=ekf", "--set", "bms.limit_method=ahead")
FIRST = ("gcc -O0", "clang -O3", "gcc -O2 -m32")
REST = ("gcc -O3", "clang -O0", "clang -O2 -m32", "gcc -O2 -fsanitize=undefined")
FOLDERS = ("base", "codec", "bms", "master", "app", "port/lockstep")
NINJA = """\
flags = -std=c++17 -fno-exceptions -fno-rtti -fno-threadsafe-statics -I{root}/firmware -I{codecs} -I{config} -I{numbers}
rule object
  command = {compiler} {options} $flags -MD -MF $out.d -c $in -o $out
  depfile = $out.d
rule program
  command = {compiler} {options} $in -o $out
"""


def sources():
    files = [path for folder in FOLDERS for path in sorted((ROOT / "firmware" / folder).rglob("*.cpp"))]
    examples = ROOT / "firmware" / "examples"
    return [*files, examples / "bms_memory.cpp", examples / "both_loop.cpp", examples / "driven_by_plant" / "main.cpp",
            ROOT / "firmware" / "port" / "host" / "pipe_board.cpp",
            HOST / "firmware" / "examples" / "driven_by_plant_info.cpp"]


def compiles(compiler, options, folder):
    (folder / "try.cpp").write_text("#include <cstdint>\n#include <cstdio>\nint main() { return 0; }\n")
    done = subprocess.run([compiler, *options, "try.cpp", "-o", "try"], cwd=folder, capture_output=True)
    return done.returncode == 0


def built(variant, folder):
    name, *options = variant.split()
    compiler = {"gcc": "g++", "clang": "clang++"}[name]
    if shutil.which(compiler) is None:
        pytest.skip(f"{compiler} is not installed")
    if not compiles(compiler, options, folder):
        pytest.skip(f"{compiler} {' '.join(options)} makes no program here (Debian: apt-get install g++-multilib)")
    objects, text = [], NINJA.format(compiler=compiler, options=" ".join(options), root=ROOT,
                                     codecs=HOST / "can_dbc" / "generated", config=ROOT / "firmware" / "examples",
                                     numbers=HOST / "firmware" / "source_numbers")
    for k, source in enumerate(sources()):
        objects.append(f"{k}.o")
        text += f"build {k}.o: object {source}\n"
    (folder / "build.ninja").write_text(f"{text}build firmware: program {' '.join(objects)}\n")
    done = subprocess.run(["ninja", "-C", folder, "firmware"], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout
    return folder / "firmware"


def endurance(folder, *arguments):
    (folder / "course.csv").write_text(COURSE)
    out = folder / "run.json"
    done = subprocess.run([VOLTLAP, "endurance", "--drive", folder / "course.csv", *SETTINGS, "--json", out,
                           *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return json.loads(out.read_text())


@pytest.mark.parametrize("variant", [*FIRST, *(REST if os.environ.get("VOLTLAP_TEST_WHOLE") == "1" else ())])
def test_every_compiler_makes_the_same_frames(tmp_path, variant):
    program = built(variant, tmp_path)
    outside = endurance(tmp_path, "--ecu", "process", "--image", program)
    assert outside["ecu"]["where"] == "process"
    assert outside["trace_hash"] == endurance(tmp_path)["trace_hash"]


def test_a_defect_that_is_planted_gives_other_frames(tmp_path):
    """The comparison sees what a compiler might do: here a current is a milliampere off."""
    inside = endurance(tmp_path)
    other = endurance(tmp_path, "--set", "bms.discharge_current_max_a=249.999")
    assert inside["trace_hash"] != other["trace_hash"]


def test_the_shipped_program_sends_them_too(tmp_path):
    assert endurance(tmp_path, "--ecu", "process")["trace_hash"] == endurance(tmp_path)["trace_hash"]


def test_started_by_hand_it_says_by_what_it_is_started():
    done = subprocess.run([HOST / "bin" / "voltlap-firmware"], capture_output=True, text=True, close_fds=True)
    assert done.returncode == 2 and "--ecu process" in done.stderr


def test_a_program_that_is_none_of_the_firmware_is_refused(tmp_path):
    (tmp_path / "course.csv").write_text(COURSE)
    done = subprocess.run([VOLTLAP, "endurance", "--drive", tmp_path / "course.csv", "--ecu", "process", "--image",
                           "/bin/true"], capture_output=True, text=True)
    assert done.returncode == 2 and "/bin/true" in done.stderr and "does not start" in done.stderr
