# SPDX-License-Identifier: Apache-2.0
"""Writes a CppUTest file that compares the generated codecs with cantools, byte for byte.

usage: make_vectors.py --can-dbc DIR --out FILE
For every message: raw codes at both ends of each range, a few LSB around them, the invalid code and random ones.
cantools packs the bytes and says what they mean; only the names of the C++ members come from the generator.
"""
from __future__ import annotations

import argparse
import random
import sys
from fractions import Fraction
from pathlib import Path

import cantools

FIRMWARE_UNITS = {"A": 1000, "V": 10_000, "degC": 10, "%": 10_000, "mOhm": 1000, "rpm": 1, "m/s": 1000, "bar": 1000,
                  "Nm": 1000}
SEED = 20150509
RANDOM_VECTORS = 40


class Column:
    """One signal: its codes, and what the firmware must make of each."""

    def __init__(self, signal, field, index):
        self.s, self.f, self.index = signal, field, index
        self.bits = (-(1 << signal.length - 1), (1 << signal.length - 1) - 1) if signal.is_signed else (
            0, (1 << signal.length) - 1)
        self.physical = field.ok is not None
        if self.physical:
            scale = Fraction(str(signal.scale))
            self.factor = int(scale * FIRMWARE_UNITS[signal.unit])
            self.low = -((-Fraction(str(signal.minimum)) / scale).__floor__())
            self.high = (Fraction(str(signal.maximum)) / scale).__floor__()
        else:
            self.factor, (self.low, self.high) = 1, self.bits
        self.invalid = next((raw for raw, name in (signal.choices or {}).items() if str(name) == "invalid"), None)
        self.names = {raw for raw, name in (signal.choices or {}).items() if str(name) != "invalid"}

    def codes(self):
        edges = {c + d for c in (self.low, self.high, 0) for d in (-3, -2, -1, 0, 1, 2, 3)} | set(self.bits)
        edges |= set() if self.invalid is None else {self.invalid}
        return sorted(c for c in edges if self.bits[0] <= c <= self.bits[1])

    def valid(self, raw):
        return self.low <= raw <= self.high

    def value(self, raw):
        """As a signed 32-bit number, which is how the suite compares."""
        if self.names:
            return raw if raw in self.names else 0
        if not self.physical:
            return raw - (1 << 32) if raw >= 1 << 31 else raw
        return raw * self.factor if self.valid(raw) else 0

    def encodable(self, raw):
        return raw in self.names if self.names else self.valid(raw)

    def member(self, ok=False):
        return f"m.{self.f.ok if ok else self.f.name}{self.f.at}"


def vectors_of(columns, rng):
    rows = []
    for k, column in enumerate(columns):
        for code in column.codes():
            row = [rng.randint(*c.bits) for c in columns]
            row[k] = code
            rows.append(row)
    rows += [[rng.randint(*c.bits) for c in columns] for _ in range(RANDOM_VECTORS)]
    return rows


def pack(message, columns, row):
    data = {c.s.name: raw for c, raw in zip(columns, row)}
    data.update({s.name: 0 for s in message.signals if s.name not in data})
    return message.encode(data, scaling=False, strict=False)


def test_lines(message, m, fields, rng):
    group = m.group
    by_name = {s.name: s for s in message.signals}
    columns = [Column(by_name[f.s.name], f, i) for i, (f, _) in enumerate(fields)]
    rows = vectors_of(columns, rng)
    name = group[0] if group else message.name
    title = f"{name}{group[1]:02d}" if group else name
    n = len(columns)
    lines = ["", f"TEST(CodecAgainstCantools, {title}) {{",
             f"  static const struct {{ std::int32_t value[{n}]; bool ok[{n}]; bool encodable; std::uint8_t data[8]; }}"
             " kRows[] = {"]
    for row in rows:
        value = ", ".join(str(c.value(raw)) for c, raw in zip(columns, row))
        ok = ", ".join(str(c.valid(raw)).lower() for c, raw in zip(columns, row))
        encodable = all(c.encodable(raw) or raw == c.invalid for c, raw in zip(columns, row))
        data = ", ".join(str(b) for b in pack(message, columns, row))
        lines.append(f"      {{{{{value}}}, {{{ok}}}, {str(encodable).lower()}, {{{data}}}}},")
    lines += ["  };", "  for (const auto& row : kRows) {",
              f"    Frame frame{{{m.id:#x}, 8, {{}}}};", "    std::memcpy(frame.data, row.data, 8);",
              f"    can::{name} m;", "    CHECK(can::decode(frame, m));"]
    for i, c in enumerate(columns):
        lines.append(f"    LONGS_EQUAL(row.value[{i}], static_cast<std::int32_t>({c.member()}));")
        if c.physical:
            lines.append(f"    CHECK_EQUAL(row.ok[{i}], {c.member(ok=True)});")
    lines += ["    if (!row.encodable) continue;", "    Frame again;", "    can::encode(m, again);",
              "    CHECK(again.id == frame.id && again.dlc == 8);", "    MEMCMP_EQUAL(row.data, again.data, 8);",
              "  }", "}"]
    return lines


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--can-dbc", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    arguments = parser.parse_args()
    sys.path.insert(0, str(arguments.can_dbc))
    import generate
    import model

    rng = random.Random(SEED)
    files = [arguments.can_dbc / f"{name}.dbc" for name in ("car", "orion", "charger", "pm100", "lockstep")]
    lines = ["// Generated by tests/can_dbc/make_vectors.py.", "#include <cstdint>", "#include <cstring>", "",
             '#include "can_dbc/car.hpp"', '#include "can_dbc/charger.hpp"', '#include "can_dbc/lockstep.hpp"',
             '#include "can_dbc/orion.hpp"', '#include "can_dbc/pm100.hpp"', "",
             '#include "CppUTest/TestHarness.h"', "",
             "using namespace voltlap;", "", "TEST_GROUP(CodecAgainstCantools) {};"]
    databases = [cantools.database.load_file(str(f)) for f in files]
    for m in model.load(files).messages:
        message = next(k for d in databases for k in d.messages if k.name == m.name)
        lines += test_lines(message, m, generate.fields_of(m), rng)
    arguments.out.write_text("\n".join(lines) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
