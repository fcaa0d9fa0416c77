# SPDX-License-Identifier: Apache-2.0
"""The fault matrix as text, JSON, Markdown and one HTML page."""
from __future__ import annotations

import json
import os
import textwrap
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from .errors import InputError
from .fault_page import html_page
from .fault_run import FAILED, KNOWN, NOT_RUN, PASSED, RowResult, bound_ms
from .fault_table import Row
from .in_process import PROCESS

_ORDER = {FAILED: 0, KNOWN: 1, PASSED: 2, NOT_RUN: 3}


@dataclass(frozen=True)
class Matrix:
    rows: Sequence[Row]
    results: Sequence[RowResult]
    seed: int
    bus: str
    wall_s: float
    ecu: str = "inside"

    def count(self, verdict: str) -> int:
        return sum(result.verdict == verdict for result in self.results)

    def failures_first(self) -> list[tuple[Row, RowResult]]:
        return sorted(zip(self.rows, self.results, strict=True), key=lambda pair: _ORDER[pair[1].verdict])

    @property
    def where(self) -> str:
        if self.ecu != "inside":
            return f"firmware on {'emulated boards' if self.ecu == 'qemu' else 'boards that are processes'}"
        return "in one process" if self.bus == PROCESS else f"as processes on {self.bus}"

    @property
    def same_frames(self) -> int:
        """Rows whose every frame was that of the run in one process."""
        return sum(bool(result.trace_hash) and not result.other_frame for result in self.results)

    def steps(self, node: str) -> tuple[float, int, str] | None:
        """Instructions of a step over all rows: mean, worst, and the row of that."""
        costs = [(row.id, result.ecu["instructions_per_step"][node]) for row, result in
                 zip(self.rows, self.results, strict=True) if result.ecu]
        counted = [(row, cost) for row, cost in costs if cost]
        if not counted:
            return None
        steps = sum(cost["steps"] for _, cost in counted)
        worst, row = max((cost["worst"], row) for row, cost in counted)
        return sum(cost["mean"] * cost["steps"] for _, cost in counted) / steps, worst, row

    @property
    def summary(self) -> str:
        known = f", {self.count(KNOWN)} known" if self.count(KNOWN) else ""
        not_run = f", {self.count(NOT_RUN)} could not be run" if self.count(NOT_RUN) else ""
        faults = "1 fault" if len(self.rows) == 1 else f"{len(self.rows)} faults"
        return f"{faults}: {self.count(PASSED)} passed, {self.count(FAILED)} failed{known}{not_run}"

    def not_run(self) -> dict[str, list[str]]:
        """Why rows could not be run, each reason once -> their ids."""
        out: dict[str, list[str]] = {}
        for row, result in zip(self.rows, self.results, strict=True):
            if result.verdict == NOT_RUN:
                out.setdefault(result.error, []).append(row.id)
        return out


def milliseconds(value: float | None) -> str:
    return "-" if value is None else f"{value:g} ms"


def bounds(row: Row) -> dict[str, str]:
    """What the table asks: name of the column -> bound in ms."""
    out = {}
    if row.seen:
        out["seen"] = f"{bound_ms(row, row.seen):g}"
    for name, check in row.reactions.items():
        out[name] = f"{bound_ms(row, check):g}"
    if row.goes_on_ms:
        out["goes_on"] = f"{row.goes_on_ms:g}"
    return out


def _reaction(result_ms: float | None, name: str, row: Row) -> str:
    bound = bounds(row).get(name)
    return "" if bound is None else f"{milliseconds(result_ms)} of {bound}"


def cells(row: Row, result: RowResult) -> list[str]:
    """seen, torque zero, contactors: measured beside its bound."""
    seen = _reaction(result.seen_ms, "seen", row)
    contactors = _reaction(result.contactors_open_ms, "contactors_open_within", row)
    return [seen, _reaction(result.torque_zero_ms, "torque_zero_within", row), contactors]


def reasons(result: RowResult) -> list[str]:
    """Why a row did not pass."""
    out = [result.error] if result.error else [str(r) for r in result.results if not r.held]
    if result.other_frame:
        out.append(f"another frame than in one process: {result.other_frame}")
    if result.sound_car not in ("", "goes on"):
        out.append(f"the sound car {result.sound_car}")
    return out


def listing(rows: Sequence[Row]) -> str:
    width = max(len(row.id) for row in rows)
    lines, group = [], ""
    for row in sorted(rows, key=lambda r: r.group):
        if row.group != group:
            group = row.group
            lines.append(group)
        lines.append(f"  {row.id:{width}}  {row.what} [{row.answers_to}]{' vcan' if row.vcan else ''}")
    return "\n".join([*lines, f"{len(rows)} rows"])


def text(matrix: Matrix) -> str:
    head = ("", "fault", "told", "torque zero", "contactors open", "the car")
    table: list[tuple[str, ...]] = [head]
    shown = [pair for pair in matrix.failures_first() if pair[1].verdict != NOT_RUN]
    for row, result in shown:
        table.append((result.verdict, row.id, *cells(row, result), result.did))
    widths = [max(len(line[i]) for line in table) for i in range(len(head))]
    lines = []
    for line, pair in zip(table, [None, *shown], strict=True):
        lines.append("  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip())
        if pair is not None and pair[1].verdict in (FAILED, KNOWN):
            lines += [f"{'':{widths[0]}}    {reason}" for reason in reasons(pair[1])]
            if pair[0].known:
                lines.append(f"{'':{widths[0]}}    known: {pair[0].known}")
    for reason, ids in matrix.not_run().items():
        lines += ["", reason, *textwrap.wrap(", ".join(ids), 116, initial_indent="  ", subsequent_indent="  ")]
    if matrix.ecu != "inside":
        driven = len(matrix.rows) - matrix.count(NOT_RUN)
        lines += ["", f"{matrix.same_frames} of {driven} with every frame as in one process"]
        lines += [f"instructions of a step, {node}: {found[0]:.0f} mean, {found[1]} at most ({found[2]})"
                  for node in ("bms", "master") if (found := matrix.steps(node))]
    return "\n".join([*lines, "", f"{matrix.summary}; seed {matrix.seed}, {matrix.where}, {matrix.wall_s:.0f} s"])


def json_text(matrix: Matrix) -> str:
    rows = []
    for row, result in zip(matrix.rows, matrix.results, strict=True):
        measured = asdict(result)
        measured["results"] = [asdict(check) for check in result.results]
        rows.append({"id": row.id, "group": row.group, "what": row.what, "rule": row.rule,
                     "table": row.scenario.path.name, "line": row.line, "proves": row.scenario.proves,
                     "drive": row.situation.name, "bounds_ms": bounds(row),
                     "known": row.known, "vcan": row.vcan, **{k: v for k, v in measured.items() if k != "id"}})
    head = {"summary": matrix.summary, "seed": matrix.seed, "bus": matrix.bus, "ecu": matrix.ecu,
            "same_frames": matrix.same_frames, "wall_s": round(matrix.wall_s, 1),
            "instructions_per_step": {node: dict(zip(("mean", "worst", "row"), found, strict=True))
                                      for node in ("bms", "master") if (found := matrix.steps(node))}}
    return json.dumps({**head, "rows": rows}, indent=1) + "\n"


def markdown(matrix: Matrix) -> str:
    """The table of docs/fault_matrix.md; nothing in it depends on the machine."""
    lines = []
    for group in dict.fromkeys(row.group for row in matrix.rows):
        lines += ["", f"### {group[0].upper()}{group[1:]}", "",
                  "| row | fault | rule, requirement | told | torque zero | contactors open | the car | result |",
                  "|---|---|---|---|---|---|---|---|"]
        for row, result in zip(matrix.rows, matrix.results, strict=True):
            if row.group == group:
                told = [row.id, row.what, row.answers_to, *cells(row, result), result.did, result.verdict]
                lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in told) + " |")
    known = [f"- `{row.id}`: {row.known}" for row, result in zip(matrix.rows, matrix.results, strict=True)
             if result.verdict == KNOWN]
    tail = ["", "Known failures:", "", *known] if known else []
    return "\n".join([f"{matrix.summary} (seed {matrix.seed}).", *lines, *tail]) + "\n"


def page(matrix: Matrix) -> str:
    return html_page(matrix.summary, f"{matrix.where}, seed {matrix.seed}",
                     [(row, result, cells(row, result), reasons(result)) for row, result in matrix.failures_first()])


BEGIN, END = "<!-- rows of hil/faults.yaml: begin -->\n", "<!-- rows of hil/faults.yaml: end -->\n"


def renewed(path: Path, table: str) -> str:
    """The table alone, or in its place in a document that has marks for it."""
    if not path.exists():
        return table
    old = path.read_text(encoding="utf-8")
    if BEGIN not in old or END not in old:
        raise InputError(f"{path}: found a file without the marks {BEGIN.strip()} and {END.strip()}, expected one with "
                         "them or none; name another file")
    head, _, rest = old.partition(BEGIN)
    return f"{head}{BEGIN}\n{table}\n{END}{rest.partition(END)[2]}"


def write(path: Path, content: str) -> None:
    """The file is there whole or not at all."""
    part = path.with_name(path.name + ".part")
    try:
        part.write_text(content, encoding="utf-8")
        os.replace(part, path)
    except OSError as error:
        raise InputError(f"{path}: cannot write: {error.strerror}") from None
