# SPDX-License-Identifier: Apache-2.0
"""What the driver and the laboratory do: speed over time on a random track, and currents of a cell on a cycler."""
import numpy as np

STEP_S = 0.1


def track(rng):
    """Speed limit along one lap of a random autocross track: (position_m, limit_mps, slope)."""
    position, limit = [], []
    here = 0.0
    for _ in range(rng.integers(14, 24)):
        straight, corner = rng.uniform(15.0, 75.0), rng.uniform(10.0, 30.0)
        apex = rng.uniform(8.0, 17.0)
        for length, speed in ((straight, 30.0), (corner, apex)):
            steps = max(2, int(length))
            position.extend(here + np.linspace(0.0, length, steps, endpoint=False))
            limit.extend([speed] * steps)
            here += length
    position, limit = np.array(position), np.array(limit)
    phase = rng.uniform(0.0, 2 * np.pi, 3)
    waves = zip((1, 2, 3), (0.006, 0.004, 0.003), phase)
    slope = sum(size * np.sin(2 * np.pi * k * position / here + begin) for k, size, begin in waves)
    return position, limit, slope, here


def lap_speed(limit, position, entry, pull, brake):
    """Highest speed along the track under the limits of pull and brakes [m/s^2]."""
    speed = limit.copy()
    speed[0] = min(speed[0], entry)
    gaps = np.diff(position)
    for k in range(len(gaps)):
        speed[k + 1] = min(speed[k + 1], np.sqrt(speed[k] ** 2 + 2 * pull * (1 - speed[k] / 40.0) * gaps[k]))
    for k in range(len(gaps) - 1, -1, -1):
        speed[k] = min(speed[k], np.sqrt(speed[k + 1] ** 2 + 2 * brake * gaps[k]))
    return speed


def endurance(rng, duration_s):
    """Speed [m/s] and slope over time: rest, a stint, a driver change, another stint, rest. (steps,), (steps,).

    duration_s: at least 450, the rests alone take up to 400.
    """
    position, limit, slope, length = track(rng)
    steps = int(duration_s / STEP_S)
    speed_out, slope_out = np.zeros(steps), np.zeros(steps)
    rest, change, end = rng.uniform(40.0, 80.0), rng.uniform(120.0, 180.0), rng.uniform(80.0, 140.0)
    half = 0.5 * (duration_s - rest - change - end)
    for begin in (rest, rest + half + change):
        entry, now = 0.5, begin
        pull, brake = rng.uniform(3.5, 5.0), rng.uniform(6.0, 8.0)
        while now < begin + half:
            effort = rng.uniform(0.88, 1.0)
            dared = limit * effort * (1 + 0.02 * rng.standard_normal(limit.size))
            speed = np.maximum(lap_speed(dared, position, entry, pull, brake), 0.5)
            spent = np.concatenate(([0.0], np.cumsum(np.diff(position) / (0.5 * (speed[1:] + speed[:-1])))))
            first, last = int(np.ceil(now / STEP_S)), int(min(now + spent[-1], begin + half) / STEP_S)
            at = np.arange(first, min(last + 1, steps))
            speed_out[at] = np.interp(at * STEP_S - now, spent, speed)
            slope_out[at] = np.interp(at * STEP_S - now, spent, slope)
            now, entry = now + spent[-1], speed[-1]
        stop = int((begin + half) / STEP_S)
        ramp = np.arange(stop, min(stop + 80, steps))
        speed_out[ramp] = np.maximum(speed_out[stop - 1] - 3.0 * (ramp - stop + 1) * STEP_S, 0.0)
        slope_out[ramp] = 0.0
    smooth = np.hanning(9)
    return np.convolve(speed_out, smooth / smooth.sum(), "same"), slope_out


def drive_current(rng, duration_s, capacity_ah, speed_slope=None):
    """Current [A] of a cell that a car would draw: power of the drive cycle scaled to about 1.3 C in the mean."""
    speed, slope = endurance(rng, duration_s) if speed_slope is None else speed_slope
    pull = np.gradient(speed, STEP_S)
    demand = np.clip(speed * (pull + 0.02 * speed ** 2 / 10.0 + 0.15 + 9.81 * slope), 0.0, 60.0)
    return demand * (1.3 * capacity_ah * rng.uniform(0.8, 1.1) / demand[speed > 0.1].mean())


def pulse_test(capacity_ah, step_s, rate, pulses=20, pulse_s=18.0, rest_s=900.0):
    """Cycler test from full at one rate: 5 % of charge in each step, a short pulse of it ahead, then a rest [A]."""
    current = rate * capacity_ah
    parts = [np.zeros(int(60 / step_s))]
    rest_of_step_s = 3600.0 / rate / (pulses + 0.5) - pulse_s
    for _ in range(pulses):
        parts += [np.full(int(pulse_s / step_s), current), np.zeros(int(60 / step_s))]
        parts += [np.full(int(rest_of_step_s / step_s), current), np.zeros(int(rest_s / step_s))]
    return np.concatenate(parts)
