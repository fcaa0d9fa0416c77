# SPDX-License-Identifier: Apache-2.0
"""The fault matrix as one HTML file: no network, no script; light and dark, table on a desk and cards on a phone.

It wears the style sheet of the project's other reports, plant_sim/io/page/html/page.css.
"""
from __future__ import annotations

import html
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from .quantity import with_unit

_STYLE = Path(__file__).resolve().parents[2] / "plant_sim" / "io" / "page" / "html" / "page.css"
_OWN_STYLE = """
.matrix > summary, .row > summary { cursor: pointer; list-style: none; }
.row { border-bottom: 1px solid var(--line); padding: 7px 0; }
.row > summary { display: grid; gap: 2px 14px; align-items: baseline; font-size: 13.5px;
  grid-template-columns: 74px minmax(0, 2.2fr) minmax(0, 1.1fr) repeat(3, minmax(0, 0.95fr)) minmax(0, 1.1fr); }
.row .id { font-size: 12.5px; color: var(--muted); overflow-wrap: anywhere; display: block; }
.row .label { display: none; color: var(--muted); }
.row.head { color: var(--muted); font-size: 12.5px; }
.row.head > div { display: grid; gap: 2px 14px;
  grid-template-columns: 74px minmax(0, 2.2fr) minmax(0, 1.1fr) repeat(3, minmax(0, 0.95fr)) minmax(0, 1.1fr); }
.row .more { padding: 10px 0 6px; display: grid; gap: 10px; grid-template-columns: minmax(0, 1fr) minmax(0, 2fr); }
.row .more ul { margin: 0; padding-left: 18px; font-size: 13px; overflow-wrap: anywhere; }
.curves { display: grid; gap: 8px; grid-template-columns: repeat(auto-fill, minmax(min(100%, 300px), 1fr)); }
.curve { min-width: 0; } .curve svg { display: block; width: 100%; height: 96px; overflow: visible; }
.curve figcaption { font-size: 12.5px; color: var(--muted); overflow-wrap: anywhere; } .curve { margin: 0; }
.curve .line { fill: none; stroke: var(--blue); stroke-width: 1.6; vector-effect: non-scaling-stroke; }
.curve .event { stroke: var(--orange); stroke-width: 1.2; vector-effect: non-scaling-stroke; stroke-dasharray: 4 3; }
.curve .bound { stroke: var(--purple); stroke-width: 1.2; vector-effect: non-scaling-stroke; }
.curve .axis { stroke: var(--line); vector-effect: non-scaling-stroke; }
@media (max-width: 820px) {
  main { padding: 18px 12px 32px; }
  .row.head { display: none; }
  .row > summary { grid-template-columns: 74px minmax(0, 1fr); }
  .row > summary > :nth-child(n+3) { grid-column: 2; }
  .row .label { display: inline; }
  .row .more { grid-template-columns: minmax(0, 1fr); }
}
@media print { .row .more { display: none; } }
"""
_CHIP = {"passed": "good", "failed": "bad", "known": "open"}
_HEAD = ("", "fault", "rule, requirement", "told after", "torque zero after", "contactors open after", "the car")
_WIDTH, _HEIGHT = 300.0, 90.0


def html_page(summary: str, facts: str, rows: Sequence[tuple[Any, Any, Sequence[str], Sequence[str]]]) -> str:
    verdicts = [result.verdict for _, result, _, _ in rows]
    style = _STYLE.read_text(encoding="utf-8") if _STYLE.exists() else ""
    tiles = "".join(f'<div class="tile"><dt>{name}</dt><dd><b>{count}</b></dd></div>' for name, count in (
        ("faults", len(rows)), ("passed", verdicts.count("passed")), ("failed", verdicts.count("failed")),
        ("known failures", verdicts.count("known"))))
    chip = "good" if all(v == "passed" for v in verdicts) else "bad" if "failed" in verdicts else "open"
    groups = "".join(_group(name, [r for r in rows if r[0].group == name])
                     for name in dict.fromkeys(row.group for row, *_ in rows))
    return (f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
            f'<meta name="viewport" content="width=device-width, initial-scale=1">'
            f'<meta name="color-scheme" content="light dark"><title>Fault matrix</title>'
            f"<style>{style}{_OWN_STYLE}</style></head>\n<body><main>\n"
            f'<p class="status {chip}">{html.escape(summary)}</p>\n<h1>What the car does when something breaks</h1>\n'
            f'<p class="facts">Plant and firmware in the loop, {html.escape(facts)}. Times count from the fault and '
            "stand beside their bound; failures come first. A row opens to what was checked and to the curves: the "
            "fault is at 0 s (dashed orange), the bound of what is asserted purple.</p>\n"
            f'<dl class="tiles">{tiles}</dl>\n{groups}\n</main></body></html>\n')


def _group(name: str, rows: Iterable[tuple[Any, Any, Sequence[str], Sequence[str]]]) -> str:
    head = "".join(f"<span>{html.escape(title)}</span>" for title in _HEAD)
    body = "\n".join(_row(*row) for row in rows)
    return (f"<h2>{html.escape(name[0].upper() + name[1:])}</h2>\n"
            f'<div class="card"><div class="row head"><div>{head}</div></div>\n{body}</div>\n')


def _row(row: Any, result: Any, cells: Sequence[str], reasons: Sequence[str]) -> str:
    labelled = "".join(
        f'<span><span class="label">{html.escape(title)}: </span>{html.escape(cell) or "&ndash;"}</span>'
        for title, cell in zip(_HEAD[2:], (row.answers_to, *cells, result.did), strict=True))
    checked = "".join(f"<li>{html.escape(str(check))}</li>" for check in result.results)
    checked += "".join(f"<li><b>{html.escape(reason)}</b></li>" for reason in reasons)
    if result.sound_car:
        checked += f"<li>the same drive without the fault: {html.escape(result.sound_car)}</li>"
    if row.known:
        checked += f"<li>known: {html.escape(row.known)}</li>"
    curves = "".join(_curve(name, curve) for name, curve in result.curves.items() if curve.points)
    chip = f'<span><span class="status {_CHIP[result.verdict]}">{result.verdict}</span></span>'
    name = f'<span>{html.escape(row.what)}<span class="id">{row.id}; {html.escape(row.situation.what)}</span></span>'
    return (f'<details class="row"{" open" if result.verdict == "failed" else ""}><summary>{chip}{name}{labelled}'
            f'</summary><div class="more"><ul>{checked}</ul><div class="curves">{curves}</div></div></details>')


def _curve(name: str, curve: Any) -> str:
    """Steps from value to value, as a bus holds them; what never changes is a line of words."""
    points, title = curve.points, html.escape(name)
    first, last = points[0][0], points[-1][0]
    low, high = min(0.0, *(v for _, v in points)), max(0.0, *(v for _, v in points))
    if all(v == points[0][1] for _, v in points) or last <= first:
        value = with_unit(points[0][1], curve.unit)
        return f'<figure class="curve"><figcaption>{title}: {value} all the while</figcaption></figure>'

    def x(time_s: float) -> str:
        return f"{(time_s - first) / (last - first) * _WIDTH:.1f}"

    def y(value: float) -> str:
        return f"{_HEIGHT - (value - low) / (high - low) * (_HEIGHT - 4) - 2:.1f}"

    path = f"M{x(first)} {y(points[0][1])}" + "".join(f"H{x(t)}V{y(v)}" for t, v in points[1:])
    marks = [("event", 0.0), *(("bound", ms * 1e-3) for ms in sorted(set(curve.bounds_ms)))]
    lines = f'<line class="axis" x1="0" x2="{_WIDTH:g}" y1="{y(0.0)}" y2="{y(0.0)}"/>'
    lines += "".join(f'<line class="{kind}" x1="{x(t)}" x2="{x(t)}" y1="0" y2="{_HEIGHT:g}"/>'
                     for kind, t in marks if first < t < last)
    span = f"{low:.6g} to {with_unit(high, curve.unit)}, {first:g} to {last:g} s"
    return (f'<figure class="curve"><figcaption>{title}: {span}</figcaption>'
            f'<svg viewBox="0 0 {_WIDTH:g} {_HEIGHT:g}" preserveAspectRatio="none" role="img" '
            f'aria-label="{title}">{lines}<path class="line" d="{path}"/></svg></figure>')
