# SPDX-License-Identifier: Apache-2.0
"""The example images are clean, and the check finds each thing that is planted in one."""
import shutil
import subprocess

import pytest
from image_tools import ROOT, tool

PORT = ROOT / "firmware" / "port"
NAMES = ("bms_node", "master_node", "both_nodes", "driven_by_plant")
FLAGS = ["-mcpu=cortex-m4", "-mthumb", "-std=c++17", "-O2", "-ffreestanding", "-nostdlib", f"-I{ROOT / 'firmware'}"]
SOFT = ["-mfloat-abi=soft"]
NO_EXCEPTIONS = ["-fno-exceptions", "-fno-rtti", "-fno-unwind-tables", "-fno-asynchronous-unwind-tables"]
MARK = '__attribute__((section(".image_info"), used)) extern const char kMark[4] = {\'V\', \'T\', \'L\', \'2\'};\n'
FAULT = 'extern "C" [[noreturn]] void board_fault(unsigned) { for (;;) {} }\n'
CLEAN = "volatile long long x = 7; int main() { x = x * 3 / x; return 0; }\n"


def linked(tmp_path, source, flags=(), libraries=("-lgcc",), scripts=None):
    """An image of the project's start-up with a program of the test's."""
    (tmp_path / "planted.cpp").write_text((MARK if MARK not in source else "") + FAULT + source)
    elf, map_file = tmp_path / "planted.elf", tmp_path / "planted.map"
    start = [PORT / "cortex_m" / name for name in ("start_up.cpp", "memory.cpp", "stack.cpp")]
    scripts = scripts or [PORT / "mps2_an386" / "memory.ld", PORT / "cortex_m" / "sections.ld"]
    command = ["arm-none-eabi-g++", *FLAGS, *(flags or [*SOFT, *NO_EXCEPTIONS]), "-fno-tree-loop-distribute-patterns",
               *start, tmp_path / "planted.cpp", *[f"-T{script}" for script in scripts], "-Wl,--gc-sections",
               f"-Wl,-Map={map_file}", *libraries, "-o", elf]
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return elf, map_file


@pytest.mark.parametrize("cells", [None, 24])
def test_the_example_images_are_clean(kind_of, cells):
    for name in NAMES:
        image = kind_of(cells).image(name)
        result = tool("check_image.py", "--map", image.with_suffix(".map"), image)
        assert result.returncode == 0, result.stderr


def test_the_libraries_are_clean(kind_of):
    libraries = sorted(kind_of().folder.rglob("*.a"))
    assert len(libraries) >= 7
    result = tool("check_firmware_objects.py", *libraries)
    assert result.returncode == 0, result.stderr


def test_a_program_of_integers_is_clean(tmp_path):
    elf, map_file = linked(tmp_path, CLEAN)
    result = tool("check_image.py", "--map", map_file, elf)
    assert result.returncode == 0, result.stderr


MALLOC = 'extern "C" void* malloc(unsigned n) { static char heap[64]; return heap + n; }\n'
PLANTED = {
    "a floating-point instruction": ("volatile float x; int main() { x = x * x; }",
                                     ["-mfloat-abi=hard", "-mfpu=fpv4-sp-d16", *NO_EXCEPTIONS], "floating point: vmul"),
    "a float helper": ("volatile float x; int main() { x = x * x; }", [*SOFT, *NO_EXCEPTIONS],
                       "floating point: __aeabi_fmul"),
    "a heap": (MALLOC + "void* volatile p; int main() { p = malloc(8); }", [*SOFT, *NO_EXCEPTIONS], "heap: malloc"),
    "a new": ("void* operator new(unsigned) { return nullptr; }\nint* volatile p; int main() { p = new int(3); }",
              [*SOFT, *NO_EXCEPTIONS], "heap: _Znwj"),
    "an unwinder": ('extern "C" void _Unwind_Resume(void*) { for (;;) {} }\nint main() { _Unwind_Resume(nullptr); }',
                    [*SOFT, *NO_EXCEPTIONS], "exceptions: _Unwind_Resume"),
    "run-time type information": ("struct A { virtual void f(); }; void A::f() {}\nA a; namespace __cxxabiv1 { struct "
                                  "__class_type_info { virtual void f(); }; void __class_type_info::f() {} }\n"
                                  "int main() { A* volatile p = &a; p->f(); }",
                                  [*SOFT, "-fno-exceptions", "-frtti", "-fno-unwind-tables"],
                                  "run-time type information: _ZTI1A"),
}


@pytest.mark.parametrize("what", PLANTED)
def test_what_is_planted_is_found(tmp_path, what):
    source, flags, said = PLANTED[what]
    elf, _ = linked(tmp_path, source + "\n", flags)
    result = tool("check_image.py", elf)
    assert result.returncode == 1 and said in result.stderr, result.stderr


def test_an_exception_table_is_found(tmp_path):
    """sections.ld leaves them out; a script that does not is what the check is for."""
    script = tmp_path / "sections.ld"
    text = (PORT / "cortex_m" / "sections.ld").read_text()
    script.write_text(text[:text.index("/DISCARD/")] + ".ARM.exidx : { KEEP(*(.ARM.exidx*)) } > FLASH\n}\n")
    table = '__attribute__((section(".ARM.exidx"), used)) extern const int kTable[2] = {0, 1};\n'
    elf, _ = linked(tmp_path, table + CLEAN, scripts=[PORT / "mps2_an386" / "memory.ld", script])
    result = tool("check_image.py", elf)
    assert result.returncode == 1 and "exceptions: .ARM.exidx" in result.stderr


def test_code_of_the_c_library_is_found(tmp_path):
    source = 'extern "C" int atoi(const char*); volatile int x; int main() { x = atoi("3"); }\n'
    elf, map_file = linked(tmp_path, source, libraries=("-lc", "-lgcc"))
    result = tool("check_image.py", "--map", map_file, elf)
    assert result.returncode == 1 and "foreign library" in result.stderr and "libc.a" in result.stderr


def test_an_image_without_its_mark_is_found(tmp_path):
    source = "/*" + MARK + "*/" + CLEAN  # the fixture adds none then
    elf, _ = linked(tmp_path, source)
    result = tool("check_image.py", elf)
    assert result.returncode == 1 and "image info: no mark" in result.stderr


def test_a_reset_handler_elsewhere_is_found(image_of, tmp_path):
    elf = tmp_path / "moved.elf"
    shutil.copy(image_of("bms_node"), elf)
    data = bytearray(elf.read_bytes())
    info = data.index(b"VTL2")  # behind the 16 vectors
    data[info - 64 + 4] ^= 0x10
    elf.write_bytes(data)
    result = tool("check_image.py", elf)
    assert result.returncode == 1 and "vector table: the reset handler is" in result.stderr


def test_a_static_with_a_constructor_does_not_link(tmp_path):
    (tmp_path / "planted.cpp").write_text("int g(); int x = g(); int g() { return 3; }\n"
                                          "int main() { return x; }\n" + FAULT)
    command = ["arm-none-eabi-g++", *FLAGS, *SOFT, *NO_EXCEPTIONS, PORT / "cortex_m" / "start_up.cpp",
               tmp_path / "planted.cpp", f"-T{PORT / 'mps2_an386' / 'memory.ld'}",
               f"-T{PORT / 'cortex_m' / 'sections.ld'}", "-o", tmp_path / "x.elf"]
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    assert done.returncode != 0 and "a static object has a constructor that runs before main()" in done.stderr


def test_no_elf_is_said(tmp_path):
    (tmp_path / "text.elf").write_text("no image")
    assert tool("check_image.py", tmp_path / "text.elf").returncode != 0
