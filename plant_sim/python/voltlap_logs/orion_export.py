# SPDX-License-Identifier: Apache-2.0
"""Known faults of the DBC files that the Orion utility exports: mended where what is meant is certain, and said.

Its currents and temperatures are two's complement on the bus, and some exports mark them unsigned; the offset of a
checksum is the constant of its rule. Names and identifiers that stand twice are refused where every file's are."""
from __future__ import annotations

import re

NODE, FRAME = "Third_Party_Device", "MSGID_0X"
SIGNED = {"Celsius": re.compile(r"\w+_Temperature"), "Amps": re.compile(r"(?!Abs)\w+_Current")}


def orion_frames(database) -> set[str]:
    """Names of the frames that the utility wrote, by its names for frames and their receiver: a team's own file may
    hold them beside others."""
    return set() if database is None else {
        message.name for message in database.messages
        if message.name.startswith(FRAME) and any(NODE in signal.receivers for signal in message.signals)}


def mended(entries: list[dict], names: set[str]) -> list[dict]:
    """Reads as signed what the exporter marks unsigned in these frames; a note with its line for each fault."""
    notes = []
    for entry in entries:
        for signal in entry["signals"] if entry["name"] in names else []:
            name = f"{entry['name']}.{signal['name']}"
            pattern = SIGNED.get(signal["unit"])
            if pattern and pattern.fullmatch(signal["name"]) and not signal["signed"] and not signal["float"]:
                signal["signed"] = True
                notes.append({"line": signal["line"], "text": f"{name} unsigned, as Orion's exporter writes it; it is "
                              "two's complement, and read as that"})
            elif signal["name"] == "CRC_Checksum" and signal["offset"]:
                notes.append({"line": signal["line"], "text": f"{name} with offset {signal['offset']:g}, as Orion's "
                              "exporter writes it: the constant of its rule, not an offset of its value"})
    return notes
