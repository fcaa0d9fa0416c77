# SPDX-License-Identifier: Apache-2.0
"""The result as text, with the engines side by side; as JSON; and one CSV line a case and engine."""

import csv
import json
import math

from bank.table import share_json

from . import marks
from .cases import RATE

WIDE, COLUMN = 38, 30
BOUNDS = {
    ("rho of 3 and more", "found"): ">= 97 %",
    ("rho of 3 and more", "named"): ">= 90 %",
    ("rho of 3 and more", "in the set"): ">= 96 %",
    ("rho of 3 and more", "misnamed"): "<= 0.5 %",
    ("rho 1 to 3", "found"): ">= 85 %",
    ("rho 1 to 3", "in the set"): ">= 80 %",
    ("rho 1 to 3", "misnamed"): "<= 1 %",
}
BOUNDS_ALONE = {  # without references
    ("rho of 3 and more", "found"): ">= 95 %",
    ("rho of 3 and more", "in the set"): ">= 90 %",
    ("rho of 3 and more", "misnamed"): "<= 2 %",
}


def row(text, values, bound=""):
    return (f"{text:{WIDE}}" + "".join(f"{value!s:{COLUMN}}" for value in values) + bound).rstrip()


def percent(value, of):
    return "no case" if math.isnan(value) else f"{100 * value:.1f} % over {of}"


def bin_lines(by_engine):
    """What is asked of a tool that knows sound drives, and of one that does not."""
    lines = []
    for title, bounds, alone in (("with references", BOUNDS, False), ("without references", BOUNDS_ALONE, True)):
        here = [marks.asked_alone(said, alone) for said in by_engine]
        lines += ["", row(title, []), row(f"sound logs {title}: alarms", [marks.alarms(said) for said in here])]
        for text, low, high in marks.BINS:
            each = [marks.shares(marks.in_bin(marks.effects(said), low, high)) for said in here]
            for what in each[0]:
                lines.append(row(f"{text}: {what}", [shares[what] for shares in each], bounds.get((text, what), "")))
    return lines + [""]


def number_lines(by_engine):
    effects = [marks.effects(said) for said in by_engine]
    sizes, gains = [marks.sizes(said) for said in effects], [marks.gains(said) for said in effects]
    return [
        row("error of a size, median", [percent(error, covered.of) for error, covered in sizes], "<= 5 %"),
        row("intervals that cover", [covered for _, covered in sizes], "88 to 99 %"),
        row("real gain over the true model's", ["no case" if not n else f"{g:.2f} over {n}" for g, n, _ in gains],
            ">= 0.95"),
        row("real gain within 10 % of promised", [close for _, _, close in gains]),
    ]


def group_lines(title, key, by_engine):
    """Found and named at rho of 3 and more, by one fact of the label, and alarms of its sound logs."""
    lines = ["", row(f"by {title}", [])]
    values = sorted({s.label[key] for said in by_engine for s in said})
    for value in values:
        here = [[s for s in said if s.label[key] == value] for said in by_engine]
        clear = [marks.shares(marks.in_bin(marks.effects(said), marks.CLEAR, math.inf)) for said in here]
        lines.append(row(f"  {value}: sound, alarms", [marks.alarms(said) for said in here]))
        for what in ("found", "named", "misnamed"):
            lines.append(row(f"  {value}: {what}", [shares[what] for shares in clear]))
    return lines


def cause_lines(names, by_engine):
    lines = ["", "by cause, rho of 3 and more: found, named, in the set, misnamed of cases; what was said instead"]
    for engine, said in zip(names, by_engine):
        if len(names) > 1:
            lines.append(engine)
        clear = marks.in_bin(marks.effects(said), marks.CLEAR, math.inf)
        for cause in sorted({s.judged.truth[0] for s in clear}):
            here = [s for s in clear if s.judged.truth[0] == cause]
            counts = ", ".join(str(s.hits) for s in marks.shares(here).values())
            most = sorted(marks.instead(here).items(), key=lambda item: (-item[1], item[0]))[:2]
            lines.append(f"  {cause:26} {counts:>14} of {len(here):<3} " + "; ".join(f"{n} x {w}" for w, n in most))
    return lines


def text_of(outcomes, engines, facts, repeat):
    """`repeat`: the command line of a case, by its number."""
    by_engine = [marks.said_by(name, outcomes) for name in engines]
    single = [o for o in outcomes if o.label["ask"] == "single"]
    rate = f", CSV of {facts['rate']} rows a second" if facts.get("rate", RATE) != RATE else ""
    lines = [f"seed {facts['seed']}: {len(outcomes)} cases, {len(single)} with an effect{rate}", ""]
    lines.append(row("", engines))
    lines.append(row("sound logs: alarms", [marks.alarms(said) for said in by_engine], "none"))
    for channel, scale, unit in (("voltage", 1e3, "mV"), ("temperature", 1.0, "K")):
        left = [marks.left_of_sound(said, channel) for said in by_engine]
        words = ["no case" if not n else f"{scale * x:.2f} {unit} over {n}" for x, n in left]
        lines.append(row(f"  left of their {channel}, median", words))
    lines += bin_lines(by_engine) + number_lines(by_engine)
    for title, key in (("kind", "kind"), ("format", "format"), ("references", "references"), ("noise", "noise"),
                       ("whole endurance", "whole")):
        lines += group_lines(title, key, by_engine)
    lines += cause_lines(engines, by_engine)
    lines += invisible_lines(outcomes, engines, by_engine) + failing_lines(outcomes, engines, by_engine, repeat)
    return "\n".join(lines)


def invisible_lines(outcomes, engines, by_engine):
    hidden, of_all = marks.invisible(outcomes)
    lines = ["", f"no log of its kind can show it: {of_all} (at most 15 %), not counted above"]
    lines += [f"  {count} x {what}" for what, count in hidden]
    hidden_said = [marks.effects(said, visible=False) for said in by_engine]
    if hidden:
        lines.append(row("  misnamed of these", [marks.shares(said)["misnamed"] for said in hidden_said]))
    return lines


def failing_lines(outcomes, engines, by_engine, repeat):
    lines = [""]
    not_driven = [o for o in outcomes if o.not_driven]
    if not_driven:
        lines.append(f"not driven: {len(not_driven)}, such as case {not_driven[0].label['number']}: "
                     + not_driven[0].not_driven)
    for name, said in zip(engines, by_engine):
        failed = [s for s in said if s.judged.answer.failed]
        if failed:
            lines.append(f"{name}: no answer to {len(failed)}, such as case {failed[0].label['number']}: "
                         + failed[0].judged.answer.failed)
        smallest = marks.smallest_failing(said)
        if smallest:
            count = sum(s.failing for s in said)
            lines.append(f"{name}: {count} fail; the one with the least to read, {words_of(smallest)}:")
            lines.append("  " + repeat(smallest.label["number"]))
    return lines


def words_of(said):
    truth = " + ".join(said.judged.truth) or "a sound log"
    rho = f" of rho {said.label['rho']:.1f}" if said.judged.truth else ""
    names = " + ".join(cause["name"] for cause in said.judged.answer.causes)
    return f"case {said.label['number']}, {truth}{rho}, said {said.judged.answer.verdict} {names}".rstrip()


def engine_json(said):
    smallest = marks.smallest_failing(said)
    effects = marks.effects(said)
    error, covered = marks.sizes(effects)
    gain, count, close = marks.gains(effects)
    return {
        "sound": {"alarms": share_json(marks.alarms(said))},
        "rho": [
            {"from": low, "to": None if math.isinf(high) else high,
             **{what.replace(" ", "_"): share_json(s)
                for what, s in marks.shares(marks.in_bin(effects, low, high)).items()}}
            for _, low, high in marks.BINS
        ],
        **{name: {what.replace(" ", "_"): share_json(s) for what, s in marks.shares(
            marks.in_bin(marks.asked_alone(effects, alone), marks.CLEAR, math.inf)).items()}
           for name, alone in (("with_references", False), ("without_references", True))},
        "size": {"median_error": None if math.isnan(error) else error, "covered": share_json(covered)},
        "gain": {"real_over_true": gain if count else None, "cases": count, "as_promised": share_json(close)},
        "no_answer": sum(bool(s.judged.answer.failed) for s in said),
        "smallest_failing_case": smallest.label["number"] if smallest else None,
    }


def case_json(outcome):
    return {
        **outcome.label,
        "not_driven": outcome.not_driven,
        "answers": {
            name: {"verdict": j.answer.verdict, "causes": j.answer.causes, "alternatives": j.answer.alternatives,
                   "found": j.found, "named": j.named, "in_set": j.in_set, "misnamed": j.misnamed,
                   "failed": j.answer.failed, "gain": outcome.gains.get(name)}
            for name, j in outcome.judged.items()
        },
    }


def json_of(outcomes, engines, facts):
    hidden, of_all = marks.invisible(outcomes)
    return json.dumps({
        **facts,
        "engines": {name: engine_json(marks.said_by(name, outcomes)) for name in engines},
        "invisible": {"share": share_json(of_all), "effects": dict(hidden)},
        "cases": [case_json(outcome) for outcome in outcomes],
    }, indent=1) + "\n"


COLUMNS = ("number", "kind", "cells", "format", "noise", "whole", "references", "truth", "form", "rho", "channel",
           "visible", "parameters", "engine", "verdict", "said",
           "found", "named", "in_set", "misnamed", "value", "low", "high",
           "promised_gain", "real_gain", "true_gain", "seconds", "failed", "sentence")


def csv_row(said, engine):
    label, judged, gain = said.label, said.judged, said.gain or {}
    answer, given = judged.answer, judged.parameter()
    parameters = "; ".join(f"{k} {v}" for e in label["effects"] for k, v in e["parameters"].items())
    facts = [label[key] for key in ("number", "kind", "cells", "format", "noise", "whole", "references")]
    reported = " + ".join("/".join(sorted(group)) for group in judged.reported)
    return [*facts, " + ".join(judged.truth), label.get("form", ""), label["rho"], label["channel"], label["visible"],
            parameters, engine, answer.verdict, reported, judged.found, judged.named, judged.in_set, judged.misnamed,
            *(given[1:] if given else ("", "", "")), *(gain.get(key, "") for key in ("promised", "real", "true")),
            f"{answer.seconds:.2f}", answer.failed, answer.sentence]


def write_csv(path, outcomes, engines):
    with open(path, "w", newline="", encoding="utf-8") as out:
        rows = csv.writer(out)
        rows.writerow(COLUMNS)
        for engine in engines:
            rows.writerows(csv_row(said, engine) for said in marks.said_by(engine, outcomes))
