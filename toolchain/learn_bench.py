#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Cells drawn at random against `voltlap identify`: recordings of a known truth, one of them kept back and predicted.

Each cell is drawn like a chemistry (NMC, NCA, LFP with hysteresis) with 1 to 3 branches, laws over temperature and
current, and instruments with noise, steps, offset and gain; the truth is a simulator in numpy of its own
(toolchain/drawn_cells). `identify` gets all recordings but one, at a rate and temperature of its own, which `validate`
then judges. Counted are crashes, refusals of sound recordings, doubts about them, files that are not read back, bounds
without a word, the true value in 95 % intervals, and the error of the kept recording over that of the true model class:
the true circuit fitted to the same rows (toolchain/drawn_cells/reference.py).
"""
import argparse
import csv
import importlib.util
import json
import os
import secrets
import shutil
import signal
import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path

from outputs import output_file

ROOT = Path(__file__).resolve().parents[1]
SHORT_CELLS, CELLS, GOAL = 8, 200, 1.2
COVERED = (0.90, 0.98)


def arguments():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="Examples: python3 toolchain/learn_bench.py --seed 1 --json marks.json --csv cells.csv\n"
               "          python3 toolchain/learn_bench.py --seed 1 --cell 17 --keep build/cell17\n"
               "Exit code: 0 all went; 1 a crash, a refusal or a file that is not read back; 2 usage.")
    parser.add_argument("--cells", type=int, help=f"how many; default {CELLS}")
    parser.add_argument("--short", action="store_true", help=f"{SHORT_CELLS} cells, minutes instead of hours")
    parser.add_argument("--seed", type=int, help="whole number of 0 or more; drawn when it is not given")
    parser.add_argument("--cell", type=int, action="append", default=[], metavar="K",
                        help="only this one of the seed; may be repeated")
    parser.add_argument("--keep", type=Path, metavar="FOLDER",
                        help="keep recordings, models, what was said and the commands of each cell there")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="processes at once; default: all cores")
    parser.add_argument("--tool", type=Path, default=ROOT / "build/default/bin/voltlap", help="default: the built one")
    parser.add_argument("--json", type=output_file, metavar="FILE", help="write everything")
    parser.add_argument("--csv", type=output_file, metavar="FILE", help="write one line a cell")
    return parser.parse_args()


def refuse(text):
    print("learn_bench: " + text, file=sys.stderr)
    sys.exit(2)


def check(given):
    for name, low in (("cells", 1), ("seed", 0), ("jobs", 1)):
        value = getattr(given, name)
        if value is not None and value < low:
            refuse(f"--{name} {value}: expected {low} or more")
    if any(k < 0 for k in given.cell):
        refuse(f"--cell {min(given.cell)}: expected 0 or more, as the lists of a run count them")
    if importlib.util.find_spec("scipy") is None:
        refuse("scipy is not there; pip install -r toolchain/requirements/fit.txt -r toolchain/requirements/test.txt")
    if not os.access(given.tool, os.X_OK):
        refuse(f"{given.tool} is not there; run ./voltlap build, or name it with --tool")


def one(tool, seed, number, folder, kept):
    """In a process of its own."""
    from drawn_cells.trial import Trial  # numpy: not for --help

    place = Path(folder) / f"cell_{number}"
    place.mkdir(parents=True, exist_ok=True)
    trial = Trial(tool, seed, number, place)
    found = trial.judged()
    (place / "commands.txt").write_text("\n".join(trial.commands) + "\n")
    if not kept:
        shutil.rmtree(place)
    return found


def quiet_worker():
    os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"
    os.setpgrp()
    signal.signal(signal.SIGTERM, signal.SIG_DFL)


def run(given, seed, folder):
    """(what was found, whether it was let to its end)."""
    numbers = given.cell or range(given.cells or (SHORT_CELLS if given.short else CELLS))
    out = []
    with ProcessPoolExecutor(given.jobs, initializer=quiet_worker) as pool:
        waiting = {pool.submit(one, given.tool.resolve(), seed, k, str(folder), given.keep is not None): k
                   for k in numbers}
        try:
            for done in as_completed(waiting):
                try:
                    out.append(done.result())
                except Exception as error:  # of this program, not of the tool: said, and the others go on
                    out.append({"cell": waiting[done], "failures": [["bench", repr(error)]], "ratio": None,
                                "coverage": []})
                print(f"learn_bench: {len(out)} of {len(waiting)}: {line_of(out[-1])}", file=sys.stderr, flush=True)
        except KeyboardInterrupt:
            for process in list(pool._processes.values()):  # each leads its own group with what it runs
                os.killpg(process.pid, signal.SIGKILL)
            pool.shutdown(wait=False, cancel_futures=True)
            return sorted(out, key=lambda one: one["cell"]), False
    return sorted(out, key=lambda one: one["cell"]), True


def line_of(found):
    if found["ratio"] is None:
        return f"cell {found['cell']}: " + "; ".join(f"{kind}: {text[:160]}" for kind, text in found["failures"])
    return (f"cell {found['cell']} ({found['chemistry']}, {found['branches']} branches, found "
            f"{found['found_branches']}): {found['rms_mv']:.2f} mV, true class {found['reference_mv']:.2f} mV, "
            f"{found['plan']}"
            + "".join(f"; {kind}" for kind, _ in found["failures"]))


def coverage(found):
    out = {}
    for one_cell in found:
        for key, low, high, true in one_cell["coverage"]:
            into = out.setdefault(key, {"intervals": 0, "hold": 0, "below": 0, "above": 0})
            into["intervals"] += 1
            into["hold"] += low <= true <= high
            into["below"] += high < true  # the interval lies below the truth
            into["above"] += low > true
    return out


def quantile(values, share):
    values = sorted(values)
    return values[min(len(values) - 1, int(share * len(values)))] if values else float("nan")


def groups(found):
    """(name, ratios) of the cells by what might matter."""
    for key in ("chemistry", "branches", "charge_transfer", "thermometer", "instrument", "sample_s", "phase"):
        for value in sorted({str(x[key]) for x in found}):
            yield f"{key} {value}", [x["ratio"] for x in found if str(x[key]) == value]


def text_of(found, seed):
    judged = [x for x in found if x["ratio"] is not None]
    ratios = [x["ratio"] for x in judged]
    knowing = [x["rms_mv"] / x["reference_at_true_temperature_mv"] for x in judged]
    lines = [f"seed {seed}, {len(found)} cells", "", "what failed:"]
    kinds = {}
    for x in found:
        for kind, text in x["failures"]:
            kinds.setdefault(kind, []).append((x["cell"], text))
    for kind, cases in sorted(kinds.items(), key=lambda item: -len(item[1])):
        lines += [f"  {kind}: {len(cases)}, cells {sorted({k for k, _ in cases})}",
                  f"    cell {cases[0][0]}: {cases[0][1][:300]}"]
    lines += ["", f"95 % intervals that hold the true value (wanted: {COVERED[0]:.0%} to {COVERED[1]:.0%}):"]
    for key, n in sorted(coverage(found).items()):
        lines.append(f"  {key:<34} {n['hold']:>5} of {n['intervals']:<5} {n['hold'] / n['intervals']:>6.1%}, "
                     f"{n['below']} lie below it, {n['above']} above")
    if not judged:
        return "\n".join(lines)
    lines += ["", f"RMS of the kept recording over that of the true model class (wanted: {GOAL} at most):",
              f"  median {quantile(ratios, 0.5):.2f}, 90 % {quantile(ratios, 0.9):.2f}, largest {max(ratios):.2f}; "
              f"within {GOAL}: {sum(r <= GOAL for r in ratios)} of {len(ratios)}",
              f"  of one that knows the true temperature: median {quantile(knowing, 0.5):.2f}, 90 % "
              f"{quantile(knowing, 0.9):.2f}"]
    lines += [f"  {name:<24} {len(r):>4} cells, median {quantile(r, 0.5):.2f}, 90 % {quantile(r, 0.9):.2f}"
              for name, r in groups(judged)]
    lines += ["", "worst cells:"]
    lines += [f"  {x['ratio']:6.2f}  {line_of(x)}; sample {x['sample_s']:g} s, noise {x['noise_mv']} mV, step "
              f"{x['step_mv']:g} mV, thermometer {x['thermometer']}, instrument {x['instrument']}"
              for x in sorted(judged, key=lambda x: -x["ratio"])[:12]]
    return "\n".join(lines)


def write_csv(path, found):
    names = [n for n in max(found, key=len) if n not in ("coverage", "failures")]
    with path.open("w", newline="") as file:
        table = csv.writer(file)
        table.writerow([*names, "failures"])
        table.writerows([*(x.get(n) for n in names), "; ".join(k for k, _ in x["failures"])] for x in found)


def main():
    given = arguments()
    check(given)
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    seed = secrets.randbelow(2 ** 31) if given.seed is None else given.seed
    print(f"learn_bench: seed {seed}", file=sys.stderr)
    with tempfile.TemporaryDirectory(prefix="learn-bench-") as scratch:
        found, whole = run(given, seed, given.keep or Path(scratch))
    if not whole:
        print(f"learn_bench: interrupted after {len(found)} cells", file=sys.stderr)
    if not found:
        return 130
    print(text_of(found, seed))
    if given.json:
        given.json.write_text(json.dumps({"seed": seed, "coverage": coverage(found), "cells": found}, indent=1) + "\n")
    if given.csv:
        write_csv(given.csv, found)
    if not whole:
        return 130
    broken = ("crashed", "refused", "read back", "bench")
    return int(any(word in kind for x in found for kind, _ in x["failures"] for word in broken))


if __name__ == "__main__":
    sys.exit(main())
