# SPDX-License-Identifier: Apache-2.0
"""Writes the reference of all messages, can_dbc/doc/*.md, from the DBC files.

usage: reference.py [--check] [--dbc DIR] [--out DIR]
--check writes nothing; exit code 1 and one line for each page that is not what the DBC files say
"""
from __future__ import annotations

import argparse
import sys
from fractions import Fraction
from itertools import groupby
from pathlib import Path

import check
import model

HERE = Path(__file__).resolve().parent
COMMAND = "build/venv/bin/python can_dbc/reference.py"
MADE = f"Made from the DBC files by `{COMMAND}`; a test keeps it up to date. Edit the DBC, not this page.\n"
FILES = ("car.dbc", "orion.dbc", "charger.dbc", "pm100.dbc", "amk.dbc", "lockstep.dbc")
ON_THE_BUS = 5                # of them
PROTECTION = {"kCounterCrc": "counter, CRC-8", "kOrionSum": "checksum", "kNone": "none",
              "kAge": "none, believed by age"}


def number(value: Fraction | None) -> str:
    """The decimal that stands in the DBC."""
    if value is None:
        return ""
    return str(value.numerator) if value.denominator == 1 else f"{float(value):.12g}"


def identifier(value: int) -> str:
    return f"0x{value & 0x1FFFFFFF:08X}" if value >> 31 else f"0x{value:03X}"


def cell(text: str) -> str:
    return text.replace("|", "\\|").replace("\n", " ")


def table(header: list[str], rows: list[list[str]]) -> list[str]:
    return [f"| {' | '.join(row)} |" for row in (header, ["---"] * len(header), *rows)] + [""]


def shape(m: model.Message) -> tuple:
    """What messages of one group have in common: all but identifier, name and the words about them."""
    return (m.group[0] if m.group else m.name, m.dlc, m.sender, m.cycle_ms, m.cycle_many_cells_ms, m.timeout_ms,
            tuple((s.name, s.start, s.length, s.scale, s.offset, s.unit, s.minimum, s.maximum, tuple(s.receivers))
                  for s in m.signals))


def entries(messages: list[model.Message]) -> list[list[model.Message]]:
    """Messages by identifier; those of one group and shape that follow each other are one entry."""
    return [list(group) for _, group in groupby(messages, key=shape)]


def title(entry: list[model.Message]) -> str:
    first, last = entry[0], entry[-1]
    return first.name if first is last else f"{first.name} to {last.name.rsplit('_', 1)[1]}"


def ids(entry: list[model.Message]) -> str:
    first, last = identifier(entry[0].id), identifier(entry[-1].id)
    return first if first == last else f"{first} to {last}"


def anchor(entry: list[model.Message]) -> str:
    """As the usual renderers of Markdown make it of the heading."""
    return title(entry).lower().replace(" ", "-")


def delay(m: model.Message) -> str:
    return f", first after {m.delay_ms} ms" if m.delay_ms else ""


def cycle(m: model.Message, fast_cells: int) -> str:
    if not m.cycle_ms:
        return "on event"
    many = f" ({m.cycle_many_cells_ms} ms beyond {fast_cells} cells)" if m.cycle_many_cells_ms != m.cycle_ms else ""
    return f"{m.cycle_ms} ms{many}"


def receivers(m: model.Message) -> str:
    named = sorted(m.receivers - {"Vector__XXX"})
    return ", ".join(named) or "whoever listens"


def message_row(entry: list[model.Message], bus: model.Bus) -> list[str]:
    m = entry[0]
    return [ids(entry), f"[{title(entry)}](#{anchor(entry)})", m.sender, receivers(m), cycle(m, bus.fast_cells),
            f"{m.timeout_ms} ms" if m.timeout_ms else "", str(m.dlc), PROTECTION[m.protection]]


def pieces(m: model.Message, byte: int) -> list[tuple[str, int]]:
    """(words, width) from bit 7 to bit 0: which bits of which signal lie there."""
    owner = {position: (s.name, i if not s.big_endian else s.length - 1 - i, s.length)
             for s in m.signals for i, position in enumerate(s.bits())}
    found = [owner.get(8 * byte + bit) for bit in range(7, -1, -1)]
    out = []
    for name, run in groupby(found, key=lambda o: o[0] if o else None):
        run = list(run)
        if name is None:
            out.append(("", len(run)))
            continue
        high, low, length = run[0][1], run[-1][1], run[0][2]
        which = "" if len(run) == length else f" {high}" if high == low else f" {high}..{low}"
        out.append((name + which, len(run)))
    return out


def layout(m: model.Message) -> list[str]:
    """A picture of the payload; numbers behind a name are the bits of that signal, 0 the lowest."""
    lines = ["<table>", "<tr><th>byte</th>" + "".join(f"<th>bit {b}</th>" for b in range(7, -1, -1)) + "</tr>"]
    for byte in range(m.dlc):
        cells = "".join(f'<td colspan="{width}" align="center">{words or "&nbsp;"}</td>'
                        for words, width in pieces(m, byte))
        lines.append(f"<tr><th>{byte}</th>{cells}</tr>")
    return [*lines, "</table>", ""]


def coding(s: model.Signal) -> str:
    order = "big-endian" if s.big_endian else "little-endian"
    return f"{s.start}, {s.length}" + (f", {order}" if s.length > 8 else "") + (", signed" if s.signed else "")


def meaning(s: model.Signal) -> str:
    words = [s.comment] if s.comment else []
    if s.is_enum:
        words.append(", ".join(f"{raw} {name}" for raw, name in sorted(s.choices.items()) if name != model.INVALID))
    if s.bit_names:
        words.append(", ".join(f"bit {i} {name}" for i, name in enumerate(s.bit_names)))
    if not words and s.role in ("counter", "crc", "checksum"):
        words.append({"counter": "Rolling counter.", "crc": "CRC-8 over identifier and bytes before it.",
                      "checksum": "Of identifier and bytes before it."}[s.role])
    return cell(" ".join(words))


def signal_row(s: model.Signal) -> list[str]:
    has_number = s.needs_unit or s.role == "raw"
    return [s.name, coding(s), s.unit, f"{number(s.minimum)} to {number(s.maximum)}" if has_number else "",
            number(s.scale) if has_number else "", number(s.offset) if has_number and s.offset else "",
            "" if s.invalid_code is None else f"0x{s.invalid_code & (1 << s.length) - 1:X}", meaning(s)]


def message_section(entry: list[model.Message], bus: model.Bus) -> list[str]:
    m = entry[0]
    facts = [f"{ids(entry)}, {m.dlc} bytes, sent by {m.sender} to {receivers(m)}, {cycle(m, bus.fast_cells)}{delay(m)}"]
    if m.timeout_ms:
        facts.append(f"lost after {m.timeout_ms} ms")
    facts.append(f"at most {model.worst_case_bits(m.dlc, bool(m.id >> 31))} bits on the wire")
    lines = [f"## {title(entry)}", "", "; ".join(facts) + "."]
    if m.comment:
        lines.append(m.comment if len(entry) == 1 else f"The first of them: {m.comment[0].lower()}{m.comment[1:]}")
    lines += ["", *layout(m)]
    return lines + table(["signal", "start bit, length", "unit", "range", "factor", "offset", "no value", "meaning"],
                         [signal_row(s) for s in m.signals])


def page(file: Path, folder_bus: model.Bus) -> str:
    bus = model.load([file])
    lines = [f"# {file.name}", "", bus.comment, "", MADE]
    if file.name != "lockstep.dbc":
        instead = ", ".join(sorted(next(iter(bus.instead_of.values()), ())))
        car = folder_bus.variants()[1 + list(folder_bus.instead_of).index(str(file)) if instead else 0]
        loads = ", ".join(f"{check.load_pct(car, n):.1f} % with {n} cells" for n in (48, 144))
        lines += [f"{bus.bit_rate // 1000} kbit/s. Load of car.dbc, orion.dbc and charger.dbc together"
                  f"{', with these in the place of ' + instead + ',' if instead else ''} with every "
                  f"stuff bit that can occur: {loads}.", ""]
    lines += table(["id", "message", "sender", "receivers", "cycle", "lost after", "bytes", "protection"],
                   [message_row(entry, bus) for entry in entries(bus.messages)])
    lines.append('Numbers behind a name in the pictures are bits of that signal, 0 the lowest. "No value" is the raw '
                 "code that says: no measurement.\n")
    for entry in entries(bus.messages):
        lines += message_section(entry, bus)
    return "\n".join(lines).rstrip() + "\n"


def index(files: list[Path]) -> str:
    lines = ["# Messages on the bus", "", MADE]
    rows = []
    for file in files:
        rows += [(entry[0].id, entry, file) for entry in entries(model.load([file]).messages)]
    lines += table(["id", "message", "sender", "what", "page"],
                   [[ids(entry), f"[{title(entry)}]({file.stem}.md#{anchor(entry)})", entry[0].sender,
                     cell(entry[0].comment), f"[{file.name}]({file.stem}.md)"]
                    for _, entry, file in sorted(rows, key=lambda row: row[0])])
    return "\n".join(lines).rstrip() + "\n"


def pages(folder: Path) -> dict[str, str]:
    files = [folder / name for name in FILES]
    bus = model.load(files[:ON_THE_BUS])
    return {"README.md": index(files), **{f"{file.stem}.md": page(file, bus) for file in files}}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="write nothing, say which pages are out of date")
    parser.add_argument("--dbc", type=Path, default=HERE, metavar="DIR", help="folder of the DBC files (can_dbc)")
    parser.add_argument("--out", type=Path, default=HERE / "doc", metavar="DIR",
                        help="folder of the pages (can_dbc/doc)")
    arguments = parser.parse_args()
    made = pages(arguments.dbc)
    if not arguments.check:
        arguments.out.mkdir(parents=True, exist_ok=True)
        for name, text in made.items():
            (arguments.out / name).write_text(text)
        return 0
    old = [name for name, text in made.items()
           if not (arguments.out / name).exists() or (arguments.out / name).read_text() != text]
    for name in old:
        print(f"can_dbc: {arguments.out / name} is not what the DBC files say; run {COMMAND}", file=sys.stderr)
    return 1 if old else 0


if __name__ == "__main__":
    sys.exit(main())
