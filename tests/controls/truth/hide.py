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
    resolution), N one column for each parameter that differs from day to day, a standard deviation long.
    """

    def __init__(self, sound, now):
        self.sound, self.now = sound, now
        drives = [(sound, now)]
        for name, sigma in world.day_to_day(sound).items():
            other = copy.deepcopy(now)
            other.day[name] = other.day[name] + sigma
            drives.append((sound, other))
        self.quiet, *others = shown(drives)
        self.nuisance = np.stack([self._changes(log) for log in others], 1)  # (cases, parameters, samples)
        inner = np.einsum("bpi,bqi->bpq", self.nuisance, self.nuisance) + np.eye(self.nuisance.shape[1])
        self.inverse = np.linalg.inv(inner)

    def _changes(self, log):
        """Whitened difference from the quiet log, all channels in a row (cases, samples)."""
        names = [name for name in log if name != "ambient"]
        parts = []
        for kind in sorted({world.channel_kind(name) for name in names}):
            of_kind = np.stack([log[name] - self.quiet[name] for name in names if world.channel_kind(name) == kind], 1)
            parts.append(instruments.whitened(of_kind, kind, drive.STEP_S).reshape(len(of_kind), -1))
        return np.concatenate(parts, 1)

    def separations(self, cases_of_hidden):
        """d' of each list of effects, all its effects together: (lists, cases)."""
        logs = shown([with_effects(self.sound, self.now, hidden) for hidden in cases_of_hidden])
        return np.array([self.separation(log) for log in logs])

    def separation(self, log):
        """d' of a noise-free log from the quiet one, (cases,)."""
        change = self._changes(log)
        return np.sqrt(np.maximum(self._product(change, change), 0.0))

    def likeness(self, one, other):
        """Cosine between what two effects change, (cases,): 1 when nobody can tell them apart."""
        a, b = self._changes(one), self._changes(other)
        return self._product(a, b) / np.sqrt(np.maximum(self._product(a, a) * self._product(b, b), 1e-300))

    def _product(self, a, b):
        inside = np.einsum("bpi,bi->bp", self.nuisance, a), np.einsum("bpi,bi->bp", self.nuisance, b)
        return (a * b).sum(1) - np.einsum("bp,bpq,bq->b", inside[0], self.inverse, inside[1])

    def detectable(self, effect, fixed, sign):
        """Size whose d' is DETECTABLE, (cases,): from the slope at a fifth of the largest size, mended once."""
        size = 0.2 * largest(effect, self.sound)
        for _ in range(2):
            seen = self.separations([[Hidden(effect, sign * size, fixed)]])[0]
            size = np.minimum(size * DETECTABLE / np.maximum(seen, 1e-9), largest(effect, self.sound))
        return size
