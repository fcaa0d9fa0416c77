#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes an image into the flash of a board, by OpenOCD, st-flash or probe-rs, whichever is installed.

Of a car it is the image for the board, built as ./voltlap image does with the same --vehicle, --cells and --set; no car
is taken that was not named. Before anything is written the image is looked at: that it is one, for this board's flash,
whose configuration is in it. An IMAGE with a configuration of another car than --vehicle is refused.
--dry-run prints the command and runs nothing.
"""
import argparse
import shlex
import shutil
import struct
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import image_build
import image_car
import image_crc
from image_build import Kind, Refused

IMAGE_MARK, EARLIER_MARK = b"VTL2", b"VTL1"  # firmware/port/image_info.hpp
INFO = struct.Struct("<IHBBII24s16sIIHH24s")
SEARCHED = 1024                    # bytes behind the vector table
BY_PLANT = "driven_by_plant"       # the image that has no configuration
EXIT_USAGE, EXIT_FAILED, EXIT_MISSING = 2, 3, 4


@dataclass
class Board:
    what: str
    image: str            # of the project
    flash: int            # its first address
    size: int             # for an image [byte]
    openocd: str = ""     # target of its scripts
    probe_rs: str = ""    # name of the chip
    st_flash: bool = False


BOARDS = {
    "stm32f407": Board("STM32F407xG: STM32F4DISCOVERY, Olimex STM32-H407 and others", "both_nodes_stm32f4",
                       0x0800_0000, 512 * 1024, "target/stm32f4x.cfg", "STM32F407VGTx", True),
    "stm32g474": Board("STM32G474xE: Nucleo-G474RE and others with a 24 MHz crystal", "both_nodes_stm32g4",
                       0x0800_0000, 256 * 1024, "target/stm32g4x.cfg", "STM32G474RETx", True),
    "mps2-an386": Board("ARM MPS2 with AN386, as QEMU emulates it; nothing is written: it is run", "driven_by_plant",
                        0, 4 * 1024 * 1024),
}
TOOLS = {"openocd": "openocd", "st-flash": "stlink-tools",
         "probe-rs": "https://probe.rs/docs/getting-started/installation"}
EPILOG = f"""\
boards:
{chr(10).join(f"  {name:<12}{board.what}" for name, board in BOARDS.items())}
Example: ./voltlap flash --vehicle ours.toml --cells 96 --dry-run
Exit codes: 0 written, 2 usage, or an image that does not fit, 3 the tool failed, 4 a program is missing, 5 the build
failed, 130 interrupted"""


@dataclass
class Image:
    path: Path
    first: int            # address of its first byte
    size: int
    name: str
    version: str
    cells: int            # that it has memory for
    has_bms: bool
    has_master: bool
    bms_number: int       # of its configuration; 0: changed by hand, or none
    master_number: int
    cells_in_series: int  # of the pack that it is for
    car: str              # empty: it has no configuration

    @property
    def nodes(self):
        return " and ".join(word for word, there in (("BMS", self.has_bms), ("master controller", self.has_master))
                            if there)

    @property
    def configuration(self):
        if not self.car:
            return "no configuration: the plant hands it over"
        cells = f"{self.cells_in_series} cells in series, " if self.has_bms else ""
        number = image_car.number_text(self.bms_number, self.master_number)
        by_hand = self.has_bms and not self.bms_number or self.has_master and not self.master_number
        return f"of {self.car}, {cells}configuration {number}{' (changed by hand)' if by_hand else ''}"


def read_image(path):
    try:
        data = path.read_bytes()
    except OSError as error:
        raise Refused(EXIT_USAGE, f"{path}: found that it cannot be read ({error.strerror}); expected an ELF image. "
                                  "Check the name.") from error
    if data[:6] != b"\x7fELF\x01\x01" or len(data) < 52:
        raise Refused(EXIT_USAGE, f"{path}: found no 32-bit little-endian ELF; expected an image. ./voltlap image "
                                  "builds them: IMAGE is the file that ends with .elf.")
    parts = [(address, piece) for address, _, piece in image_crc.load_parts(data)]
    head = parts[0][1][:SEARCHED] if parts else b""
    at = head.find(IMAGE_MARK)
    if at < 0:
        raise Refused(EXIT_USAGE, f"{path}: found {what_else(head)}")
    if fault := image_crc.fault_of(data):
        raise Refused(EXIT_USAGE, f"{path}: found that {fault}; expected an image as toolchain/image.cmake makes it, "
                                  "for a board refuses to drive with another. Build it again: ./voltlap image.")
    (_, cells, bms, master, _, _, name, version,
     bms_number, master_number, series, _, car) = INFO.unpack_from(parts[0][1], at)
    name, version, car = (text.split(b"\0")[0].decode("ascii", "replace") for text in (name, version, car))
    end = parts[-1][0] + len(parts[-1][1])
    return Image(path, parts[0][0], end - parts[0][0], name, version, cells, bool(bms), bool(master), bms_number,
                 master_number, series, car)


def what_else(head):
    if EARLIER_MARK in head:
        return "an image that does not say whose configuration it has; expected one that does. Build it again: " \
               "./voltlap image."
    return "no mark of the project behind the vector table; expected an image of firmware/examples. Other programs " \
           "are written with their own tools."


def locate(given, board):
    """The image that was named, or the project's own, built, and the car that was asked for."""
    asks = given.vehicle is not None or bool(given.settings)
    car = image_car.car_of(given.vehicle, given.settings) if asks else None
    if given.image:
        return given.image, car
    if car is None and board.image != BY_PLANT:
        raise Refused(EXIT_USAGE, "found no car; expected --vehicle with the one whose configuration is to be written, "
                                  "by name or file, such as --vehicle ours.toml, or IMAGE.elf. The example car is "
                                  f"--vehicle {image_car.EXAMPLE}.")
    kind = image_car.kind_of(car, cells=given.cells) if car else Kind(cells=given.cells)
    image_build.build(kind)
    return kind.image(board.image), car


def check(image, board, name):
    if image.first != board.flash:
        raise Refused(EXIT_USAGE, f"{image.path}: found an image linked for address 0x{image.first:08x}; expected "
                                  f"0x{board.flash:08x}, where the flash of {name} begins. Take the image of that "
                                  f"board: {board.image}.elf.")
    if image.size > board.size:
        raise Refused(EXIT_USAGE, f"{image.path}: found {image.size} bytes; expected at most {board.size}, the flash "
                                  f"of {name} that is for an image. Build a smaller one.")


def check_owner(image, car, cells):
    """That it is of the car, and with memory for the cells, that were asked for."""
    others = [there and found != wanted for there, found, wanted in (
        (image.has_bms, image.bms_number, car.bms_number),
        (image.has_master, image.master_number, car.master_number))] if car and image.car else []
    if any(others):
        raise Refused(EXIT_USAGE, f"{image.path}: found an image {image.configuration}; expected one of {car}. Leave "
                                  "IMAGE out, and it is built.")
    if cells is not None and image.cells != cells:
        raise Refused(EXIT_USAGE, f"{image.path}: found memory for {image.cells} cells; expected the {cells} of "
                                  "--cells. Leave IMAGE or --cells out.")


def command_of(tool, image, board):
    if tool == "openocd":
        # OpenOCD User's Guide, 12.4: `program` writes, verifies and starts.
        return ["openocd", "-f", "interface/stlink.cfg", "-f", board.openocd, "-c",
                f"program {{{image.path}}} verify reset exit"]
    if tool == "st-flash":
        return ["st-flash", "--reset", "write", str(image.path.with_suffix(".bin")), f"0x{board.flash:08x}"]
    return ["probe-rs", "download", "--chip", board.probe_rs, "--verify", str(image.path)]


def choose_tool(given):
    if given.tool:
        if shutil.which(given.tool) is None and not given.dry_run:
            raise Refused(EXIT_MISSING, f"found no {given.tool}; expected it on the PATH. {how_to_install(given.tool)}")
        return given.tool
    there = [tool for tool in TOOLS if shutil.which(tool)]
    if there:
        return there[0]
    if given.dry_run:
        return "openocd"
    words = "; ".join(how_to_install(tool) for tool in TOOLS)
    raise Refused(EXIT_MISSING, f"found none of {', '.join(TOOLS)}; expected one of them on the PATH. {words}.")


def how_to_install(tool):
    source = TOOLS[tool]
    return f"{tool}: {source}" if source.startswith("http") else f"{tool}: apt-get install {source}"


def arguments():
    parser = argparse.ArgumentParser(prog="voltlap flash", description=__doc__, epilog=EPILOG,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("image", nargs="?", type=Path, metavar="IMAGE.elf", help="(default: that of --vehicle, built)")
    image_car.add_flags(parser)
    parser.add_argument("--board", default="stm32f407", choices=BOARDS, help="(default: %(default)s)")
    parser.add_argument("--tool", choices=TOOLS, help="(default: the first that is installed)")
    parser.add_argument("--dry-run", action="store_true", help="print the command, run nothing")
    given = parser.parse_args()
    image_car.check_flags(parser, given)
    return given


def flash(given):
    board = BOARDS[given.board]
    path, car = locate(given, board)
    image = read_image(path)
    check(image, board, given.board)
    check_owner(image, car, given.cells)
    print(f"{image.path}: {image.name} {image.version}, {image.nodes}, at most {image.cells} cells, {image.size} "
          f"bytes from 0x{image.first:08x}\n{image.configuration}{f', asked for as {car.asked}' if car else ''}",
          flush=True)
    if given.board == "mps2-an386":
        print(f"this board is emulated: ./voltlap endurance --ecu qemu --image {image.path}")
        return 0
    command = command_of(choose_tool(given), image, board)
    print(shlex.join(command), flush=True)
    if given.dry_run:
        return 0
    code = subprocess.run(command).returncode
    if code != 0:
        raise Refused(EXIT_FAILED, f"{command[0]} ended with exit code {code}. Is the probe plugged in, the board "
                                   "supplied, no other program on the probe?")
    return 0


def main():
    try:
        return flash(arguments())
    except Refused as error:
        print(f"voltlap flash: {error}", file=sys.stderr)
        return error.code
    except KeyboardInterrupt:
        return 130


if __name__ == "__main__":
    sys.exit(main())
