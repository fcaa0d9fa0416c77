# SPDX-License-Identifier: Apache-2.0
"""Instruments with noise, steps, offset and gain; the file that they leave."""
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Logger:
    sample_s: float
    phase: float  # of the reading in its row's interval: 0 just before the current may change, else after that share
    sparse: bool
    noise_v: float
    step_v: float
    noise_a: float
    step_a: float
    offset_a: float
    gain: float
    temperature: str  # "fine", "1 K" or "none"
    declared: bool  # --current-error and the like are told

    @property
    def sound(self):
        """No error that intervals must know of, or all are told."""
        return self.declared or (self.offset_a == 0.0 and self.gain == 1.0)


def draw(rng, capacity_ah):
    lab = rng.random() < 0.5
    noise = np.exp(rng.uniform(np.log(1e-4), np.log(5e-4 if lab else 5e-3)))
    step = float(rng.choice([1e-4, 1e-3] if lab else [1e-3, 2e-3, 5e-3, 1e-2]))
    off = rng.random() < 0.5
    share = 3e-4 if lab else 2e-3
    return Logger(sample_s=float(rng.choice([0.1, 0.5, 1.0, 1.0, 2.0, 10.0])),
                  phase=float(rng.choice([0.0, 1e-3, 0.5])),
                  sparse=bool(rng.random() < 0.4), noise_v=float(noise), step_v=step,
                  noise_a=capacity_ah * (2e-4 if lab else 2e-3), step_a=capacity_ah * (1e-4 if lab else 2e-3),
                  offset_a=capacity_ah * share * rng.uniform(-1, 1) if off else 0.0,
                  gain=1.0 + (0.001 if lab else 0.005) * rng.uniform(-1, 1) if off else 1.0,
                  temperature=str(rng.choice(["fine", "fine", "1 K", "none"])),
                  declared=bool(off and rng.random() < 0.5))


def error_flags(logger, capacity_ah):
    """What identify is told of the instruments: the limits of their class, not their errors."""
    if not logger.declared:
        return []
    lab = logger.noise_v < 5e-4 and logger.step_v <= 1e-3
    offset = capacity_ah * (3e-4 if lab else 2e-3)
    return ["--current-error", f"{offset:.4g}", "--rest-current-error", f"{offset:.4g}", "--current-gain-error",
            "0.001" if lab else "0.005"]


def steps(x, step):
    return np.round(x / step) * step


@dataclass
class Rows:
    """As written."""

    t: np.ndarray
    current: np.ndarray
    v: np.ndarray
    temperature: np.ndarray | None
    true_temperature: np.ndarray


def read(rng, logger, program, response, mask):
    t = response.t[mask] - program.phase_s
    n = len(t)
    true_t = response.temperature[mask]
    current = response.current[mask] * logger.gain + logger.offset_a + rng.normal(0, logger.noise_a, n)
    temperature = None
    if logger.temperature != "none":
        fine = logger.temperature == "fine"
        temperature = steps(response.surface[mask] + rng.normal(0, 0.03, n), 0.1 if fine else 1.0)
    v = steps(response.v[mask] + rng.normal(0, logger.noise_v, n), logger.step_v)
    return Rows(t, steps(current, logger.step_a), v, temperature, true_t)


def write(path, rows):
    names = ["time_s", "current_a", "voltage_v"]
    columns, form = [rows.t, rows.current, rows.v], ["%.3f", "%.5g", "%.5f"]
    if rows.temperature is not None:
        names, columns, form = [*names, "temperature_c"], [*columns, rows.temperature], [*form, "%.1f"]
    np.savetxt(path, np.column_stack(columns), fmt=form, delimiter=",", header=",".join(names), comments="")
