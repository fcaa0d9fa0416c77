#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Gives drawn inputs to every reader of the project (tests/fuzz/target.cpp), under libFuzzer with the address and
undefined-behaviour sanitizers, and to the reader of scenario files. A reader may refuse an input in words. A crash,
another exception, a report of a sanitizer, more than 2 s for a megabyte or 50 times its memory is a finding: the input
is kept, with the command that shows it again.

Drawn inputs that reached something new stay in build/fuzz/corpus: the next campaign goes on from there.
"""
import argparse
import concurrent.futures
import dataclasses
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

from outputs import output_file

ROOT = Path(__file__).resolve().parents[1]
BUILD = ROOT / "build" / "fuzz"
FUZZER = BUILD / "bin" / "voltlap-fuzz"
SEEDS, CORPUS, FINDINGS = BUILD / "tests" / "fuzz" / "seeds", BUILD / "corpus", BUILD / "findings"
REGRESSIONS = ROOT / "tests" / "fuzz" / "regressions"
SCENARIOS = "scenarios"  # the one reader that is Python
SCENARIO_TEST = ROOT / "hil" / "tests" / "scenario_mutations_test.py"
EXIT_FINDING, EXIT_USAGE, EXIT_MISSING, EXIT_BUILD, EXIT_INTERRUPTED = 1, 2, 4, 5, 130
SCENARIO_CHANGES = 64  # of each scenario file in one run of the test
HANG_S = 25  # wall time of one input; what is slower than allowed, but ends, the fuzzer tells itself
WEDGED_S = 600  # first what a corpus holds is run, however long it takes
MEMORY_MB = 3000
stop = threading.Event()


@dataclasses.dataclass
class Campaign:
    target: str
    seconds: float = 0.0
    executions: int = 0
    coverage: int = 0  # edges of the program that were reached
    corpus: int = 0
    findings: tuple = ()  # files
    words: str = ""  # of the first finding


class Refused(Exception):
    """What a person can mend, with the exit code."""

    def __init__(self, code, text):
        super().__init__(text)
        self.code = code


def duration(text):
    match = re.fullmatch(r"(\d+(?:\.\d+)?)(s|min|h)", text)
    if not match or float(match[1]) <= 0:
        raise argparse.ArgumentTypeError(f"found {text}; expected a time such as 10s, 30min or 1h")
    return float(match[1]) * {"s": 1, "min": 60, "h": 3600}[match[2]]


def arguments():
    parser = argparse.ArgumentParser(
        prog="voltlap fuzz", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="Example: ./voltlap fuzz --for 1h\n"
               "Exit code: 0 no finding, 1 findings, 2 usage, 4 no clang, 5 the build failed, 130 interrupted.")
    parser.add_argument("targets", metavar="TARGET", nargs="*", help="only these readers, see --list")
    length = parser.add_mutually_exclusive_group()
    length.add_argument("--each", type=duration, default=10.0, metavar="TIME", help="for each reader (10s)")
    length.add_argument("--for", type=duration, dest="total", metavar="TIME", help="for all of them, such as 30min, 1h")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, metavar="N",
                        help="readers at a time (%(default)s)")
    parser.add_argument("--fresh", action="store_true", help="from the seeds alone, and keep nothing but findings")
    parser.add_argument("--json", type=output_file, metavar="FILE",
                        help="write executions, coverage and findings as JSON")
    parser.add_argument("--list", action="store_true", help="the readers, with the longest input in bytes; and end")
    return parser.parse_args()


def has_libfuzzer():
    if not shutil.which("clang++"):
        return False
    library = f"libclang_rt.fuzzer-{os.uname().machine}.a"  # printed with its folder where there is one
    asked = subprocess.run(["clang++", f"-print-file-name={library}"], check=True, capture_output=True, text=True)
    return "/" in asked.stdout


def build():
    """The fuzzer, made anew where a source has changed."""
    if not has_libfuzzer():
        raise Refused(EXIT_MISSING, "no clang++ with libFuzzer. Install it (Debian: clang and libclang-rt-dev)")
    BUILD.mkdir(parents=True, exist_ok=True)
    log = BUILD / "build.log"
    steps = [["cmake", "--preset", "fuzz", f"-DVOLTLAP_PYTHON={sys.executable}"],
             ["ninja", "-C", str(BUILD), "-j", str(os.cpu_count() or 1), "voltlap-fuzz"]]
    if (BUILD / "build.ninja").exists():
        del steps[0]
    else:
        print("building for the first time; this takes some minutes", file=sys.stderr, flush=True)
    with log.open("w") as out:
        for step in steps:
            if subprocess.run(step, cwd=ROOT, stdout=out, stderr=subprocess.STDOUT, check=False).returncode != 0:
                raise Refused(EXIT_BUILD, f"the fuzzer does not build; see {log}")


def known_targets():
    """Names with the longest input in bytes."""
    listing = subprocess.run([FUZZER, "--list"], check=True, capture_output=True, text=True).stdout
    return {name: int(longest) for name, longest in (line.split() for line in listing.splitlines())}


def last_number(pattern, text):
    found = re.findall(pattern, text)
    return int(found[-1]) if found else 0


def first_words(output):
    """What a finding is, in a line."""
    for pattern in (r"FINDING: (.*)", r"(\S+: runtime error: .*)", r"ERROR: \w+Sanitizer: (.*)",
                    r"ERROR: libFuzzer: (.*)"):
        if match := re.search(pattern, output):
            return match[1].strip()
    return output.strip().splitlines()[-1] if output.strip() else "no words"


def run_process(command, seconds, environment):
    """Its output; it is ended with this program, or when it does not end itself."""
    process = subprocess.Popen(command, cwd=ROOT, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                               text=True, errors="replace")
    latest = time.monotonic() + seconds + WEDGED_S
    while True:
        try:
            output, _ = process.communicate(timeout=0.5)
            return process.returncode, output
        except subprocess.TimeoutExpired:
            if stop.is_set() or time.monotonic() > latest:
                process.kill()


def fuzz(target, longest, seconds, fresh):
    """libFuzzer on one reader, until the time is over or it has a finding."""
    corpus, findings = CORPUS / target, FINDINGS / target
    findings.mkdir(parents=True, exist_ok=True)
    before = set(findings.iterdir())
    seeds = [folder for folder in (SEEDS / target, REGRESSIONS / target) if folder.is_dir()]
    begin = time.monotonic()
    memory = "/dev/shm" if os.access("/dev/shm", os.W_OK) else None
    with tempfile.TemporaryDirectory(prefix="voltlap-fuzz-", dir=memory) as scratch:
        if fresh:
            corpus = Path(scratch) / "corpus"
        corpus.mkdir(parents=True, exist_ok=True)
        _, output = run_process(
            [FUZZER, f"--target={target}", f"-max_total_time={max(1, round(seconds))}", f"-max_len={longest}",
             f"-timeout={HANG_S}", f"-rss_limit_mb={MEMORY_MB}", f"-dict={SEEDS / target}.dict", "-print_final_stats=1",
             "-report_slow_units=1000",
             f"-artifact_prefix={findings}/", corpus, *seeds], seconds, environment_of(scratch))
        kept = len(list(corpus.iterdir()))
    new = tuple(sorted(set(findings.iterdir()) - before))
    ended = "stat::number_of_executed_units" in output
    return Campaign(target, time.monotonic() - begin, last_number(r"stat::number_of_executed_units: (\d+)", output),
                    last_number(r"cov: (\d+)", output), kept, new,
                    first_words(output) if new or not (ended or stop.is_set()) else "")


def environment_of(scratch):
    return {**os.environ, "TMPDIR": scratch, "UBSAN_OPTIONS": "print_stacktrace=1",
            "ASAN_OPTIONS": "detect_stack_use_after_return=1:strict_string_checks=1"}


def change_scenarios(seconds):
    """The drawn changes of the harness's own test, again and again."""
    folder = FINDINGS / SCENARIOS
    campaign = Campaign(SCENARIOS)
    begin = time.monotonic()
    while time.monotonic() - begin < seconds and not campaign.words and not stop.is_set():
        pytest = [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", SCENARIO_TEST]
        code, output = run_process(pytest, 600, {**os.environ, "VOLTLAP_SCENARIO_CHANGES": str(SCENARIO_CHANGES)})
        campaign.executions += SCENARIO_CHANGES * last_number(r"(\d+) passed", output)
        if code != 0 and not stop.is_set():
            folder.mkdir(parents=True, exist_ok=True)
            kept = folder / f"{time.time_ns():x}.txt"
            kept.write_text(output)
            campaign.findings = (kept,)
            campaign.words = first_words("\n".join(re.findall(r"^E +(.*)", output, re.MULTILINE)[:1]) or output)
    campaign.seconds = time.monotonic() - begin
    return campaign


def show_command(campaign, finding):
    if campaign.target == SCENARIOS:
        return f"the input and its seed stand in {finding}"
    return f"{FUZZER.relative_to(ROOT)} --target={campaign.target} {finding.relative_to(ROOT)}"


def report(campaign):
    mark = "FINDING" if campaign.words else "ok"
    print(f"{mark:>8}  {campaign.target:<16}{campaign.executions:>11} inputs {campaign.seconds:>7.0f} s "
          f"{campaign.coverage:>7} edges {campaign.corpus:>6} kept", flush=True)
    if campaign.words:
        print(f"          {campaign.words}", flush=True)
    for finding in campaign.findings:
        print(f"          {show_command(campaign, finding)}", flush=True)


def run_all(targets, each, jobs, fresh):
    def run_one(name):
        if stop.is_set():
            return Campaign(name)
        return change_scenarios(each) if name == SCENARIOS else fuzz(name, targets[name], each, fresh)

    campaigns = []
    pool = concurrent.futures.ThreadPoolExecutor(jobs)
    try:
        for done in concurrent.futures.as_completed([pool.submit(run_one, name) for name in targets]):
            campaigns.append(done.result())
            report(campaigns[-1])
    except KeyboardInterrupt:
        stop.set()
        pool.shutdown(wait=True, cancel_futures=True)
        raise
    return campaigns


def chosen(wanted):
    known = {**known_targets(), SCENARIOS: 0}
    for name in wanted:
        if name not in known:
            raise Refused(EXIT_USAGE, f"TARGET: found {name}; expected one of {', '.join(known)}")
    return {name: longest for name, longest in known.items() if not wanted or name in wanted}


def run(args):
    if args.jobs < 1:
        raise Refused(EXIT_USAGE, f"--jobs: found {args.jobs}; expected 1 or more")
    build()
    targets = chosen(args.targets)
    if args.list:
        for name, longest in targets.items():
            print(f"{name:<16}{longest or ''}".rstrip())
        return 0
    each = args.total * args.jobs / max(len(targets), args.jobs) if args.total else args.each
    print(f"{len(targets)} readers, {each:.0f} s each, {args.jobs} at a time", file=sys.stderr, flush=True)
    campaigns = run_all(targets, each, args.jobs, args.fresh)
    if args.json:
        args.json.write_text(json.dumps(
            [{**dataclasses.asdict(campaign), "findings": [str(file) for file in campaign.findings]}
             for campaign in campaigns], indent=1) + "\n")
    found = sum(1 for campaign in campaigns if campaign.words)
    print(f"{sum(campaign.executions for campaign in campaigns)} inputs, {found} readers with a finding")
    return EXIT_FINDING if found else 0


def main():
    args = arguments()
    signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        return run(args)
    except Refused as refused:
        print(f"voltlap fuzz: {refused}", file=sys.stderr)
        return refused.code
    except KeyboardInterrupt:
        print("voltlap fuzz: interrupted", file=sys.stderr)
        return EXIT_INTERRUPTED


if __name__ == "__main__":
    sys.exit(main())
