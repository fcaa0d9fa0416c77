#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Refuses firmware objects that need what the microcontroller must not use.

usage: check_firmware_objects.py [--prefix arm-none-eabi-] FILE.a|FILE.o ...

Looked for in the symbols and the sections of every object, and in its disassembly: floating-point instructions and
helpers, heap, exceptions and their unwind tables, run-time type information, hidden state (.data, .bss, static
constructors), the C library's input and output. Exit code 0: clean; 1: something found; 2: usage.
"""
import argparse
import re
import subprocess
import sys

SYMBOLS = {
    "floating point": re.compile(
        r"__aeabi_(?:[fd]|c[fd]|h2f|(?:u?[il])2[fd])\w*"
        r"|__(?:add|sub|mul|div|neg|cmp|eq|ne|lt|le|gt|ge|unord|pow)[sdt](?:f|c)[23]"
        r"|__powi[sdt]f2|__(?:float|fix|extend|trunc)\w*[sdt]f\w*"
        r"|(?:sqrt|sin|cos|tan|atan2?|asin|acos|exp|log|log10|pow|floor|ceil|round|fabs|fmod|ldexp)[fl]?"
    ),
    "heap": re.compile(
        r"malloc|calloc|realloc|free|aligned_alloc|memalign|strdup|_?sbrk|_malloc_r|_free_r"
        r"|_Zn[wa]\w*|_Zd[la]\w*"
    ),
    "exceptions": re.compile(
        r"__cxa_(?:throw|rethrow|allocate_exception|free_exception|begin_catch|end_catch|end_cleanup"
        r"|get_exception_ptr|bad_cast|bad_typeid|call_unexpected|throw_bad_array_new_length)"
        r"|__gxx_personality\w*|_Unwind_\w*|__aeabi_unwind_cpp_pr\w*|_ZSt\d+(?:terminate|__throw)\w*"
    ),
    "run-time type information": re.compile(r"_ZT[IS]\w*|__dynamic_cast"),
    "hidden state": re.compile(r"__cxa_guard\w*|__cxa_atexit|__aeabi_atexit|_GLOBAL__sub_I\w*"),
    "input and output": re.compile(r"(?:v?s?n?|f|v?f)printf|puts|putchar|f(?:open|read|write)|_ZS[iot]\w*|_ZNS[io]\w*"),
}
SECTIONS = {
    "exceptions": re.compile(r"\.ARM\.extab\S*|\.ARM\.exidx\S*|\.gcc_except_table\S*|\.eh_frame\S*"),
    "hidden state": re.compile(r"\.data(?!\.rel\.ro)\S*|\.bss\S*|\.init_array\S*|\.ctors\S*|COMMON"),
}
# Every VFP and NEON instruction begins with v in the unified syntax, and no other Thumb instruction does.
INSTRUCTION = re.compile(r"^\s*[0-9a-f]+:\s+(?:[0-9a-f]{2,8}\s)+\s*(v[a-z0-9.]+)", re.MULTILINE)
SECTION_ROW = re.compile(r"^\s*\d+\s+(\S+)\s+([0-9a-f]{8})\s", re.MULTILINE)
OBJECT_HEAD = re.compile(r"^(\S+):\s+file format ", re.MULTILINE)


def run(tool, *arguments):
    return subprocess.run([tool, *arguments], check=True, capture_output=True, text=True).stdout


def split_by_object(text):
    """(name, text) of each object in the output of objdump on a library or an object."""
    heads = list(OBJECT_HEAD.finditer(text))
    ends = [head.start() for head in heads[1:]] + [len(text)]
    return [(head.group(1), text[head.end():end]) for head, end in zip(heads, ends)]


def symbols_of(table):
    """The names in `objdump -t`: the last word of each row."""
    return {line.split()[-1] for line in table.splitlines() if re.match(r"^[0-9a-f]{8}\s", line) and len(line) > 18}


def findings(prefix, path):
    """[(object, what, name)] for one file, and how many objects it holds."""
    objdump = prefix + "objdump"
    found = []
    symbol_tables = split_by_object(run(objdump, "-t", path))
    for name, table in symbol_tables:
        for symbol in sorted(symbols_of(table)):
            found += [(name, what, symbol) for what, rule in SYMBOLS.items() if rule.fullmatch(symbol)]
    for name, table in split_by_object(run(objdump, "-h", path)):
        for section, size in SECTION_ROW.findall(table):
            if int(size, 16) == 0:
                continue
            found += [(name, what, section) for what, rule in SECTIONS.items() if rule.fullmatch(section)]
    for name, listing in split_by_object(run(objdump, "-d", path)):
        found += [(name, "floating point", mnemonic) for mnemonic in sorted(set(INSTRUCTION.findall(listing)))]
    return found, len(symbol_tables)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--prefix", default="arm-none-eabi-", help="of the cross tools (default: %(default)s)")
    parser.add_argument("files", nargs="+", metavar="FILE")
    arguments = parser.parse_args()
    objects, bad = 0, []
    for path in arguments.files:
        found, count = findings(arguments.prefix, path)
        if count == 0:
            print(f"{path}: no objects", file=sys.stderr)
            return 1
        objects += count
        bad += found
    for name, what, detail in bad:
        print(f"{name}: {what}: {detail}", file=sys.stderr)
    print(f"{objects} objects, {len(bad)} findings")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
