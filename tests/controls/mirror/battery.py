# SPDX-License-Identifier: Apache-2.0
"""A cell by hand: what a small change of it, or of what its sensors say, adds to the voltage and the temperature.

It reads the numbers of a cell file and shares nothing else with the plant or with explain. Branches answer a change of
the current by their values at half charge and at the file's reference; all else is taken along the sound drive.
"""

import tomllib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.signal import lfilter

CELLS = Path(__file__).resolve().parents[3] / "plant_sim/data/cells"
GAS, FARADAY, ZERO_C = 8.314462618, 96485.33212, 273.15
LOW_END = 0.3  # SOC below which the low end's change begins


def lagged(values, tau_s, step_s):
    """First-order lag of a row, from rest."""
    keep = np.exp(-step_s / tau_s)
    return lfilter([1.0 - keep], [1.0, -keep], values)


@dataclass
class Cell:
    """A cell file and what of it a pack or a world changed."""

    file: dict
    capacity_ah: float
    convection: float  # W/m2/K

    @classmethod
    def named(cls, name, capacity_ah=None, convection=None):
        file = tomllib.loads((CELLS / f"{name}.toml").read_text())
        return cls(file, capacity_ah or file["capacity_ah"], convection or file["convection_w_per_m2_k"])

    def ocv(self, soc):
        curve = self.file["ocv"]
        if "soc" in curve:
            return np.interp(soc, curve["soc"], curve["voltage_v"])
        return np.polynomial.polynomial.polyval(np.clip(soc, 0.0, 1.0), curve["polynomial_v"])

    def ocv_slope(self, soc):
        """dOCV/dSOC [V] over 2 % of the charge."""
        return (self.ocv(soc + 0.01) - self.ocv(soc - 0.01)) / 0.02

    def middle(self, name):
        return float(np.interp(0.5, self.file["breakpoints"]["soc"], self.file[name]["value"]))

    @property
    def heat_j_per_k(self):
        return self.file["mass_kg"] * self.file["heat_capacity_j_per_kg_k"]

    @property
    def cooling_w_per_k(self):
        return self.file["surface_area_m2"] * self.convection

    @property
    def cooling_s(self):
        return self.heat_j_per_k / self.cooling_w_per_k

    @property
    def reference_c(self):
        return self.file["reference_temperature_c"]

    def answer(self, current_a, step_s):
        """Volts that a change of the current takes from the cell, its charge included."""
        drop = self.middle("r0") * current_a
        for k in (1, 2):
            drop = drop + self.middle(f"r{k}") * lagged(current_a, self.middle(f"tau{k}"), step_s)
        return drop

    def drawn(self, current_a, step_s):
        """Share of the charge that was drawn."""
        return np.cumsum(current_a) * step_s / 3600.0 / self.capacity_ah

    def exchange_a(self):
        """Exchange current that bends R0 over the currents of the tables, as the plant looks for it: on a grid."""
        currents = np.array(self.file["breakpoints"]["current_a"], float)
        per_ampere = self.file["r0"].get("per_ampere", 0.0)
        r0 = self.middle("r0") * (1.0 + per_ampere * (currents - self.file["reference_current_a"]))
        used = currents > 0.0
        currents, r0 = currents[used], r0[used]
        if len(currents) == 1:
            return 2.0 * GAS * (self.reference_c + ZERO_C) / FARADAY / self.middle("r1")
        tried = currents[-1] * np.geomspace(0.02, 5.0, 121)
        rest = r0 - transfer_v(tried[:, None], currents, self.reference_c) / currents
        ohms = np.maximum(rest.mean(1), 0.0)
        return float(tried[np.argmin(((rest - ohms[:, None]) ** 2).sum(1))])


def transfer_v(exchange_a, current_a, temperature_c):
    """Volts of the charge transfer of both electrodes, Butler-Volmer."""
    return 4.0 * GAS * (temperature_c + ZERO_C) / FARADAY * np.arcsinh(current_a / (2.0 * exchange_a))


def hysteresis(drawn, per_soc, begin):
    """State in -1 .. 1 by the share of the charge drawn so far (Plett, 2004)."""
    steps = np.diff(drawn, prepend=0.0)
    side, keep = np.where(steps >= 0.0, 1.0, -1.0), np.exp(-per_soc * np.abs(steps))
    out, state = np.empty(len(drawn)), begin
    for k, (s, x) in enumerate(zip(side, keep)):
        state = s + (state - s) * x
        out[k] = state
    return out
