# SPDX-License-Identifier: Apache-2.0
"""Hides an effect of a wanted separation in a world: copies, sizes, d'."""
import copy
import dataclasses

import numpy as np

from . import car as cars
from . import drive, effects, instruments, observer, world

DETECTABLE = 3.3  # d' at which an effect can just be told from noise
# What is worth a word: volts of a cell, kelvin, and a share of the RMS of what a car asks for.
PRACTICAL_V, PRACTICAL_K, PRACTICAL_SHARE = 1e-3, 0.1, 0.005
ASKED = ("power_a", "motor_torque", "motor_speed")
DRIVEN = {"speed": "speed_mps", "wheel_speed_1": "wheel_speed_mps", "motor_speed": "motor_rad_per_s",
          "motor_torque": "torque_nm", "accelerator": "accelerator", "brake": "brake"}  # of car.Demand


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
    what its motor takes is one more channel, in amperes. A car that needs another force is held against the sound one on
    a road that asks for that force, and the road's slope goes through the filter: from force to pedals it is one way for
    both, and bends (one pedal is released before the other is pressed, either can be pressed no further) tell nothing.
    """

    def __init__(self, sound, now):
        self.sound, self.now = sound, now
        self.asked = world.happens([(sound, now)])[0]
        self.quiet = world.channels(sound, *self.asked, now)
        self.filter = self._filter()
        unlike = world.unlike(sound, now)
        differences = self.differences(shown([(sound, other) for other, _ in unlike]))
        # (things, channels, steps) of what it begins with: as many of charge as of warmth.
        self.charges, self.warmths = np.split(differences[len(world.day_to_day(sound)):], 2)
        changes = self.filter.apply(differences)
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
            nothing = np.zeros((current.shape[1], 3))
            by_drive = np.stack([asks["power_w"] / self._volts()[:, None] if name == "power_a"
                                 else asks[DRIVEN[name]] if name in DRIVEN else nothing for name in quiet], 1)
            self.by_slope = by_drive[:, :, 2].T
        return observer.Filter(noises, np.stack(list(quiet.values())), noise["current"],
                               observer.Sensitivity(fast, slow, by_drive))

    def _same_force(self, made, now):
        """Of a drive: slope (steps,) on which the sound car needs the same force, and what is read of it there."""
        pull = np.gradient(now.speed_mps, drive.STEP_S, axis=1)
        car = world.of_today(self.sound, self.now.day)[1]
        needed, usual = (cars.force_n(each, now.speed_mps, now.slope, pull)
                         for each in (world.of_today(made, now.day)[1], car))
        rise = (needed - usual) / (car.mass_kg * cars.GRAVITY)
        demand = cars.drive(car, now.speed_mps, now.slope + rise, drive.STEP_S)
        read = {name: getattr(demand, field)[0] for name, field in DRIVEN.items()}
        more_w = (demand.power_w - self.asked[1].power_w)[0]
        return rise[0], read | {"power_a": self.quiet["current"][0] + more_w / self._volts()}

    def changes(self, logs, drives=None):
        """What is different in noise-free logs, whitened: (logs, samples). drives: [(world, situation)] of the logs."""
        return self.filter.apply(self.differences(logs, drives)) if logs else np.zeros((0, 0))

    def differences(self, logs, drives=None):
        """The same as it is: (logs, channels, steps)."""
        quiet = [self.quiet] * len(logs)
        other = [k for k, log in enumerate(logs) if not np.array_equal(log["current"], self.quiet["current"])]
        same_current = [(self.sound, dataclasses.replace(self.now, current_a=logs[k]["current"])) for k in other]
        for k, log in zip(other, shown(same_current) if same_current else []):
            quiet[k] = log
        out = []
        for k, (log, of) in enumerate(zip(logs, quiet)):
            seen, expected, by_road = self._channels(log), self._channels(of), 0.0
            if self.asked[1] is not None:
                expected["power_a"] = self.quiet["current"][0]
            if self.asked[1] is not None and drives is not None:
                rise, read = self._same_force(*drives[k])
                expected |= {name: read[name] for name in read if name in seen}
                by_road = self.by_slope * rise
            out.append(np.stack([seen[name] - expected[name] for name in seen]) + by_road)
        return np.stack(out)

    def separations(self, lists_of_hidden):
        """d' of each list of effects, all its effects together: (lists,)."""
        drives = [with_effects(self.sound, self.now, hidden) for hidden in lists_of_hidden]
        return self.separations_of(shown(drives), drives)

    def separations_of(self, logs, drives):
        """d' of noise-free logs of these drives [(world, situation)]: (logs,)."""
        return self._separations(self.changes(logs, drives))

    def sizes_of(self, logs, drives):
        """(d' (logs,), [(rho, channel)]) of noise-free logs of these drives [(world, situation)]."""
        differences = self.differences(logs, drives)
        return self._separations(self.filter.apply(differences)), [self._rho(each) for each in differences]

    def _separations(self, changes):
        return np.sqrt(np.maximum([self._product(change, change) for change in changes], 0.0))

    def _practical(self, name, values):
        """What is worth a word in a channel; None: another channel tells it."""
        if name in ASKED:
            return PRACTICAL_SHARE * float(np.sqrt(np.mean(values**2)))
        kind = world.channel_kind(name)
        cells = self.sound.shape[1] if kind == "pack_voltage" else 1
        return {"voltage": PRACTICAL_V, "pack_voltage": cells * PRACTICAL_V, "temperature": PRACTICAL_K}.get(kind)

    def _rho(self, difference):
        """(rho, channel): RMS of what a drive of the same current adds to a channel, its beginning refitted, over what
        is worth a word there; of the channel where that is most. Of a voltage the charge is refitted, not the warmth:
        thermistors are read beside it."""
        best = (0.0, "")
        for k, (name, quiet) in enumerate(self._channels(self.quiet).items()):
            practical = self._practical(name, quiet)
            if practical is None or practical <= 0.0:
                continue
            starts = (self.warmths if world.channel_kind(name) == "temperature" else self.charges)[:, k].T
            left = difference[k] - starts @ np.linalg.lstsq(starts, difference[k], rcond=1e-9)[0]
            best = max(best, (float(np.sqrt(np.mean(left**2))) / practical, name))
        return best

    def likeness(self, logs, drives):
        """Cosine between what two effects change in noise-free logs: 1 when nobody can tell them apart."""
        a, b = self.changes(logs, drives)
        return self._product(a, b) / np.sqrt(max(self._product(a, a) * self._product(b, b), 1e-300))

    def _product(self, a, b):
        return a @ b - (self.nuisance @ a) @ self.inverse @ (self.nuisance @ b)
