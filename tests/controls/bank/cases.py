# SPDX-License-Identifier: Apache-2.0
"""Draws worlds and the cases in them: clean logs, one effect, two effects, with d' of each from the truth itself.

A world is one car with its logger: its model, its reference logs, and the cases that are made of it. Sizes are
log-uniform from half to a hundred times the detectable one, as far as such sizes happen in practice.
"""

import copy
from dataclasses import dataclass, field

import numpy as np
from truth import drive, effects, hide, world

from . import models, packer

GATE = ("dropped_or_late_frames", "quantisation", "frozen_signal")  # seen by the integrity gate, not by d'
SMALLEST, LARGEST = 0.5, 100.0  # times the detectable size
CLEAR = 10.0  # d' that a pair's members have each


@dataclass
class Case:
    """One log that the tool is asked about. Everything that it must not know is in `label`."""

    world: "DrawnWorld"
    log: dict  # {role: (steps,)}
    keep: np.ndarray | None  # rows that were not lost
    label: dict
    without: str = ""  # cause that is taken out of the tool's catalogue
    sound: dict | None = None  # the same drive and the same noise without the effect, of a clear single case


@dataclass
class DrawnWorld:
    kind: str
    cell_text: str = ""
    model_text: str = ""
    logger: packer.Logger | None = None
    references: list = field(default_factory=list)  # [{role: (steps,)}]
    cases: list = field(default_factory=list)


def row_of(log, row=0):
    return {role: values[row] for role, values in log.items()}


def bend_driven(hidden, log):
    """RMS [V] of a bent open-circuit voltage over the charges that the log went through: of others it tells nothing."""
    charge = np.linspace(log["soc"][0].min(), log["soc"][0].max(), 101)
    waves = np.array([hidden.fixed[name][0] for name in ("first", "second", "third")])
    curve = np.sin(np.pi * charge[:, None] * np.arange(1, 4)) @ waves
    return float(hidden.value[0] * np.sqrt(np.mean(curve**2) / (0.5 * np.sum(waves**2))))


def parameters_of(hidden, sound, log):
    """What a report should give, {name: value}, of the first case; the numbers that are scored come first.

    `log` is the noise-free one with the effect in it, {role: (cases, steps)}.
    """
    effect, value = hidden.effect, float(hidden.value[0])
    fixed = {name: hidden.fixed[name][0] for name in hidden.fixed}
    out = {effect.main: value}
    if effect.name == "weak_cell":
        out = {"cell": int(fixed["cell"])}
        out["capacity_change" if fixed["by_capacity"] else "resistance_change"] = (
            -value if fixed["by_capacity"] else value
        )
    if effect.name == "current_saturation":
        out = {"limit_a": (1.0 - value) * 5.0 * float(sound.cells.capacity_ah.mean())}
    if effect.name == "ocv_shape":
        out = {effect.main: bend_driven(hidden, log)}
    if effect.name == "self_discharge":
        out["cell"] = int(fixed["cell"])
    if "channel" in fixed:
        out["channel"] = str(fixed["channel"])
    if "tau_s" in fixed:
        out["tau_s"] = float(fixed["tau_s"])
    return out


def label_of(ask, kind, hidden, sound, log, d_prime, each):
    return {
        "ask": ask,
        "kind": kind,
        "d_prime": round(float(d_prime), 4),
        "effects": [
            {"name": h.effect.name, "parameters": parameters_of(h, sound, log), "d_prime": round(float(d), 4)}
            for h, d in zip(hidden, each)
        ],
    }


class Maker:
    """Makes one world and its cases."""

    def __init__(self, rng, kind, duration_s, wanted, clean, references, pairs, family="particle"):
        self.rng, self.kind, self.duration_s = rng, kind, duration_s
        self.sound = world.make(rng, kind, 1, family)
        self.now = world.situation(rng, self.sound, duration_s)
        self.wanted = [effects.BY_NAME[name] for name in wanted]
        self.clean, self.references, self.pairs = clean, references, pairs

    def make(self):
        out = DrawnWorld(self.kind)
        bench = hide.Bench(self.sound, self.now)
        sound_logs = hide.shown(
            [
                (self.sound, world.situation(self.rng, self.sound, self.duration_s))
                for _ in range(self.clean + self.references)
            ]
        )
        measured = [row_of(world.measured(self.rng, log, self.sound)) for log in sound_logs]
        out.references = measured[: self.references]
        for log in measured[self.references :]:
            label = {"ask": "clean", "kind": self.kind, "d_prime": 0.0, "rho": 0.0, "channel": "", "effects": []}
            out.cases.append(Case(out, log, None, label))
        self._singles(bench, out)
        self._pairs(bench, out)
        out.logger = packer.logger_of(self.rng, self.kind, list(measured[0]))
        return out

    def _hidden(self, effect, size, fixed, sign):
        return hide.Hidden(effect, sign * np.atleast_1d(size), fixed)

    def _log(self, changed, shown):
        """The log with its noise, and the rows that arrived."""
        log = row_of(world.measured(self.rng, shown, changed))
        share = float(np.ravel(np.broadcast_to(changed.instruments.dropped_share, (1,)))[0])
        steps = len(log["current"])
        keep = None if share <= 0.0 else self.rng.random(steps) > share
        return log, keep

    def _draw(self, bench):
        """[(effect, fixed, sign, detectable size)] of every wanted effect, by the slope at a fifth of the largest size.

        It only sets how sizes are spread: the d' of a case is that of the size that it got.
        """
        drawn = [
            (effect, effect.fixed(self.rng, self.sound), int(self.rng.choice(effect.signs))) for effect in self.wanted
        ]
        regular = [entry for entry in drawn if entry[0].name not in GATE]
        sizes = [0.2 * hide.largest(effect, self.sound) for effect, _, _ in regular]
        if regular:
            seen = bench.separations(
                [[self._hidden(effect, size, fixed, sign)] for (effect, fixed, sign), size in zip(regular, sizes)]
            )
            sizes = [
                np.minimum(size * hide.DETECTABLE / max(d, 1e-9), hide.largest(effect, self.sound))
                for (effect, _, _), size, d in zip(regular, sizes, seen)
            ]
        self.gate = [entry for entry in drawn if entry[0].name in GATE]
        return [(*entry, size) for entry, size in zip(regular, sizes)]

    def _singles(self, bench, out):
        self.drawn = self._draw(bench)
        hidden = []
        for effect, fixed, sign, detectable in self.drawn:
            factor = self._factor(effect, detectable, SMALLEST)
            hidden.append(self._hidden(effect, factor * detectable, fixed, sign))
        for effect, fixed, sign in self.gate:
            size = hide.largest(effect, self.sound) * np.exp(self.rng.uniform(np.log(0.1), 0.0))
            size = np.maximum(size, effect.least(self.sound))
            hidden.append(self._hidden(effect, size, fixed, sign))
        self._add(bench, out, "single", [[h] for h in hidden])

    def _factor(self, effect, detectable, lowest):
        """Size over the detectable one, log-uniform up to what happens in practice."""
        top = min(LARGEST, float(hide.largest(effect, self.sound)[0] / detectable[0]))
        return np.exp(self.rng.uniform(np.log(lowest), np.log(max(top, 1.01 * lowest))))

    def _pairs(self, bench, out):
        """Two effects, each far above what can be told; the same world holds them together."""
        able = [
            entry
            for entry in self.drawn
            if hide.largest(entry[0], self.sound)[0] / entry[3][0] > 1.05 * CLEAR / hide.DETECTABLE
        ]
        chosen = []
        for _ in range(self.pairs if len(able) > 1 else 0):
            first, second = self.rng.choice(len(able), 2, replace=False)
            chosen.append((able[first], able[second]))
        hidden = [
            [
                self._hidden(
                    effect, self._factor(effect, detectable, 1.05 * CLEAR / hide.DETECTABLE) * detectable, fixed, sign
                )
                for effect, fixed, sign, detectable in pair
            ]
            for pair in chosen
        ]
        self._add(bench, out, "pair", hidden)

    def _add(self, bench, out, ask, hidden):
        if not hidden:
            return
        made = [hide.with_effects(self.sound, self.now, each) for each in hidden]
        alone = [member for each in hidden for member in each] if ask == "pair" else []
        drives = made + [hide.with_effects(self.sound, self.now, [member]) for member in alone]
        logs = hide.shown(drives)
        separations, rhos = bench.sizes_of(logs, drives)
        alone, alone_drives, alone_separations = (of[len(made) :] for of in (logs, drives, separations))
        for number, (members, (changed, _), log) in enumerate(zip(hidden, made, logs)):
            d_prime = float(separations[number])
            parts = alone[2 * number : 2 * number + 2]
            each = [float(d) for d in alone_separations[2 * number : 2 * number + 2]] or [d_prime]
            label = label_of(ask, self.kind, members, self.sound, log, d_prime, each)
            label["rho"], label["channel"] = round(rhos[number][0], 4), rhos[number][1]
            if parts:
                label["likeness"] = round(float(bench.likeness(parts, alone_drives[2 * number : 2 * number + 2])), 4)
            if members[0].effect.name in GATE:
                label["ask"] = "gate"
            again = copy.deepcopy(self.rng)
            measured, keep = self._log(changed, log)
            clear = label["ask"] == "single" and d_prime >= CLEAR
            sound = row_of(world.measured(again, bench.quiet, self.sound)) if clear else None
            out.cases.append(Case(out, measured, keep, label, sound=sound))


def leave_out(rng, drawn, share):
    """Cases of one clear effect again, with its cause taken out of the catalogue."""
    for case in list(drawn.cases):
        if case.label["ask"] != "single" or case.label["d_prime"] < CLEAR or rng.random() > share:
            continue
        label = dict(case.label, ask="left_out")
        drawn.cases.append(Case(drawn, case.log, case.keep, label, without=label["effects"][0]["name"]))


def give_model(rng, tool, folder, maker, made):
    """Identifies the world's cell in the folder and writes the texts of its model."""
    heat = models.heat_of(maker.sound.cells, maker.sound.family)[0]
    made.cell_text = models.identify(
        tool, folder, rng, models.pulse_tests(maker.sound.cells, maker.sound.family)[0], heat
    ).read_text()
    ambient_c = float(np.mean(made.references[0]["ambient"]))
    cells = maker.sound.shape[1]
    if made.kind == "cell":
        made.model_text = made.cell_text
    elif made.kind == "pack":
        made.model_text = models.pack_file(cells, ambient_c)
    else:
        made.model_text = models.car_file(maker.sound.car, cells, ambient_c, models.losses_of(made.references[0]))


def effects_step_s():
    """Time between two rows of a log."""
    return drive.STEP_S
