# SPDX-License-Identifier: Apache-2.0
"""BMS-091: an image of which one bit has changed drives nothing, whichever bit it is. The bits are drawn;
VOLTLAP_TEST_SEED repeats them, and with VOLTLAP_TEST_WHOLE=1 there are 300."""
import os
import random
import re
import shutil
import struct
import subprocess
import zlib

import pytest
from image_tools import VOLTLAP, tool

import image_build
import image_crc

SEED = os.environ.get("VOLTLAP_TEST_SEED") or str(random.randrange(2**32))
BITS = 300 if os.environ.get("VOLTLAP_TEST_WHOLE") else 8
COURSE = "time_s,speed_mps\n0,0\n2,8\n4,12\n5,3\n6,0\n"
CONTACTORS, INVERTER, LIMITS, SELF_TEST_FLASH = 0x0A0, 0x0A1, 0x0C0, 19
LINE = re.compile(r"\(\S+\) \w+ ([0-9A-F]+)#([0-9A-F]*)")
EXIT_DEFECT = 70


def flat(elf):
    return image_crc.bytes_of(image_crc.load_parts(elf.read_bytes()))


def flipped(elf, bit, target):
    """A copy of which one bit of what goes into flash is another."""
    data = bytearray(elf.read_bytes())
    offset = bit // 8
    for _, at, piece in image_crc.load_parts(bytes(data)):
        if offset < len(piece):
            data[at + offset] ^= 1 << bit % 8
            break
        offset -= len(piece)
    target.write_bytes(data)
    return target


def drive(tmp_path, image):
    """What the nodes sent, as {id: set of data}, with the run's code and words."""
    course, log = tmp_path / "course.csv", tmp_path / "run.log"
    course.write_text(COURSE)
    log.unlink(missing_ok=True)
    done = subprocess.run([VOLTLAP, "endurance", "--drive", course, "--ecu", "qemu", "--image", image, "--candump",
                           log], capture_output=True, text=True, timeout=120)
    sent = {}
    for line in log.read_text().splitlines() if log.exists() else []:
        name, data = LINE.match(line).groups()
        sent.setdefault(int(name, 16), set()).add(bytes.fromhex(data))
    return sent, done.returncode, done.stdout + done.stderr


needs_qemu = pytest.mark.skipif(shutil.which("qemu-system-arm") is None, reason="qemu-system-arm is not installed")


def moves_nothing(sent):
    """No contactor, no torque, no current allowed; of a board that fell silent, too."""
    return (all(data[0] & 7 == 0 for data in sent.get(CONTACTORS, ()))
            and all(data[:2] == b"\0\0" and data[2] & 1 == 0 for data in sent.get(INVERTER, ()))
            and all(data[:4] == bytes(4) for data in sent.get(LIMITS, ())))


def says_why(sent):
    return CONTACTORS in sent and all(data[1] == SELF_TEST_FLASH for data in sent[CONTACTORS])


@needs_qemu
def test_a_whole_image_closes_and_drives(tmp_path, image_of):
    sent, code, text = drive(tmp_path, image_of("both_nodes"))
    assert code == 0 and not moves_nothing(sent) and not says_why(sent), text


@needs_qemu
@pytest.mark.parametrize("name", ["both_nodes", "driven_by_plant"])
def test_one_changed_bit_anywhere_moves_nothing_and_says_so(tmp_path, image_of, name):
    image = image_of(name)
    draw = random.Random(f"{SEED} {name}")
    bits = 8 * len(flat(image))
    chosen = [draw.randrange(bits) for _ in range(BITS)] + [draw.randrange(bits - 64, bits)]  # the value's own, too
    silent = []
    for bit in chosen:
        sent, code, text = drive(tmp_path, flipped(image, bit, tmp_path / "changed.elf"))
        assert code != 0 and moves_nothing(sent), f"seed {SEED}, bit {bit}: {text}"
        if not says_why(sent):
            silent.append((bit, code, text))
    # What runs before the test, what the plant reads of the image, and what says so may be what has changed.
    assert len(silent) <= 1 + len(chosen) // 4, f"seed {SEED}: {silent}"


@needs_qemu
def test_each_bit_of_the_test_itself_moves_nothing(tmp_path, image_of):
    """The code that looks, and the function that judges: where a changed bit could have it see what is not there."""
    image = image_of("both_nodes")
    table = subprocess.run(["arm-none-eabi-nm", "-S", image], capture_output=True, text=True, check=True).stdout
    name = re.compile(r" [Tt] (main|_ZN7voltlap4port13image_residueEv)$")
    rows = [line.split() for line in table.splitlines() if name.search(line)]
    assert len(rows) == 2
    bits = [8 * (int(row[0], 16) & ~1) + k for row in rows for k in range(8 * int(row[1], 16))]
    draw = random.Random(f"{SEED} itself")
    for bit in bits if os.environ.get("VOLTLAP_TEST_WHOLE") else draw.sample(bits, BITS):
        sent, _, text = drive(tmp_path, flipped(image, bit, tmp_path / "changed.elf"))
        assert moves_nothing(sent), f"seed {SEED}, bit {bit}: {text}"


def test_elf_bin_and_hex_hold_the_same_value(tmp_path, image_of):
    for name in (*image_build.EXAMPLES, "both_nodes_stm32f4", "both_nodes_stm32g4"):
        elf = image_of(name)
        image = flat(elf)
        assert image[-8:-4] == image_crc.MARK
        assert struct.unpack("<I", image[-4:])[0] == zlib.crc32(image[:-4])
        assert elf.with_suffix(".bin").read_bytes() == image
        back = tmp_path / "back.bin"
        subprocess.run(["arm-none-eabi-objcopy", "-I", "ihex", "-O", "binary", elf.with_suffix(".hex"), back],
                       check=True)
        assert back.read_bytes() == image


def test_placing_it_again_changes_nothing_and_a_changed_image_is_found(tmp_path, image_of):
    copy = tmp_path / "copy.elf"
    shutil.copy(image_of("bms_node"), copy)
    before = copy.read_bytes()
    assert tool("image_crc.py", copy).returncode == 0 and copy.read_bytes() == before
    assert tool("image_crc.py", "--check", copy).returncode == 0
    flipped(copy, 12_345, copy)
    done = tool("image_crc.py", "--check", copy)
    assert done.returncode == 1 and "not those that it was linked with" in done.stderr


def test_an_image_without_the_value_or_with_another_is_not_flashed(tmp_path, image_of):
    image = image_of("both_nodes_stm32f4")
    bits = 8 * len(flat(image))
    for bit, words in ((bits - 64, "there is no value behind it"), (bits - 5, "the CRC behind them is of others"),
                       (80_001, "the CRC behind them is of others")):
        done = tool("flash.py", flipped(image, bit, tmp_path / "x.elf"), "--board", "stm32f407", "--dry-run")
        assert done.returncode == 2 and words in done.stderr and "./voltlap image" in done.stderr
