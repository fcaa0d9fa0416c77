# SPDX-License-Identifier: Apache-2.0
"""Instruments between the truth and the log: noise with a memory, lag, gain, offset, delay, steps, losses.

A channel's noise is white plus a slow wander (first-order, so an exponential memory), as real loggers show, and its
resolution. Each world has its own logger; d' is computed with exactly its noise. Channels are (cases, steps).
"""
import dataclasses

import numpy as np


@dataclasses.dataclass(frozen=True)
class Noise:
    white: float  # standard deviation
    wander: float
    memory_s: float
    step: float  # resolution; 0: none


# By kind of channel: the finest and the coarsest logger that race teams have. Resolutions are those of recorded cars and
# of data sheets: cells 0.1 mV (a team's own board) to 1.5 mV (Orion BMS), pack 10 mV (shunt on the bus) to 0.1 V (Orion
# BMS), current 10 mA (that shunt) to 1 A (a data logger), thermistors 0.05 to 1 K (Orion BMS), SOC to 0.5 % (Orion BMS),
# pedals to 1 %. White noise of the recorded cars at rest was 0.11 A of a shunt, 0.43 A of an energy meter, 0.4 mV of a
# cell, 0.3 Nm of an inverter. Wander, memory, and all of the speeds' and the SOC's noise are assumed.
FINEST = {
    "voltage": Noise(0.2e-3, 0.3e-3, 30.0, 0.1e-3),  # V, one cell
    "pack_voltage": Noise(10e-3, 10e-3, 30.0, 10e-3),  # V
    "current": Noise(0.10, 0.03, 60.0, 0.01),  # A
    "temperature": Noise(0.02, 0.03, 60.0, 0.05),  # K
    "speed": Noise(0.03, 0.01, 10.0, 0.01),  # m/s
    "accelerator": Noise(0.002, 0.001, 20.0, 0.001),
    "brake": Noise(0.002, 0.001, 20.0, 0.001),
    "motor_speed": Noise(0.4, 0.2, 20.0, 0.1),  # rad/s
    "motor_torque": Noise(0.3, 0.2, 20.0, 0.1),  # Nm
    "soc": Noise(0.0002, 0.0002, 60.0, 0.0001),
}
COARSEST = {
    "voltage": Noise(1.0e-3, 1.0e-3, 30.0, 1.5e-3),
    "pack_voltage": Noise(50e-3, 50e-3, 30.0, 0.1),
    "current": Noise(0.45, 0.15, 60.0, 1.0),
    "temperature": Noise(0.10, 0.20, 60.0, 1.0),
    "speed": Noise(0.10, 0.05, 10.0, 0.1),
    "accelerator": Noise(0.005, 0.003, 20.0, 0.01),
    "brake": Noise(0.005, 0.003, 20.0, 0.01),
    "motor_speed": Noise(1.0, 0.4, 20.0, 0.5),
    "motor_torque": Noise(1.0, 0.5, 20.0, 0.5),
    "soc": Noise(0.0005, 0.0005, 60.0, 0.005),
}


def draw(rng):
    """One logger: {kind: Noise}, each number log-uniform between the finest and the coarsest."""
    def between(low, high):
        return Noise(*(float(np.exp(rng.uniform(np.log(a), np.log(b)))) if a < b else a
                       for a, b in zip(dataclasses.astuple(low), dataclasses.astuple(high))))
    return {kind: between(FINEST[kind], COARSEST[kind]) for kind in FINEST}


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


def noisy(rng, truth, noise: Noise, step_s):
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
