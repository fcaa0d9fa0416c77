#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs every suite of a build and sums what they count.

usage: voltlap test [--only WORD] [--jobs N] [--list]

Each suite is a CppUTest program or a pytest folder that the build registered. A suite that fails is printed whole, the
others in one line. The last line is `N passed, N failed, N skipped`, over single tests. Exit code 0: none failed; 1: some
did; 2: usage, or no suite.
"""
import argparse
import concurrent.futures
import json
import os
import re
import subprocess
import sys
import time
from typing import NamedTuple


class Suite(NamedTuple):
    name: str
    kind: str
    command: list
    environment: dict
    directory: str


class Outcome(NamedTuple):
    suite: Suite
    passed: int
    failed: int
    skipped: int
    seconds: float
    output: str


def suites_of(build):
    """The suites that CMake registered, slowest kinds first."""
    listing = subprocess.run(["ctest", "--show-only=json-v1"], cwd=build, capture_output=True, text=True, check=True)
    found = []
    for test in json.loads(listing.stdout)["tests"]:
        properties = {p["name"]: p["value"] for p in test["properties"]}
        environment = dict(entry.split("=", 1) for entry in properties.get("ENVIRONMENT", []))
        kind = properties.get("LABELS", ["?"])[0]
        found.append(Suite(test["name"], kind, test["command"], environment, properties.get("WORKING_DIRECTORY", build)))
    return sorted(found, key=lambda s: (s.kind != "pytest", s.name))


def count_cpputest(output, exit_code):
    """(passed, failed, skipped) of a CppUTest program, from its closing line; a crash is one failure."""
    line = re.search(r"(?:OK|Errors) \((?:(\d+) failures?, )?(\d+) tests?, (\d+) ran, \d+ checks?, (\d+) ignored", output)
    if not line:
        return 0, 1, 0
    failed = len(set(re.findall(r"error: Failure in (.+)", output))) if line[1] else 0
    if exit_code != 0:
        failed = max(failed, 1)
    return int(line[3]) - failed, failed, int(line[4])


def count_pytest(output, exit_code):
    """(passed, failed, skipped) of a pytest run, from its closing line; errors count as failures."""
    closing = output.strip().splitlines()[-1] if output.strip() else ""
    count = {word: int(n) for n, word in re.findall(r"(\d+) (passed|failed|skipped|error)", closing)}
    failed = count.get("failed", 0) + count.get("error", 0)
    if exit_code != 0:
        failed = max(failed, 1)
    return count.get("passed", 0), failed, count.get("skipped", 0)


def run(suite):
    started = time.monotonic()
    done = subprocess.run(suite.command, cwd=suite.directory, env={**os.environ, **suite.environment}, text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, errors="replace")
    count = count_pytest if suite.kind == "pytest" else count_cpputest
    return Outcome(suite, *count(done.stdout, done.returncode), time.monotonic() - started, done.stdout)


def main():
    parser = argparse.ArgumentParser(prog="voltlap test", description=__doc__.split("\n\n")[0],
                                     epilog="Exit code 0: no test failed; 1: some did; 2: usage, or no suite.")
    parser.add_argument("--build", default="build/default", help=argparse.SUPPRESS)
    parser.add_argument("--only", metavar="WORD", default="", help="only suites whose name contains WORD")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, metavar="N", help="suites at once (default: cores)")
    parser.add_argument("--list", action="store_true", help="name the suites and stop")
    options = parser.parse_args()

    suites = [s for s in suites_of(options.build) if options.only in s.name]
    if options.list:
        print("\n".join(f"{s.name} ({s.kind})" for s in suites))
        return 0
    if not suites:
        print(f"voltlap test: no suite's name contains '{options.only}'; --list names them", file=sys.stderr)
        return 2

    total = [0, 0, 0]
    with concurrent.futures.ThreadPoolExecutor(max(1, options.jobs)) as pool:
        for done in concurrent.futures.as_completed([pool.submit(run, s) for s in suites]):
            outcome = done.result()
            if outcome.failed:
                print(f"\n---- {outcome.suite.name} ----\n{outcome.output.strip()}\n")
            if "SKIPPED" in outcome.output:
                print("\n".join(l for l in outcome.output.splitlines() if l.startswith("SKIPPED")))
            print(f"{'FAILED' if outcome.failed else 'ok':6} {outcome.suite.name}: {outcome.passed} passed, "
                  f"{outcome.failed} failed, {outcome.skipped} skipped in {outcome.seconds:.1f} s", flush=True)
            total = [a + b for a, b in zip(total, outcome[1:4])]
    print(f"{total[0]} passed, {total[1]} failed, {total[2]} skipped")
    return 1 if total[1] else 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        sys.exit(130)
