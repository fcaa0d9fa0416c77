# SPDX-License-Identifier: Apache-2.0
"""Builds images and says how large they are: what voltlap image, flash and image-budgets have in common."""
import re
import shutil
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
CPUS = ("cortex-m0plus", "cortex-m4", "cortex-m7")
CELLS_MOST = 144
EXAMPLES = ("bms_node", "master_node", "both_nodes", "both_nodes_slcan", "driven_by_plant")
BOARDS = {"stm32f4": "cortex-m4", "stm32g4": "cortex-m4"}   # parts with images of their own, and their processor
BOARD_EXAMPLES = ("bms_node", "both_nodes")
STEP = re.compile(r"^\[(\d+)/(\d+)\]")
STEPS_SHOWN = 20   # where no terminal is
FLASH_SECTIONS, RAM_SECTIONS = (".vectors", ".text", ".rodata", ".data", ".image_crc"), (".data", ".bss")
EXIT_MISSING, EXIT_BUILD = 4, 5


class Refused(Exception):
    """What a person can mend, with the exit code."""

    def __init__(self, code, text):
        super().__init__(text)
        self.code = code


@dataclass
class Kind:
    """Which image: of which processor, for how many cells, with which configuration."""
    cpu: str = "cortex-m4"
    cells: int | None = None        # None: as many as the frames carry
    config: Path | None = None      # folder of pack_config.hpp and master_config.hpp; None: the example car's
    name: str = ""                  # of the car, part of the folder's name

    @property
    def folder(self):
        parts = [self.cpu, str(self.cells) if self.cells else "", self.name]
        return ROOT / "build" / "-".join(part for part in parts if part)

    def image(self, name):
        return self.folder / "images" / f"{name}.elf"


def require(program, package):
    if shutil.which(program) is None:
        raise Refused(EXIT_MISSING, f"found no {program}; expected it on the PATH. Install it (Debian: apt-get install "
                                    f"{package}).")


def quiet(command, what):
    done = subprocess.run([str(word) for word in command], cwd=ROOT, capture_output=True, text=True)
    if done.returncode != 0:
        raise Refused(EXIT_BUILD, f"{what} failed:\n{(done.stdout + done.stderr)[-3000:]}")


def show(step, last):
    if sys.stderr.isatty():
        print(f"\rvoltlap: building {step}/{last}   ", end="", file=sys.stderr, flush=True)
    elif int(step) % STEPS_SHOWN == 0:
        print(f"voltlap: building {step}/{last}", file=sys.stderr, flush=True)


def compile_all(folder):
    """Ninja with its count shown; what it prints comes out when it fails."""
    lines = []
    with subprocess.Popen(["cmake", "--build", str(folder)], cwd=ROOT, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True) as process:
        for line in process.stdout:
            lines.append(line)
            if step := STEP.match(line):
                show(step[1], step[2])
    if sys.stderr.isatty():
        print(f"\r{'':40}\r", end="", file=sys.stderr, flush=True)
    if process.returncode != 0:
        words = [line for line in lines if not STEP.match(line)]
        raise Refused(EXIT_BUILD, "the build failed:\n" + "".join(words)[-3000:])


def build(kind):
    """Configures and builds all images of a kind; quick when nothing has changed."""
    require("arm-none-eabi-g++", "gcc-arm-none-eabi libnewlib-arm-none-eabi libstdc++-arm-none-eabi-newlib")
    require("cmake", "cmake")
    options = [f"-DVOLTLAP_CPU={kind.cpu}", "-DVOLTLAP_TESTS=OFF", f"-DVOLTLAP_PYTHON={sys.executable}",
               f"-DVOLTLAP_IMAGE_PYTHON={sys.executable}", f"-DVOLTLAP_CELLS_MAX={kind.cells or ''}",
               f"-DVOLTLAP_CONFIG_DIR={kind.config or ROOT / 'firmware' / 'examples'}"]
    quiet(["cmake", "-S", ROOT, "-B", kind.folder, "-G", "Ninja", f"--toolchain={ROOT}/toolchain/arm-none-eabi.cmake",
           *options], "configuring")
    begin = time.monotonic()
    compile_all(kind.folder)
    return time.monotonic() - begin


@dataclass
class Size:
    flash: int     # bytes of code, constants and what .data begins with
    ram: int       # bytes of .data and .bss, without the stack
    stack: int     # bytes at most, by the calls


def size_of(image):
    text = subprocess.run(["arm-none-eabi-size", "-A", str(image)], check=True, capture_output=True, text=True).stdout
    sizes = {name: int(size) for name, size in re.findall(r"^(\.\S+)\s+(\d+)", text, re.MULTILINE)}
    stack = int(re.search(r"at most (\d+) bytes", image.with_suffix(".stack").read_text())[1])
    return Size(sum(sizes.get(name, 0) for name in FLASH_SECTIONS), sum(sizes.get(name, 0) for name in RAM_SECTIONS),
                stack)
