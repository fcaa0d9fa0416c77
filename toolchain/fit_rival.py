# SPDX-License-Identifier: Apache-2.0
"""The objective of the full fit in numpy: tables as matrices, a branch as cumulative sums over blocks of rows."""
import numpy as np
from scipy import sparse

BLOCK = 128


class Rival:
    """The objective in numpy."""

    def __init__(self, problem):
        for name in ("dt_s", "begin_a", "end_a", "current_a", "voltage_v", "soc", "weight_s"):
            setattr(self, name, np.array(problem[name]))
        self.nodes, self.ocv = np.array(problem["soc_nodes"]), np.array(problem["ocv_soc"])
        self.table = self.straight(self.soc)
        before = np.concatenate([self.soc[:1], self.soc[:-1]])
        self.middle = self.straight(0.5 * (self.soc + before))
        self.em = self.smooth(self.soc)
        self.root = np.sqrt(self.weight_s)
        self.used = self.weight_s > 0
        self.roughness = [self.rough(self.ocv)] + [self.rough(self.nodes)] * 5
        self.weights = problem["roughness_weights"]
        self.tau_weight, self.tau_centre = problem["log_tau_weight"], problem["log_tau_centre"]
        self.padded = -len(self.dt_s) % BLOCK

    def straight(self, soc):
        at = np.clip(np.searchsorted(self.nodes, soc, side="right") - 1, 0, len(self.nodes) - 2)
        fraction = np.clip((soc - self.nodes[at]) / (self.nodes[at + 1] - self.nodes[at]), 0, 1)
        rows = np.arange(len(soc))
        return sparse.csr_matrix((np.concatenate([1 - fraction, fraction]),
                                  (np.concatenate([rows, rows]), np.concatenate([at, at + 1]))),
                                 shape=(len(soc), len(self.nodes)))

    def smooth(self, soc):
        at = np.clip(np.searchsorted(self.ocv, soc, side="right") - 1, 0, len(self.ocv) - 2)
        first = np.clip(at - 1, 0, len(self.ocv) - 4)
        x = np.clip(soc, self.ocv[0], self.ocv[-1])
        rows, out = np.arange(len(soc)), sparse.csr_matrix((len(soc), len(self.ocv)))
        for k in range(4):
            weight = np.ones(len(soc))
            for other in range(4):
                if other != k:
                    weight *= (x - self.ocv[first + other]) / (self.ocv[first + k] - self.ocv[first + other])
            out += sparse.csr_matrix((weight, (rows, first + k)), shape=out.shape)
        return out

    @staticmethod
    def rough(at):
        rows = np.zeros((len(at) - 2, len(at)))
        for k in range(1, len(at) - 1):
            before, after = at[k] - at[k - 1], at[k + 1] - at[k]
            scale = 1 / np.sqrt(0.5 * (before + after))
            rows[k - 1, k - 1:k + 2] = scale / before, -scale * (1 / before + 1 / after), scale / after
        return rows

    def branch(self, resistance, tau):
        """v' = a v + b, row after row: within blocks by cumulative sums, from block to block by a short loop."""
        source = self.table @ resistance
        middle = self.middle @ tau
        x = np.divide(self.dt_s, middle)
        a = np.exp(-x)
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.where(x > 0, (1 - a) / x, 1.0)
        before = np.concatenate([source[:1], source[:-1]])
        b = (share - a) * before * self.begin_a + (1 - share) * source * self.end_a
        b[0] = 0.0
        x = np.pad(x, (0, self.padded)).reshape(-1, BLOCK)
        b = np.pad(b, (0, self.padded)).reshape(-1, BLOCK)
        decay = np.exp(-np.cumsum(x, axis=1))
        within = decay * np.cumsum(b / decay, axis=1)
        carried, v = np.empty(len(b)), 0.0
        for k, (last, kept) in enumerate(zip(within[:, -1].tolist(), decay[:, -1].tolist())):
            carried[k] = v
            v = last + kept * v
        return (within + decay * carried[:, None]).ravel()[:len(self.dt_s)]

    def residuals(self, p):
        em, tables = p[:len(self.ocv)], p[len(self.ocv):].reshape(5, -1)
        r, log_tau = np.exp(tables[:3]), tables[3:]
        tau = np.exp(log_tau)
        v = (self.em @ em - (self.table @ r[0]) * self.current_a - self.branch(r[1], tau[0])
             - self.branch(r[2], tau[1]))
        smooth = [w * (d @ y) for w, d, y in zip(self.weights, self.roughness, [em, *r, *log_tau])]
        centre = [self.tau_weight * (y - c) for y, c in zip(log_tau, self.tau_centre)]
        return np.concatenate([(self.root * (v - self.voltage_v))[self.used], *smooth, *centre])

    def cost(self, p):
        return float(np.sum(self.residuals(np.asarray(p)) ** 2))
