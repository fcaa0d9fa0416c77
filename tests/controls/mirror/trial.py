# SPDX-License-Identifier: Apache-2.0
"""The whole mirror: worlds are driven, every engine is asked about every log, gains are driven again."""

import json
import os
import secrets
import shlex
import shutil
import signal
import sys
import tempfile
import threading
import time
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from dataclasses import dataclass, field
from pathlib import Path

from bank import tool
from bank.score import Judged

from . import cases, drives

LEAST_GAIN = 0.05  # of the squares that the true model takes; less is not worth a share


@dataclass
class Outcome:
    """A case, what each engine said, and what the answers are worth on another drive."""

    label: dict
    judged: dict = field(default_factory=dict)  # {engine: Judged}
    gains: dict = field(default_factory=dict)  # {engine: {"promised", "real", "channel"}}
    weight: float = 0.0  # bytes that an engine reads
    not_driven: str = ""


@dataclass(frozen=True)
class Programs:
    """The simulator, today's explain as the meter of what a model leaves, and the engines under test."""

    folder: Path  # bin/ of the build
    engines: tuple  # ((name, path), ...)

    def simulator(self, running):
        return drives.Simulator(self.folder / "voltlap", self.folder / "voltlap-learn", running)

    @property
    def meter(self):
        return self.folder / "voltlap"


class Prepared:
    """A world that is driven: its folder with the sound car, its references, driven when a case asks for them."""

    def __init__(self, plan, number, programs, folder, running):
        self.world = cases.draw_world(plan, number)
        self.folder = Path(tempfile.mkdtemp(dir=folder, prefix="world-"))
        self.car = self.world.car
        self.every = 1 if self.car.kind == "cell" else cases.RATE // plan.rate  # rows of a CSV
        (self.folder / "model.toml").write_text(self.car.text)
        (self.folder / "cell.toml").write_text(self.car.text)
        (self.folder / "vehicle.toml").write_text(self.car.vehicle)
        self.simulator = programs.simulator(running)
        self.programs, self.running = programs, running
        self.lock, self.reference_logs, self.open_cases = threading.Lock(), [], 0
        self.sound_log, truth = self.simulator.drive(self.car, self.folder, self.world.cases[0].settings, "sound")
        cases.weigh(self.world, drives.read_truth(truth, self.car))

    def references(self, count):
        with self.lock:
            while len(self.reference_logs) < count:
                k = len(self.reference_logs)
                log, _ = self.simulator.drive(self.car, self.folder, self.world.references[k], f"reference{k}")
                self.reference_logs.append(log)
            return self.reference_logs[:count]

    def log_of(self, case):
        if case.number % cases.PER_WORLD == 0:
            return self.sound_log
        return self.simulator.drive(self.car, self.folder, case.settings, f"log{case.number}", case.keys)[0]


def hand_over(log, to, every):
    """The log as it is, or of a drive's CSV one row of `every`."""
    if every == 1 or log.suffix != ".csv":
        os.link(log, to)
        return
    with open(log, encoding="ascii") as read, open(to, "w", encoding="ascii") as written:
        rows = -1  # the names are no row
        for line in read:
            if line.startswith("#"):
                written.write(line)
                continue
            if rows < 0 or rows % every == 0:
                written.write(line)
            rows += 1


def question(prepared, case, log, folder):
    """A folder with a random name: log, model and references, and nothing else."""
    place = folder / secrets.token_hex(8)
    place.mkdir()
    hand_over(log, place / f"log{prepared.car.ending}", prepared.every)
    shutil.copy(prepared.folder / "model.toml", place)
    for k, reference in enumerate(prepared.references(case.references)):
        hand_over(reference, place / f"reference_{k}{prepared.car.ending}", prepared.every)
    return place


def words(engine, place, seed):
    return [*tool.command(engine, place, seed), "--write-model", "extended.toml"]


def answered(prepared, case, folder):
    """The outcome of one case, and the extended models by engine."""
    out = Outcome(case.label)
    try:
        log = prepared.log_of(case)
        place = question(prepared, case, log, folder)
    except drives.NotDriven as failure:
        out.not_driven = str(failure)
        return out
    out.weight = float(sum(file.stat().st_size for file in place.iterdir()))
    extended = {}
    for name, engine in prepared.programs.engines:
        answer = tool.run(words(engine, place, case.settings.seed), place, prepared.running)
        out.judged[name] = Judged(str(case.number), case.label, answer)
        (place / "answer.json").unlink(missing_ok=True)
        if (place / "extended.toml").exists():
            extended[name] = (place / "extended.toml").rename(prepared.folder / f"extended-{case.number}-{name}.toml")
    shutil.rmtree(place)
    if case.number % cases.PER_WORLD:
        log.unlink(missing_ok=True)
    named = {name: extended[name] for name in extended if out.judged[name].answer.verdict == "named"}
    if case.hidden and case.gain and not case.hidden.effect.sensor and named:
        measure_gains(prepared, case, named, out, folder)
    return out


def left_by(prepared, place, model, keys=()):
    """RMS by channel of what a model leaves of the log in the folder, by the meter."""
    settings = ["--set", *keys] if keys else []
    given = [str(prepared.programs.meter), "explain", f"log{prepared.car.ending}", "--model", model, "--json",
             "answer.json", *settings]
    answer = tool.run(given, place, prepared.running)
    return {name: gain["heldout_rms_before"] for name, gain in answer.gain.items()}


def measure_gains(prepared, case, named, out, folder):
    """Drives the effect once more, otherwise, and holds the extended models, the given and the true one against it."""
    try:
        log, _ = prepared.simulator.drive(prepared.car, prepared.folder, prepared.world.other, f"other{case.number}",
                                          case.keys)
    except drives.NotDriven:
        return
    place = folder / secrets.token_hex(8)
    place.mkdir()
    hand_over(log, place / f"log{prepared.car.ending}", prepared.every)
    shutil.copy(prepared.folder / "model.toml", place)
    before = left_by(prepared, place, "model.toml")
    if prepared.car.kind == "cell":
        (place / "true.toml").write_text(drives.true_cell(prepared.car.text, case.keys))
        true = left_by(prepared, place, "true.toml")
    else:
        true = left_by(prepared, place, "model.toml", case.keys)
    for name, model in named.items():
        shutil.copy(model, place / "extended.toml")
        gain = gain_of(before, left_by(prepared, place, "extended.toml"), true, out.judged[name].answer.gain)
        if gain:
            out.gains[name] = gain
    shutil.rmtree(place)
    log.unlink(missing_ok=True)


def gain_of(before, after, true, promised):
    """Shares of the squares in the channel where the true model takes most; None where it takes nothing."""
    ways = [(1.0 - (true[c] / before[c]) ** 2, c) for c in before if before[c] > 0 and c in true and c in after]
    share, channel = max(ways, default=(0.0, ""))
    told = promised.get(channel, {})
    if share < LEAST_GAIN or not told.get("heldout_rms_before"):  # nothing was read there
        return None
    return {"channel": channel, "true": share, "real": 1.0 - (after[channel] / before[channel]) ** 2,
            "promised": 1.0 - (told["heldout_rms_after"] / told["heldout_rms_before"]) ** 2}


class Trial:
    """Runs the cases with these numbers. On KeyboardInterrupt everything that was started is ended."""

    def __init__(self, plan, programs, numbers, jobs):
        self.plan, self.programs, self.jobs = plan, programs, jobs
        self.numbers = sorted(numbers)
        self.folder = Path(tempfile.mkdtemp(prefix="explain-mirror-"))
        self.running, self.outcomes = set(), []
        self.begun, self.told = time.monotonic(), -30.0
        self.stopped = False

    def run(self):
        worlds = {}
        for number in self.numbers:
            worlds.setdefault(number // cases.PER_WORLD, set()).add(number)
        pool = ThreadPoolExecutor(self.jobs)
        try:
            ahead, pending = list(worlds.items())[::-1], set()
            while pending or ahead:
                while ahead and len(pending) <= self.jobs:  # no more worlds on the disk than keep all busy
                    pending.add(pool.submit(self._prepare, *ahead.pop()))
                done, pending = wait(pending, timeout=1.0, return_when=FIRST_COMPLETED)
                for future in done:
                    for prepared, case in future.result():
                        pending.add(pool.submit(self._answer, prepared, case))
                self._progress()
        except BaseException:
            self.stopped = True
            pool.shutdown(wait=False, cancel_futures=True)
            for process in list(self.running):
                process.kill()
            raise
        finally:
            pool.shutdown()
            shutil.rmtree(self.folder, ignore_errors=True)
        self._progress(last=True)
        return sorted(self.outcomes, key=lambda outcome: outcome.label["number"])

    def keep(self, number, folder):
        """Drives one case and leaves its question in the folder. Returns what was hidden, and the command that asks."""
        try:
            prepared = Prepared(self.plan, number // cases.PER_WORLD, self.programs, self.folder, self.running)
            case = next(case for case in prepared.world.cases if case.number == number)
            place = question(prepared, case, prepared.log_of(case), self.folder)
            shutil.copytree(place, folder)
        finally:
            shutil.rmtree(self.folder, ignore_errors=True)
        asked = words(self.programs.engines[0][1], Path(folder), case.settings.seed)
        return f"{json.dumps(case.label)}\ncd {shlex.quote(str(folder))} && {shlex.join(asked)}"

    def _prepare(self, number, chosen):
        """Drives the sound car of a world. Returns its chosen cases."""
        if self.stopped:
            return []
        try:
            prepared = Prepared(self.plan, number, self.programs, self.folder, self.running)
        except drives.NotDriven as failure:
            kind = cases.kind_of(self.plan, number)
            for case in sorted(chosen):
                self.outcomes.append(Outcome({"number": case, "kind": kind, "ask": "none"}, not_driven=str(failure)))
            return []
        found = [(prepared, case) for case in prepared.world.cases if case.number in chosen]
        prepared.open_cases = len(found)
        return found

    def _answer(self, prepared, case):
        if not self.stopped:
            self.outcomes.append(answered(prepared, case, self.folder))
        with prepared.lock:
            prepared.open_cases -= 1
            if prepared.open_cases == 0:
                shutil.rmtree(prepared.folder)
        return []

    def _progress(self, last=False):
        seconds = time.monotonic() - self.begun
        text = f"explain-mirror: {len(self.outcomes)} of {len(self.numbers)} cases, {seconds:.0f} s"
        if sys.stderr.isatty():
            print("\r" + text, end="\n" if last else "", file=sys.stderr, flush=True)
        elif last or seconds - self.told >= 30.0:
            self.told = seconds
            print(text, file=sys.stderr, flush=True)


def hear_the_end():
    """Whoever ends the run gets the same clean end; a shell's background jobs do not hear Ctrl-C by themselves."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.default_int_handler)
