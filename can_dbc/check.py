# SPDX-License-Identifier: Apache-2.0
"""Refuses a bus that cannot work: overlaps, missing units, unprotected frames, too much load, too many frames a tick.

usage: check.py [--cells N,M] [--lockstep LOCKSTEP.dbc] FILE.dbc ...
exit code 1 and one line a finding when something is wrong
"""
from __future__ import annotations

import argparse
import sys
from collections import Counter
from pathlib import Path

import model

LOAD_MAX_PCT, FRAMES_PER_TICK_MAX = 60.0, 22
INSTEAD_MAX = {  # file -> load, frames a tick
    "pm100.dbc": (61.0, 24),  # it repeats four frames where another sends one
    "amk.dbc": (72.0, 28),    # four inverters: 28 frames at their longest take 7.6 of the 10 ms
}
TICK_MS = 10
LOCKSTEP_IDS = range(0x7E0, 0x800)


def check_ids(bus: model.Bus) -> list[str]:
    seen: dict[int, model.Message] = {}
    findings = []
    for m in bus.messages:
        if m.id in seen:
            findings.append(f"id 0x{m.id:03X} is used by {seen[m.id].name} and by {m.name}")
        seen.setdefault(m.id, m)
        if m.id > 0x7FF and not (m.unsealed and m.id >= model.EXTENDED):  # a CRC covers 16 bits of it
            findings.append(f"{m.name}: the identifier 0x{m.id:X} needs more than 11 bits")
    names = Counter(m.name for m in bus.messages)
    findings += [f"message name {name} is used {n} times" for name, n in names.items() if n > 1]
    return findings


def check_overlaps(bus: model.Bus) -> list[str]:
    findings = []
    for m in bus.messages:
        owner: dict[int, str] = {}
        for s in m.signals:
            bits = s.bits()
            if min(bits) < 0 or max(bits) >= 8 * m.dlc:
                findings.append(f"{m.name}.{s.name} reaches beyond the {m.dlc} bytes of its message")
            clash = sorted({owner[b] for b in bits if b in owner})
            if clash:
                findings.append(f"{m.name}.{s.name} overlaps {', '.join(clash)}")
            owner.update(dict.fromkeys(bits, s.name))
    return findings


def check_signals(bus: model.Bus) -> list[str]:
    """Units, ranges that fit their bits, an invalid code outside the range, and a code 0 in every table."""
    findings = []
    for m in bus.messages:
        for s in m.signals:
            where = f"{m.name}.{s.name}"
            if s.needs_unit and not s.unit:
                findings.append(f"{where} has no unit")
            if s.is_enum and (0 not in s.choices or not s.enum):
                findings.append(f"{where} needs a name for code 0 and the attribute VL_Enum")
            if len(s.bit_names) > s.length:
                findings.append(f"{where} names {len(s.bit_names)} bits and has {s.length}")
            if not s.needs_unit:
                continue
            if s.minimum is None or s.maximum is None or s.minimum >= s.maximum:
                findings.append(f"{where} has no range")
                continue
            low, high = (-(1 << (s.length - 1)), (1 << (s.length - 1)) - 1) if s.signed else (0, (1 << s.length) - 1)
            raw = [(v - s.offset) / s.scale for v in (s.minimum, s.maximum)]
            if raw[0] < low or raw[1] > high:
                findings.append(f"{where}: range {float(s.minimum)} to {float(s.maximum)} does not fit {s.length} bits")
            if s.invalid_code is not None and raw[0] <= s.invalid_code <= raw[1]:
                findings.append(f"{where}: the invalid code {s.invalid_code} lies inside the range")
    return findings


def check_protection(bus: model.Bus) -> list[str]:
    """Every frame is sealed, in the place that the codec knows, and has a sender, a cycle and a timeout."""
    findings = []
    for m in bus.messages:
        roles = {s.role for s in m.signals} & {"counter", "crc", "checksum"}
        if m.unsealed and roles:
            findings.append(f"{m.name} is VL_Unsealed and has a {', a '.join(sorted(roles))}")
        if m.protection == "kNone":
            findings.append(f"{m.name} has neither counter and CRC nor a checksum")
        counter, seal = m.signal_of_role("counter"), m.signal_of_role("crc") or m.signal_of_role("checksum")
        if counter and (counter.length != 8 or counter.start % 8):
            findings.append(f"{m.name}.{counter.name}: a rolling counter has 8 bits, those of one byte")
        if seal and (seal.length != 8 or sorted(seal.bits()) != list(range(8 * m.dlc - 8, 8 * m.dlc))):
            findings.append(f"{m.name}.{seal.name}: not the last byte of the message")
        if not m.sender or m.sender == "Vector__XXX":
            findings.append(f"{m.name} has no sender")
        if m.cycle_ms <= 0 or m.cycle_ms % TICK_MS or m.cycle_many_cells_ms % TICK_MS or m.delay_ms % TICK_MS:
            findings.append(f"{m.name}: cycle and start delay are whole ticks of {TICK_MS} ms, and the cycle is not 0")
        elif m.timeout_ms < 2 * max(m.cycle_ms, m.cycle_many_cells_ms):
            findings.append(f"{m.name}: the timeout of {m.timeout_ms} ms does not survive one lost frame")
    return findings


def load_pct(bus: model.Bus, cells: int) -> float:
    """Share of the bus with every frame as long as stuffing can make it, averaged over the schedule."""
    bits_per_s = sum(model.worst_case_bits(m.dlc, bool(m.id >> 31)) * 1000 / cycle
                     for m, cycle in bus.sent_with(cells) if cycle > 0)
    return 100 * bits_per_s / bus.bit_rate


def frames_per_tick(bus: model.Bus, cells: int) -> int:
    """Most frames of all nodes that are due in one tick."""
    sent = [(m, cycle) for m, cycle in bus.sent_with(cells) if cycle > 0]
    ticks = model.ticks_of_schedule(sent, TICK_MS)
    return max(sum(model.due(m, cycle, tick, TICK_MS) for m, cycle in sent) for tick in range(ticks))


def check_load(bus: model.Bus, cells: int, instead: str = "") -> list[str]:
    """`instead`: the file whose messages stand in the place of others."""
    load_max, frames_max = INSTEAD_MAX.get(Path(instead).name, (LOAD_MAX_PCT, FRAMES_PER_TICK_MAX))
    where = f"{cells} cells" + (f" and {Path(instead).name}" if instead else "")
    findings = []
    load, frames = load_pct(bus, cells), frames_per_tick(bus, cells)
    if load > load_max:
        findings.append(f"bus load of {load:.1f} % with {where}, at most {load_max:.0f} % allowed")
    if frames > frames_max:
        findings.append(f"{frames} frames in one tick with {where}, at most {frames_max} allowed")
    return findings


def check(bus: model.Bus, cell_counts=(48, 144)) -> list[str]:
    findings = check_ids(bus) + check_overlaps(bus) + check_signals(bus) + check_protection(bus)
    for instead, variant in zip(["", *bus.instead_of], bus.variants()):
        for cells in cell_counts:
            findings += check_load(variant, cells, instead)
    return findings


def check_lockstep(lockstep: model.Bus, bus: model.Bus) -> list[str]:
    """Frames that keep processes in step: in the ids set aside for them, which the car leaves free, and unsealed."""
    findings = check_ids(lockstep) + check_overlaps(lockstep) + check_signals(lockstep)
    for m in lockstep.messages:
        if m.id not in LOCKSTEP_IDS:
            findings.append(f"{m.name}: the identifier 0x{m.id:X} is not a lockstep one "
                            f"(0x{LOCKSTEP_IDS[0]:X} to 0x{LOCKSTEP_IDS[-1]:X})")
        if m.dlc != 8 or not m.sender or m.sender == "Vector__XXX":
            findings.append(f"{m.name}: a lockstep message has 8 bytes and a sender")
        if m.protection != "kNone":
            findings.append(f"{m.name}: a lockstep message has neither counter nor CRC")
    findings += [f"{m.name}: the identifier 0x{m.id:X} is a lockstep one" for m in bus.messages if m.id in LOCKSTEP_IDS]
    names = {m.name for m in bus.messages}
    return findings + [f"message name {m.name} is used twice" for m in lockstep.messages if m.name in names]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cells", type=lambda text: [int(n) for n in text.split(",")], default=[48, 144])
    parser.add_argument("--lockstep", help="the messages that keep processes in step, beside the bus of the car")
    parser.add_argument("files", nargs="+")
    arguments = parser.parse_args()
    bus = model.load(arguments.files)
    findings = check(bus, arguments.cells)
    if arguments.lockstep:
        findings += check_lockstep(model.load([arguments.lockstep]), bus)
    for finding in findings:
        print(f"can_dbc: {finding}", file=sys.stderr)
    if not findings:
        for name, variant in zip(["", *bus.instead_of], bus.variants()):
            for cells in arguments.cells:
                print(f"can_dbc: {cells} cells{', with ' + Path(name).name if name else ''}: bus load "
                      f"{load_pct(variant, cells):.1f} %, at most {frames_per_tick(variant, cells)} frames a tick")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
