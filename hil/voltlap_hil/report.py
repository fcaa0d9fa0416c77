# SPDX-License-Identifier: Apache-2.0
"""Outcomes as JUnit XML for machines, and as a page of Markdown or HTML for people."""
from __future__ import annotations

import html
import os
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Sequence
from pathlib import Path

from .checks import Result
from .errors import InputError, check_place
from .runner import Outcome

_COLUMNS = ("scenario", "proves", "run", "check", "measured", "bound", "verdict")


def _measured(result: Result) -> str:
    return "never" if result.measured is None else f"{result.measured:g} {result.unit}"


def _rows(outcomes: Sequence[Outcome]) -> list[tuple[str, ...]]:
    rows: list[tuple[str, ...]] = []
    for outcome in outcomes:
        run = "with event" if outcome.with_event else "without event"
        head = (outcome.scenario.title, ", ".join(outcome.scenario.proves), run)
        if outcome.error:
            rows.append((*head, outcome.error, "", "", "not run"))
        for results, wanted in ((outcome.then, outcome.with_event), (outcome.always, True)):
            rows += [(*head, f"{r.check}{': ' + r.detail if r.detail else ''}", _measured(r), r.bound,
                      ("held" if r.held else "not held") + ("" if r.held == wanted else ", WRONG")) for r in results]
    return rows


def _summary(outcomes: Sequence[Outcome]) -> str:
    good, not_run = sum(outcome.good for outcome in outcomes), sum(bool(outcome.error) for outcome in outcomes)
    runs = "1 run" if len(outcomes) == 1 else f"{len(outcomes)} runs"
    rest = f", {not_run} could not be run" if not_run else ""
    return f"{runs}: {good} as it must be, {len(outcomes) - good - not_run} not{rest}."


def markdown(outcomes: Sequence[Outcome]) -> str:
    head = ["| " + " | ".join(_COLUMNS) + " |", "|---" * len(_COLUMNS) + "|"]
    lines = ["# Scenarios", "", _summary(outcomes), "", *head]
    lines += ["| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |" for row in _rows(outcomes)]
    return "\n".join(lines) + "\n"


_SHEET = Path(__file__).resolve().parents[2] / "plant_sim" / "io" / "page" / "html" / "page.css"
_OWN_STYLE = """
table { border-collapse: collapse; width: 100%; font-size: 13.5px; }
td, th { border-bottom: 1px solid var(--line, #ccc); padding: 5px 10px 5px 0; text-align: left; vertical-align: top;
  overflow-wrap: anywhere; }
td[data-name]::before { display: none; content: attr(data-name) ": "; color: var(--muted, #666); }
.wrong td { font-weight: 600; }
@media (max-width: 820px) {
  main { padding: 18px 12px 32px; }
  thead { display: none; }
  table, tbody, tr, td { display: block; }
  tr { border-bottom: 1px solid var(--line, #ccc); padding: 8px 0; }
  td { border: 0; padding: 1px 0; }
  td:empty { display: none; }
  td[data-name]::before { display: inline; }
}
"""


def html_page(outcomes: Sequence[Outcome]) -> str:
    """One file, no network; a table on a desk, a card a check on a phone. It wears the sheet of the other reports."""
    def row(cells: Sequence[str]) -> str:
        wrong = ' class="wrong"' if cells[-1].endswith("WRONG") or cells[-1] == "not run" else ""
        named = zip(_COLUMNS, cells, strict=True)
        cells = "".join(f'<td data-name="{name}">{html.escape(cell)}</td>' for name, cell in named)
        return f"<tr{wrong}>{cells}</tr>"

    head = "".join(f"<th>{name}</th>" for name in _COLUMNS)
    body = "\n".join(row(cells) for cells in _rows(outcomes))
    chip = "good" if all(outcome.good for outcome in outcomes) else "bad"
    sheet = _SHEET.read_text(encoding="utf-8") if _SHEET.exists() else ""
    return ('<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
            '<meta name="viewport" content="width=device-width, initial-scale=1">'
            f'<meta name="color-scheme" content="light dark"><title>Scenarios</title><style>{sheet}{_OWN_STYLE}</style>'
            f'</head>\n<body><main>\n<p class="status {chip}">{html.escape(_summary(outcomes))}</p>\n'
            f"<h1>Scenarios</h1>\n<table><thead><tr>{head}</tr></thead>\n<tbody>\n{body}\n</tbody></table>\n"
            "</main></body></html>\n")


def junit(outcomes: Sequence[Outcome]) -> str:
    suite = ElementTree.Element("testsuite", name="voltlap_hil", tests=str(len(outcomes)),
                                failures=str(sum(not o.good and not o.error for o in outcomes)),
                                errors=str(sum(bool(o.error) for o in outcomes)))
    for outcome in outcomes:
        case = ElementTree.SubElement(suite, "testcase", classname="voltlap_hil.scenarios",
                                      time=f"{outcome.wall_s:.3f}",
                                      name=outcome.scenario.title + ("" if outcome.with_event else " (without event)"))
        if outcome.error:
            ElementTree.SubElement(case, "error", message=outcome.error)
        elif not outcome.good:
            text = "\n".join(str(r) for r in [*outcome.then, *outcome.always])
            ElementTree.SubElement(case, "failure", message="not as it must be").text = text
        ElementTree.SubElement(case, "system-out").text = "\n".join(str(r) for r in [*outcome.then, *outcome.always])
    return ElementTree.tostring(suite, encoding="unicode", xml_declaration=True) + "\n"


WRITERS: dict[str, Callable[[Sequence[Outcome]], str]] = {".xml": junit, ".md": markdown, ".html": html_page}


def check_name(path: Path) -> None:
    """What can be said before a run: the suffix names a form, and there is a folder to write to."""
    if path.suffix not in WRITERS:
        raise InputError(f"{path}: found {path.suffix or 'no suffix'}, expected one of {', '.join(WRITERS)}")
    check_place(path)


def write(path: str | Path, outcomes: Sequence[Outcome]) -> None:
    """The form follows the suffix. The file is there whole or not at all."""
    path = Path(path)
    check_name(path)
    part = path.with_name(path.name + ".part")
    try:
        part.write_text(WRITERS[path.suffix](outcomes), encoding="utf-8")
        os.replace(part, path)
    except OSError as error:
        raise InputError(f"{path}: cannot write: {error.strerror}") from None
