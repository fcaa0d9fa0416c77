# SPDX-License-Identifier: Apache-2.0
"""The whole trial: worlds made side by side, folders sealed, the tool asked, labels revealed, answers judged."""

import os
import secrets
import shutil
import signal
import sys
import tempfile
import time
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, ThreadPoolExecutor, wait
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from . import cases, packer, seal, tool
from .score import Judged


@dataclass(frozen=True)
class Plan:
    """What is asked, of each kind of world."""

    kinds: tuple
    worlds: int  # a kind
    clean: int  # clean logs a world
    references: int
    pairs: int
    left_out: float  # share of the clear single cases that are asked again without their cause
    duration_s: float
    causes: tuple  # of single effects
    family: str  # of the cells' physics, a key of world.FAMILIES


@dataclass(frozen=True)
class Question:
    """A folder and how to ask about it; the label goes to the ledger and nowhere else."""

    name: str
    without: str
    sound: Path | None = None  # the log without its effect, out of the tool's reach; None: not asked


def leave_the_end_to_the_parent():
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)


def prepare(binary, folder, plan, kind, seed, kept=None):
    """In a process of its own: one world, its model, the folders of its cases. Returns [(Question, label)].

    `kept`: where logs without their effect are put, to tell what the true model would leave.
    """
    rng = np.random.default_rng(seed)
    wanted = [name for name in plan.causes if kind in cases.effects.BY_NAME[name].kinds]
    maker = cases.Maker(rng, kind, plan.duration_s, wanted, plan.clean, plan.references, plan.pairs, plan.family)
    made = maker.make()
    cases.leave_out(rng, made, plan.left_out)
    base = Path(tempfile.mkdtemp(dir=folder, prefix="w"))
    cases.give_model(rng, binary, base, maker, made)
    (base / "model.toml").write_text(made.model_text)
    ending = ".csv.gz" if made.logger.packed else ".csv"
    text = packer.role_map(made.logger)
    if text is not None:
        (base / "map.toml").write_text(text)
    for number, log in enumerate(made.references):
        packer.write_log(base / f"reference_{number}{ending}", made.logger, log, cases.effects_step_s())
    shared = sorted(base.iterdir())
    out = []
    for number in rng.permutation(len(made.cases)):
        case = made.cases[number]
        name = secrets.token_hex(8)
        place = folder / name
        place.mkdir()
        for file in shared:
            os.link(file, place / file.name)
        packer.write_log(place / f"log{ending}", made.logger, case.log, cases.effects_step_s(), case.keep)
        sound = None
        if kept is not None and case.sound is not None:
            sound = packer.write_log(kept / f"{name}{ending}", made.logger, case.sound, cases.effects_step_s())
        out.append((Question(name, case.without, sound), case.label))
    shutil.rmtree(base)
    return out


class Trial:
    def __init__(self, binary, plan, seed, folder, jobs):
        self.binary, self.plan, self.folder, self.jobs = Path(binary).resolve(), plan, Path(folder), jobs
        self.seeds = np.random.SeedSequence(seed)
        self.kept = Path(tempfile.mkdtemp(prefix="explain-bench-kept-"))
        self.ledger = seal.Ledger(self.folder)
        self.running, self.answers, self.questions = set(), {}, {}
        self.begun = time.monotonic()
        self.asked = self.worlds_done = 0
        self.worlds = len(plan.kinds) * plan.worlds

    def run(self):
        """Returns the judged cases. On KeyboardInterrupt everything that was started is ended."""
        makers = ProcessPoolExecutor(self.jobs, initializer=leave_the_end_to_the_parent)
        askers = ThreadPoolExecutor(self.jobs)
        try:
            pending = {
                makers.submit(prepare, self.binary, self.folder, self.plan, kind, seed, self.kept): "world"
                for kind, seed in zip(self.plan.kinds * self.plan.worlds, self.seeds.spawn(self.worlds))
            }
            while pending:
                done, _ = wait(pending, timeout=1.0, return_when=FIRST_COMPLETED)
                for future in done:
                    if pending.pop(future) == "world":
                        self.worlds_done += 1
                        self._ask_all(future.result(), askers, pending)
                    else:
                        future.result()
                self._progress()
        except BaseException:
            self._stop(makers, askers)
            raise
        finally:
            shutil.rmtree(self.kept, ignore_errors=True)
        makers.shutdown()
        askers.shutdown()
        self._progress(last=True)
        labels = self.ledger.reveal()
        return [
            Judged(name, labels[name], answer, self.questions[name].without) for name, answer in self.answers.items()
        ]

    def _ask_all(self, prepared, askers, pending):
        for question, label in prepared:
            self.ledger.commit(question.name, label)
            self.questions[question.name] = question
        for question, _ in prepared:
            self.asked += 1
            pending[askers.submit(self._ask, question)] = "answer"

    def _ask(self, question):
        place = self.folder / question.name
        answer = tool.ask(self.binary, place, secrets.randbelow(2**31), question.without, self.running)
        if answer.verdict == "named" and question.sound is not None:
            # What the true model would leave is what the given one leaves of the same drive without the effect.
            shutil.copy(question.sound, place / f"log{''.join(question.sound.suffixes)}")
            sound = tool.ask(self.binary, place, 1, "", self.running)
            answer.sound_rms = {name: g["heldout_rms_before"] for name, g in sound.gain.items()}
        self.answers[question.name] = answer
        shutil.rmtree(place)

    def _stop(self, makers, askers):
        for process in list(makers._processes.values()):
            process.terminate()
        makers.shutdown(wait=False, cancel_futures=True)
        askers.shutdown(wait=False, cancel_futures=True)
        for process in list(self.running):
            process.kill()

    def _progress(self, last=False):
        seconds = time.monotonic() - self.begun
        text = (
            f"explain-bench: {self.worlds_done} of {self.worlds} worlds made, {len(self.answers)} of {self.asked} "
            f"questions answered, {seconds:.0f} s"
        )
        if sys.stderr.isatty():
            print("\r" + text, end="\n" if last else "", file=sys.stderr, flush=True)
        elif last or seconds - getattr(self, "_told", -30.0) >= 30.0:
            self._told = seconds
            print(text, file=sys.stderr, flush=True)
