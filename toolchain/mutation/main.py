# SPDX-License-Identifier: Apache-2.0
"""The work of `voltlap mutate`: builds the copy, runs the tests that reach a mutant, says what no test saw."""
import random
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from mutation import explained
from mutation.named import of_paths
from mutation.options import DEFAULT, arguments
from mutation.refused import take_out_refused
from mutation.rewrite import number_mutants
from mutation.sites import Reader, Unreadable, parser_flags
from mutation.tree import BLOCK, Broken, Tree
from mutation.trial import Trial
from outputs import write_json

ROOT = Path(__file__).resolve().parents[2]
EXIT_SURVIVED, EXIT_USAGE, EXIT_BUILD, EXIT_INTERRUPTED = 1, 2, 5, 130
VERDICTS = ("killed", "explained", "survived", "not reached", "not run")


def say(text, last=False):
    if sys.stderr.isatty():
        print(f"\r\033[K{text}", end="\n" if last else "", file=sys.stderr, flush=True)
    elif last:
        print(text, file=sys.stderr, flush=True)


class Session:
    def __init__(self, given, parser):
        self.given = given
        self.tree = Tree(ROOT, ROOT / "build/mutate")
        every = sorted(str(path.relative_to(ROOT)) for path in (ROOT / "firmware").rglob("*.cpp"))
        say("copying and configuring", last=True)
        self.tree.copy(len(every))
        self.tree.configure()
        self.commands = self.tree.commands()
        self.block = {name: BLOCK * index for index, name in enumerate(every)}
        self.files = of_paths(given.paths or DEFAULT, self.commands, ROOT, parser)
        self.rows, self.refused, self.fixed = [], {}, []

    def prepare(self, name):
        """The file with its switches into the copy; its mutants as rows."""
        reader = Reader(ROOT / name, parser_flags(self.commands[name])).read()
        end = number_mutants(reader.sites, self.block[name])
        if end > self.block[name] + BLOCK:
            raise Broken(f"{name} has more than {BLOCK} mutants")
        refused = take_out_refused(self.tree, name, reader, self.commands[name])
        lines, rows = reader.data.decode().splitlines(), {}
        for site in reader.sites:
            for mutant in site.mutants:
                rows.setdefault(mutant.number, {
                    "number": mutant.number, "file": name, "function": site.function, "row": site.line,
                    "column": site.column, "text": " ".join(lines[site.line - 1].split()), "change": mutant.change,
                    "verdict": "not run"})
        return name, list(rows.values()), len(refused), reader.fixed

    def build(self):
        for name in self.commands:
            if name not in self.files:
                self.tree.put(name, (ROOT / name).read_bytes())
        for path in (ROOT / "firmware").rglob("*.hpp"):
            self.tree.put(path.relative_to(ROOT), path.read_bytes())
        with ThreadPoolExecutor(self.given.jobs) as pool:
            for count, (name, rows, refused, fixed) in enumerate(pool.map(self.prepare, self.files), 1):
                say(f"reading sources {count}/{len(self.files)}", last=count == len(self.files))
                self.rows += rows
                self.refused[name] = refused
                self.fixed += [f"{name}: {constant}" for constant in fixed]

    def chosen(self):
        if self.given.only is not None:
            return [row for row in self.rows if row["number"] == self.given.only]
        if self.given.draw is None:
            return self.rows
        seed = self.given.seed if self.given.seed is not None else random.SystemRandom().randrange(2**31)
        print(f"drawn with --seed {seed}")
        return random.Random(seed).sample(self.rows, min(self.given.draw, len(self.rows)))

    def run(self):
        chosen = self.chosen()
        targets = self.tree.suites(any(name.startswith("firmware/port") for name in self.files))
        say(f"building {len(self.rows)} mutants into {len(targets)} suites", last=True)
        self.tree.make(targets, self.given.jobs)
        begin = time.monotonic()
        trial = Trial(self.tree, targets, self.given,
                      lambda done, of: say(f"mutants {done}/{of}", last=done == of or done % 100 == 0))
        trial.record()
        found = trial.run([(row["number"], row["file"].split("/")[1]) for row in chosen])
        for row in chosen:
            row["verdict"], row["test"] = found[row["number"]]
        return time.monotonic() - begin


def print_table(session, seconds):
    files = session.files
    print(f"\n{'':40}{'killed':>9}{'explained':>11}{'survived':>10}{'not reached':>13}{'refused':>9}")
    for name in [*files, "all"]:
        rows = [row for row in session.rows if name in (row["file"], "all")]
        counts = [sum(row["verdict"] == verdict for row in rows) for verdict in VERDICTS[:4]]
        refused = sum(session.refused.values()) if name == "all" else session.refused[name]
        print(f"{name:40}{counts[0]:9}{counts[1]:11}{counts[2]:10}{counts[3]:13}{refused:9}")
    print(f"constants that no change reaches: {len(session.fixed)}; run in {seconds:.0f} s")


def report(session, seconds):
    known = explained.read(ROOT / "firmware/mutants.toml")
    stale = explained.judge(session.rows, known, set(session.files))
    left = [row for row in session.rows if row["verdict"] in ("survived", "not reached")]
    for row in sorted(left, key=lambda row: (row["file"], row["row"], row["column"])):
        print(f"{row['file']}:{row['row']}:{row['column']}: {row['change']}  [{row['number']}, {row['verdict']}]")
    for text in stale:
        print(f"stale explanation: {text}")
    print_table(session, seconds)
    if session.given.json:
        write_json(session.given.json, {"mutants": session.rows, "refused": session.refused, "fixed": session.fixed,
                                        "stale": stale, "seconds": round(seconds, 1)})
    survived = any(row["verdict"] == "survived" for row in session.rows)
    return EXIT_SURVIVED if survived or stale else 0


def main():
    given, parser = arguments()
    try:
        session = Session(given, parser)
        session.build()
        if given.list:
            for row in session.rows:
                print(f"{row['number']:7} {row['file']}:{row['row']}:{row['column']}: {row['change']}")
            return 0
        return report(session, session.run())
    except explained.Malformed as error:
        print(f"voltlap mutate: {error}", file=sys.stderr)
        return EXIT_USAGE
    except (Broken, Unreadable) as error:
        print(f"voltlap mutate: {error}", file=sys.stderr)
        return EXIT_BUILD
    except KeyboardInterrupt:
        print("\nvoltlap mutate: interrupted", file=sys.stderr)
        return EXIT_INTERRUPTED
