# SPDX-License-Identifier: Apache-2.0
"""Which lines of the firmware its tests never run, and which conditions always have the same answer in them. What
cannot be reached says why in firmware/unreached.toml; what else is not reached is printed.
"""
import argparse
import collections
import errno
import os
import shutil
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from mutation import explained
from mutation.named import of_paths
from mutation.tree import Broken
from outputs import output_file, write_json
from unreached.measure import Build, Counted, totals, unreached

ROOT = Path(__file__).resolve().parents[2]
DEFAULT = ("firmware/base", "firmware/codec", "firmware/bms", "firmware/master", "firmware/app")
PROGRAMS = ("clang++", "llvm-profdata", "llvm-cov", "cmake", "ninja")
KEYS = ("file", "line", "what")
EXIT_UNREACHED, EXIT_USAGE, EXIT_MISSING, EXIT_BUILD, EXIT_INTERRUPTED = 1, 2, 4, 5, 130


def arguments():
    parser = argparse.ArgumentParser(
        prog="voltlap coverage", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="Example: ./voltlap coverage firmware/master\n"
               "Exit code: 0 all is reached or explained, 1 something is not, or an explanation is stale, 2 usage, 4 "
               "Clang is missing, 5 the build or a test fails, 130 interrupted.")
    parser.add_argument("paths", nargs="*", metavar="PATH", help=f"sources or folders ({' '.join(DEFAULT)})")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), metavar="N", help="at a time (as many as CPUs)")
    parser.add_argument("--json", type=output_file, metavar="FILE", help="every stretch and condition, with its file")
    parser.add_argument("--files", action="store_true", help="a row for each file, too, not for each folder alone")
    given = parser.parse_args()
    if given.jobs < 1:
        parser.error(f"--jobs {given.jobs}: 1 or more is expected")
    every = [str(path.relative_to(ROOT)) for path in (ROOT / "firmware").rglob("*.?pp")]
    of_paths(given.paths, every, ROOT, parser)  # what is none is told before the build
    return given, parser


def check_programs():
    missing = [name for name in PROGRAMS if shutil.which(name) is None]
    if missing:
        raise FileNotFoundError(errno.ENOENT, "not installed", ", ".join(missing))


def measured(given, parser):
    """{name: Counted} of what is asked for."""
    build = Build(ROOT, ROOT / "build/coverage")
    print("building the suites", file=sys.stderr, flush=True)
    build.configure()
    suites = build.make(any("port" in path for path in given.paths), given.jobs)
    counts = []

    def of(suite):
        found = collections.defaultdict(Counted)
        build.count(suite, found)
        counts.append(found)
        print(f"suites {len(counts)}/{len(suites)}", file=sys.stderr, flush=True)
    with ThreadPoolExecutor(given.jobs) as pool:
        list(pool.map(of, suites))
    whole = collections.defaultdict(Counted)
    for found in counts:
        for name, counted in found.items():
            whole[name].lines.update(counted.lines)
            for place, (yes, no) in counted.answers.items():
                answers = whole[name].answers.setdefault(place, [0, 0])
                answers[0] += yes
                answers[1] += no
    return {name: whole[name] for name in of_paths(given.paths or DEFAULT, whole, ROOT, parser)}


def judge(rows, known, files):
    """Marks what is explained; explanations of these files that explain nothing, as sentences."""
    there = {tuple(row[key] for key in KEYS) for row in rows}
    for row in rows:
        row["why"] = known.get(tuple(row[key] for key in KEYS))
    return [f"{key[0]}: nothing is unreached there any more: {key[1]}: {key[2]}"
            for key in known if key[0] in files and key not in there]


def print_table(found, texts, rows, by_file):
    table = collections.defaultdict(lambda: [0] * 6)
    for name, counted in found.items():
        left = [row for row in rows if row["file"] == name]
        why = sum(bool(row["why"]) for row in left)
        own = [*totals(texts[name], counted), len(left) - why, why]
        for key in ["/".join(name.split("/")[:2]), "all", *([name] if by_file else [])]:
            table[key] = [a + b for a, b in zip(table[key], own)]
    print(f"\n{'':44}{'lines run':>14}{'answers given':>16}{'unreached':>11}{'explained':>11}")
    for key in sorted(table, key=lambda name: (name == "all", name)):
        lines, run, answers, gave, left, why = table[key]
        print(f"{key:44}{f'{run} of {lines}':>14}{f'{gave} of {answers}':>16}{left:11}{why:11}")


def report(given, parser):
    known = explained.read(ROOT / "firmware/unreached.toml", "unreached", KEYS)
    found = measured(given, parser)
    texts = {name: (ROOT / name).read_text() for name in found}
    rows = [row for name in sorted(found) for row in unreached(name, texts[name], found[name])]
    stale = judge(rows, known, set(found))
    for row in rows:
        if not row["why"]:
            more = f" ({row['rows']} lines)" if row["rows"] > 1 else ""
            text = f": {row['line']}" if row["what"] == "never runs" else ""
            print(f"{row['file']}:{row['row']}: {row['what']}{more}{text}")
    for text in stale:
        print(f"stale explanation: {text}")
    print_table(found, texts, rows, given.files)
    if given.json:
        write_json(given.json, {"unreached": rows, "stale": stale})
    return EXIT_UNREACHED if stale or any(not row["why"] for row in rows) else 0


def main():
    given, parser = arguments()
    try:
        check_programs()
        return report(given, parser)
    except explained.Malformed as error:
        print(f"voltlap coverage: {error}", file=sys.stderr)
        return EXIT_USAGE
    except FileNotFoundError as error:
        print(f"voltlap coverage: not found: {error.filename}. Install it (apt-get install clang llvm), or start "
              "./voltlap coverage, which does.", file=sys.stderr)
        return EXIT_MISSING
    except Broken as error:
        print(f"voltlap coverage: {error}", file=sys.stderr)
        return EXIT_BUILD
    except KeyboardInterrupt:
        print("\nvoltlap coverage: interrupted", file=sys.stderr)
        return EXIT_INTERRUPTED
