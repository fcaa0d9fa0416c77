# SPDX-License-Identifier: Apache-2.0
"""Cells and thermistors of an Orion come one by one, each frame with the number of its own. Drawn frames, some lost and
some corrupt, become channels of exactly what came: nothing for what was lost, nothing held."""
import math
import os
import random
import subprocess
from pathlib import Path

BIN = Path(os.environ["VOLTLAP_BUILD_DIR"]) / "tests/bin"
SEED = int(os.environ.get("VOLTLAP_TEST_SEED") or random.randrange(2**32))
CYCLE_S = 0.02
STEPS = 3000


def sealed(identifier, data):
    return bytes([*data, (identifier + 8 + sum(data)) & 0xFF])


def cell_frame(cell, voltage_raw):
    return sealed(0x036, bytes([cell, *voltage_raw.to_bytes(2, "big"), 0x04, 0x10, *voltage_raw.to_bytes(2, "big")]))


def module_frame(thermistor, celsius):
    return bytes([*thermistor.to_bytes(2, "big"), celsius & 0xFF, thermistor % 80, 15, 40, 1, 2])


def broadcast_frame(first, values):
    pairs = [byte for k in range(3) for byte in ((first + k) % len(values), values[(first + k) % len(values)] & 0xFF)]
    return sealed(0x076, bytes([*pairs, 0]))


def channels_of(tmp_path, lines, map_name, roles):
    """{role: {time: value}}, holes left out."""
    log = tmp_path / "drawn.log"
    log.write_text("".join(f"({time:.6f}) can0 {identifier}#{data.hex().upper()}\n"
                           for time, identifier, data in lines))
    result = subprocess.run([BIN / "show_log", log, map_name, *roles], capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
    out = {}
    for line in result.stdout.splitlines():
        if line.startswith("sample "):
            _, role, time, value = line.split(" ")
            if not math.isnan(float(value)):
                out.setdefault(role, {})[round(float(time), 6)] = float(value)
    return out, result.stdout


def check(found, drawn):
    assert found.keys() == drawn.keys()
    for role, values in drawn.items():
        assert found[role].keys() == values.keys(), role
        assert all(abs(found[role][time] - value) < 1e-6 for time, value in values.items()), role


def pack_frames(time):
    current = sealed(0x6B0, bytes([0, 50, 0x0B, 0x6E, 160, 0, 0]))
    limits = sealed(0x6B1, bytes([0, 100, 50, 25, 20, 0, 0]))
    return [(time + 0.001, "6B0", current), (time + 0.002, "6B1", limits)]


def test_cells_and_modules_are_what_was_drawn(tmp_path):
    print(f"VOLTLAP_TEST_SEED={SEED}")
    source = random.Random(SEED)
    cells, modules = source.randrange(10, 145), source.randrange(1, 9)
    counts = [source.randrange(5, 81) for _ in range(modules)]
    lines, drawn = [], {}
    for step in range(STEPS):
        time = round(step * CYCLE_S, 6)
        lines += pack_frames(time)
        cell, raw = step % cells, source.randrange(33000, 41000)
        fate, frame = source.random(), cell_frame(cell, raw)
        if fate < 0.1:  # a bit is flipped on the way
            frame = bytes([frame[0], frame[1] ^ 1 << source.randrange(8), *frame[2:]])
        if fate < 0.8:
            lines.append((time + 0.003, "036", frame))
        if 0.1 <= fate < 0.8:
            drawn.setdefault(f"cell_voltage_{cell + 1}", {})[round(time + 0.003, 6)] = raw / 1e4
        for module, count in enumerate(counts):
            thermistor, celsius = 80 * module + step % count, source.randrange(-20, 60)
            if source.random() < 0.75:
                at = time + 0.004 + 0.001 * module
                lines.append((at, f"{0x1838F380 + module:08X}", module_frame(thermistor, celsius)))
                drawn.setdefault(f"temperature_{thermistor + 1}", {})[round(at, 6)] = celsius
    roles = [f"cell_voltage_{n}" for n in range(1, 150)] + [f"temperature_{n}" for n in range(1, 700)]
    found, _ = channels_of(tmp_path, lines, "orion_thermistors_can", roles)
    check(found, drawn)
    longest = max(later - earlier for values in found.values()
                  for earlier, later in zip(list(values), list(values)[1:], strict=False))
    assert longest > 1.9 * CYCLE_S * min(cells, *counts)  # what was lost is a gap of its own channel


def test_the_map_with_modules_is_taken_where_they_are_on_the_bus(tmp_path):
    source = random.Random(3)
    lines = []
    for step in range(500):
        time = step * CYCLE_S
        lines += [*pack_frames(time), (time + 0.003, "036", cell_frame(step % 12, 36000 + step % 7)),
                  (time + 0.004, "1838F380", module_frame(step % 9, source.randrange(18, 24)))]
    found, _ = channels_of(tmp_path, lines, "-", ["temperature_9", "cell_voltage_12"])
    assert set(found) == {"temperature_9", "cell_voltage_12"}  # the map without modules has temperature_1 alone


def test_the_units_own_thermistors_pass_their_checksum(tmp_path):
    print(f"VOLTLAP_TEST_SEED={SEED}")
    source = random.Random(SEED)
    lines, drawn = [], {}
    for step in range(800):
        time = round(step * CYCLE_S, 6)
        values = [source.randrange(-20, 60) for _ in range(8)]
        lines.append((time + 0.001, "356", bytes([0x6E, 0x0B, 0, 0, 0xA0, 0])))
        lines.append((time + 0.002, "355", bytes([95, 0, 100, 0, 0xB6, 3])))
        frame = broadcast_frame(step % 8, values)
        broken = source.random() < 0.2
        lines.append((time + 0.003, "076", frame[:1] + bytes([frame[1] ^ 4]) + frame[2:] if broken else frame))
        if not broken:
            drawn.setdefault(f"temperature_{step % 8 + 2}", {})[round(time + 0.003, 6)] = values[step % 8]
    roles = [f"temperature_{n}" for n in range(2, 20)]
    found, said = channels_of(tmp_path, lines, "orion2_conversion_can", roles)
    check(found, drawn)
    assert "discarded by their checksum" in said
