# SPDX-License-Identifier: Apache-2.0
"""Blind trials of `voltlap explain` on a hidden truth of another physics, scored with 95 % intervals.

A truth in Python (tests/controls/truth) drives cells, packs and cars of random make, sound or with an effect of the
catalogue in them; the tool is asked about each log and must find, name and measure what is wrong, or say that nothing
is. Labels are sealed before the tool runs. The distance d' of a case is computed from the truth, never by the tool.
"""

import argparse
import os
import secrets
import shutil
import signal
import sys
import tempfile
import time
from pathlib import Path

from outputs import output_file

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests/controls"))  # the truth and the bank; read only when they are asked
KINDS = ("cell", "pack", "car")


def arguments():
    parser = argparse.ArgumentParser(
        prog="voltlap explain-bench",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="Example: ./voltlap explain-bench --quick --seed 7 --json marks.json --csv cases.csv",
    )
    parser.add_argument(
        "--quick",
        action="store_true",
        help="one world of each kind, 600 s logs, every fourth cause; minutes instead of hours",
    )
    parser.add_argument("--seed", type=int, help="of the truth, whole number of 0 or more; drawn when it is not given")
    parser.add_argument("--kind", action="append", choices=KINDS, help="only this kind of world; may be repeated")
    parser.add_argument(
        "--cause",
        action="append",
        metavar="NAME",
        help="only this effect; may be repeated",
    )
    parser.add_argument(
        "--own-family",
        action="store_true",
        help="cells of the kind that the tool itself assumes, a circuit with one mass of heat",
    )
    parser.add_argument("--worlds", type=int, help="worlds of each kind; default 12, with --quick 1")
    parser.add_argument("--clean", type=int, help="clean logs a world; default 9, with --quick 6")
    parser.add_argument("--references", type=int, default=3, help="known good logs that the tool is given; default 3")
    parser.add_argument("--duration", type=float, help="seconds of each log; default 900, with --quick 600")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="processes at once; default: all cores")
    parser.add_argument(
        "--real", action="store_true", help="instead: effects put exactly into recordings of real cars in VOLTLAP_DATA"
    )
    parser.add_argument("--tool", default=ROOT / "build/default/bin/voltlap", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("--json", type=output_file, metavar="FILE", help="write marks, curves and causes")
    parser.add_argument("--csv", type=output_file, metavar="FILE", help="write one line a case")
    parser.add_argument(
        "--ledger", type=Path, metavar="FOLDER", help="keep the commitments and the revealed labels in this new folder"
    )
    return parser.parse_args()


def plan_of(given):
    from bank import cases  # numpy: not for --help
    from bank.trial import Plan

    quick = given.quick
    for name in given.cause or ():
        if name not in cases.effects.BY_NAME:
            refuse(f"--cause {name}: expected one of {', '.join(sorted(cases.effects.BY_NAME))}")
    names = [effect.name for effect in cases.effects.ALL]
    causes = tuple(given.cause or (names[given.seed % 4 :: 4] if quick else names))
    return Plan(
        kinds=tuple(given.kind or KINDS),
        worlds=given.worlds or (1 if quick else 12),
        clean=(6 if quick else 9) if given.clean is None else given.clean,
        references=given.references,
        pairs=2 if quick else 6,
        left_out=1.0,
        duration_s=given.duration or (600.0 if quick else 900.0),
        causes=causes,
        family="circuit" if given.own_family else "particle",
    )


def refuse(text):
    """Usage or input that cannot be used: one line, exit code 2 as of every command."""
    print("explain-bench: " + text, file=sys.stderr)
    sys.exit(2)


def check(given):
    for name, low in (("seed", 0), ("worlds", 1), ("clean", 0), ("references", 0), ("duration", 460), ("jobs", 1)):
        value = getattr(given, name)
        if value is not None and value < low:
            refuse(f"--{name} {value}: expected {low} or more")
    if not os.access(given.tool, os.X_OK):
        refuse(f"{given.tool} is not there; run ./voltlap build")
    if given.ledger is not None:
        try:
            given.ledger.mkdir(parents=True)
        except OSError as error:
            refuse(f"--ledger {given.ledger}: {error.strerror}; give a folder that is not there yet")


def real_recordings(binary):
    """Prints what was said about recordings of real cars with effects put into them."""
    from bank import real

    data = os.environ.get("VOLTLAP_DATA")
    if not data:
        refuse("--real needs the folder of measured data in VOLTLAP_DATA")
    running = set()
    with tempfile.TemporaryDirectory(prefix="explain-bench-") as folder:
        try:
            outcomes = real.run(
                Path(binary).resolve(),
                Path(data),
                Path(folder),
                running,
                lambda text: print("explain-bench: " + text, file=sys.stderr, flush=True),
            )
        except KeyboardInterrupt:
            for process in list(running):
                process.kill()
            print("explain-bench: interrupted; nothing is kept", file=sys.stderr)
            return 130
    print(real.text_of(outcomes))
    return 0


def main():
    given = arguments()
    check(given)
    # Whoever ends the trial gets the same clean end; a shell's background jobs do not hear Ctrl-C by themselves.
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.default_int_handler)
    if given.real:
        return real_recordings(given.tool)
    from bank import table
    from bank.trial import Trial

    seed = secrets.randbelow(2**31) if given.seed is None else given.seed
    given.seed = seed
    plan = plan_of(given)
    print(f"explain-bench: seed {seed}", file=sys.stderr)
    folder = Path(tempfile.mkdtemp(prefix="explain-bench-"))
    begun = time.monotonic()
    try:
        trial = Trial(given.tool, plan, seed, folder, given.jobs)
        judged = trial.run()
        if given.ledger is not None:
            for file in (trial.ledger.commitments, trial.ledger.revealed):
                shutil.copy(file, given.ledger)
    except KeyboardInterrupt:
        shutil.rmtree(folder, ignore_errors=True)
        print("\nexplain-bench: interrupted; nothing is kept", file=sys.stderr, flush=True)
        os._exit(130)  # a worker that was ended with a lock of the pool in its hand keeps Python's own end waiting
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    facts = {"seed": seed, "seconds": round(time.monotonic() - begun, 1), "quick": given.quick}
    print(table.text_of(judged, facts))
    if given.json:
        given.json.write_text(table.json_of(judged, facts))
    if given.csv:
        table.write_csv(given.csv, judged)
    return 0


if __name__ == "__main__":
    sys.exit(main())
