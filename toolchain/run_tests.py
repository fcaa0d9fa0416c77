#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs every test that the build knows, prints what failed, and ends with one line: N passed, N failed, N skipped.

The suites are those of ctest. A CppUTest executable and a pytest folder count their single tests, any other command
counts as one.
"""
import argparse
import concurrent.futures
import dataclasses
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time
import xml.etree.ElementTree as ElementTree
from pathlib import Path

PROJECT = Path(__file__).resolve().parent.parent
SUITE_TIMEOUT_S = 2400  # a hang; the longest suite builds all with another compiler, 15 min on a machine of two cores
EXIT_INTERRUPTED = 130
YOUNG_S = 10.0

_interrupted = threading.Event()
_running = {}  # processes of suites and when they began


@dataclasses.dataclass
class Outcome:
    name: str
    passed: int = 0
    failed: int = 0
    skipped: int = 0
    output: str = ""  # shown when something failed
    skips: tuple = ()  # reasons
    seconds: float = 0.0


def call(command, folder, environment=None):
    """Exit code and output; a suite that hangs has failed."""
    if _interrupted.is_set():
        return EXIT_INTERRUPTED, "interrupted"
    try:
        with subprocess.Popen(command, cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              text=True, errors="replace") as process:
            _running[process] = time.monotonic()
            try:
                if _interrupted.is_set():
                    process.send_signal(signal.SIGINT)
                text, _ = process.communicate(timeout=SUITE_TIMEOUT_S)
                return process.returncode, text
            except subprocess.TimeoutExpired as late:  # its own children may hold the pipe for ever
                process.kill()
                text = late.stdout or ""
                text = text if isinstance(text, str) else text.decode(errors="replace")
                return 1, f"{text}\nno end after {SUITE_TIMEOUT_S} s"
            finally:
                del _running[process]
    except OSError as error:
        return 1, f"{command[0]}: {error.strerror}"


def interrupt_the_young():
    """The terminal interrupts what runs. A suite that a free worker started just then has not heard it."""
    _interrupted.set()
    now = time.monotonic()
    for process, begin in list(_running.items()):
        if now - begin < YOUNG_S:
            process.send_signal(signal.SIGINT)


def whole_command(name, code, output):
    return Outcome(name, passed=int(code == 0), failed=int(code != 0), output=output)


def run_cpputest(name, command, folder):
    code, output = call(command, folder)
    summary = re.search(r"\((?:(\d+) failures?, )?(\d+) tests, (\d+) ran, \d+ checks, (\d+) ignored", output)
    if summary is None:  # crashed, or not a CppUTest executable at all
        return Outcome(name, failed=1, output=output + f"\nno summary, exit code {code}")
    failed, ran, ignored = int(summary[1] or 0), int(summary[3]), int(summary[4])
    if code != 0 and failed == 0:
        failed = 1
    if ran == 0:
        return Outcome(name, failed=1, output=output + "\nthe suite ran no test")
    return Outcome(name, passed=max(0, ran - failed), failed=failed, skipped=ignored, output=output)


def run_pytest(name, command, folder, environment):
    with tempfile.TemporaryDirectory() as scratch:
        report = Path(scratch) / "report.xml"
        code, output = call([*command, f"--junitxml={report}"], folder, environment)
        if not report.exists():
            return Outcome(name, failed=1, output=output + f"\nno report, exit code {code}")
        root = ElementTree.parse(report).getroot()
    outcome = Outcome(name, output=output)
    reasons = []
    for case in root.iter("testcase"):
        if case.find("failure") is not None or case.find("error") is not None:
            outcome.failed += 1
        elif (skip := case.find("skipped")) is not None:
            outcome.skipped += 1
            reasons.append(skip.get("message", ""))
        else:
            outcome.passed += 1
    if code != 0 and outcome.failed == 0:
        outcome.failed = 1
    outcome.skips = tuple(sorted(set(reasons)))
    return outcome


def run_suite(suite):
    properties = {entry["name"]: entry["value"] for entry in suite.get("properties", [])}
    environment = dict(os.environ)
    environment.update(pair.split("=", 1) for pair in properties.get("ENVIRONMENT", []))
    folder, command = properties.get("WORKING_DIRECTORY", PROJECT), suite["command"]
    labels = properties.get("LABELS", [])
    begin = time.monotonic()
    if "pytest" in labels or "pytest" in command:
        outcome = run_pytest(suite["name"], command, folder, environment)
    elif "cpputest" in labels:
        outcome = run_cpputest(suite["name"], command, folder)
    else:
        outcome = whole_command(suite["name"], *call(command, folder, environment))
    outcome.seconds = time.monotonic() - begin
    return outcome


def known_suites(build):
    listing = subprocess.run(["ctest", "--test-dir", str(build), "--show-only=json-v1"], check=True,
                             stdout=subprocess.PIPE)
    return json.loads(listing.stdout)["tests"]


def longest_first(suites):
    """In this order no processor is left with a long suite at the end. Those that say no COST keep their order."""
    def cost(suite):
        return max([0.0, *(float(entry["value"]) for entry in suite.get("properties", []) if entry["name"] == "COST")])

    return sorted(suites, key=cost, reverse=True)


def targets_of(suites):
    """What has to be built for the suites, by their labels needs:TARGET."""
    labels = {label for suite in suites for entry in suite.get("properties", [])
              if entry["name"] == "LABELS" for label in entry["value"]}
    targets = sorted(label.removeprefix("needs:") for label in labels if label.startswith("needs:"))
    return ["all"] if "all" in targets else targets


def report(outcome):
    mark = "FAILED" if outcome.failed else "ok"
    print(f"{mark:>6}  {outcome.name:<36} {outcome.passed:>5} passed {outcome.failed:>3} failed "
          f"{outcome.skipped:>3} skipped  {outcome.seconds:5.1f} s", flush=True)
    if outcome.failed:
        print(outcome.output.rstrip(), flush=True)
    for reason in outcome.skips:
        print(f"        skipped: {reason}", flush=True)


def hear_interruptions():
    """A job in the background of a shell ignores Ctrl-C, and so would its suites: those that
    send one would wait forever."""
    signal.signal(signal.SIGINT, signal.default_int_handler)


def main():
    parser = argparse.ArgumentParser(prog="voltlap test", description=__doc__,
                                     formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--build", type=Path, default=PROJECT / "build" / "default", help=argparse.SUPPRESS)
    parser.add_argument("--only", metavar="REGEX", default="", help="only suites whose name matches; builds only those")
    parser.add_argument("--targets", action="store_true", help=argparse.SUPPRESS)  # for the start script, which builds
    arguments = parser.parse_args()

    suites = [suite for suite in known_suites(arguments.build) if re.search(arguments.only, suite["name"])]
    if not suites:
        print(f"no suite matches --only {arguments.only}; `ctest --test-dir {arguments.build} -N` lists them",
              file=sys.stderr)
        return 2
    if arguments.targets:
        print(*(targets_of(suites) if arguments.only else ["all"]))
        return 0
    hear_interruptions()
    outcomes = []
    pool = concurrent.futures.ThreadPoolExecutor(os.cpu_count() or 1)
    try:
        running = [pool.submit(run_suite, suite) for suite in longest_first(suites)]
        for done in concurrent.futures.as_completed(running):
            outcomes.append(done.result())
            report(outcomes[-1])
    except KeyboardInterrupt:  # the suites that run have had it from the terminal too; the others do not start
        interrupt_the_young()
        pool.shutdown(wait=True, cancel_futures=True)
        print("interrupted", file=sys.stderr)
        return EXIT_INTERRUPTED
    failed = sum(outcome.failed for outcome in outcomes)
    print(f"{sum(o.passed for o in outcomes)} passed, {failed} failed, {sum(o.skipped for o in outcomes)} skipped")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
