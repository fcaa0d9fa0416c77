# SPDX-License-Identifier: Apache-2.0
"""The true cell: its numbers, drawn like a chemistry, and its response to a current on a fine grid of time.

  V = U(z) + e (T - 25) - M h - R0 I - eta(I) - sum of v_k        I > 0 is a discharge, z the state of charge
  R(z, T) = R(z) exp(E/R_g (1/T - 1/T_ref)), eta = 2 R_g T/F (asinh(I/2 i_p) + asinh(I/2 i_n))
  C dT/dt = I (U - V) - I T e - G (T - T_air), h towards the sign of the current with the charge
Temperature and voltage depend on one another: both are run in turn until they agree.
"""
from dataclasses import dataclass, field

import numpy as np
from scipy.interpolate import PchipInterpolator

GAS, FARADAY, ZERO_C, REFERENCE_C = 8.314462618, 96485.33212, 273.15, 25.0
NODES = np.array([0.0, 0.05, 0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 0.9, 1.0])  # of every resistance
BEYOND_V = 30.0  # a unit of charge below empty and above full
CURVES = {  # z and U [V], after the usual published curves of each chemistry
    "nmc": ([0, .02, .05, .1, .15, .2, .3, .4, .5, .6, .7, .8, .9, .95, 1],
            [2.95, 3.16, 3.33, 3.44, 3.51, 3.55, 3.60, 3.64, 3.69, 3.78, 3.88, 3.98, 4.07, 4.12, 4.19], 2.7, 4.2),
    "nca": ([0, .02, .05, .1, .15, .2, .3, .4, .5, .6, .7, .8, .9, .95, 1],
            [2.70, 2.98, 3.16, 3.30, 3.39, 3.45, 3.53, 3.59, 3.66, 3.76, 3.85, 3.94, 4.05, 4.09, 4.18], 2.5, 4.2),
    "lfp": ([0, .02, .05, .1, .15, .2, .3, .4, .5, .6, .65, .7, .8, .9, .95, .98, 1],
            [2.55, 2.88, 3.06, 3.17, 3.21, 3.235, 3.27, 3.287, 3.293, 3.298, 3.308, 3.322, 3.333, 3.336, 3.338, 3.345,
             3.42], 2.0, 3.6),
}


@dataclass
class Cell:
    chemistry: str
    capacity_ah: float
    v_min: float
    v_max: float
    ocv_z: np.ndarray
    ocv_v: np.ndarray
    r0: np.ndarray  # ohm at NODES
    r: list  # of arrays, one a branch
    tau_s: np.ndarray
    tau_slope: float  # relative, over the whole SOC
    e0: float  # J/mol
    e_branch: float
    e_tau: float
    exchange_a: tuple  # of both electrodes at 25 degC; empty: no charge transfer
    hysteresis_v: float
    hysteresis_rate: float
    entropy_v_per_k: float
    mass_kg: float
    heat_j_per_kg_k: float
    cooling_w_per_k: float
    size: str
    surface_lag_s: float = 0.0  # of the thermometer behind the mass that counts
    ocv: object = field(init=False, repr=False)

    def __post_init__(self):
        self.ocv = PchipInterpolator(self.ocv_z, self.ocv_v)

    def resistance(self, table, z):
        return np.exp(PchipInterpolator(NODES, np.log(table))(np.clip(z, 0.0, 1.0)))


def arrhenius(energy, temperature_c):
    return np.exp(energy / GAS * (1.0 / (temperature_c + ZERO_C) - 1.0 / (REFERENCE_C + ZERO_C)))


def bathtub(rng, at_half):
    low, high = rng.uniform(0.3, 3.0), rng.uniform(0.0, 0.4)
    return at_half * (1.0 + low * np.exp(-NODES / 0.08) + high * np.exp(-(1.0 - NODES) / 0.12)
                      + 0.04 * rng.standard_normal(len(NODES)))


def body(rng, capacity_ah, mean_v):
    """(mass kg, cooling W/K, size): a cylinder up to 5 Ah, else a pouch; cooled by air, some by a fixture."""
    convection = 15.0 if rng.random() < 0.5 else rng.uniform(8.0, 40.0)
    mass = capacity_ah * mean_v / rng.uniform(150.0, 240.0)
    if capacity_ah <= 5.5:
        size, diameter, length = ("18650", .01835, .065) if capacity_ah < 3.6 else ("21700", .0216, .0702)
        return mass, convection * np.pi * diameter * (length + diameter / 2), size
    thick = rng.uniform(0.007, 0.015)
    edge = np.sqrt(mass / 2200.0 / thick / 1.5)
    size = f"{1500 * edge:.0f}x{1000 * edge:.0f}x{1000 * thick:.1f}"
    return mass, convection * (3.0 * edge * edge + 5.0 * edge * thick), size


def draw(rng):
    chemistry = str(rng.choice(["nmc", "nmc", "nca", "lfp"]))
    z, v, v_min, v_max = CURVES[chemistry]
    v = np.array(v)
    v[2:-2] += rng.normal(0.0, 0.001 if chemistry == "lfp" else 0.004) * np.sin(np.linspace(0, 9, len(v) - 4))
    q = float(np.exp(rng.uniform(np.log(1.5), np.log(60.0))))
    drop = rng.uniform(0.03, 0.10) / q  # ohm: volts at 1C over amperes
    branches = int(rng.integers(1, 4))
    split = rng.dirichlet(3.0 * np.ones(branches)) * rng.uniform(0.5, 1.2) * drop
    tau = {1: [rng.uniform(10, 60)], 2: [rng.uniform(2, 12), rng.uniform(40, 400)],
           3: [rng.uniform(0.8, 4), rng.uniform(15, 50), rng.uniform(200, 1000)]}[branches]
    e_branch = rng.uniform(20e3, 55e3)
    exchange = ()
    if rng.random() < 0.4:
        first = q * rng.uniform(0.5, 4.0)
        exchange = (first, first * rng.uniform(1.0, 4.0))
    lfp = chemistry == "lfp"
    mass, cooling, size = body(rng, q, 3.25 if lfp else 3.65)
    return Cell(chemistry, q, v_min, v_max, np.array(z), v, bathtub(rng, drop), [bathtub(rng, s) for s in split],
                np.array(tau), rng.uniform(-0.3, 0.3), rng.uniform(8e3, 30e3), e_branch,
                0.0 if rng.random() < 0.3 else rng.uniform(0.0, e_branch), exchange,
                rng.uniform(0.004, 0.02) if lfp else (rng.uniform(0.0, 0.005) if rng.random() < 0.3 else 0.0),
                rng.uniform(8.0, 40.0), rng.uniform(-1e-4, 2e-4), mass, rng.uniform(800.0, 1100.0), cooling, size)


def lag(begin, kept, towards):
    """x = kept x + towards, step after step."""
    out, x = [begin], begin
    for a, b in zip(kept[1:].tolist(), towards[1:].tolist()):
        x = a * x + b
        out.append(x)
    return np.array(out)


@dataclass
class Response:
    t: np.ndarray
    current: np.ndarray  # over the step that ends there
    z: np.ndarray
    h: np.ndarray
    v: np.ndarray
    temperature: np.ndarray
    surface: np.ndarray  # where the thermometer is


def charge_transfer(cell, current, temperature):
    if not cell.exchange_a:
        return np.zeros_like(current)
    thermal = 2.0 * GAS * (temperature + ZERO_C) / FARADAY
    slow = arrhenius(cell.e_branch, temperature)
    return thermal * sum(np.arcsinh(current * slow / (2.0 * i)) for i in cell.exchange_a)


def hysteresis(cell, z, current, begin):
    swing = np.exp(-cell.hysteresis_rate * np.abs(np.diff(z, prepend=z[0])))
    return lag(begin, swing, np.sign(current) * (1.0 - swing))


def polarisation(cell, current, z, temperature, dt):
    out = []
    slow = arrhenius(cell.e_tau, temperature)
    for table, tau in zip(cell.r, cell.tau_s):
        kept = np.exp(-dt / (tau * (1.0 + cell.tau_slope * (z - 0.5)) * slow))
        r = cell.resistance(table, z) * arrhenius(cell.e_branch, temperature)
        out.append(lag(0.0, kept, r * current * (1.0 - kept)))
    return out


def respond(cell, t, current, air_c, begin=(1.0, -1.0)):
    """current[k] flows from t[k-1] to t[k]; `begin`: SOC and hysteresis. It begins at rest, as warm as the air."""
    dt = np.diff(t, prepend=t[0])
    z = begin[0] - np.cumsum(current * dt) / 3600.0 / cell.capacity_ah
    h = hysteresis(cell, z, current, begin[1])
    inner = np.clip(z, 0.0, 1.0)
    r0 = cell.resistance(cell.r0, z)
    u = cell.ocv(inner) + BEYOND_V * (np.minimum(z, 0.0) + np.maximum(z - 1.0, 0.0))
    heat = cell.mass_kg * cell.heat_j_per_kg_k
    kept = np.exp(-dt * cell.cooling_w_per_k / heat)
    temperature = np.full(len(t), float(air_c))
    for _ in range(12):
        now = u + cell.entropy_v_per_k * (temperature - REFERENCE_C)
        v = now - cell.hysteresis_v * h - r0 * arrhenius(cell.e0, temperature) * current
        v = v - charge_transfer(cell, current, temperature) - sum(polarisation(cell, current, z, temperature, dt))
        power = current * (now - v) - current * (temperature + ZERO_C) * cell.entropy_v_per_k
        new = lag(float(air_c), kept, (1.0 - kept) * (air_c + np.clip(power, -1e3, 1e3) / cell.cooling_w_per_k))
        moved = np.max(np.abs(new - temperature))
        temperature = 0.3 * temperature + 0.7 * new if moved > 3.0 else new
        if moved < 0.01:
            break
    surface = temperature
    if cell.surface_lag_s > 0.0:
        kept = np.exp(-dt / cell.surface_lag_s)
        surface = lag(float(air_c), kept, (1.0 - kept) * temperature)
    return Response(t, current, z, h, v, temperature, surface)
