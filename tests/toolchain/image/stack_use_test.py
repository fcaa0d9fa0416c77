# SPDX-License-Identifier: Apache-2.0
"""The bound of the stack holds against the compiler's own numbers and against runs, and what has none is refused."""
import re
import subprocess

import pytest
from check_image_test import FLAGS, NO_EXCEPTIONS, SOFT, linked
from image_tools import ROOT, tool

import elf_code


def use(elf, *arguments):
    return tool("stack_use.py", *arguments, elf)


def bytes_of(elf):
    result = use(elf)
    assert result.returncode == 0, result.stderr
    return int(re.search(r"at most (\d+) bytes", result.stdout)[1])


LEAF = "volatile int sink; __attribute__((noinline)) void leaf() { volatile char a[%d]; a[0] = 1; sink = a[0]; }\n"


def test_a_larger_frame_is_that_much_deeper(tmp_path):
    depths = [bytes_of(linked(tmp_path, LEAF % size + "int main() { leaf(); leaf(); }\n")[0]) for size in (64, 1064)]
    assert depths[1] - depths[0] == 1000


def test_a_call_through_a_table_is_followed(tmp_path):
    source = LEAF % 800 + "void (*const table[])() = {leaf};\nint main() { table[sink](); }\n"
    assert bytes_of(linked(tmp_path, source)[0]) > 800


def test_recursion_is_refused_and_named(tmp_path):
    source = ("volatile int n;\n"
              "__attribute__((noinline)) int f(int k) { volatile int a = k; return k ? f(k - n) + a : 0; }\n")
    result = use(linked(tmp_path, source + "int main() { return f(n); }\n")[0])
    # GCC makes a call of oneself a jump where it can; here it cannot.
    assert result.returncode == 1 and "recursion: f(int) -> f(int)" in result.stderr


def test_a_frame_that_is_not_known_is_refused(tmp_path):
    source = ("volatile int n;\n__attribute__((noinline)) void f(int k) {\n"
              "  volatile char* a = (char*)__builtin_alloca(k);\n  a[0] = 1;\n  n = a[0];\n}\n")
    result = use(linked(tmp_path, source + "int main() { f(n); }\n")[0])
    assert result.returncode == 1 and "unknown size" in result.stderr


def test_a_limit_is_held(image_of):
    result = use(image_of("bms_node", 24), "--limit", 1000)
    assert result.returncode == 1 and "at most 1000 are allowed" in result.stderr
    assert use(image_of("bms_node", 24), "--limit", 4096).returncode == 0


@pytest.mark.parametrize("file", ["bms/bms_step.cpp", "bms/transmit.cpp", "bms/estimate/cell_model.cpp"])
def test_frames_are_at_least_what_the_compiler_says(tmp_path, file, kind_of):
    generated = kind_of().folder / "can_dbc" / "generated"
    output, linked_elf = tmp_path / "unit.o", tmp_path / "unit.elf"
    command = ["arm-none-eabi-g++", *FLAGS, *SOFT, *NO_EXCEPTIONS, f"-I{generated}", "-fstack-usage", "-c",
               ROOT / "firmware" / file, "-o", output]
    subprocess.run([str(word) for word in command], check=True)
    usage = {line.split("\t")[0].split(":", 3)[3]: int(line.split("\t")[1])
             for line in output.with_suffix(".su").read_text().splitlines()}
    subprocess.run(["arm-none-eabi-g++", *SOFT, "-mcpu=cortex-m4", "-mthumb", "-nostdlib", "-Wl,-e,0",
                    "-Wl,--unresolved-symbols=ignore-all", output, "-o", linked_elf], check=True)
    found = elf_code.functions(linked_elf)
    assert usage and max(usage.values()) > 50
    largest = max(function.frame for function in found.values())
    assert max(usage.values()) <= largest <= max(usage.values()) + 64
