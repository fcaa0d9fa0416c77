# SPDX-License-Identifier: Apache-2.0
"""The state of a car's buses as tables for the terminal."""
from __future__ import annotations

from typing import Any

from rich.columns import Columns
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from .monitor_view import COLOURS, number

_UNKNOWN = 8
_WRAPPED = ("", "value", "states so far")
_RIGHT = ("frames", "1/s", "load, %", "age, ms", "value", "lowest", "highest")


def _table(title: str, *columns: str) -> Table:
    table = Table(title=title, title_justify="left", title_style="bold", box=None, pad_edge=False)
    for column in columns:
        table.add_column(column, justify="right" if column in _RIGHT else "left", no_wrap=column not in _WRAPPED)
    return table


def header(snapshot: dict[str, Any], channel: str) -> Text:
    text = Text.assemble((channel, "bold"), f"   {snapshot['time_s']:.2f} s   {snapshot['frames']} frames")
    if snapshot.get("format"):
        text.append(f"   {snapshot['format']}")
    for what, counts in (("unknown to the DBC files", snapshot["unknown"]), ("refused", snapshot["refused"])):
        if counts:
            named = ", ".join(f"{i} ({n})" for i, n in list(counts.items())[:_UNKNOWN])
            more = f" and {len(counts) - _UNKNOWN} more" if len(counts) > _UNKNOWN else ""
            text.append(f"\n{sum(counts.values())} frames of {len(counts)} identifiers {what}: {named}{more}", "yellow")
    if silent := snapshot["never_heard"]:
        more = f" and {len(silent) - _UNKNOWN} more" if len(silent) > _UNKNOWN else ""
        text.append(f"\n{len(silent)} frames of the DBC files were never heard: {', '.join(silent[:_UNKNOWN])}{more}",
                    "dim")
    for note in snapshot.get("notes", []):
        text.append(f"\n{note}", "yellow")
    return text


def buses(snapshot: dict[str, Any]) -> Table:
    table = _table("Buses", "bus", "frames", "1/s", "load, %")
    for bus, row in snapshot["buses"].items():
        table.add_row(bus, str(row["frames"]), f"{row['per_s']:.0f}", f"{row['load_pct']:.1f}")
    return table


def messages(snapshot: dict[str, Any]) -> Table:
    several = len(snapshot["buses"]) > 1
    table = _table("Messages", "id", *(["bus"] if several else []), "message", "is", "age, ms", "1/s", "frames", "")
    for row in snapshot["messages"]:
        wrong = Text(f"{row['short']} shorter than in the file" if row["short"] else "", "red")
        table.add_row(row["id"], *([row["bus"]] if several else []), row["message"],
                      Text(row["state"], COLOURS[row["state"]]), f"{row['age_ms']:.0f}", f"{row['per_s']:.0f}",
                      str(row["frames"]), wrong)
    return table


def signals(snapshot: dict[str, Any]) -> Table:
    several = len(snapshot["buses"]) > 1
    table = _table("Signals", "signal", "value", "unit", "lowest", "highest", "states so far")
    for row in snapshot["messages"]:
        place = f"{row['bus']}:" if several else ""
        for name, reading in row["signals"].items():
            states = reading.get("seen", [])
            moved = reading["least"] != reading["most"] and not states
            ends = [number(reading[end]) if moved else "" for end in ("least", "most")]
            table.add_row(f"{place}{row['message']}.{name}", number(reading["value"]), reading["unit"], *ends,
                          ", ".join(map(number, states)) if len(states) > 1 else "",
                          style="" if row["state"] == "fresh" else "dim")
    return table


def view(snapshot: dict[str, Any], channel: str) -> RenderableType:
    return Group(header(snapshot, channel), "", Columns([buses(snapshot), messages(snapshot)], padding=(0, 4)), "",
                 signals(snapshot))
