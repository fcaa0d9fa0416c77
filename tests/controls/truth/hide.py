# SPDX-License-Identifier: Apache-2.0
"""Hides an effect of a wanted separation in a world: copies, sizes, d'."""
import copy
import dataclasses

import numpy as np

from . import drive, effects, instruments, observer, world

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
    """d' of effects in one situation of one case: how surely they can be told by who knows the physics and the logger.

    d'^2 = D' (S + N N')^-1 D with D the change of all channels, S what noise and an unknown drive hide (observer.py),
    N one column for each thing that two sound drives differ by, a standard deviation long. D is the difference from the
    sound drive that shows the same current: who reads a log knows the current by its sensor only. A car's power against
    what its motor takes is one more channel, in amperes.
    """

    def __init__(self, sound, now):
        self.sound, self.now = sound, now
        self.asked = world.happens([(sound, now)])[0]
        self.quiet = world.channels(sound, *self.asked, now)
        self.filter = self._filter()
        unlike = world.unlike(sound, now)
        changes = self.changes(shown([(sound, other) for other, _ in unlike]))
        self.nuisance = np.stack([change / share for change, (_, share) in zip(changes, unlike)])  # (things, samples)
        self.inverse = np.linalg.inv(self.nuisance @ self.nuisance.T + np.eye(len(self.nuisance)))

    def _channels(self, log):
        """What is compared: all but the current, by which the rest is foreseen, and what is given."""
        out = {name: values[0] for name, values in log.items() if name not in ("ambient", "current")}
        if self.asked[1] is not None:
            cells = sum(values for name, values in out.items() if name.startswith("cell_voltage"))
            out["power_a"] = log["current"][0] * cells / self._volts()
        return out

    def _volts(self):
        return self.asked[0].voltage_v[0].sum(1)

    def _filter(self):
        quiet, noise = self._channels(self.quiet), self.sound.instruments.noise
        noises = [instruments.Noise(1e-2, 0.0, 1.0, 0.0) if name == "power_a" else noise[world.channel_kind(name)]
                  for name in quiet]
        rng, current = np.random.default_rng(0), self.quiet["current"]
        errors = [rng.standard_normal(current.shape),
                  instruments.wander(rng, current.shape, 1.0, noise["current"].memory_s, drive.STEP_S)]
        flows = [(self.sound, dataclasses.replace(self.now, current_a=current + error)) for error in [0.0, *errors]]
        same, *moved = [self._channels(log) for log in shown(flows)]
        fast, slow = (np.array([-((log[name] - same[name]) * error[0]).sum() / (error ** 2).sum() for name in quiet])
                      for log, error in zip(moved, errors))
        by_drive = None
        if self.asked[1] is not None:
            # The power row compares with what is driven; an error of the current stands in it as it is.
            fast[-1] = slow[-1] = 1.0
            asks = observer.of_drive(world.of_today(self.sound, self.now.day)[1], self.now.speed_mps, self.now.slope,
                                     drive.STEP_S)
            field = {"speed": "speed_mps", "wheel_speed_1": "wheel_speed_mps", "motor_speed": "motor_rad_per_s",
                     "motor_torque": "torque_nm", "accelerator": "accelerator", "brake": "brake"}
            nothing = np.zeros((current.shape[1], 3))
            by_drive = np.stack([asks["power_w"] / self._volts()[:, None] if name == "power_a"
                                 else asks[field[name]] if name in field else nothing for name in quiet], 1)
        return observer.Filter(noises, np.stack(list(quiet.values())), noise["current"],
                               observer.Sensitivity(fast, slow, by_drive))

    def changes(self, logs):
        """What is different in noise-free logs, whitened: (logs, samples)."""
        quiet = [self.quiet] * len(logs)
        other = [k for k, log in enumerate(logs) if not np.array_equal(log["current"], self.quiet["current"])]
        drives = [(self.sound, dataclasses.replace(self.now, current_a=logs[k]["current"])) for k in other]
        for k, log in zip(other, shown(drives) if drives else []):
            quiet[k] = log
        out = []
        for log, of in zip(logs, quiet):
            seen, expected = self._channels(log), self._channels(of)
            if self.asked[1] is not None:
                expected["power_a"] = self.quiet["current"][0]
            out.append(np.stack([seen[name] - expected[name] for name in seen]))
        return self.filter.apply(np.stack(out)) if out else np.zeros((0, 0))

    def separations(self, lists_of_hidden):
        """d' of each list of effects, all its effects together: (lists,)."""
        return self.separations_of(shown([with_effects(self.sound, self.now, hidden) for hidden in lists_of_hidden]))

    def separations_of(self, logs):
        """d' of noise-free logs: (logs,)."""
        return np.sqrt(np.maximum([self._product(change, change) for change in self.changes(logs)], 0.0))

    def likeness(self, one, other):
        """Cosine between what two effects change in noise-free logs: 1 when nobody can tell them apart."""
        a, b = self.changes([one, other])
        return self._product(a, b) / np.sqrt(max(self._product(a, a) * self._product(b, b), 1e-300))

    def _product(self, a, b):
        return a @ b - (self.nuisance @ a) @ self.inverse @ (self.nuisance @ b)
