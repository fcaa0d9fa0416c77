# SPDX-License-Identifier: Apache-2.0
"""What the true model class reaches with the same rows: the true circuit, begun at the truth and fitted to them.

Free are the OCV on its nodes, every resistance on its nodes, time constants, energies, exchange current, hysteresis and
entropy; least squares by Gauss-Newton. Currents, voltages and the count of charge are the recorded ones, with all their
errors, and so is the temperature; the true one beside it tells what the thermometer costs. What the rows do not tell it
does not know of the truth either: it is held to what is usual. Energies 15 +- 10 kJ/mol, of the time constants 0 +- 10
kJ/mol, entropy 0 +- 0.15 mV/K; resistances, time constants and exchange currents at the middle of what such cells have,
within a factor of two to three; tables and OCV smooth over their nodes.
"""
import numpy as np

from . import cell as cells

ROWS_MAX = 30000
USUAL_DROP_V = 0.06  # of each part at 1C
USUAL_TAU_S = {1: (25.0,), 2: (5.0, 130.0), 3: (1.8, 27.0, 450.0)}
USUAL_EXCHANGE = (1.4, 3.0)  # over the capacity, of both electrodes


def hat(nodes, x):
    x = np.clip(x, nodes[0], nodes[-1])
    at = np.clip(np.searchsorted(nodes, x, side="right") - 1, 0, len(nodes) - 2)
    f = (x - nodes[at]) / (nodes[at + 1] - nodes[at])
    out = np.zeros((len(x), len(nodes)))
    out[np.arange(len(x)), at] = 1.0 - f
    out[np.arange(len(x)), at + 1] = f
    return out


def recorded_temperature(rows):
    """As it was read, steps of a kelvin as the mean of five minutes; the true one where no thermometer was, until it is
    known what is believed of the body."""
    if rows.temperature is None:
        return rows.true_temperature
    values = np.unique(rows.temperature)
    if len(values) > 1 and np.diff(values).min() < 0.5:
        return rows.temperature
    sums = np.concatenate([[0.0], np.cumsum(rows.temperature)])
    low, high = (np.searchsorted(rows.t, rows.t + s) for s in (-150.0, 150.0))
    return (sums[high] - sums[low]) / (high - low)


class Recording:
    """Rows as the reference sees them."""

    def __init__(self, cell, logger, rows, temperature):
        self.t, self.v, self.current = rows.t, rows.v, rows.current
        self.dt = np.diff(self.t, prepend=self.t[0])
        before = np.concatenate([self.current[:1], self.current[:-1]])
        # A reading just before a change: its current has flowed; just after: the one before has; else between them.
        self.source = {0.0: self.current, 1e-3: before}.get(logger.phase, 0.5 * (self.current + before))
        self.z = 1.0 - np.cumsum(self.source * self.dt) / 3600.0 / cell.capacity_ah
        self.temperature = temperature
        self.h = cells.hysteresis(cell, self.z, self.source, -1.0)
        sigma = np.sqrt(logger.noise_v ** 2 + logger.step_v ** 2 / 12.0 + 2.5e-7 + (cell.r0[5] * logger.noise_a) ** 2)
        jump = np.abs(self.current - before) if logger.phase == 0.5 else np.zeros_like(before)
        self.sigma = sigma + 0.5 * cell.r0[5] * jump * (jump > 5 * logger.noise_a + 2 * logger.step_a)
        # Where the OCV is steep an error of the count is an error of the voltage.
        slope = np.where((self.z > 0) & (self.z < 1), np.abs(cell.ocv.derivative()(np.clip(self.z, 0, 1))),
                         cells.BEYOND_V)
        self.sigma = np.hypot(self.sigma, 0.001 * slope)
        self.hat_r, self.hat_u = hat(cells.NODES, self.z), hat(cell.ocv_z, self.z)


class Fit:
    """Deviations from the truth, as one vector."""

    def __init__(self, cell):
        self.cell, self.k, self.n = cell, len(cell.r), len(cells.NODES)
        self.u = slice(0, len(cell.ocv_z))
        self.r = [slice(self.u.stop + self.n * j, self.u.stop + self.n * (j + 1)) for j in range(self.k + 1)]
        self.rest = self.r[-1].stop  # log tau, E0, E of branches, E of taus [kJ/mol], log exchange, M, e [mV, mV/K]
        self.size = self.rest + self.k + 6

    def model(self, p, rec, columns=False):
        """Voltage, and with `columns` its derivatives by OCV and resistances."""
        cell, rest = self.cell, p[self.rest:]
        t, x = rec.temperature, rec.z
        e0, eb, et = (cell.e0 + 1e3 * rest[self.k], cell.e_branch + 1e3 * rest[self.k + 1],
                      cell.e_tau + 1e3 * rest[self.k + 2])
        out = cell.ocv(np.clip(x, 0, 1)) + cells.BEYOND_V * (np.minimum(x, 0) + np.maximum(x - 1, 0))
        out = out + rec.hat_u @ p[self.u] + (cell.entropy_v_per_k + 1e-3 * rest[self.k + 5]) * (t - cells.REFERENCE_C)
        out = out - (cell.hysteresis_v + 1e-3 * rest[self.k + 4]) * rec.h
        ohmic = cell.resistance(cell.r0, x) * np.exp(rec.hat_r @ p[self.r[0]]) * cells.arrhenius(e0, t) * rec.current
        out = out - ohmic
        if cell.exchange_a:
            slow = cells.arrhenius(eb, t) * np.exp(-rest[self.k + 3])
            thermal = 2.0 * cells.GAS * (t + cells.ZERO_C) / cells.FARADAY
            out = out - thermal * sum(np.arcsinh(rec.current * slow / (2.0 * i)) for i in cell.exchange_a)
        parts = [rec.hat_u, -rec.hat_r * ohmic[:, None]] if columns else None
        for j in range(self.k):
            tau = cell.tau_s[j] * np.exp(rest[j]) * (1 + cell.tau_slope * (x - 0.5)) * cells.arrhenius(et, t)
            kept = np.exp(-rec.dt / tau)
            r = cell.resistance(cell.r[j], x) * np.exp(rec.hat_r @ p[self.r[j + 1]]) * cells.arrhenius(eb, t)
            drive = r * rec.source * (1 - kept)
            out = out - cells.lag(0.0, kept, drive)
            if columns:
                parts.append(-np.column_stack([cells.lag(0.0, kept, rec.hat_r[:, m] * drive) for m in range(self.n)]))
        return (out, np.column_stack(parts)) if columns else out

    def rows(self, p, recs):
        """Weighted residuals and their derivatives."""
        r, a = [], []
        thin = max(1, int(np.ceil(sum(len(x.t) for x in recs) / ROWS_MAX)))
        for rec in recs:
            v, left = self.model(p, rec, columns=True)
            right = np.empty((len(v), self.size - self.rest))
            for m in range(self.size - self.rest):
                q = p.copy()
                q[self.rest + m] += 1e-3
                right[:, m] = (self.model(q, rec) - v) / 1e-3
            w = 1.0 / rec.sigma
            a.append((np.column_stack([left, right]) * w[:, None])[::thin])
            r.append(((v - rec.v) * w)[::thin])
        return np.concatenate(r), np.vstack(a)

    def believed(self, p):
        """Residuals of what is believed beforehand, and their derivatives."""
        cell, a, r = self.cell, [], []

        def add(places, factors, offset=0.0):
            row = np.zeros(self.size)
            row[list(places)] = factors
            a.append(row)
            r.append(row @ p + offset)
        k, drop = self.rest + self.k, USUAL_DROP_V / cell.capacity_ah
        exchange = 0.0
        if cell.exchange_a:
            exchange = float(np.mean(np.log(np.divide(cell.exchange_a, USUAL_EXCHANGE) / cell.capacity_ah)))
        for place, true, mean, sigma in ((k, cell.e0 / 1e3, 15, 10), (k + 1, cell.e_branch / 1e3, 15, 10),
                                         (k + 2, cell.e_tau / 1e3, 0, 10), (k + 3, exchange, 0, 1),
                                         (k + 4, 1e3 * cell.hysteresis_v, 0, 30),
                                         (k + 5, 1e3 * cell.entropy_v_per_k, 0, 0.15)):
            add([place], [1.0 / sigma], (true - mean) / sigma)
        for j in range(self.k):
            add([self.rest + j], [1.0], np.log(cell.tau_s[j] / USUAL_TAU_S[self.k][j]))
        for table, true, usual in zip(self.r, [cell.r0, *cell.r], [drop] + [drop / self.k] * self.k):
            level = np.log(true / usual)
            for m in range(self.n):
                add([table.start + m], [1.0], level[m])
            for m in range(1, self.n - 1):
                bend = np.array([1, -2, 1]) / 0.2
                add(range(table.start + m - 1, table.start + m + 2), bend, bend @ level[m - 1:m + 2])
        for m in range(1, self.u.stop - 1):
            bend = np.array([1, -2, 1]) / 0.1
            add(range(m - 1, m + 2), bend, bend @ cell.ocv_v[m - 1:m + 2])
        return np.array(r), np.array(a)

    def solve(self, recs):
        p, cost = np.zeros(self.size), np.inf
        step = np.zeros(self.size)
        for _ in range(12):
            r, a = self.rows(p, recs)
            b, c = self.believed(p)
            now = r @ r + b @ b
            if now > cost * (1 + 1e-9):
                p, step = p - 0.5 * step, 0.5 * step
                continue
            done = cost - now < 1e-3 * cost
            cost, best = now, p
            if done:
                break
            full = np.vstack([a, c])
            step = np.linalg.lstsq(full, -np.concatenate([r, b]), rcond=1e-12)[0]
            step[self.rest:] = np.clip(step[self.rest:], -20, 20)
            p = p + step
        return best
