# SPDX-License-Identifier: Apache-2.0
"""How large an effect is, and whether a log of its kind can show it: both decided before any engine is asked.

rho = RMS of what it adds to a channel, start charge, start temperature and, within 3 K, the air of a log that does not
say it refitted, over the practical size of that channel; the largest over the channels. Invisible: the fit of its true signature, starts free, gains less than ln 20 on
minutes that it did not see.
"""

import math

import numpy as np

PRACTICAL = {"voltage": 1e-3, "cell": 1e-3, "pack": 20e-3, "temperature": 0.1, "thermistor": 0.1}  # V, K
SHARE = 0.005  # of the RMS of power and force
BLOCK_S = 60.0
GRID_S = 1.0  # between the rows that visibility is reckoned on
DECISIVE = math.log(20.0)
AIR_K = 3.0  # within which an air that is not logged is known; references of other days differ by 2 K
FLOOR = 0.1  # of the practical size: what no log is better than
# White noise and step of one reading, as the vehicle files have them [V, A, K].
CELL_NOISE, CELL_STEP, CURRENT_NOISE, TEMPERATURE_NOISE, TEMPERATURE_STEP = 1.5e-3, 1.5e-3, 0.6, 0.1, 1.0


def practical(channel, scene):
    truth = scene.truth
    if channel == "power":
        return SHARE * float(np.sqrt(np.mean(truth.power_w**2)))
    if channel == "force":
        force = scene.car.masses_kg * truth.acceleration
        return SHARE * float(np.sqrt(np.mean(force**2)))
    return PRACTICAL[channel]


def starts(channel, scene):
    """Columns of what may be refitted. The voltage has no start temperature of its own: thermistors were logged."""
    truth, cell = scene.truth, scene.car.cell
    fade = np.exp(-np.arange(len(truth)) * truth.step_s / cell.cooling_s)
    if channel in ("voltage", "cell"):
        return cell.ocv_slope(truth.soc)[:, None]
    if channel in ("temperature", "thermistor"):
        lag = cell.file.get("surface_lag_s", 0.0)
        columns = [fade]
        if lag > 0.0:
            columns.append(np.exp(-np.arange(len(truth)) * truth.step_s / lag))
        return np.column_stack(columns)
    return np.empty((len(truth), 0))


def seen(channel, scene):
    """Rows that tell of it: a brake hides what the motor pulls."""
    return scene.truth.free if channel == "force" else np.ones(len(scene.truth), bool)


def refitted(values, columns):
    if columns.shape[1] == 0:
        return values
    return values - columns @ np.linalg.lstsq(columns, values, rcond=None)[0]


def beyond_air(channel, scene, values):
    """What an effect adds that no air within AIR_K of the model's would."""
    if channel != "temperature" or scene.car.kind == "cell":  # a bench logs its air
        return values
    truth, columns = scene.truth, starts(channel, scene)
    kelvin = 1.0 - np.exp(-np.arange(len(truth)) * truth.step_s / scene.car.cell.cooling_s)
    best = np.linalg.lstsq(np.column_stack([columns, kelvin]), values, rcond=None)[0][-1]
    return values - float(np.clip(best, -AIR_K, AIR_K)) * kelvin


def rho_of(effect, scene, size):
    """(rho, channel)."""
    best = (0.0, "")
    for channel, values in effect.adds(scene, size).items():
        rows = seen(channel, scene)
        values = beyond_air(channel, scene, values)
        left = refitted(values[rows], starts(channel, scene)[rows])
        best = max(best, (float(np.sqrt(np.mean(left**2))) / practical(channel, scene), channel))
    return best


def sized(effect, scene, sign, wanted):
    """The size [main parameter, with its sign] whose rho is `wanted`, or the nearest that happens in practice."""
    low, high = math.log(effect.least), math.log(effect.largest(scene))
    if rho_of(effect, scene, sign * effect.largest(scene))[0] <= wanted:
        return sign * effect.largest(scene)
    if rho_of(effect, scene, sign * effect.least)[0] >= wanted:
        return sign * effect.least
    for _ in range(14):
        middle = 0.5 * (low + high)
        if rho_of(effect, scene, sign * math.exp(middle))[0] < wanted:
            low = middle
        else:
            high = middle
    size = math.exp(0.5 * (low + high))
    if effect.step:
        size = max(effect.step, effect.step * round(size / effect.step))
    return sign * float(f"{size:.6g}")


def noise_of(channel, scene):
    """White standard deviation of a second's mean."""
    car, truth = scene.car, scene.truth
    readings = max(1.0, GRID_S / truth.step_s)
    noisy = 1.0 if car.noise and (car.candump or car.kind == "cell") else 0.0  # the CSV of a drive has no sensors
    cell = math.hypot(CELL_NOISE, CELL_STEP / math.sqrt(12.0))
    ohm = car.cell.middle("r0") * CURRENT_NOISE / car.parallel
    white = {
        "voltage": math.hypot(cell / math.sqrt(car.series), ohm),
        "cell": cell,
        "pack": cell * math.sqrt(car.series) + 0.05,
        "temperature": TEMPERATURE_NOISE,
        "thermistor": TEMPERATURE_NOISE,
    }.get(channel, 0.0)
    if channel == "power":
        white = CURRENT_NOISE * car.series * float(np.mean(truth.voltage_v))
    return math.hypot(noisy * white / math.sqrt(readings), FLOOR * practical(channel, scene))


def coarse(channel, scene):
    return channel in ("temperature", "thermistor") and scene.car.noise and (
        scene.car.candump or scene.car.kind == "cell")


def stepped(scene, rng, temperature):
    """What coarse thermistors make of a temperature; a mean of as many as the car has."""
    count = scene.car.thermistors
    noisy = temperature + TEMPERATURE_NOISE * rng.standard_normal((count, len(temperature)))
    return np.round(noisy / TEMPERATURE_STEP).mean(0) * TEMPERATURE_STEP if count > 1 else (
        np.round(noisy[0] / TEMPERATURE_STEP) * TEMPERATURE_STEP)


def whitened(values, keep):
    out = values.copy()
    out[1:] -= keep * values[:-1]
    return out


def channel_rows(channel, values, scene, rng):
    """(log minus sound model, the same of a sound log, starts, signature), over its noise, white, by seconds."""
    every = max(1, round(GRID_S / scene.truth.step_s))
    rows = np.flatnonzero(seen(channel, scene))[::every]
    signature, columns = beyond_air(channel, scene, values)[rows], starts(channel, scene)[rows]
    if coarse(channel, scene):
        sound = scene.truth.temperature_c[rows]
        error = stepped(scene, rng, sound) - sound
        keep = float(np.clip(np.dot(error[1:], error[:-1]) / np.dot(error, error), 0.0, 0.999))
        deviation = math.hypot(float(np.std(error)) * math.sqrt(1.0 - keep**2), noise_of(channel, scene))
        shown = stepped(scene, rng, sound + signature) - sound
    else:
        keep, deviation = 0.0, noise_of(channel, scene)
        error = deviation * rng.standard_normal(len(rows))
        shown = signature + error
    parts = [whitened(x, keep) / deviation for x in (shown, error, columns, signature)]
    return (*parts, (rows * scene.truth.step_s // BLOCK_S).astype(int))


def held_out(shown, columns, blocks):
    """Half the squares that a fit of the other blocks leaves, by block; by the normal equations of scaled columns."""
    scaled = columns / np.maximum(1e-12, np.sqrt(np.sum(columns**2, axis=0)))
    rows = [np.flatnonzero(blocks == block) for block in np.unique(blocks)]
    squares = [scaled[here].T @ scaled[here] for here in rows]
    products = [scaled[here].T @ shown[here] for here in rows]
    all_squares, all_products = sum(squares), sum(products)
    out = []
    for here, square, product in zip(rows, squares, products):
        size = np.linalg.lstsq(all_squares - square, all_products - product, rcond=1e-12)[0]
        out.append(0.5 * float(np.sum((shown[here] - scaled[here] @ size) ** 2)))
    return np.array(out)


def gain_unseen(effect, scene, size, rng):
    """ln evidence that the true signature, of one size, gains on unseen minutes, beyond what a sound log shows."""
    parts = [channel_rows(name, values, scene, rng) for name, values in effect.adds(scene, size).items()]
    shown, sound, signature, blocks = (np.concatenate([p[k] for p in parts]) for k in (0, 1, 3, 4))
    columns, row, column = np.zeros((len(shown), sum(p[2].shape[1] for p in parts))), 0, 0
    for _, _, start, _, _ in parts:
        rows, free = start.shape
        columns[row : row + rows, column : column + free] = start
        row, column = row + rows, column + free
    more = np.column_stack([columns, signature])
    gains = [held_out(log, columns, blocks).sum() - held_out(log, more, blocks).sum() for log in (shown, sound)]
    return float(gains[0] - max(0.0, gains[1]))


def visible(effect, scene, size, rng):
    return gain_unseen(effect, scene, size, rng) >= DECISIVE
