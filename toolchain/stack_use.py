#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The deepest stack that an image can reach, from its calls.

usage: stack_use.py [--limit BYTES] IMAGE.elf

A function's frame is all that it pushes and reserves, whichever way it takes, so what is printed is a bound. A call
through a register, which only the seams to the board are, may go to every function whose address the image holds; from
one of those only to such as make no call through a register themselves. An exception adds its 8 words and its handler.
Recursion, and a frame whose size is not in the code, have no bound and are refused. Exit code: 0, 1 beyond the limit or
without a bound, 2 usage.
"""
import argparse
import sys

import elf_code

EXCEPTION_BYTES = 8 * 4 + 4  # ARMv7-M Architecture Reference Manual, B1.5.6: the frame, and a word to align it
LIBGCC_DIVISION = "__aeabi_idiv0"  # weak, empty


class Unbounded(Exception):
    """No number can be given; the message says why."""


class Depths:
    def __init__(self, code, taken):
        self.code = code
        self.seams = {address for address in taken if address in code}
        self.leaves = {address for address in self.seams if not self.reaches_indirect(address, set())}
        self.known = {}

    def reaches_indirect(self, address, seen):
        if address in seen:
            return False
        seen.add(address)
        function = self.code[address]
        return function.indirect > 0 or any(self.reaches_indirect(call, seen) for call in function.calls)

    def of(self, address, path=(), behind_seam=False):
        """(bytes, functions on the way) below and with this function."""
        if (address, behind_seam) in self.known:
            return self.known[address, behind_seam]
        function = self.code[address]
        if address in path:
            names = " -> ".join(self.code[step].name for step in (*path[path.index(address):], address))
            raise Unbounded(f"recursion: {names}")
        if function.unknown_frame:
            raise Unbounded(f"{function.name}: a frame of unknown size ({function.unknown_frame})")
        path = (*path, address)
        below = [self.of(call, path, behind_seam) for call in function.calls]
        if function.indirect:
            below += [self.of(call, path, True) for call in (self.leaves if behind_seam else self.seams)
                      if call not in path]
        depth, way = max(below, default=(0, ()), key=lambda one: one[0])
        self.known[address, behind_seam] = function.frame + depth, (function, *way)
        return self.known[address, behind_seam]


def worst(elf):
    """(bytes with an exception on top, functions of the deepest way)."""
    code = elf_code.functions(elf)
    named = {function.name: address for address, function in code.items()}
    if "reset" not in named:
        raise Unbounded("no function `reset`: this is no image of the project")
    taken = {word & ~1 for word in elf_code.words(elf) if word & 1}
    handlers = {named[name] for name in ("reset", "unexpected_exception()", "unexpected_exception") if name in named}
    depths = Depths(code, taken - handlers)
    depth, way = depths.of(named["reset"])
    on_top = max((depths.of(handler)[0] for handler in handlers - {named["reset"]}), default=0)
    return depth + EXCEPTION_BYTES + on_top, way


def main():
    parser = argparse.ArgumentParser(prog="stack_use.py", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--limit", type=int, metavar="BYTES", help="more is an error")
    parser.add_argument("image", metavar="IMAGE.elf")
    given = parser.parse_args()
    try:
        depth, way = worst(given.image)
    except Unbounded as error:
        print(f"{given.image}: no bound for the stack: {error}", file=sys.stderr)
        return 1
    print(f"{given.image}: at most {depth} bytes of stack")
    for function in way:
        print(f"  {function.frame:6d} {function.name}")
    if given.limit is not None and depth > given.limit:
        print(f"{given.image}: {depth} bytes of stack; at most {given.limit} are allowed", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
