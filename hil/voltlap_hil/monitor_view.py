# SPDX-License-Identifier: Apache-2.0
"""The state of the bus as tables for the terminal."""
from __future__ import annotations

from typing import Any

from rich.columns import Columns
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

COLOURS = {"fresh": "green", "late": "yellow", "lost": "bold red", "never": "dim"}
_GROUPS = ("CellVoltages", "Temperatures")
_STATE_STYLES = {**dict.fromkeys(("TsActive", "ReadyToDrive", "Enabled"), "green"),
                 **dict.fromkeys(("Fault", "CommandTimeout"), "bold red")}
_NUMBERS = ("age, ms", "1/s", "value")  # columns of numbers


def number(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, float) else "no value" if value is None else str(value)


def _with_unit(reading: dict[str, Any]) -> str:
    unit = reading["unit"] if reading["value"] is not None else ""
    return f"{number(reading['value'])} {unit}".rstrip()


def _age(row: dict[str, Any]) -> str:
    return "" if row["age_ms"] is None else f"{row['age_ms']:.0f}"


def header(snapshot: dict[str, Any], channel: str) -> Text:
    clock = "simulated time" if snapshot["clock"] == "lockstep" else "time of the bus"
    pace = f", {snapshot['pace']:g} times real time" if snapshot["pace"] else ""
    text = Text.assemble((channel, "bold"), f"   {snapshot['time_s']:.2f} s ({clock}{pace})   "
                         f"{snapshot['frames_per_s']:.0f} frames/s   bus load ",
                         (f"{snapshot['bus_load_pct']:.1f} %", "bold"))
    if snapshot["unknown_ids"]:
        text.append("   unknown: " + ", ".join(f"{i} ({n})" for i, n in snapshot["unknown_ids"].items()), "yellow")
    return text


def _table(*columns: str, title: str) -> Table:
    table = Table(title=title, title_justify="left", title_style="bold", box=None, pad_edge=False)
    for column in columns:
        table.add_column(column, justify="right" if column in _NUMBERS else "left", no_wrap=column != "")
    return table


def states(snapshot: dict[str, Any]) -> Table:
    table = _table("node", "state", "", title="States")
    for node, row in snapshot["states"].items():
        more = [(", ".join(row["faults"]), "bold red")] if row["faults"] else []
        more += [(f"{name} {number(value)}", "yellow" if value not in (None, "None") else "dim")
                 for name, value in row.items() if name not in ("state", "faults")]
        state = Text(number(row["state"]), _STATE_STYLES.get(row["state"], ""))
        table.add_row(node, state, Text("  ").join(Text(*m) for m in more))
    return table


def limits(snapshot: dict[str, Any]) -> Table:
    table = _table("limit", "value", "reason", title="Limits")
    for row in snapshot["limits"]:
        cell = f" (cell {row['cell']})" if row["cell"] is not None else ""
        table.add_row(row["what"], f"{number(row['value'])} {row['unit']}" if row["value"] is not None else "no value",
                      f"{number(row['reason'])}{cell}")
    for what in ("cells", "temperatures"):
        if row := snapshot[what]:
            table.add_row(what, f"{number(row['least'])} .. {number(row['most'])} {row['unit']}",
                          f"{row['count']} of them, least at {row['least_at']}, most at {row['most_at']}")
    return table


def nodes(snapshot: dict[str, Any]) -> Table:
    table = _table("node", "is", "age, ms", "1/s", "", title="Nodes")
    for node, row in snapshot["nodes"].items():
        lost = ", ".join(row["lost"][:3]) + (" ..." if len(row["lost"]) > 3 else "")
        table.add_row(node, Text(row["state"], COLOURS[row["state"]]), _age(row), f"{row['per_s']:.0f}",
                      Text(f"lost: {lost}" if lost else "", "red"))
    return table


def messages(snapshot: dict[str, Any]) -> Table:
    table = _table("id", "message", "age, ms", "1/s", "", title="Messages")
    for name, row in snapshot["messages"].items():
        if name.rpartition("_")[0] in _GROUPS:
            continue
        content = Text(", ".join(f"{signal} {_with_unit(reading)}" for signal, reading in row["signals"].items()))
        wrong = [f"{row['bad_seals']} bad CRC"] if row["bad_seals"] else []
        wrong += [f"{row['counter_gaps']} counter gaps"] if row["counter_gaps"] else []
        if wrong:
            content.append(("  " if content else "") + ", ".join(wrong), "bold red")
        table.add_row(row["id"], Text(name, COLOURS[row["state"]] if row["state"] != "fresh" else ""), _age(row),
                      f"{row['per_s']:.0f}", content)
    return table


def view(snapshot: dict[str, Any], channel: str) -> RenderableType:
    overview = Columns([nodes(snapshot), states(snapshot), limits(snapshot)], padding=(0, 4))
    return Group(header(snapshot, channel), "", overview, "", messages(snapshot))
