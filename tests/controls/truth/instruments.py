# SPDX-License-Identifier: Apache-2.0
"""Instruments between the truth and the log: noise with a memory, lag, gain, offset, delay, steps, losses.

A channel's noise is white plus a slow wander (first-order, so an exponential memory), as real loggers show; d' is
computed with exactly this noise. Channels are (cases, steps).
"""
import dataclasses

import numpy as np


@dataclasses.dataclass(frozen=True)
class Noise:
    white: float  # standard deviation
    wander: float
    memory_s: float
    step: float  # resolution; 0: none


# By kind of channel; what a good amateur logger does.
NOISE = {
    "voltage": Noise(0.4e-3, 0.5e-3, 30.0, 0.5e-3),  # V, one cell
    "pack_voltage": Noise(15e-3, 15e-3, 30.0, 10e-3),  # V
    "current": Noise(0.15, 0.05, 60.0, 0.05),  # A
    "temperature": Noise(0.05, 0.05, 60.0, 0.05),  # K
    "speed": Noise(0.03, 0.01, 10.0, 0.01),  # m/s
    "accelerator": Noise(0.002, 0.001, 20.0, 0.001),
    "brake": Noise(0.002, 0.001, 20.0, 0.001),
    "motor_speed": Noise(0.5, 0.2, 20.0, 0.1),  # rad/s
    "motor_torque": Noise(0.4, 0.2, 20.0, 0.1),  # Nm
    "soc": Noise(0.0002, 0.0002, 60.0, 0.0001),
}


def remembered(kick, keep, before):
    """out[k] = keep out[k - 1] + kick[k] along the last axis, `before` standing ahead of the first.

    In closed form over blocks short enough for keep^-k to stay small: a loop over steps costs a hundred times more.
    """
    block = max(1, int(8.0 / -np.log(keep)))
    weight = keep ** np.arange(1, block + 1)
    out, last = np.empty(kick.shape), before
    for begin in range(0, kick.shape[-1], block):
        part = kick[..., begin:begin + block]
        own = weight[:part.shape[-1]]
        out[..., begin:begin + block] = own * (np.cumsum(part / own, -1) + last[..., None])
        last = out[..., begin + part.shape[-1] - 1]
    return out


def wander(rng, shape, sigma, memory_s, step_s):
    """Exponentially correlated noise along the last axis."""
    keep = np.exp(-step_s / memory_s)
    kick = sigma * np.sqrt(1.0 - keep * keep) * rng.standard_normal(shape)
    kick[..., 0] = sigma * rng.standard_normal(shape[:-1])
    return remembered(kick, keep, np.zeros(shape[:-1]))


def noisy(rng, truth, kind, step_s):
    noise = NOISE[kind]
    seen = truth + noise.white * rng.standard_normal(truth.shape)
    seen += wander(rng, truth.shape, noise.wander, noise.memory_s, step_s)
    return np.round(seen / noise.step) * noise.step if noise.step else seen


def delayed(truth, delay_s, step_s):
    """The channel as it was delay_s ago (cases,), between samples by a straight line."""
    steps = truth.shape[-1]
    at = np.arange(steps) * step_s
    return np.stack([np.interp(at - late, at, row) for row, late in zip(truth, delay_s)])


def lagging(truth, lag_s, step_s):
    """First-order lag (cases,); 0: none."""
    out = truth.copy()
    share = np.where(lag_s > 0, 1.0 - np.exp(-step_s / np.maximum(lag_s, 1e-9)), 1.0)
    for k in range(1, truth.shape[-1]):
        out[..., k] = out[..., k - 1] + share * (truth[..., k] - out[..., k - 1])
    return out


def whitened(differences, kind, step_s):
    """Differences (..., steps) in units of the channel's noise, independent in time order: white, wander, resolution.

    A Kalman filter with one state, the wander, turns them into innovations; it is the same for every row.
    """
    noise = NOISE[kind]
    white = noise.white ** 2 + noise.step ** 2 / 12.0
    keep = np.exp(-step_s / noise.memory_s)
    drive = noise.wander ** 2 * (1.0 - keep * keep)
    variance, state = noise.wander ** 2, np.zeros(differences.shape[:-1])
    out = np.empty(differences.shape)
    for k in range(differences.shape[-1]):
        total = variance + white
        innovation = differences[..., k] - state
        out[..., k] = innovation / np.sqrt(total)
        gain = variance / total
        state = keep * (state + gain * innovation)
        before, variance = variance, keep * keep * (1.0 - gain) * variance + drive
        if abs(variance - before) < 1e-12 * variance:
            break
    # From here on the gain stands still.
    rest = differences[..., k + 1:]
    if rest.shape[-1]:
        states = remembered(keep * gain * rest, keep * (1.0 - gain), state)
        out[..., k + 1] = (rest[..., 0] - state) / np.sqrt(total)
        out[..., k + 2:] = (rest[..., 1:] - states[..., :-1]) / np.sqrt(total)
    return out
