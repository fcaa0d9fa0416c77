# SPDX-License-Identifier: Apache-2.0
"""What the firmware's suites run of it, as Clang counts it: lines, and both answers of every condition."""
import collections
import dataclasses
import json
import os
import re
import subprocess
import sys
from pathlib import Path

from mutation.tree import Broken, suites_of

FLAGS = "-O1 -fprofile-instr-generate -fcoverage-mapping"


@dataclasses.dataclass
class Counted:
    """Of one source file."""
    lines: dict = dataclasses.field(default_factory=collections.Counter)  # line: times run
    answers: dict = dataclasses.field(default_factory=dict)  # (line, column, line, column): [times true, times false]


def run(command, **more):
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False, **more)
    if done.returncode:
        raise Broken(f"{Path(command[0]).name} failed:\n{(done.stdout + done.stderr)[-4000:]}")
    return done.stdout


class Build:
    def __init__(self, root, folder):
        self.root, self.folder, self.raw = root, folder, folder / "raw"

    def configure(self):
        if not (self.folder / "build.ninja").exists():
            run(["cmake", "-G", "Ninja", "-S", self.root, "-B", self.folder, "-DCMAKE_BUILD_TYPE=Coverage",
                 "-DCMAKE_C_COMPILER=clang", "-DCMAKE_CXX_COMPILER=clang++", f"-DCMAKE_CXX_FLAGS_COVERAGE={FLAGS}",
                 f"-DVOLTLAP_PYTHON={sys.executable}", "-DVOLTLAP_PCH=OFF"])
        run(["ninja", "-C", self.folder, "build.ninja"])

    def make(self, with_ports, jobs):
        suites = suites_of(self.folder, with_ports)
        run(["ninja", "-C", self.folder, f"-j{jobs}", *suites])
        return suites

    def count(self, suite, found):
        """Runs a suite and adds what it ran to `found`, {name: Counted}."""
        program, profile = self.folder / "tests/bin" / suite, self.raw / f"{suite}.profdata"
        self.raw.mkdir(exist_ok=True)
        for old in self.raw.glob(f"{suite}-*.profraw"):
            old.unlink()
        run([program], env={**os.environ, "LLVM_PROFILE_FILE": str(self.raw / f"{suite}-%p.profraw")})
        run(["llvm-profdata", "merge", "-sparse", "-o", profile, *self.raw.glob(f"{suite}-*.profraw")])
        export = ["llvm-cov", "export", program, "-instr-profile", profile]
        self.add_lines(run([*export, "-format=lcov"]), found)
        for entry in json.loads(run(export))["data"][0]["files"]:
            name = self.name_of(entry["filename"])
            for branch in entry["branches"] if name else []:
                answers = found[name].answers.setdefault(tuple(branch[:4]), [0, 0])
                answers[0] += branch[4]
                answers[1] += branch[5]

    def add_lines(self, text, found):
        name = None
        for line in text.splitlines():
            if line.startswith("SF:"):
                name = self.name_of(line[3:])
            elif line.startswith("DA:") and name:
                number, times = line[3:].split(",")[:2]
                found[name].lines[int(number)] += int(times)

    def name_of(self, filename):
        """Of a source of the firmware, else None. The compiler keeps the way that it came by."""
        path = Path(os.path.normpath(self.folder / filename))
        return str(path.relative_to(self.root)) if path.is_relative_to(self.root / "firmware") else None


def required_spans(text):
    """Lines of conditions that are a contract: what breaks it ends the program."""
    lines = set()
    for match in re.finditer(r"VOLTLAP_REQUIRE\(", text):
        end = text.find(";", match.end())
        first, last = text.count("\n", 0, match.start()) + 1, text.count("\n", 0, end) + 1
        lines.update(range(first, last + 1))
    return lines


def conditions(text, counted):
    """(line, condition, is a label of a switch, times true, times false). A condition without any answer stands in a
    stretch that never runs, behind one that always has the same answer, or is a constant."""
    source, required = text.splitlines(), required_spans(text)
    for (line, begin, last, end), (yes, no) in sorted(counted.answers.items()):
        # Of a switch whose cases are all there are, that none was taken has no answer either.
        if not any((yes, no)) or line in required or source[line - 1][:begin - 1].endswith("switch ("):
            continue
        condition = source[line - 1][begin - 1:end - 1 if last == line else None].strip()
        yield line, condition, re.match(r"(case\b|default\b)", condition) is not None, yes, no


def unreached(name, text, counted):
    """Rows {file, row, rows, line, what}: stretches that never run, conditions that have one answer alone."""
    source, rows = text.splitlines(), []

    def add(line, what):
        rows.append({"file": name, "row": line, "rows": 1, "line": " ".join(source[line - 1].split()), "what": what})

    never = sorted(line for line, times in counted.lines.items() if times == 0)
    for k, line in enumerate(never):
        if k and never[k - 1] == line - 1:
            rows[-1]["rows"] += 1
        else:
            add(line, "never runs")
    for line, condition, label, yes, no in conditions(text, counted):
        if label and yes == 0 and line not in never:
            add(line, f"{condition} is never taken")
        elif not label and (yes == 0 or no == 0):
            add(line, f"{condition} is never {'false' if yes else 'true'}")
    return sorted(rows, key=lambda row: row["row"])


def totals(text, counted):
    """Lines, those that ran, answers of conditions, those that were given."""
    answers = [(1, yes > 0) if label else (2, (yes > 0) + (no > 0))
               for _, _, label, yes, no in conditions(text, counted)]
    return (len(counted.lines), sum(times > 0 for times in counted.lines.values()),
            sum(of for of, _ in answers), sum(given for _, given in answers))
