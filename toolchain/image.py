#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Builds the example images of the firmware for a Cortex-M, and prints how large they are.

In images/ of the build folder lie for each: .elf, .bin, .hex, .map, .stack (its deepest calls) and .spdx.json (what it
is made of). With --vehicle they have that car's configuration; the image driven_by_plant gets it from the plant when it
is started (./voltlap endurance --ecu qemu).
"""
import argparse
import os
import re
import subprocess
import sys
from pathlib import Path

import image_build
from image_build import Kind, Refused

HOST = Path(os.environ.get("VOLTLAP_BUILD_DIR", image_build.ROOT / "build" / "default"))
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
    parser.add_argument("--cells", type=int, metavar="N",
                        help=f"most cells that the BMS has memory for, 1 to {image_build.CELLS_MOST} (default: all)")
    parser.add_argument("--vehicle", metavar="CAR", help="a car by name or file (default: the example car, vtm16e)")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", dest="settings",
                        help="another value of the car; may be repeated")
    given = parser.parse_args()
    if given.cells is not None and not 1 <= given.cells <= image_build.CELLS_MOST:
        parser.error(f"--cells {given.cells}: 1 to {image_build.CELLS_MOST} are expected")
    own = image_build.BOARDS.get(given.board, given.cpu or "cortex-m4")
    if given.cpu not in (None, own):
        parser.error(f"--board {given.board} --cpu {given.cpu}: that part has a {own}; leave out --cpu")
    given.cpu = own
    return given


def car_headers(given):
    """(folder, name) of the car's configuration as headers; (None, "") for the example car as it is."""
    if given.vehicle is None and not given.settings:
        return None, ""
    vehicle = given.vehicle or "vtm16e"
    name = re.sub(r"\W+", "_", "_".join([Path(vehicle).stem, *given.settings]))
    folder = image_build.ROOT / "build" / "images_of" / name
    folder.mkdir(parents=True, exist_ok=True)
    command = [HOST / "bin" / "voltlap", "firmware-tables", "--vehicle", vehicle, "--out", folder / "pack_config.hpp",
               "--master-out", folder / "master_config.hpp"]
    for setting in given.settings:
        command += ["--set", setting]
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if done.returncode != 0:
        if not any(folder.iterdir()):
            folder.rmdir()
        raise Refused(2, done.stderr.strip().removeprefix("voltlap: "))
    return folder, name


def table(kind, names):
    rows = [f"{'image':<18}{'flash':>9}{'RAM':>9}{'stack':>9}   bytes; RAM without the stack, which is a bound"]
    for name in names:
        size = image_build.size_of(kind.image(name))
        rows.append(f"{name:<18}{size.flash:>9}{size.ram:>9}{size.stack:>9}")
    return "\n".join([*rows, f"in {kind.folder / 'images'}"])


def main():
    given = arguments()
    try:
        config, name = car_headers(given)
        kind = Kind(given.cpu, given.cells, config, name)
        image_build.build(kind)
        ours = [f"{image}_{given.board}" for image in image_build.BOARD_EXAMPLES]
        names = ours if given.board else image_build.EXAMPLES
        print(table(kind, names))
    except Refused as error:
        print(f"voltlap image: {error}", file=sys.stderr)
        return error.code
    except KeyboardInterrupt:
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main())
