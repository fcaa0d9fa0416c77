# SPDX-License-Identifier: Apache-2.0
"""What can be told from a log by one who knows the physics but neither what was driven nor the current that flowed.

All channels go through one Kalman filter. Its states are the wander of each channel, what coarse steps hide of slow
ones, the wander of the current's sensor, and in a car its speed, pull and the slope of the road: a torque tells of a
mass only as well as the sensors of the speed tell the pull. What comes out is white, so that the squares of a change
that went through are how surely it can be told (d'^2).
"""
import dataclasses

import numpy as np

from . import car as cars
from . import drive

SLOPE, SLOPE_MEMORY_S = 0.0055, 10.0  # of drive.track, standard deviation
SPEED_MPS, PULL_MPS2, PULL_MEMORY_S = 5.0, 4.0, 0.7  # what a driver may have done otherwise


@dataclasses.dataclass
class Sensitivity:
    """How channels follow what no channel shows as it is, by channel (m,) and, in a car, by step (steps, m, 3)."""

    current_fast: np.ndarray  # per ampere that the current's sensor errs
    current_slow: np.ndarray
    drive: np.ndarray | None = None  # per m/s of speed, m/s2 of pull, and slope


def of_drive(car, speed, slope, step_s):
    """{name: (steps, 3)}: derivatives of what a drive (1, steps) asks to speed, pull and slope."""
    pull = np.gradient(speed, step_s, axis=1)
    out = {}
    for number, size in enumerate((0.05, 0.05, 0.0005)):
        each = []
        for sign in (0.5, -0.5):
            moved = [speed, pull, slope]
            moved[number] = np.where(speed > 0.1, moved[number] + sign * size, moved[number])
            each.append(cars.drive(car, moved[0], moved[2], step_s, moved[1]))
        for field in dataclasses.fields(each[0]):
            slopes = (getattr(each[0], field.name) - getattr(each[1], field.name))[0] / size
            out.setdefault(field.name, np.zeros((slopes.size, 3)))[:, number] = slopes
    return out


def stands_s(values, step):
    """How long a coarse channel (steps,) stands on one value."""
    moved = np.abs(np.diff(values)).sum()
    return np.inf if moved <= 0.0 else values.size * drive.STEP_S * step / moved


class Filter:
    """Gains for channels with these noises (m,), in units of each channel's white noise."""

    def __init__(self, noises, quiet, current, sensitivity):
        """noises: instruments.Noise by channel; quiet: (m, steps) without noise; current: Noise of its sensor."""
        count, steps = quiet.shape
        white2, keep, power, rows = np.empty(count), [], [], []
        for k, noise in enumerate(noises):
            white2[k] = noise.white ** 2
            states = [(noise.wander, noise.memory_s)]
            stands = stands_s(quiet[k], noise.step)
            if stands > 1.0 and noise.white < 0.5 * noise.step:  # no noise blurs its steps
                states.append((noise.step / np.sqrt(12.0), min(stands, 600.0)))
            else:
                white2[k] += noise.step ** 2 / 12.0
            for sigma, memory_s in states:
                keep.append(np.exp(-drive.STEP_S / memory_s))
                power.append(sigma ** 2)
                rows.append(np.eye(count)[k])
        keep.append(np.exp(-drive.STEP_S / current.memory_s))
        power.append(current.wander ** 2)
        rows.append(sensitivity.current_slow)
        free = len(keep)
        if sensitivity.drive is not None:
            keep += [1.0, np.exp(-drive.STEP_S / PULL_MEMORY_S), np.exp(-drive.STEP_S / SLOPE_MEMORY_S)]
            power += [SPEED_MPS ** 2, PULL_MPS2 ** 2, SLOPE ** 2]
            rows += [np.zeros(count)] * 3
        keep, power = np.array(keep), np.array(power)
        self.forward = np.diag(keep)
        if sensitivity.drive is not None:
            self.forward[free, free + 1] = drive.STEP_S  # pull moves the speed
        self.scale = np.sqrt(white2)
        self.shows = (np.stack(rows, 1) / self.scale[:, None])[None]  # one for all steps, or one for each
        if sensitivity.drive is not None:
            self.shows = np.repeat(self.shows, steps, 0)
            self.shows[:, :, free:] = sensitivity.drive / self.scale[None, :, None]
        fast_a = np.hypot(current.white, current.step / np.sqrt(12.0))
        at_once = fast_a * sensitivity.current_fast / self.scale
        self._find_gains(np.eye(count) + np.outer(at_once, at_once), np.diag(power), np.diag(power * (1 - keep ** 2)),
                         steps)

    def _find_gains(self, white, covariance, driven, steps):
        self.gains, self.roots = [], []
        for k in range(steps):
            shows = self.shows[min(k, len(self.shows) - 1)]
            reaches = covariance @ shows.T
            root = np.linalg.inv(np.linalg.cholesky(shows @ reaches + white))
            gain = reaches @ (root.T @ root)
            after = covariance - gain @ reaches.T
            before, covariance = covariance, self.forward @ after @ self.forward.T + driven
            self.gains.append(self.forward @ gain)
            self.roots.append(root)
            if len(self.shows) == 1 and np.abs(covariance - before).max() < 1e-9 * np.abs(covariance).max():
                break

    def apply(self, changes):
        """White innovations of changes (things, m, steps), each in a row (things, m steps)."""
        things, count, steps = changes.shape
        changes = np.ascontiguousarray(changes.transpose(2, 1, 0)) / self.scale[None, :, None]
        out, state = np.empty((steps, count, things)), np.zeros((len(self.forward), things))
        for k in range(steps):
            at = min(k, len(self.gains) - 1)
            new = changes[k] - self.shows[min(k, len(self.shows) - 1)] @ state
            out[k] = self.roots[at] @ new
            state = self.forward @ state + self.gains[at] @ new
        return out.transpose(2, 1, 0).reshape(things, -1)
