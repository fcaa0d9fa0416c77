# SPDX-License-Identifier: Apache-2.0
"""Cells of the family that the diagnosing tool assumes: an open-circuit voltage, a resistance, two lags, one mass.

The second truth. A tool that fails here fails on its own terms; one that succeeds here alone flatters itself. Same
interface as cell.Pack: what is different is that nothing diffuses and that core and surface are one.
"""
import numpy as np

from . import cell

SECOND_SHARE = 0.5  # of the film's resistance, in the slower lag
SECOND_LAG_S = 120.0


class Circuit(cell.Pack):
    def __init__(self, cells, charge, temperature_k):
        super().__init__(cells, charge, temperature_k)
        self.second = np.zeros(self.shape)

    def voltage(self, current):
        p = self.p
        through = current[:, None] + p.leak_a
        self._through = through
        kinetic = self._arrhenius(p.kinetic_activation + p.extra_activation)
        thermal = 2.0 * cell.GAS * self.core / cell.FARADAY
        film = self._arrhenius(p.film_activation + p.extra_activation)
        over = sum(thermal * np.arcsinh(through / (2.0 * exchange * kinetic))
                   for exchange in (p.negative_exchange_a, p.positive_exchange_a))
        low = 1.0 + p.low_end * np.clip((0.3 - self.charge) / 0.3, 0.0, None)
        turns = np.sin(np.pi * self.charge[..., None] * np.arange(1, 4))
        self._rest = cell.open_circuit(self.charge)
        return (self._rest - over - through * (low * p.film_ohm / film + p.extra_ohm)
                - low / film * (p.electrolyte_ohm * self.electrolyte + SECOND_SHARE * p.film_ohm * self.second)
                - p.branch_ohm * self.branch - p.slow_ohm * self.slow
                + p.hysteresis_v * self.turned + np.einsum("bck,bck->bc", turns, p.bend_v)
                + p.entropy_v_per_k * (self.core - cell.REFERENCE_K))

    def _diffuse(self, step_s):
        self.second += (1.0 - np.exp(-step_s / SECOND_LAG_S)) * (self._through - self.second)

    def _warm(self, step_s, heat, to_surface, from_outside):
        self.core += step_s * (heat + from_outside) / (self.p.core_j_per_k + self.p.surface_j_per_k)
        self.surface = self.core.copy()
