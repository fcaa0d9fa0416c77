# SPDX-License-Identifier: Apache-2.0
"""Both nodes on an emulated STM32F407: the frames that they send are those of the run in one process, byte for byte.

Two seconds of it; VOLTLAP_TEST_WHOLE=1: sixty, which take some ten minutes."""
import os
import pathlib
import re
import shutil
import subprocess

import pytest

labwired = pytest.importorskip(
    "labwired", reason="the package labwired is not installed (toolchain/requirements/test.txt: x86-64, ARM64)")
from emulated import EXTENDED, Board, without_second_clock  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[4]
BUILD = pathlib.Path(os.environ["VOLTLAP_BUILD_DIR"])
TICKS = 6000 if os.environ.get("VOLTLAP_TEST_WHOLE") else 200
LINE = re.compile(r"\((\d+)\.(\d{6})\) \w+ ([0-9A-F]+)#([0-9A-F]*)")


@pytest.fixture(scope="module")
def image():
    """Linked from the same sources as every image of the board."""
    if not shutil.which("arm-none-eabi-g++"):
        pytest.skip("arm-none-eabi-g++ is not installed")
    folder = BUILD / "emulated_stm32f4"
    subprocess.run(["cmake", "-S", ROOT, "-B", folder, "-G", "Ninja", "-DVOLTLAP_TESTS=OFF",
                    f"-DCMAKE_TOOLCHAIN_FILE={ROOT / 'toolchain' / 'arm-none-eabi.cmake'}",
                    f"-DVOLTLAP_CODECS={BUILD / 'can_dbc' / 'generated'}"], check=True, stdout=subprocess.DEVNULL)
    subprocess.run(["cmake", "--build", folder, "-j2", "--target", "both_nodes_stm32f4"], check=True,
                   stdout=subprocess.DEVNULL)
    return folder / "images" / "both_nodes_stm32f4.elf"


@pytest.fixture
def board(image, tmp_path):
    return Board(labwired, without_second_clock(image, tmp_path), tmp_path)


def rows_of(table):
    """The identifiers of a generated table."""
    text = (BUILD / "can_dbc" / "generated" / "can_dbc" / "tables.hpp").read_text()
    body = text.split(f"MessageRow {table}[]", 1)[1].split("};", 1)[0]
    return {int(row, 16) for row in re.findall(r"\{(0x[0-9A-F]+),", body)}


@pytest.fixture(scope="module")
def drive(tmp_path_factory):
    """A drive in one process: for each tick what the plant sent, and what the nodes answered."""
    log = tmp_path_factory.mktemp("drive") / "lap.log"
    subprocess.run([BUILD / "bin" / "voltlap", "endurance", "--laps", "1", "--candump", log], check=True,
                   stdout=subprocess.DEVNULL)
    nodes = rows_of("kBmsTx") | rows_of("kMasterTx")
    ticks = []
    for line in log.read_text().splitlines():
        seconds, micros, name, data = LINE.match(line).groups()
        tick = (int(seconds) * 1_000_000 + int(micros)) // 10_000
        while len(ticks) <= tick:
            ticks.append(([], []))
        can_id = int(name, 16) | (EXTENDED if len(name) > 3 else 0)
        ticks[tick][can_id in nodes].append((can_id, bytes.fromhex(data)))
    return ticks


def test_the_frames_are_those_of_the_run_in_one_process_byte_for_byte(board, drive):
    compared = 0
    for tick, (from_plant, from_nodes) in enumerate(drive[:TICKS]):
        for can_id, data in from_plant:
            board.receive(can_id, data)
        sent = board.run_until_sent()
        assert sent == from_nodes, f"tick {tick}: sent {sent}, in one process {from_nodes}"
        compared += len(sent)
    assert len(drive) >= TICKS and compared > 5 * TICKS
    print(f"{compared} frames of {TICKS} ticks are equal")


def test_what_no_filter_names_is_not_received(board):
    for can_id in (0x123, 0x7FF, 0x000, EXTENDED | 0x0B0, EXTENDED | 0x18FF50E4):
        with pytest.raises(ValueError, match="filter"):
            board.receive(can_id, bytes(8))
    board.receive(0x0B0, bytes(8))
    with pytest.raises(ValueError, match="FIFO1, which is not modeled"):  # behind its filter
        board.receive(EXTENDED | 0x18FF50E5, bytes(8))
