# SPDX-License-Identifier: Apache-2.0
"""Hides an effect of a wanted separation in a world: copies, sizes, d'."""
import copy
import dataclasses

import numpy as np

from . import drive, effects, instruments, world

DETECTABLE = 3.3  # d' at which an effect can just be told from noise


@dataclasses.dataclass
class Hidden:
    """One effect in every case: its parameters as a report must give them, (cases,)."""

    effect: effects.Effect
    value: np.ndarray  # of the main parameter
    fixed: dict


def largest(effect, sound):
    """Largest size that happens in practice, (cases,)."""
    ohm = 0.09 / sound.cells.capacity_ah.mean(1) if effect.relative_to_ohm else np.ones(sound.shape[0])
    return effect.high * ohm


def with_effects(sound, now, hidden):
    """World and situation with the effects in them; the arguments stay as they are."""
    changed, then = copy.deepcopy(sound), copy.deepcopy(now)
    for each in hidden:
        each.effect.change(changed, then, each.value, each.fixed)
    return changed, then


def shown(drives):
    """Noise-free logs of drives [(world, situation)], each {role: (cases, steps)}."""
    return [world.channels(made, history, demand, now)
            for (made, now), (history, demand) in zip(drives, world.happens(drives))]


class Bench:
    """d' of effects in one situation: what they change, over the noise of all channels and over what changes by itself.

    d'^2 = D' (S + N N')^-1 D with D the change of all channels, S the noise of the instruments (white, wander,
    resolution), N one column for each thing that two sound drives differ by, a standard deviation long. D is the
    difference from the sound drive that shows the same current: who reads a log knows the current by its sensor only.
    A car's current follows from what is driven.
    """

    def __init__(self, sound, now):
        self.sound, self.now = sound, now
        unlike = world.unlike(sound, now)
        self.quiet, *others = shown([(sound, now)] + [(sound, other) for other, _ in unlike])
        self.nuisance = np.stack(  # (cases, things, samples)
            [self._difference(log, self.quiet) / share for log, (_, share) in zip(others, unlike)], 1)
        inner = np.einsum("bpi,bqi->bpq", self.nuisance, self.nuisance) + np.eye(self.nuisance.shape[1])
        self.inverse = np.linalg.inv(inner)

    @staticmethod
    def _difference(log, quiet):
        """Whitened difference of two logs, all channels in a row (cases, samples)."""
        names = [name for name in log if name != "ambient"]
        parts = []
        for kind in sorted({world.channel_kind(name) for name in names}):
            of_kind = np.stack([log[name] - quiet[name] for name in names if world.channel_kind(name) == kind], 1)
            parts.append(instruments.whitened(of_kind, kind, drive.STEP_S).reshape(len(of_kind), -1))
        return np.concatenate(parts, 1)

    def changes(self, logs):
        """What is different in noise-free logs, whitened: [(cases, samples)]."""
        quiet = [self.quiet] * len(logs)
        if self.now.current_a is not None:
            other = [k for k, log in enumerate(logs) if not np.array_equal(log["current"], self.quiet["current"])]
            drives = [(self.sound, dataclasses.replace(self.now, current_a=logs[k]["current"])) for k in other]
            for k, log in zip(other, shown(drives) if drives else []):
                quiet[k] = log
        return [self._difference(log, of) for log, of in zip(logs, quiet)]

    def separations(self, cases_of_hidden):
        """d' of each list of effects, all its effects together: (lists, cases)."""
        return self.separations_of(shown([with_effects(self.sound, self.now, hidden) for hidden in cases_of_hidden]))

    def separations_of(self, logs):
        """d' of noise-free logs: (logs, cases)."""
        squares = [self._product(change, change) for change in self.changes(logs)]
        return np.sqrt(np.maximum(np.array(squares), 0.0))

    def likeness(self, one, other):
        """Cosine between what two effects change in noise-free logs, (cases,): 1 when nobody can tell them apart."""
        a, b = self.changes([one, other])
        return self._product(a, b) / np.sqrt(np.maximum(self._product(a, a) * self._product(b, b), 1e-300))

    def _product(self, a, b):
        inside = np.einsum("bpi,bi->bp", self.nuisance, a), np.einsum("bpi,bi->bp", self.nuisance, b)
        return (a * b).sum(1) - np.einsum("bp,bpq,bq->b", inside[0], self.inverse, inside[1])
