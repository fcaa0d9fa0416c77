# SPDX-License-Identifier: Apache-2.0
"""The object check refuses what is planted. That the firmware passes it is in image/check_image_test.py."""
import pathlib
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
CHECK = ROOT / "toolchain" / "check_firmware_objects.py"
COMPILE = ["arm-none-eabi-g++", "-mcpu=cortex-m4", "-mthumb", "-std=c++17", "-O2", "-ffreestanding", "-c"]
NO_EXCEPTIONS = ["-fno-exceptions", "-fno-rtti", "-fno-unwind-tables", "-fno-asynchronous-unwind-tables"]


def check(*files):
    return subprocess.run([sys.executable, CHECK, *files], capture_output=True, text=True)


def compiled(tmp_path, source, flags):
    path = tmp_path / "planted.cpp"
    path.write_text(source)
    output = tmp_path / "planted.o"
    subprocess.run([*COMPILE, *flags, path, "-o", output], check=True)
    return output


def test_integers_of_every_width_are_clean(tmp_path):
    source = "long long f(long long a, int b) { return a / b + (a << b) % 7; }"
    result = check(compiled(tmp_path, source, ["-mfloat-abi=soft", *NO_EXCEPTIONS]))
    assert result.returncode == 0, result.stderr


PLANTED = {
    "helper of a float": ("float f(float a, float b) { return a * b; }", ["-mfloat-abi=soft"], "floating point"),
    "helper of a double": ("double f(int a) { return a / 3.0; }", ["-mfloat-abi=soft"], "floating point"),
    "floating-point instruction": ("float f(float a, float b) { return a * b; }",
                                   ["-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"], "floating point"),
    "new": ("int* f() { return new int(3); }", ["-mfloat-abi=soft"], "heap"),
    "malloc": ("extern \"C\" void* malloc(unsigned); void* f() { return malloc(8); }", ["-mfloat-abi=soft"], "heap"),
    "static constructor": ("int g(); int x = g();", ["-mfloat-abi=soft"], "hidden state"),
    "hidden static": ("int f() { static int calls = 3; return ++calls; }", ["-mfloat-abi=soft"], "hidden state"),
    "run-time type information": ("struct A { virtual void f(); }; void A::f() {}", ["-mfloat-abi=soft", "-frtti"],
                                  "run-time type information"),
}


@pytest.mark.parametrize("name", PLANTED)
def test_what_is_planted_is_refused(tmp_path, name):
    source, flags, what = PLANTED[name]
    result = check(compiled(tmp_path, source, [*NO_EXCEPTIONS, *flags]))
    assert result.returncode == 1
    assert f": {what}: " in result.stderr


def test_a_throw_is_refused(tmp_path):
    source = "struct A { ~A(); }; void g(); void f(int a) { A x; g(); if (a) throw 1; }"
    result = check(compiled(tmp_path, source, ["-mfloat-abi=soft"]))
    assert result.returncode == 1
    assert "__cxa_throw" in result.stderr and "__gxx_personality" in result.stderr and ".ARM.extab" in result.stderr


def test_an_empty_library_is_refused(tmp_path):
    library = tmp_path / "empty.a"
    subprocess.run(["arm-none-eabi-ar", "rc", library], check=True)
    assert check(library).returncode == 1
