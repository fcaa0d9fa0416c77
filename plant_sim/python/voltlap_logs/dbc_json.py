# SPDX-License-Identifier: Apache-2.0
"""Frames and signals of a DBC, KCD, SYM or ARXML file as JSON, read by cantools.

    python -m voltlap_logs.dbc_json FILE

What cannot be used stands under "refused" with its line and reason, and hurts only who asks for it. Exit code 2: the
file as a whole cannot be used; the reason is on standard error."""
from __future__ import annotations

import gzip
import json
import logging
import math
import pathlib
import sys
import zlib

try:
    import cantools
except ModuleNotFoundError as missing:  # its own dependencies included
    print(f"No module named '{missing.name}'", file=sys.stderr)
    sys.exit(3)

from voltlap_logs.dbc_invalid_codes import invalid_codes, protocol_is_j1939
from voltlap_logs.dbc_statements import Refused, TooMuchUnreadable, Unit, read_statements
from voltlap_logs.orion_export import mended, orion_frames

FORMAT = 5  # also in plant_sim/io/logs/dbc_json.cpp: another number makes every cache entry anew
MOST_BYTES = 32_000_000
MOST_FRAME_BYTES = 64
OTHER_KINDS = (".kcd", ".sym", ".arxml", ".cdd")
EXTENDED = 0x80000000


class FileRefused(Exception):
    def __init__(self, where, found, expected, action):
        super().__init__(f"{where}: found {found}; expected {expected}. {action}.")


def hexadecimal(identifier: int, extended: bool) -> str:
    return f"0x{identifier:08X}" if extended else f"0x{identifier:X}"


def text_of(path: pathlib.Path) -> str:
    wanted = ("a DBC file", "Check that this is the file you meant")
    try:
        if path.stat().st_size > MOST_BYTES:
            raise FileRefused(path, f"{path.stat().st_size / 1e6:.0f} MB",
                              f"at most {MOST_BYTES / 1e6:.0f} MB of a DBC file", wanted[1])
        data = path.read_bytes()
        if data.startswith(b"\x1f\x8b"):
            with gzip.open(path) as packed:
                data = packed.read(MOST_BYTES + 1)
    except (OSError, EOFError, zlib.error) as error:
        raise FileRefused(path, f"that it cannot be read ({error})", *wanted) from error
    if len(data) > MOST_BYTES:
        raise FileRefused(path, f"more than {MOST_BYTES / 1e6:.0f} MB", *wanted)
    if not data.strip():
        raise FileRefused(path, "an empty file", *wanted)
    if b"\0" in data[:100000] and not data.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise FileRefused(path, "a binary file", *wanted)
    for encoding in ("utf-16",) if data.startswith((b"\xff\xfe", b"\xfe\xff")) else ("utf-8-sig", "cp1252"):
        try:
            text = data.decode(encoding)
            break
        except UnicodeDecodeError:
            text = data.decode("cp1252", errors="replace")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def ranges(numbers) -> list[list[int]]:
    out: list[list[int]] = []
    for number in sorted(numbers):
        if out and number == out[-1][1] + 1:
            out[-1][1] = number
        else:
            out.append([number, number])
    return out


def finite(value):
    return None if value is None or not math.isfinite(value) else float(value)


def signal_json(signal, message, database, line, long_names) -> dict:
    multiplexer = signal.multiplexer_signal
    return {
        "name": signal.name, "line": line, "start": signal.start, "length": signal.length,
        "big_endian": signal.byte_order == "big_endian", "signed": bool(signal.is_signed),
        "float": bool(signal.is_float), "scale": float(signal.scale), "offset": float(signal.offset),
        "min": finite(signal.minimum), "max": finite(signal.maximum), "unit": signal.unit or "",
        "comment": signal.comment or "",
        "choices": [[int(raw), str(name)] for raw, name in (signal.choices or {}).items()],
        "invalid": invalid_codes(signal, message, database), "is_multiplexer": bool(signal.is_multiplexer),
        # cantools gives the short name here.
        "multiplexer": long_names.get(multiplexer, multiplexer), "cases": ranges(signal.multiplexer_ids or ()),
    }


def last_byte(signal) -> int:
    if signal.byte_order == "little_endian":
        return (signal.start + signal.length - 1) // 8
    return (8 * (signal.start // 8) + 7 - signal.start % 8 + signal.length - 1) // 8


def fault_of_signal(signal, message):
    """(found, expected, what to do) of a signal that cannot be decoded; None for a good one."""
    if not 1 <= signal.length <= 64:
        return f"signal {signal.name} of {signal.length} bits", "1 to 64", "Correct the signal"
    if signal.is_float and signal.length not in (16, 32, 64):
        return (f"signal {signal.name}, floating point with {signal.length} bits", "16, 32 or 64 bits",
                "Correct its length or its value type")
    if not math.isfinite(signal.scale) or not math.isfinite(signal.offset):
        return f"signal {signal.name} with a scale that is no number", "finite numbers", "Correct the signal"
    if last_byte(signal) >= message.length:
        return (f"signal {signal.name} that ends in byte {last_byte(signal)}",
                f"the {message.length} bytes of {message.name}", "Correct one of them")
    return None


def fault_of_multiplexing(signal, by_name, marker):
    name = signal["multiplexer"]
    if name is None and marker.startswith("m"):
        return (f"signal {signal['name']} ({marker}), one of several multiplexers' without its own",
                "SG_MUL_VAL_ that says which multiplexer it belongs to", "Add the statement")
    seen = {signal["name"]}
    while name is not None:
        above = by_name.get(name)
        if above is None or name in seen:
            return (f"signal {signal['name']} whose multiplexer {name} is {'itself' if above else 'not there'}",
                    "a signal of the same frame", "Correct the multiplexing")
        if above["float"]:
            return f"multiplexer {name} in floating point", "a whole number", "Correct its value type"
        seen.add(name)
        name = above["multiplexer"]
    return None


def fault_of_frame(message, entry, markers):
    """(line, found, expected, what to do) for the first thing that makes a frame unusable."""
    if message.length > MOST_FRAME_BYTES:
        return (entry["line"], f"frame {message.name} of {message.length} bytes", f"at most {MOST_FRAME_BYTES}",
                "Correct its length")
    by_name: dict[str, dict] = {}
    for signal, row in zip(message.signals, entry["signals"], strict=True):
        if signal.name in by_name:
            return (row["line"], f"signal {signal.name} for the second time in {message.name}",
                    f"each name once in a frame (line {by_name[signal.name]['line']} has it)", "Rename or remove it")
        by_name[signal.name] = row
        if fault := fault_of_signal(signal, message):
            return (row["line"], *fault)
    for row, marker in zip(entry["signals"], markers, strict=True):
        if fault := fault_of_multiplexing(row, by_name, marker):
            return (row["line"], *fault)
    return None


def marker_of(statement) -> str:
    return statement.words[2] if len(statement.words) > 2 and statement.words[2] != ":" else ""


def frame_json(message, database, unit) -> tuple[dict, list[str]]:
    """The frame, and the multiplexing mark of each of its signals as it stands in the file."""
    rows = unit.statements[1:] if unit else []
    if len(rows) != len(message.signals):
        rows = [None] * len(message.signals)
    long_names = {row.words[1]: signal.name for row, signal in zip(rows, message.signals, strict=True) if row}
    entry = {
        "id": message.frame_id, "extended": bool(message.is_extended_frame), "fd": bool(message.is_fd),
        "name": message.name, "line": unit.line if unit else 0, "length": message.length,
        "cycle_time_ms": message.cycle_time, "senders": list(message.senders),
        "comment": message.comment or "",
        "j1939": bool(message.is_extended_frame) and protocol_is_j1939(message, database),
        "signals": [signal_json(signal, message, database, row.line if row else 0, long_names)
                    for row, signal in zip(rows, message.signals, strict=True)],
    }
    return entry, [marker_of(row) if row else "" for row in rows]


def refusal(key: tuple[int, bool], name: str, fault: tuple[int, str, str, str]) -> dict:
    """`key`: identifier and whether it has 29 bits; `fault`: line, what was found, what was expected, what to do."""
    line, found, expected, action = fault
    return {"id": key[0], "extended": key[1], "name": name, "line": line, "found": found, "expected": expected,
            "action": action}


def refusals_of_statements(left_out: list[Refused], units: list[Unit]) -> tuple[list[dict], list[dict]]:
    """(refused frames, other statements that were left out). A frame is refused as well when a statement that decides
    how its bits are read cannot be read itself."""
    frames, notes = [], []
    names = {unit.number: unit.words[2] for unit in units}
    for entry in left_out:
        unit, found = entry.unit, f"what cantools cannot read ({entry.reason})"
        if unit.keyword in ("BO_", "SIG_VALTYPE_", "SG_MUL_VAL_") and unit.number is not None:
            name = unit.words[2] if unit.is_frame else names.get(unit.number, "")
            key = unit.number & ~EXTENDED, bool(unit.number & EXTENDED)
            frames.append(refusal(key, name, (unit.line, found, "a statement of a DBC file", "Correct the line")))
        elif unit.words[0] not in ("NS_", "VERSION"):
            notes.append({"line": unit.line, "text": found})
    return frames, notes


def twice(entries: list[dict]) -> list[dict]:
    first: dict[tuple[int, bool], dict] = {}
    out = []
    for entry in entries:
        key = entry["id"], entry["extended"]
        earlier = first.setdefault(key, entry)
        if earlier is not entry:
            out.append(refusal(key, entry["name"], (entry["line"], f"frame {hexadecimal(*key)} for the second time",
                                                    f"each frame once (line {earlier['line']} has it)",
                                                    "Keep the one that the car really sends")))
    return out


def database_json(path: pathlib.Path, text: str) -> dict:
    suffix = path.suffixes[-2] if path.suffix.lower() == ".gz" and len(path.suffixes) > 1 else path.suffix
    if suffix.lower() in OTHER_KINDS:
        database, units, left_out = other_database(path, text, suffix.lower()), [], []
    else:
        try:
            database, units, left_out = read_statements(text)
        except TooMuchUnreadable as error:
            raise FileRefused(f"{path}:{error}", "too much that cantools cannot read to name each statement",
                              "a DBC file", "Check that this is the file you meant, or export it anew") from error
    messages = list(database.messages) if database else []
    if len(units) != len(messages):
        units = [None] * len(messages)
    refused, notes = refusals_of_statements(left_out, [unit for unit in units if unit])
    entries = []
    for message, unit in zip(messages, units, strict=True):
        entry, markers = frame_json(message, database, unit)
        entries.append(entry)
        if fault := fault_of_frame(message, entry, markers):
            refused.append(refusal((entry["id"], entry["extended"]), entry["name"], fault))
    refused += twice(entries)
    notes += mended(entries, orion_frames(database))
    if not entries and not refused:
        raise FileRefused(path, "no frame (BO_)", "a DBC file", "Check that this is the file you meant")
    left = {(entry["id"], entry["extended"]) for entry in refused}
    usable = [entry for entry in entries if (entry["id"], entry["extended"]) not in left]
    return {"format": FORMAT, "messages": usable, "refused": refused, "notes": notes}


def other_database(path, text, suffix):
    try:
        database = cantools.database.load_string(text, suffix[1:], strict=False, sort_signals=None)
    except Exception as error:  # of whatever reads these formats
        raise FileRefused(path, f"what cantools cannot read ({' '.join(str(error).split())[:300]})",
                          f"a {suffix[1:].upper()} file", "Export it anew, or as DBC") from error
    if not hasattr(database, "messages"):
        raise FileRefused(path, "a description of diagnostics, which has no frames", "a DBC file",
                          "Export the bus's frames as DBC")
    return database


def main(arguments: list[str]) -> int:
    if len(arguments) != 1:
        print(__doc__, file=sys.stderr)
        return 2
    logging.disable(logging.CRITICAL)  # cantools' hints about what is refused here with a line
    path = pathlib.Path(arguments[0])
    try:
        result = database_json(path, text_of(path))
    except FileRefused as error:
        print(error, file=sys.stderr)
        return 2
    json.dump(result, sys.stdout, ensure_ascii=True, allow_nan=False)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
