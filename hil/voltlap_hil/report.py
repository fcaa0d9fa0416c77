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
    good = sum(outcome.good for outcome in outcomes)
    return f"{len(outcomes)} runs, {good} as they must be, {len(outcomes) - good} not."


def markdown(outcomes: Sequence[Outcome]) -> str:
    head = ["| " + " | ".join(_COLUMNS) + " |", "|---" * len(_COLUMNS) + "|"]
    lines = ["# Scenarios", "", _summary(outcomes), "", *head]
    lines += ["| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |" for row in _rows(outcomes)]
    return "\n".join(lines) + "\n"


_STYLE = ("body{font:15px/1.4 sans-serif;margin:2em;max-width:80em}table{border-collapse:collapse}"
          "td,th{border-bottom:1px solid #ccc;padding:.25em .7em;text-align:left;vertical-align:top}"
          ".wrong{background:#fdd}")


def html_page(outcomes: Sequence[Outcome]) -> str:
    def row(cells: Sequence[str], tag: str) -> str:
        wrong = ' class="wrong"' if cells[-1].endswith("WRONG") or cells[-1] == "not run" else ""
        return f"<tr{wrong}>" + "".join(f"<{tag}>{html.escape(cell)}</{tag}>" for cell in cells) + "</tr>"

    body = "\n".join([row(_COLUMNS, "th"), *(row(cells, "td") for cells in _rows(outcomes))])
    return (f'<!doctype html>\n<html lang="en"><meta charset="utf-8"><title>Scenarios</title><style>{_STYLE}</style>\n'
            f"<h1>Scenarios</h1>\n<p>{html.escape(_summary(outcomes))}</p>\n<table>\n{body}\n</table>\n</html>\n")


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
