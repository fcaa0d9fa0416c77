# SPDX-License-Identifier: Apache-2.0
"""Writes the typed C++ codecs and the rx/tx tables of the firmware from the DBC files.

usage: generate.py --out DIR [[--lockstep LOCKSTEP.dbc] FILE.dbc ...]
writes DIR/can_dbc/<file>.hpp for each file (without any: all of this folder), and DIR/can_dbc/tables.hpp, in which the
lockstep messages do not stand. A build takes them from there with -DVOLTLAP_CODECS=DIR and needs no Python.
Refuses what the check refuses, so that no codec exists for a bus that cannot work.
"""
from __future__ import annotations

import argparse
import re
import sys
from pathlib import Path

import check
import model

# DBC unit -> (suffix of the field, firmware units in one DBC unit); the scales of firmware/base/units.hpp
UNITS = {
    "A": ("_ma", 1000), "V": ("_100uv", 10_000), "degC": ("_dc", 10), "%": ("_ppm", 10_000),
    "Ohm": ("_uohm", 1_000_000), "mOhm": ("_uohm", 1000), "rpm": ("_rpm", 1), "m/s": ("_mmps", 1000),
    "bar": ("_mbar", 1000), "Nm": ("_mnm", 1000),
}
HEADER = """// SPDX-License-Identifier: Apache-2.0
// Generated from {sources} by can_dbc/generate.py. Edit the DBC, not this file.
#pragma once
{includes}
namespace voltlap::can {{
"""
FOOTER = "\n}  // namespace voltlap::can\n"
PREAMBLE = ["base/can_frame.hpp", "base/payload.hpp"]


def snake(name: str) -> str:
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()


def shift_of(s: model.Signal) -> int:
    """Bit of the 64-bit word where the signal's lowest bit stands."""
    if not s.big_endian:
        return s.start
    first = 8 * (s.start // 8) + (7 - s.start % 8)
    return 64 - first - s.length


def factor_of(s: model.Signal) -> tuple[str, int]:
    """(suffix, firmware units in one raw code)."""
    if s.unit not in UNITS:
        raise SystemExit(f"can_dbc: {s.name}: unit '{s.unit}' is unknown; known are {', '.join(UNITS)}")
    suffix, per_unit = UNITS[s.unit]
    factor = s.scale * per_unit
    if factor.denominator != 1 or factor <= 0 or s.offset != 0:
        raise SystemExit(f"can_dbc: {s.name}: scale {s.scale} is no whole number of firmware units, or has an offset")
    return suffix, int(factor)


def hex_of(value: int) -> str:
    return f"0x{value:03X}"


class Field:
    """One member of a message struct and the lines that write and read it."""

    def __init__(self, s: model.Signal, index: int | None = None):
        self.s, self.shift = s, shift_of(s)
        base = snake(s.name)
        self.at = "" if index is None else f"[{index}]"
        if index is not None:
            base = base.rstrip("0123456789")
        self.name, self.ok = base, None
        if s.needs_unit:
            suffix, self.factor = factor_of(s)
            self.name, self.ok, self.type = base + suffix, base + "_ok", "std::int32_t"
        elif s.is_bit:
            self.type = "bool"
        elif s.is_enum:
            self.type = s.enum
        else:
            self.type = f"std::{'' if s.signed else 'u'}int{8 if s.length <= 8 else 16 if s.length <= 16 else 32}_t"

    def declaration(self, count: int | None) -> list[str]:
        initial = {"bool": "false", self.s.enum: "{}"}.get(self.type, "0")
        note = f"  ///< {self.s.comment}" if self.s.comment and count is None else ""
        if count is not None:
            lines = [f"{self.type} {self.name}[{count}] = {{}};"]
            return lines + ([f"bool {self.ok}[{count}] = {{}};"] if self.ok else [])
        return [f"{self.type} {self.name} = {initial};{note}"] + ([f"bool {self.ok} = false;"] if self.ok else [])

    def raw_range(self) -> tuple[int, int]:
        """Codes inside [min|max], the ends rounded inward."""
        low, high = self.s.minimum / self.s.scale, self.s.maximum / self.s.scale
        return -(-low.numerator // low.denominator), high.numerator // high.denominator

    def encode(self) -> list[str]:
        s, member = self.s, f"m.{self.name}{self.at}"
        if self.ok:
            low, high = self.raw_range()
            code = f"static_cast<std::uint32_t>(payload::to_raw({member}, {self.factor}, {low}, {high}))"
            if s.invalid_code is not None:
                code = f"m.{self.ok}{self.at} ? {code} : {hex_of(s.invalid_code & ((1 << s.length) - 1))}U"
            return [f"word |= payload::place({code}, {self.shift}, {s.length});"]
        code = f"{member} ? 1U : 0U" if self.type == "bool" else f"static_cast<std::uint32_t>({member})"
        return [f"word |= payload::place({code}, {self.shift}, {s.length});"]

    def decode(self) -> list[str]:
        s, member = self.s, f"m.{self.name}{self.at}"
        code = f"payload::take(word, {self.shift}, {s.length})"
        if self.ok:
            low, high = self.raw_range()
            raw = f"payload::sign_extend({code}, {s.length})" if s.signed else f"static_cast<std::int32_t>({code})"
            valid = f"raw >= {low} && raw <= {high}"
            times = "raw" if self.factor == 1 else f"raw * {self.factor}"
            if low == 0 and not s.signed:
                valid = f"raw <= {high}"
            return ["{", f"  const std::int32_t raw = {raw};", f"  m.{self.ok}{self.at} = {valid};",
                    f"  m.{self.name}{self.at} = m.{self.ok}{self.at} ? {times} : 0;", "}"]
        if self.type == "bool":
            return [f"{member} = {code} != 0;"]
        if s.is_enum:
            return [f"{member} = to_{snake(s.enum)}({code});"]
        if s.signed:
            code = f"payload::sign_extend({code}, {s.length})"
        return [f"{member} = static_cast<{self.type}>({code});"]


def fields_of(m: model.Message) -> list[tuple[Field, int | None]]:
    """(field, count of its array). Signals of a group (Cell0, Cell1, Cell2) become one array."""
    value = [s for s in m.signals if s.role not in ("counter", "crc", "checksum")]
    if m.group:
        return [(Field(s, i), len(value)) for i, s in enumerate(value)]
    return [(Field(s), None) for s in value]


def enum_lines(messages) -> list[str]:
    """Enumerations from VAL_ tables and bit names, each once."""
    done, lines = {}, []
    for m in messages:
        for s in m.signals:
            if not s.enum:
                continue
            choices = tuple(sorted(s.choices.items())) or tuple(enumerate(s.bit_names))
            if s.enum in done:
                if done[s.enum] != choices:
                    raise SystemExit(f"can_dbc: {m.name}.{s.name} defines {s.enum} differently")
                continue
            done[s.enum] = choices
            note = "" if s.choices else f"  // bit numbers of {m.name}.{s.name}"
            lines += ["", f"enum class {s.enum} : std::uint8_t {{{note}"]
            lines += [f"  k{name} = {value}," for value, name in choices] + ["};"]
            if [value for value, _ in choices] == list(range(len(choices))):  # for people, on the host
                lines += [f"inline constexpr const char* k{s.enum}Names[] = {{",
                          *(f'    "{name}",' for _, name in choices), "};"]
            if not s.choices:
                lines.append(f"inline constexpr std::uint8_t k{s.enum}Count = {len(choices)};")
                continue
            cases = " ".join(f"case {value}:" for value, _ in choices)
            lines += [f"/// An unknown code reads as code 0 (k{dict(choices)[0]}).",
                      f"[[nodiscard]] constexpr {s.enum} to_{snake(s.enum)}(std::uint32_t code) {{",
                      "  switch (code) {", f"    {cases} return static_cast<{s.enum}>(code);",
                      f"    default: return {s.enum}{{}};", "  }", "}"]
    return lines


def struct_lines(m: model.Message, count: int) -> list[str]:
    """Struct, encode and decode of one message, or of a group of `count` messages that starts with `m`."""
    name = m.group[0] if m.group else m.name
    fields = fields_of(m)
    headline = f"{count} messages of one shape, sent by {m.sender}." if m.group else m.comment
    lines = ["", f"/// {headline}", f"struct {name} {{"]
    if m.group:
        lines += [f"  static constexpr std::uint32_t kBaseId = {hex_of(m.id)};",
                  f"  static constexpr std::uint8_t kGroups = {count};",
                  f"  static constexpr std::size_t kPerFrame = {len(fields)};"]
    else:
        lines.append(f"  static constexpr std::uint32_t kId = {hex_of(m.id)};")
    lines += [f"  static constexpr std::uint8_t kDlc = {m.dlc};",
              f"  static constexpr std::int32_t kCycleMs = {m.cycle_ms};",
              f"  static constexpr std::int32_t kTimeoutMs = {m.timeout_ms};"]
    if m.group:
        lines.append("  std::uint8_t group = 0;")
    shown = fields[:1] if m.group else fields
    lines += [f"  {line}" for f, n in shown for line in f.declaration(n)] + ["};"]

    order = {s.big_endian for s in m.signals if s.length > 1}
    if len(order) > 1:
        raise SystemExit(f"can_dbc: {m.name} mixes byte orders")
    suffix = "be" if order == {True} else "le"
    identifier = f"{name}::kBaseId + m.group" if m.group else f"{name}::kId"
    lines += ["", f"inline void encode(const {name}& m, Frame& frame) {{", "  std::uint64_t word = 0;"]
    lines += [f"  {line}" for f, _ in fields for line in f.encode()]
    lines += ["  frame = Frame{};", f"  frame.id = {identifier};", f"  frame.dlc = {name}::kDlc;",
              f"  payload::store_{suffix}(word, frame.data);", "}",
              "", f"[[nodiscard]] inline bool decode(const Frame& frame, {name}& m) {{"]
    if m.group:
        lines += [f"  if (frame.id < {name}::kBaseId || frame.id >= {name}::kBaseId + {name}::kGroups) return false;",
                  f"  if (frame.dlc != {name}::kDlc) return false;",
                  f"  m.group = static_cast<std::uint8_t>(frame.id - {name}::kBaseId);"]
    else:
        lines.append(f"  if (frame.id != {name}::kId || frame.dlc != {name}::kDlc) return false;")
    lines.append(f"  const std::uint64_t word = payload::load_{suffix}(frame.data);")
    lines += [f"  {line}" for f, _ in fields for line in f.decode()] + ["  return true;", "}"]
    return lines


def codec(messages: list[model.Message], source: str) -> str:
    text = HEADER.format(sources=source, includes="".join(f'#include "{i}"\n' for i in PREAMBLE))
    lines = enum_lines(messages)
    groups = [m.group[0] for m in messages if m.group]
    for m in messages:
        if m.group and m.group[1] != 0:
            first = next(k for k in messages if k.group == (m.group[0], 0))
            shape = [(s.name, s.start, s.length) for s in first.signals]
            if m.id != first.id + m.group[1] or [(s.name, s.start, s.length) for s in m.signals] != shape:
                raise SystemExit(f"can_dbc: {m.name} does not continue its group")
            continue
        lines += struct_lines(m, groups.count(m.group[0]) if m.group else 1)
    return text + "\n".join(lines) + FOOTER


def row(m: model.Message) -> str:
    counter, seal = m.signal_of_role("counter"), m.signal_of_role("crc") or m.signal_of_role("checksum")
    places = f"{counter.start // 8 if counter else 0}, {min(seal.bits()) // 8 if seal else 0}"
    return (f"    {{{hex_of(m.id)}, {m.dlc}, {m.cycle_ms}, {m.cycle_many_cells_ms}, {m.timeout_ms}, {m.delay_ms}, "
            f"Protection::{m.protection}, {places}}},  // {m.name}")


def table(name: str, messages: list[model.Message]) -> list[str]:
    return ["", f"inline constexpr MessageRow {name}[] = {{", *(row(m) for m in messages), "};"]


TABLES_TYPES = """
/// How a frame proves that it is whole and new.
enum class Protection : std::uint8_t {
  kNone = 0,
  kCounterCrc = 1,  ///< 8-bit rolling counter and CRC-8 SAE J1850
  kOrionSum = 2,    ///< Orion checksum in the last byte, no counter
  kAge = 3,         ///< neither, by its maker's protocol: believed by its age alone
};

/// One message of the bus. Tables are sorted by identifier.
struct MessageRow {
  std::uint32_t id;
  std::uint8_t dlc;
  std::int32_t cycle_ms;
  std::int32_t cycle_many_cells_ms;  ///< with more cells than kFastCells
  std::int32_t timeout_ms;
  std::int32_t delay_ms;  ///< due when (now - delay) is a whole number of cycles
  Protection protection;
  std::uint8_t counter_byte;
  std::uint8_t crc_byte;
};

enum class Node : std::uint8_t { kNone = 0, kPlant = 1, kBms = 2, kMaster = 3 };

/// Every node steps and sends on this raster.
inline constexpr std::uint32_t kTickMs = 10;

/// The rule of sending that keeps the frames of one tick few: due in the tick where (now - delay) reaches a whole
/// number of cycles. `now` need not be a whole tick: it is not after the clock has wrapped.
[[nodiscard]] constexpr bool due(std::uint32_t now_ms, std::int32_t cycle_ms, std::int32_t delay_ms) {
  const auto cycle = static_cast<std::uint32_t>(cycle_ms);
  const auto delay = static_cast<std::uint32_t>(delay_ms) % cycle;
  return (now_ms % cycle + cycle - delay) % cycle < kTickMs;
}
"""


def tables(bus: model.Bus, sources: str) -> str:
    text = HEADER.format(sources=sources, includes="#include <cstddef>\n#include <cstdint>\n") + TABLES_TYPES
    cells = [m for m in bus.messages if m.group and m.group[0] == model.CELL_GROUP_NAME]
    lines = ["", f"inline constexpr std::int32_t kBitRate = {bus.bit_rate};",
             f"inline constexpr std::size_t kFastCells = {bus.fast_cells};"]
    if cells:
        lines += ["/// Cycle of the cell voltages: fast in a small pack, slower in one with more cells.",
                  "[[nodiscard]] constexpr std::int32_t cell_cycle_ms(std::size_t cells) {",
                  f"  return cells <= kFastCells ? {cells[0].cycle_ms} : {cells[0].cycle_many_cells_ms};", "}"]
    lines += table("kMessages", bus.messages)
    lines += ["", "/// In the order of kMessages; for the host.", "inline constexpr const char* kMessageNames[] = {",
              *(f'    "{m.name}",' for m in bus.messages), "};"]
    for node in ("Bms", "Master", "Plant"):
        lines += table(f"k{node}Rx", [m for m in bus.messages if node.upper() in m.receivers])
        lines += table(f"k{node}Tx", [m for m in bus.messages if m.sender == node.upper()])
    lines += ["", "/// The node that sends this identifier, kNone for one that is not of this bus.",
              "[[nodiscard]] constexpr Node sender_of(std::uint32_t id) {"]
    for sender in sorted({m.sender for m in bus.messages}):
        tests = ranges([m.id for m in bus.messages if m.sender == sender])
        lines.append(f"  if ({' || '.join(tests)}) return Node::k{sender.capitalize()};")
    lines += ["  return Node::kNone;", "}"]
    return text + "\n".join(lines) + FOOTER


def ranges(ids: list[int]) -> list[str]:
    out, start = [], None
    for i, value in enumerate(ids):
        start = value if start is None else start
        if i + 1 < len(ids) and ids[i + 1] == value + 1:
            continue
        out.append(f"id == {hex_of(start)}" if start == value else f"(id >= {hex_of(start)} && id <= {hex_of(value)})")
        start = None
    return out


def write_if_changed(path: Path, text: str) -> None:
    """Keeps the time stamp of an unchanged file, so that nothing is compiled again for nothing."""
    if not path.exists() or path.read_text() != text:
        path.write_text(text)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, required=True, metavar="DIR",
                        help="writes DIR/can_dbc/*.hpp; a build takes them with -DVOLTLAP_CODECS=DIR")
    parser.add_argument("--lockstep", type=Path, metavar="LOCKSTEP.dbc", help="messages that stand in no table")
    parser.add_argument("files", type=Path, nargs="*", metavar="FILE.dbc", help="default: all of can_dbc/")
    arguments = parser.parse_args()
    if not arguments.files:
        here = Path(__file__).resolve().parent
        arguments.lockstep = here / "lockstep.dbc"
        arguments.files = sorted(set(here.glob("*.dbc")) - {arguments.lockstep})
    bus = model.load(arguments.files)
    findings = check.check(bus)
    lockstep = model.load([arguments.lockstep]) if arguments.lockstep else model.Bus()
    findings += check.check_lockstep(lockstep, bus)
    for finding in findings:
        print(f"can_dbc: {finding}", file=sys.stderr)
    if findings:
        return 1
    folder = arguments.out / "can_dbc"
    folder.mkdir(parents=True, exist_ok=True)
    for file in [*arguments.files, *([arguments.lockstep] if arguments.lockstep else [])]:
        messages = [m for m in bus.messages + lockstep.messages if m.file == str(file)]
        write_if_changed(folder / f"{file.stem}.hpp", codec(messages, file.name))
    write_if_changed(folder / "tables.hpp", tables(bus, ", ".join(f.name for f in arguments.files)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
