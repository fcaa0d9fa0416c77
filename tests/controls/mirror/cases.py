# SPDX-License-Identifier: Apache-2.0
"""Draws the cases: worlds of ten, two sound logs and eight with an effect.

Everything follows from the seed and the number of the case.
"""

from dataclasses import dataclass, field

import numpy as np

from . import catalogue, drives, size
from .effects import Scene

PER_WORLD, SOUND = 10, 2
RATE = 10  # rows a second of the CSV of a drive
KINDS_IN_TURN = ("car", "pack", "cell", "car", "long", "pack")
REFERENCES = (0, 1, 3)
BINS = ((0.5, 1.0, 0.10), (1.0, 3.0, 0.30), (3.0, 30.0, 0.60))  # rho from, to, share of the draws
GAIN_OF_CANDUMP = 0.34  # how many of them are driven again for the gain; of a CSV all


@dataclass(frozen=True)
class Plan:
    seed: int
    quick: bool = False
    kinds: tuple = drives.KINDS
    causes: tuple = ()  # empty: all
    rate: int = RATE  # rows a second that the engine is given of them


@dataclass
class Hidden:
    """One effect with its size: drawn, then weighed on the sound drive of its world."""

    effect: object
    sign: int
    wanted: float  # rho
    member: int
    tau_s: float
    weights: tuple
    signed: float = 0.0
    scene: Scene | None = None


@dataclass
class Case:
    number: int
    settings: drives.Settings
    references: int
    gain: bool
    hidden: Hidden | None = None
    label: dict = field(default_factory=dict)

    @property
    def keys(self):
        return self.hidden.effect.keys(self.hidden.scene, self.hidden.signed) if self.hidden else ()


@dataclass
class World:
    car: drives.Car
    references: list  # [Settings]
    other: drives.Settings  # the drive on which a gain is measured
    cases: list
    rng: np.random.Generator


def kind_of(plan, number):
    turn = [kind for kind in KINDS_IN_TURN if kind in plan.kinds]
    return turn[number % len(turn)]


def draw_world(plan, number):
    """World `number`; sizes are still open, for they are of its sound drive."""
    rng = np.random.default_rng([plan.seed, number])
    car = drives.draw_car(rng, kind_of(plan, number), plan.quick)
    settings = [drives.draw_settings(rng, car, plan.quick) for _ in range(SOUND + 1)]
    references = [drives.draw_settings(rng, car, plan.quick, sound_day=True) for _ in range(max(REFERENCES))]
    able = catalogue.able(car.kind, car.candump, plan.causes)
    order = [k for _ in range(PER_WORLD) for k in rng.permutation(len(able))]
    cases = []
    for index in range(PER_WORLD):
        count = int(rng.choice(REFERENCES))
        gain = bool(rng.random() < GAIN_OF_CANDUMP) or not car.candump
        drive = settings[index] if index < SOUND else drives.Settings(
            int(rng.integers(1, 2**31)), settings[0].keys, settings[0].arguments)
        case = Case(PER_WORLD * number + index, drive, count, gain)
        if index >= SOUND and able:
            case.hidden = draw_hidden(rng, car, able[order[index - SOUND]])
        if index < SOUND or able:
            cases.append(case)
    return World(car, references, settings[SOUND], cases, rng)


def draw_hidden(rng, car, effect):
    low, high, _ = BINS[rng.choice(len(BINS), p=[share for _, _, share in BINS])]
    members = car.thermistors if effect.name.startswith("thermistor") else car.series
    taus = catalogue.TAU_S.get(effect.name, (10.0, 10.0))
    return Hidden(
        effect,
        int(rng.choice(effect.signs)),
        float(np.exp(rng.uniform(np.log(low), np.log(high)))),
        int(rng.integers(1, members + 1)),
        float(f"{np.exp(rng.uniform(*np.log(taus))):.3g}"),
        tuple(rng.normal(size=3) / np.arange(1, 4)),
    )


def weigh(world, truth):
    """Gives each case its size and its label, by the sound drive of the world."""
    for case in world.cases:
        rng = np.random.default_rng([case.number, case.settings.seed])
        case.label = {**drives.facts_of(world.car), "number": case.number, "references": case.references,
                      "d_prime": 0.0, "ask": "sound", "effects": [], "rho": 0.0, "channel": "", "visible": True}
        hidden = case.hidden
        if hidden is None:
            continue
        hidden.scene = Scene(world.car, truth, hidden.member, hidden.tau_s, hidden.weights)
        hidden.signed = size.sized(hidden.effect, hidden.scene, hidden.sign, hidden.wanted)
        rho, channel = size.rho_of(hidden.effect, hidden.scene, hidden.signed)
        gain = size.gain_unseen(hidden.effect, hidden.scene, hidden.signed, rng) if rho > 0.0 else 0.0
        parameters = catalogue.parameters_of(hidden.effect, hidden.scene, hidden.signed)
        case.label.update(
            ask="single", rho=round(rho, 4), channel=channel, visible=gain >= size.DECISIVE, form=hidden.effect.form,
            effects=[{"name": hidden.effect.name, "parameters": parameters, "d_prime": 0.0}])
