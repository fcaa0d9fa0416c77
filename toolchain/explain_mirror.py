# SPDX-License-Identifier: Apache-2.0
"""The easiest trial of `voltlap explain`: our own simulator drives with one hidden effect, and explain is given its own
candump or CSV as it is, and the exact parameter file of the sound car.

Cells, packs and cars, six laps and whole endurances, noise on and off, no, one and three references of other drives.
The table says what was found, named and misnamed, by rho: the RMS that an effect leaves when start values are refitted,
over 1 mV, 0.1 K, 20 mV of a pack, 0.5 % of a car's power or force. Everything is drawn from the seed.
"""

import argparse
import os
import secrets
import shlex
import sys
import time
from pathlib import Path

from outputs import output_file

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # --jobs says how many cores are used, numpy does not
ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests/controls"))  # the mirror and the bank; read only when they are asked
KINDS = ("cell", "pack", "car", "long")
COUNT, QUICK = 300, 30


def arguments():
    parser = argparse.ArgumentParser(
        prog="voltlap explain-mirror",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="Example: ./voltlap explain-mirror --seed 7 --json marks.json --csv cases.csv\n"
        "Exit code: 0 the table stands, whatever it says; 2 usage or input; 130 interrupted.",
    )
    add = parser.add_argument
    add("--quick", action="store_true", help=f"{QUICK} cases of two or three laps; about a minute")
    add("--seed", type=int, help="whole number of 0 or more; drawn when it is not given")
    add("--count", type=int, help=f"cases, a fifth of them sound; default {COUNT}, with --quick {QUICK}")
    add("--kind", action="append", choices=KINDS,
        help="only: one cell on the bench, a pack file of 24 cells, cars with it, a car with 96 cells; may be repeated")
    add("--cause", action="append", metavar="NAME", help="only this effect; may be repeated")
    add("--rate", type=int, choices=(1, 2, 5, 10), default=10,
        help="rows a second of a drive's CSV, as slower loggers write them; default 10")
    add("--case", type=int, action="append", metavar="N", help="only the case of this number; may be repeated")
    add("--keep", type=Path, metavar="FOLDER", help="with one --case: leave its log, model and references there")
    add("--engine", type=Path, action="append", metavar="PROGRAM",
        help="called as voltlap is; default: this build's voltlap. Repeat it to see two on the same cases")
    add("--jobs", type=int, default=os.cpu_count(), help="processes at once; default: all cores")
    add("--json", type=output_file, metavar="FILE", help="write marks and every case")
    add("--csv", type=output_file, metavar="FILE", help="write one line a case and engine")
    add("--bin", type=Path, default=ROOT / "build/default/bin", help=argparse.SUPPRESS)
    return parser.parse_args()


def refuse(text):
    """Usage or input that cannot be used: one line, exit code 2 as of every command."""
    print("explain-mirror: " + text, file=sys.stderr)
    sys.exit(2)


def check(given):
    for name, low in (("seed", 0), ("count", 1), ("jobs", 1)):
        value = getattr(given, name)
        if value is not None and value < low:
            refuse(f"--{name} {value}: expected {low} or more")
    if any(number < 0 for number in given.case or ()):
        refuse(f"--case {min(given.case)}: expected 0 or more")
    for program in (given.bin / "voltlap", given.bin / "voltlap-learn", *(given.engine or ())):
        if not os.access(program, os.X_OK) or program.is_dir():
            refuse(f"{program} is not a program; give its path, or run ./voltlap build")
    if given.keep is not None:
        if not given.case or len(given.case) != 1:
            refuse("--keep: expected one --case with it, the case to keep")
        if given.keep.exists():
            refuse(f"--keep {given.keep}: expected a folder that is not there yet")


def check_causes(given):
    from mirror import catalogue  # numpy: not for --help

    for name in given.cause or ():
        if name not in catalogue.NAMES:
            refuse(f"--cause {name}: expected one of {', '.join(catalogue.NAMES)}")
    if given.cause and not any(catalogue.able(kind, True, given.cause) for kind in given.kind or KINDS):
        refuse(f"--cause {given.cause[0]}: no log of --kind {given.kind[0]} can hold it")


def engines_of(given):
    """((name, path), ...): the names of the programs, as they are told apart."""
    paths = [path.resolve() for path in given.engine or [given.bin / "voltlap"]]
    names = [path.name for path in paths]
    if len(set(names)) < len(names):
        names = [f"{k + 1}:{name}" for k, name in enumerate(names)]
    return tuple(zip(names, paths))


def repeat_of(given, number):
    """The command line that repeats one case."""
    words = ["./voltlap", "explain-mirror", "--seed", str(given.seed), "--case", str(number)]
    words += ["--quick"] if given.quick else []
    words += ["--rate", str(given.rate)] if given.rate != 10 else []
    for flag, values in (("--kind", given.kind), ("--cause", given.cause), ("--engine", given.engine)):
        words += [word for value in values or () for word in (flag, str(value))]
    return shlex.join(words)


def write(given, outcomes, engines):
    from mirror import table

    names = [name for name, _ in engines]
    facts = {"seed": given.seed, "quick": given.quick, "kinds": given.kind or list(KINDS),
             "causes": given.cause or [], "rate": given.rate}
    print(table.text_of(outcomes, names, facts, lambda number: repeat_of(given, number)))
    if given.json:
        given.json.write_text(table.json_of(outcomes, names, facts))
    if given.csv:
        table.write_csv(given.csv, outcomes, names)


def main():
    given = arguments()
    check(given)
    check_causes(given)
    from mirror import trial
    from mirror.cases import Plan
    from mirror.drives import NotDriven

    trial.hear_the_end()
    given.seed = secrets.randbelow(2**31) if given.seed is None else given.seed
    plan = Plan(given.seed, given.quick, tuple(given.kind or KINDS), tuple(given.cause or ()), given.rate)
    engines = engines_of(given)
    print(f"explain-mirror: seed {given.seed}", file=sys.stderr)
    numbers = given.case or range(given.count or (QUICK if given.quick else COUNT))
    begun = time.monotonic()
    try:
        run = trial.Trial(plan, trial.Programs(given.bin.resolve(), engines), set(numbers), given.jobs)
        if given.keep is not None:
            print(run.keep(given.case[0], given.keep))
            return 0
        outcomes = run.run()
    except NotDriven as failure:  # of --keep; a table counts them
        refuse(f"case {given.case[0]} cannot be driven: {failure}")
    except KeyboardInterrupt:
        print("\nexplain-mirror: interrupted; nothing is kept", file=sys.stderr)
        return 130
    write(given, outcomes, engines)
    print(f"explain-mirror: {time.monotonic() - begun:.0f} s", file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main())
