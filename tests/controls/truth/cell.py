# SPDX-License-Identifier: Apache-2.0
"""Single-particle lithium-ion cells in series, each with core and surface heat, many packs at once.

Each electrode is one sphere with radial diffusion (finite volumes), its surface current obeys Butler-Volmer, the
electrolyte answers with one lag, and an ohmic film lies in series. Kinetics, diffusion and resistances follow
Arrhenius. Open-circuit potentials: C.-H. Chen et al., J. Electrochem. Soc. 167 (2020) 080534, LG M50 NMC811 against
graphite-silicon. Shapes: (cases,) for a pack, (cases, cells) for its cells.
"""
import dataclasses

import numpy as np

GAS = 8.314462618  # J/mol/K
FARADAY = 96485.33212  # C/mol
REFERENCE_K = 298.15
SHELLS = 6
NEGATIVE_EMPTY, NEGATIVE_FULL = 0.0279, 0.9014  # stoichiometry at 0 and 100 % of the capacity
POSITIVE_EMPTY, POSITIVE_FULL = 0.9077, 0.2661


def negative_potential(x):
    """Graphite-silicon against lithium [V]."""
    return (1.9793 * np.exp(-39.3631 * x) + 0.2482 - 0.0909 * np.tanh(29.8538 * (x - 0.1234))
            - 0.04478 * np.tanh(14.9159 * (x - 0.2769)) - 0.0205 * np.tanh(30.4444 * (x - 0.6103)))


def positive_potential(y):
    """NMC811 against lithium [V]."""
    return (-0.8090 * y + 4.4875 - 0.0428 * np.tanh(18.5138 * (y - 0.5542))
            - 17.7326 * np.tanh(15.7890 * (y - 0.3117)) + 17.5842 * np.tanh(15.9308 * (y - 0.3120)))


def open_circuit(state_of_charge):
    """Cell at rest [V]; state of charge 0..1."""
    x = NEGATIVE_EMPTY + state_of_charge * (NEGATIVE_FULL - NEGATIVE_EMPTY)
    y = POSITIVE_EMPTY + state_of_charge * (POSITIVE_FULL - POSITIVE_EMPTY)
    return positive_potential(y) - negative_potential(x)


@dataclasses.dataclass
class Cells:
    """What the cells are made of. Arrays are (cases, cells); plain numbers are spread over them."""

    capacity_ah: np.ndarray
    film_ohm: np.ndarray  # at 25 degC
    electrolyte_ohm: np.ndarray
    electrolyte_lag_s: np.ndarray
    negative_exchange_a: np.ndarray  # at half filling
    positive_exchange_a: np.ndarray
    negative_diffusion_s: np.ndarray  # radius squared over diffusivity
    positive_diffusion_s: np.ndarray
    film_activation: np.ndarray  # J/mol
    kinetic_activation: np.ndarray
    diffusion_activation: np.ndarray
    core_j_per_k: np.ndarray
    surface_j_per_k: np.ndarray
    core_w_per_k: np.ndarray  # core to surface
    air_w_per_k: np.ndarray  # surface to air
    neighbour_w_per_k: np.ndarray  # surface to the next cell
    # What may be wrong with them: all nothing in a sound pack.
    extra_ohm: np.ndarray = 0.0
    branch_ohm: np.ndarray = 0.0
    branch_lag_s: np.ndarray = 20.0
    slow_ohm: np.ndarray = 0.0
    slow_lag_s: np.ndarray = 600.0
    extra_activation: np.ndarray = 0.0
    low_end: np.ndarray = 0.0  # growth of all ohmic resistance from 30 % down to empty
    hysteresis_v: np.ndarray = 0.0
    hysteresis_width: np.ndarray = 0.02  # of the capacity, to turn from one branch to the other
    leak_a: np.ndarray = 0.0
    entropy_v_per_k: np.ndarray = 0.0
    stop_air: np.ndarray = 1.0  # factor on the way to the air while the car stands
    bend_v: np.ndarray = 0.0  # amplitudes of three half waves in the open-circuit voltage: (cases, 1, 3)

    def widened(self, shape):
        out = {}
        for field in dataclasses.fields(self):
            value = np.asarray(getattr(self, field.name), float)
            if field.name == "bend_v":
                out[field.name] = np.zeros((*shape, 3)) + value
            else:
                out[field.name] = np.broadcast_to(value, shape).copy()
        return Cells(**out)


def design(rng, cases, cells, capacity_ah=(15.0, 40.0), spread=1.0):
    """Sound packs, each of its own make, its cells a little apart: 1 % in capacity, 3 % in resistance (one sigma)."""
    def make(low, high):
        return np.exp(rng.uniform(np.log(low), np.log(high), (cases, 1)))

    def alike(share):
        return 1.0 + spread * share * rng.standard_normal((cases, cells))

    capacity = make(*capacity_ah)
    unit = 30.0 / capacity  # a cell of twice the size has half the resistance
    resistance = alike(0.03)
    return Cells(
        capacity_ah=capacity * alike(0.01), film_ohm=unit * make(0.7e-3, 1.1e-3) * resistance,
        electrolyte_ohm=unit * make(0.3e-3, 0.6e-3) * resistance, electrolyte_lag_s=make(8.0, 30.0),
        negative_exchange_a=make(30.0, 60.0) / unit, positive_exchange_a=make(25.0, 50.0) / unit,
        negative_diffusion_s=make(400.0, 1200.0), positive_diffusion_s=make(300.0, 900.0),
        film_activation=make(8e3, 16e3), kinetic_activation=make(2.0e4, 3.5e4), diffusion_activation=make(1.5e4, 3.0e4),
        core_j_per_k=capacity * make(20.0, 26.0), surface_j_per_k=capacity * make(4.0, 8.0),
        core_w_per_k=make(1.5, 4.0) / unit, air_w_per_k=make(0.15, 0.5) / unit, neighbour_w_per_k=make(0.05, 0.3))


class Pack:
    """State of many packs of cells in series, and one explicit step of them."""

    def __init__(self, cells: Cells, charge, temperature_k):
        """charge: state of charge (cases, cells), all at rest; temperature_k: (cases, cells)."""
        self.shape = np.shape(charge)
        self.p = cells.widened(self.shape)
        x = NEGATIVE_EMPTY + charge * (NEGATIVE_FULL - NEGATIVE_EMPTY)
        y = POSITIVE_EMPTY + charge * (POSITIVE_FULL - POSITIVE_EMPTY)
        self.negative = np.repeat(x[None], SHELLS, 0)
        self.positive = np.repeat(y[None], SHELLS, 0)
        self.charge = charge.copy()
        self.electrolyte = np.zeros(self.shape)
        self.branch = np.zeros(self.shape)
        self.slow = np.zeros(self.shape)
        self.turned = np.zeros(self.shape)
        self.core = np.zeros(self.shape) + temperature_k
        self.surface = self.core.copy()
        edges = np.linspace(0.0, 1.0, SHELLS + 1)
        self._area = (edges[1:-1] ** 2)[:, None, None]
        self._volume = ((edges[1:] ** 3 - edges[:-1] ** 3) / 3.0)[:, None, None]
        self._width = 1.0 / SHELLS

    def _arrhenius(self, energy):
        return np.exp(-energy / GAS * (1.0 / self.core - 1.0 / REFERENCE_K))

    def voltage(self, current):
        """Terminal voltage [V] (cases, cells) at a discharge current [A] (cases,); remembers what heat() needs."""
        p = self.p
        through = current[:, None] + p.leak_a
        self._through = through
        kinetic = self._arrhenius(p.kinetic_activation + p.extra_activation)
        diffusion = self._arrhenius(p.diffusion_activation)
        self._rates = (diffusion / p.negative_diffusion_s, diffusion / p.positive_diffusion_s)
        window_n, window_p = NEGATIVE_FULL - NEGATIVE_EMPTY, POSITIVE_EMPTY - POSITIVE_FULL
        per_second = through / (3600.0 * p.capacity_ah)
        self._flows = (-per_second * window_n / 3.0, per_second * window_p / 3.0)
        x = self.negative[-1] + 0.5 * self._width * self._flows[0] / self._rates[0]
        y = self.positive[-1] + 0.5 * self._width * self._flows[1] / self._rates[1]
        x, y = np.clip(x, 1e-4, 1 - 1e-4), np.clip(y, 1e-4, 1 - 1e-4)
        thermal = 2.0 * GAS * self.core / FARADAY
        negative = thermal * np.arcsinh(through / (4.0 * p.negative_exchange_a * kinetic * np.sqrt(x * (1 - x))))
        positive = thermal * np.arcsinh(through / (4.0 * p.positive_exchange_a * kinetic * np.sqrt(y * (1 - y))))
        film = self._arrhenius(p.film_activation + p.extra_activation)
        low = 1.0 + p.low_end * np.clip((0.3 - self.charge) / 0.3, 0.0, None)
        self._film = film
        turns = np.sin(np.pi * self.charge[..., None] * np.arange(1, 4))
        self._rest = open_circuit(self.charge)
        return (positive_potential(y) - negative_potential(x) - negative - positive
                - through * (low * p.film_ohm / film + p.extra_ohm)
                - low * p.electrolyte_ohm / film * self.electrolyte
                - p.branch_ohm * self.branch - p.slow_ohm * self.slow
                + p.hysteresis_v * self.turned + np.einsum("bck,bck->bc", turns, p.bend_v)
                + p.entropy_v_per_k * (self.core - REFERENCE_K))

    def advance(self, voltage, step_s, ambient_k, standing):
        """Moves by one step after voltage(); ambient_k and standing (cases,)."""
        p, through = self.p, self._through
        self._diffuse(step_s)
        self.charge -= step_s * through / (3600.0 * p.capacity_ah)
        self.electrolyte += (1.0 - np.exp(-step_s / p.electrolyte_lag_s)) * (through - self.electrolyte)
        self.branch += (1.0 - np.exp(-step_s / p.branch_lag_s)) * (through - self.branch)
        self.slow += (1.0 - np.exp(-step_s / p.slow_lag_s)) * (through - self.slow)
        moved = step_s * np.abs(through) / (3600.0 * p.capacity_ah * p.hysteresis_width)
        self.turned += (1.0 - np.exp(-moved)) * (-np.sign(through) - self.turned)
        heat = through * (self._rest - voltage) - through * self.core * p.entropy_v_per_k
        to_surface = p.core_w_per_k * (self.core - self.surface)
        air = p.air_w_per_k * np.where(standing[:, None], p.stop_air, 1.0)
        exchanged = np.zeros(self.shape)
        if self.shape[1] > 1:
            between = p.neighbour_w_per_k[:, 1:] * np.diff(self.surface, axis=1)
            exchanged[:, :-1] += between
            exchanged[:, 1:] -= between
        self._warm(step_s, heat, to_surface, exchanged - air * (self.surface - ambient_k[:, None]))

    def _diffuse(self, step_s):
        """Lithium within the spheres."""
        for shells, rate, flow in zip((self.negative, self.positive), self._rates, self._flows):
            inner = self._area * rate * np.diff(shells, axis=0) / self._width
            change = np.zeros_like(shells)
            change[:-1] += inner
            change[1:] -= inner
            change[-1] += flow
            shells += step_s * change / self._volume

    def _warm(self, step_s, heat, to_surface, from_outside):
        """Heat [W] made in the core, going to the surface, and coming to the surface from outside."""
        self.core += step_s * (heat - to_surface) / self.p.core_j_per_k
        self.surface += step_s * (to_surface + from_outside) / self.p.surface_j_per_k


@dataclasses.dataclass
class History:
    """What really happened, (cases, steps[, cells]); current is positive when it discharges."""

    time_s: np.ndarray
    current_a: np.ndarray
    voltage_v: np.ndarray
    surface_k: np.ndarray
    charge: np.ndarray


def run(pack: Pack, step_s, ambient_k, standing, current_a=None, power_w=None):
    """Drives packs with a current [A] or a power at their terminals [W], (cases, steps). Returns a History.

    With power the current follows from the voltage of the step: two corrections, as an inverter that holds
    its torque does.
    """
    demand = current_a if power_w is None else power_w
    cases, steps = demand.shape
    history = History(np.arange(steps) * step_s, np.zeros((cases, steps)), np.zeros((cases, steps, pack.shape[1])),
                      np.zeros((cases, steps, pack.shape[1])), np.zeros((cases, steps, pack.shape[1])))
    current = np.zeros(cases)
    for k in range(steps):
        if power_w is None:
            current = demand[:, k]
            voltage = pack.voltage(current)
        else:
            for _ in range(2):
                voltage = pack.voltage(current)
                current = demand[:, k] / np.maximum(voltage.sum(1), 1.0)
            voltage = pack.voltage(current)
        history.current_a[:, k], history.voltage_v[:, k] = current, voltage
        history.surface_k[:, k], history.charge[:, k] = pack.surface, pack.charge
        pack.advance(voltage, step_s, ambient_k, standing[:, k])
    return history


def pulse_ohm(family, cells, shape):
    """What 10 s of 1C take from the voltage at half charge and 25 degC, over their current [ohm], of cells of `shape`.

    The resistance that a data sheet calls the DC resistance; `family`: Pack or another of its interface.
    """
    pack, step_s, seconds = family(cells, np.full(shape, 0.5), REFERENCE_K), 0.1, 10.0
    current = np.ones(shape[0]) * np.mean(pack.p.capacity_ah, axis=1)
    before = pack.voltage(np.zeros(shape[0]))
    for _ in range(int(seconds / step_s)):
        pack.advance(pack.voltage(current), step_s, np.full(shape[0], REFERENCE_K), np.zeros(shape[0], bool))
    return (before - pack.voltage(current)) / current[:, None]
