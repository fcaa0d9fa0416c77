#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Builds the example images of the firmware for a Cortex-M, and prints how large they are.

In images/ of the build folder lie for each: .elf, .bin, .hex, .map, .stack (its deepest calls) and .spdx.json (what it
is made of). With --vehicle they have that car's configuration, and lie in a folder of that car's own; the image
driven_by_plant gets it from the plant when it is started (./voltlap endurance --ecu qemu).
"""
import argparse
import sys

import image_build
import image_car
from image_build import Refused

EPILOG = """\
Examples: ./voltlap image --vehicle ours.toml --cells 96
          ./voltlap image --board stm32g4
Exit codes: 0 done, 2 usage or input, 4 a program is missing, 5 the build failed"""


def arguments():
    parser = argparse.ArgumentParser(prog="voltlap image", description=__doc__, epilog=EPILOG,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cpu", choices=image_build.CPUS, help="(default: cortex-m4, or the board's)")
    parser.add_argument("--board", choices=image_build.BOARDS,
                        help="the images of this part, as voltlap flash writes them (default: those that are emulated)")
    image_car.add_flags(parser)
    given = parser.parse_args()
    image_car.check_flags(parser, given)
    own = image_build.BOARDS.get(given.board, given.cpu or "cortex-m4")
    if given.cpu not in (None, own):
        parser.error(f"--board {given.board} --cpu {given.cpu}: that part has a {own}; leave out --cpu")
    given.cpu = own
    return given


def table(kind, names):
    rows = [f"{'image':<18}{'flash':>9}{'RAM':>9}{'stack':>9}   bytes; RAM without the stack, which is a bound"]
    for name in names:
        size = image_build.size_of(kind.image(name))
        rows.append(f"{name:<18}{size.flash:>9}{size.ram:>9}{size.stack:>9}")
    return "\n".join([*rows, f"in {kind.folder / 'images'}"])


def main():
    given = arguments()
    try:
        car = image_car.car_of(given.vehicle, given.settings)
        kind = image_car.kind_of(car, given.cpu, given.cells)
        image_build.build(kind)
        ours = [f"{image}_{given.board}" for image in image_build.BOARD_EXAMPLES]
        names = ours if given.board else image_build.EXAMPLES
        print(f"images of {car}\n{table(kind, names)}")
    except Refused as error:
        print(f"voltlap image: {error}", file=sys.stderr)
        return error.code
    except KeyboardInterrupt:
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main())
