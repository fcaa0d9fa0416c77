#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Refuses an image that holds what a microcontroller of the project must not run.

usage: check_image.py [--map FILE.map] IMAGE.elf ...

Looked for: floating-point instructions and helpers, heap, exceptions with their tables and their unwinder, run-time
type information, input and output of the C library, constructors that run before main(), symbols that nobody defines, a
vector table that does not begin with a stack in RAM and a reset handler in flash, a missing mark of the image
(ImageInfo); with a map, code from any library besides the project's own and libgcc. Every image is checked when it is
linked. Exit code: 0 clean, 1 something found, 2 usage.
"""
import argparse
import re
import struct
import subprocess
import sys

import check_firmware_objects as objects

SECTIONS = {
    "exceptions": re.compile(r"\.ARM\.extab\S*|\.ARM\.exidx\S*|\.gcc_except_table\S*|\.eh_frame\S*"),
    "constructors": re.compile(r"\.init_array\S*|\.ctors\S*|\.preinit_array\S*"),
}
SYMBOLS = {what: rule for what, rule in objects.SYMBOLS.items() if what != "hidden state"}
UNWINDER = re.compile(r"_Unwind_\w*|__gnu_unwind\w*|__aeabi_unwind_cpp_pr[12]|__gxx_personality\w*|_ZSt\d*terminate\w*")
CONSTRUCTORS = re.compile(r"_GLOBAL__sub_I\w*|__static_initialization\w*|__libc_init_array|__cxa_atexit|__aeabi_atexit")
OWN_LIBRARY = re.compile(r"(?:.*/)?libvoltlap_\w+\.a")
LIBGCC = re.compile(r"(?:.*/)?libgcc\.a")
# Of libgcc, integers only: division, multiplication of 64 bits, shifts, jumps of an M0+.
LIBGCC_MEMBERS = re.compile(r"_(?:aeabi_)?u?(?:l|i)?div(?:mod)?(?:si3|di4)?|_udivmoddi4|_divmoddi4|_dvmd_tls|_muldi3"
                            r"|_aeabi_lmul|_(?:ash[lr]|lsh[lr]|lshr|ashr|ashl)di3|_(?:aeabi_)?l(?:lsl|lsr|asr)"
                            r"|_thumb1_case_\w+|_c[lt]z[sd]i2|_u?divdi3|bpabi|_udivsi3|_divsi3|_aeabi_[iu]*cmp"
                            r"|_(?:u)?cmpdi2|_(?:u)?lcmp")
MEMBER = re.compile(r"^(\S+\.a)\(([^)]+)\)$", re.MULTILINE)
VECTORS_BYTES = 64
IMAGE_MARK = b"VTL2"


def run(tool, *arguments):
    return subprocess.run([tool, *arguments], check=True, capture_output=True, text=True).stdout


def symbol_findings(prefix, image):
    found = []
    for line in run(prefix + "nm", image).splitlines():
        kind, name = line.split()[-2:]
        if kind in ("U", "w"):
            found.append(("undefined", name))
            continue
        if UNWINDER.fullmatch(name):
            found.append(("exceptions", name))
        if CONSTRUCTORS.fullmatch(name):
            found.append(("constructors", name))
        # The one stub of start_up.cpp stands for the unwinder that libgcc's division names.
        found += [(what, name) for what, rule in SYMBOLS.items()
                  if rule.fullmatch(name) and name != "__aeabi_unwind_cpp_pr0"]
    return found


def section_findings(prefix, image):
    rows = objects.SECTION_ROW.findall(run(prefix + "objdump", "-h", image))
    return [(what, section) for section, size in rows if int(size, 16) > 0
            for what, rule in SECTIONS.items() if rule.fullmatch(section)]


def loaded_bytes(prefix, image):
    """{address: bytes} of what goes to flash and RAM, as far as the file has it."""
    found = {}
    with open(image, "rb") as file:
        data = file.read()
    if data[:6] != b"\x7fELF\x01\x01":
        raise SystemExit(f"{image}: found no 32-bit little-endian ELF; expected an image")
    offset, size, count = struct.unpack_from("<I", data, 28)[0], *struct.unpack_from("<HH", data, 42)
    for k in range(count):
        kind, at, address, _, length = struct.unpack_from("<5I", data, offset + k * size)
        if kind == 1 and length > 0:
            found[address] = data[at:at + length]
    return found


def vector_findings(prefix, image):
    parts = loaded_bytes(prefix, image)
    symbols = {line.split()[-1]: int(line.split()[0], 16) for line in run(prefix + "nm", image).splitlines()
               if len(line.split()) == 3}
    first = parts.get(min(parts, default=0), b"")
    if len(first) < VECTORS_BYTES:
        return [("vector table", "none at the beginning of flash")]
    stack, reset = struct.unpack_from("<2I", first)
    found = []
    if stack != symbols.get("__stack_top"):
        found.append(("vector table", f"the stack begins at 0x{stack:08x}, not at __stack_top"))
    if reset != symbols.get("reset", 0) | 1:
        found.append(("vector table", f"the reset handler is 0x{reset:08x}, not reset() in Thumb code"))
    if first[VECTORS_BYTES:VECTORS_BYTES + 256].find(IMAGE_MARK) < 0:
        found.append(("image info", "no mark behind the vector table"))
    return found


def instruction_findings(prefix, image):
    listing = run(prefix + "objdump", "-d", image)
    return [("floating point", mnemonic) for mnemonic in sorted(set(objects.INSTRUCTION.findall(listing)))]


def map_findings(path):
    with open(path) as file:
        text = file.read()
    found = []
    for library, member in sorted(set(MEMBER.findall(text))):
        if OWN_LIBRARY.fullmatch(library):
            continue
        name = member.rsplit(".", 1)[0]
        if not LIBGCC.fullmatch(library):
            found.append(("foreign library", f"{library}({member})"))
        elif not LIBGCC_MEMBERS.fullmatch(name):
            found.append(("foreign code", f"libgcc.a({member})"))
    return found


def findings(prefix, image, map_file=None):
    found = symbol_findings(prefix, image) + section_findings(prefix, image) + instruction_findings(prefix, image)
    found += vector_findings(prefix, image)
    return found + (map_findings(map_file) if map_file else [])


def main():
    parser = argparse.ArgumentParser(prog="check_image.py", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--prefix", default="arm-none-eabi-", help="of the cross tools (default: %(default)s)")
    parser.add_argument("--map", metavar="FILE", help="the linker's map of the image; then of one image")
    parser.add_argument("images", nargs="+", metavar="IMAGE.elf")
    given = parser.parse_args()
    if given.map and len(given.images) > 1:
        parser.error("--map: one map and one image are expected")
    bad = [(image, what, name) for image in given.images for what, name in findings(given.prefix, image, given.map)]
    for image, what, name in bad:
        print(f"{image}: {what}: {name}", file=sys.stderr)
    if bad:
        print(f"{len(bad)} findings", file=sys.stderr)
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
