# SPDX-License-Identifier: Apache-2.0
"""The bus load of a run against its own log, counted bit by bit in another language."""
import json
import os
import pathlib
import re
import subprocess
from collections import defaultdict

import pytest

BINARY = pathlib.Path(os.environ["VOLTLAP_BUILD_DIR"]) / "bin" / "voltlap"
BIT_RATE = 500_000
TICK_S = 0.01


def crc15(bits):
    crc = 0
    for bit in bits:
        crc <<= 1
        if (crc >> 15) ^ bit:
            crc ^= 0x4599
        crc &= 0x7FFF
    return crc


def binary(value, width):
    return [value >> i & 1 for i in range(width - 1, -1, -1)]


def frame_bits(identifier, data):
    """Of a frame with an 11-bit identifier: SOF to CRC with stuff bits, delimiters, end of frame, pause."""
    bits = [0, *binary(identifier, 11), 0, 0, 0, *binary(len(data), 4)]
    for byte in data:
        bits += binary(byte, 8)
    bits += binary(crc15(bits), 15)
    sent, run = [], 0
    for bit in bits:
        run = run + 1 if sent and sent[-1] == bit else 1
        sent.append(bit)
        if run == 5:
            sent.append(1 - bit)
            run = 1
    return len(sent) + 1 + 2 + 7 + 3


def test_counter_of_this_test_knows_the_published_check_value():
    message = [bit for byte in b"123456789" for bit in binary(byte, 8)]
    assert crc15(message) == 0x059E  # CRC-15/CAN in the catalogue of parametrised CRC algorithms


def test_counter_of_this_test_finds_the_stuff_bits_counted_by_hand():
    assert frame_bits(0, b"") == 34 + 6 + 13


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    (folder / "drive.csv").write_text("time_s,speed_mps\n0,0\n2,8\n4,12\n6,3\n")
    done = subprocess.run([BINARY, "endurance", "--drive", "drive.csv", "--bus-load", "--json", "run.json", "--candump",
                           "run.log"], cwd=folder, capture_output=True, text=True, check=True)
    frames = [(round(float(time) / TICK_S), int(identifier, 16), bytes.fromhex(data)) for time, identifier, data in
              re.findall(r"^\((\S+)\) \S+ ([0-9A-F]{3})#([0-9A-F]*)$", (folder / "run.log").read_text(), re.MULTILINE)]
    return json.loads((folder / "run.json").read_text()), frames, done.stdout


def test_every_identifier_has_the_frames_and_bits_of_the_log(run):
    result, frames, _ = run
    counted = defaultdict(list)
    for _, identifier, data in frames:
        counted[identifier].append(frame_bits(identifier, data))
    rows = {int(row["id"], 16): row for row in result["bus_load"]["ids"]}
    assert rows.keys() == counted.keys() and len(rows) > 15
    time_s = (frames[-1][0] + 1) * TICK_S
    for identifier, bits in counted.items():
        row = rows[identifier]
        assert (row["frames"], row["bits_worst"]) == (len(bits), max(bits))
        assert row["bits_mean"] == pytest.approx(sum(bits) / len(bits), rel=1e-12)
        assert row["frames_per_s"] == pytest.approx(len(bits) / time_s, rel=1e-12)
        assert row["load_pct"] == pytest.approx(100 * sum(bits) / (BIT_RATE * time_s), rel=1e-12)
    assert sum(row["frames"] for row in rows.values()) == result["frames"] == len(frames)


def test_total_and_fullest_100_ms_are_those_of_the_log(run):
    result, frames, _ = run
    bits = [0] * (frames[-1][0] + 1)
    for tick, identifier, data in frames:
        bits[tick] += frame_bits(identifier, data)
    load = result["bus_load"]
    assert load["bitrate"] == BIT_RATE
    assert load["total_pct"] == pytest.approx(100 * sum(bits) / (BIT_RATE * TICK_S * len(bits)), rel=1e-9)
    fullest = max(sum(bits[i:i + 10]) for i in range(len(bits) - 9))
    assert load["peak_100ms_pct"] == pytest.approx(100 * fullest / (BIT_RATE * 10 * TICK_S), rel=1e-9)
    assert load["total_pct"] < load["peak_100ms_pct"] < 60
    assert sum(row["share_pct"] for row in load["ids"]) == pytest.approx(100, rel=1e-9)


def test_table_says_the_same(run):
    result, _, text = run
    load = result["bus_load"]
    assert f"bus load at 500 kbit/s: {load['total_pct']:.1f} % on average, {load['peak_100ms_pct']:.1f} % in" in text
    assert re.search(r"0x0C0 +BmsLimits ", text)


def test_nothing_is_counted_when_nobody_asks(tmp_path):
    done = subprocess.run([BINARY, "endurance", "--laps", "1", "--json", "run.json"], cwd=tmp_path, capture_output=True,
                          text=True, check=True)
    assert json.loads((tmp_path / "run.json").read_text())["bus_load"] is None
    assert "bus load" not in done.stdout
