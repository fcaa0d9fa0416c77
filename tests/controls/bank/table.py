# SPDX-License-Identifier: Apache-2.0
"""The result as text, JSON and one CSV line a case."""

import csv
import json
import math

from . import score


def text_of(judged, facts):
    lines = [f"seed {facts['seed']}, {len(judged)} questions, {facts['seconds']:.0f} s", ""]
    lines.append(f"{'mark':44} {'share [95 %] cases':38} {'bound':>10}")
    for mark in score.marks(judged):
        lines.append(f"{mark.text:44} {mark.shown:38} {bound_of(mark)}")
    lines += ["", "one effect, by d' of the truth", f"{'d-prime':>14}  {'found':36} {'named':36} confidently misnamed"]
    for low, high, found, named, wrong in score.curve(judged):
        if found.of:
            end = "" if math.isinf(high) else f"{high:g}"
            lines.append(f"{low:>7g} to {end:4}  {str(found):36} {str(named):36} {wrong}")
    lines += ["", "one effect, by rho: RMS of what it adds over what is worth a word, in the channel that shows it best"]
    for low, high, marks in score.by_rho(judged):
        end = "and more" if math.isinf(high) else f"to {high:g}"
        for name, mark in marks.items():
            lines.append(f"{low:>4g} {end:8} {name:12} {mark.shown:36} {bound_of(mark)}".rstrip())
    rows, instead = score.by_cause(judged)
    lines += ["", f"{'cause (d-prime of 10 or more)':32} {'found':30} {'named':30} {'in the set':30} said instead"]
    for name, (_, found, named, inside, _) in rows.items():
        most = sorted(instead.get(name, {}).items(), key=lambda item: -item[1])[:2]
        other = "; ".join(f"{count} x {words}" for words, count in most)
        lines.append(f"{name:32} {str(found):30} {str(named):30} {str(inside):30} {other}")
    failures = [j for j in judged if j.answer.failed]
    if failures:
        lines += ["", f"no answer: {len(failures)} of {len(judged)}, such as {failures[0].answer.failed}"]
    seconds = sorted(j.answer.seconds for j in judged if not j.answer.failed)
    if seconds:
        lines += ["", f"time of an answer: median {seconds[len(seconds) // 2]:.2f} s, longest {seconds[-1]:.2f} s"]
    return "\n".join(lines)


def bound_of(mark):
    """Its bound, and whether it is met; empty where none is asked for."""
    if math.isnan(mark.bound):
        return ""
    verdict = {True: "met", False: "NOT MET", None: "no case"}[mark.met]
    return f"{'<=' if mark.side == 'most' else '>='} {mark.bound:<7g} {verdict}"


def share_json(it):
    low, high = it.interval
    return {"hits": it.hits, "of": it.of, "share": it.value if it.of else None, "ci95_low": low, "ci95_high": high}


def json_of(judged, facts):
    rows, instead = score.by_cause(judged)
    return (
        json.dumps(
            {
                **facts,
                "questions": len(judged),
                "marks": [
                    {
                        "text": m.text,
                        "value": None if math.isnan(m.value) else m.value,
                        "shown": m.shown.strip(),
                        "bound": m.bound,
                        "side": m.side,
                        "cases": m.cases,
                        "met": m.met,
                    }
                    for m in score.marks(judged)
                ],
                "curve": [
                    {
                        "d_prime_from": low,
                        "d_prime_to": None if math.isinf(high) else high,
                        "found": share_json(found),
                        "named": share_json(named),
                        "misnamed": share_json(wrong),
                    }
                    for low, high, found, named, wrong in score.curve(judged)
                ],
                "by_rho": [
                    {
                        "rho_from": low,
                        "rho_to": None if math.isinf(high) else high,
                        "cases": marks["found"].cases,
                        **{
                            name.replace(" ", "_"): None if math.isnan(mark.value) else mark.value
                            for name, mark in marks.items()
                        },
                    }
                    for low, high, marks in score.by_rho(judged)
                ],
                "causes": {
                    name: {
                        "cases": count,
                        "found": share_json(found),
                        "named": share_json(named),
                        "in_set": share_json(inside),
                        "misnamed": share_json(wrong),
                        "instead": instead.get(name, {}),
                    }
                    for name, (count, found, named, inside, wrong) in rows.items()
                },
            },
            indent=2,
        )
        + "\n"
    )


COLUMNS = (
    "name",
    "ask",
    "kind",
    "truth",
    "d_prime",
    "rho",
    "channel",
    "main_parameter",
    "without",
    "verdict",
    "said",
    "found",
    "named",
    "misnamed",
    "in_set",
    "set_size",
    "value",
    "low",
    "high",
    "seconds",
    "failed",
    "sentence",
)


def write_csv(path, judged):
    with open(path, "w", newline="") as out:
        rows = csv.writer(out)
        rows.writerow(COLUMNS)
        for j in judged:
            given = j.parameter()
            rows.writerow(
                [
                    j.name,
                    j.ask,
                    j.label["kind"],
                    " + ".join(j.truth),
                    j.label["d_prime"],
                    j.label["rho"],
                    j.label["channel"],
                    "; ".join(f"{k} {v}" for e in j.label["effects"] for k, v in e["parameters"].items()),
                    j.without,
                    j.answer.verdict,
                    " + ".join("/".join(sorted(group)) for group in j.reported),
                    j.found,
                    j.named,
                    j.misnamed,
                    j.in_set,
                    len(j.reported),
                    *(given[1:] if given else ("", "", "")),
                    f"{j.answer.seconds:.2f}",
                    j.answer.failed,
                    j.answer.sentence,
                ]
            )
