# SPDX-License-Identifier: Apache-2.0
"""The rival of leave_one_out.py: the best fit of a 2-RC circuit of constants with an OCV of 15 points, by scipy.

  V = U(SOC) - a(T) (R0 I + v_1 + v_2), tau_k dv_k/dt = R_k I - v_k,  a(T) = exp(20 kJ/mol/R_g (1/T - 1/298.15 K))

U is a natural cubic spline or straight between its points, whichever follows the recordings better. For given time
constants all else is linear: every pair of a fine grid of both is solved, and scipy.optimize.minimize goes on from the
best three. Each recording weighs the same, its rows by their time. SOC is what Voltlap counted; the temperature is the
recorded one, also of the recording that is predicted, which Voltlap itself gets only at its start.
"""
import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize

POINTS = np.array([0, .02, .05, .1, .15, .2, .3, .4, .5, .6, .7, .8, .9, .95, 1.0])
TAUS_S = np.geomspace(0.3, 5000.0, 28)  # the longest that identify itself takes
ENERGY_OVER_GAS_K = 20e3 / 8.314462618
GAP_S = 300.0
ASTRAY_V = 0.15
ROUGH = 1e-2  # weight of a volt of curvature against a volt of all rows


class Rows:
    """One recording as `validate --csv` wrote it."""

    def __init__(self, path, facts, told_c):
        table = np.genfromtxt(path, delimiter=",", skip_header=3, usecols=range(1, 9))
        table = table[np.concatenate([[True], np.diff(table[:, 0]) > 0])]
        self.t, counts, self.soc, self.current, self.v, self.model, _, temperature = table.T
        self.counts = (counts > 0) & np.isfinite(self.v) & np.isfinite(self.model)
        told = 25.0 if told_c is None else told_c
        self.temperature = np.where(np.isfinite(temperature), temperature, told)
        self.dt = np.diff(self.t, prepend=self.t[0])
        current = np.nan_to_num(self.current)
        before = np.concatenate([current[:1], current[:-1]])
        hold = facts["current_hold"]
        source = current if "since" in hold else before if "until" in hold else 0.5 * (current + before)
        self.source = np.where(self.dt > GAP_S, 0.0, source)
        self.warm = np.exp(ENERGY_OVER_GAS_K * (1.0 / (self.temperature + 273.15) - 1.0 / 298.15))

    def rms_mv(self, model, used):
        """Weighted by the time to the row before, a gap as a minute."""
        return float(1e3 * np.sqrt(np.average((model - self.v)[used] ** 2, weights=np.minimum(self.dt, 60.0)[used])))

    def branch(self, tau):
        """Lagged current, per ohm of the branch."""
        kept = np.exp(-self.dt / tau)
        out, x = [], 0.0
        for a, b in zip(kept.tolist(), (self.source * (1.0 - kept)).tolist()):
            x = a * x + b
            out.append(x)
        return np.array(out) * self.warm


def beyond(curve):
    """A curve that goes straight on below SOC 0 and above 1, with its slope over the last tenth."""
    def extended(soc):
        ends = curve(np.array([0.0, 0.1, 0.9, 1.0]))
        low, high = np.minimum(soc, 0.0), np.maximum(soc - 1.0, 0.0)
        return curve(np.clip(soc, 0.0, 1.0)) + np.outer(low, (ends[1] - ends[0]) / 0.1) + np.outer(
            high, (ends[3] - ends[2]) / 0.1)
    extended.__name__ = curve.__name__
    return extended


@beyond
def straight(soc):
    at = np.clip(np.searchsorted(POINTS, soc, side="right") - 1, 0, len(POINTS) - 2)
    f = (soc - POINTS[at]) / (POINTS[at + 1] - POINTS[at])
    out = np.zeros((len(soc), len(POINTS)))
    rows = np.arange(len(soc))
    out[rows, at], out[rows, at + 1] = 1.0 - f, f
    return out


@beyond
def spline(soc):
    return CubicSpline(POINTS, np.eye(len(POINTS)), bc_type="natural")(soc)


class Problem:
    """Least squares over all recordings with one kind of OCV; normal equations, a column added for each tau asked."""

    def __init__(self, recordings, curve):
        self.curve, self.recordings = curve, []
        for rows, seen in recordings:
            # Rows far from Voltlap's own model are of open contactors, which no circuit follows: it is spared them.
            used = seen & np.isfinite(rows.soc) & (np.abs(rows.model - rows.v) < ASTRAY_V)
            weight = np.minimum(rows.dt, 30.0) * used
            self.recordings.append((rows, used, np.sqrt(weight / weight.sum())[used]))
        self.fixed = self.stacked(lambda rows: np.column_stack([curve(rows.soc), -rows.current * rows.warm]))
        self.y = self.stacked(lambda rows: rows.v)
        rough = np.zeros((len(POINTS) - 2, len(POINTS) + 1))
        for k in range(len(POINTS) - 2):  # decides only where no recording has been
            before, after = POINTS[k + 1] - POINTS[k], POINTS[k + 2] - POINTS[k + 1]
            rough[k, k:k + 3] = ROUGH * np.array([after, -before - after, before]) / (before + after)
        self.gram = self.fixed.T @ self.fixed + rough.T @ rough
        self.right, self.square = self.fixed.T @ self.y, float(self.y @ self.y)

    def stacked(self, of):
        parts = []
        for rows, used, root in self.recordings:
            x = of(rows)[used]
            parts.append(x * (root[:, None] if x.ndim == 2 else root))
        return np.concatenate(parts)

    def column(self, tau):
        return self.stacked(lambda rows: -rows.branch(tau))

    def solve(self, columns):
        """(cost, coefficients) with these branch columns; a resistance below zero costs as much as no fit at all."""
        b = np.column_stack(columns)
        cross, n = self.fixed.T @ b, len(self.right)
        gram = np.block([[self.gram, cross], [cross.T, b.T @ b]])
        right = np.concatenate([self.right, b.T @ self.y])
        x = np.linalg.lstsq(gram, right, rcond=1e-13)[0]
        cost = self.square - 2 * x @ right + x @ gram @ x
        return (cost if np.all(x[n - 1:] >= 0.0) else self.square), x

    def cost_at(self, log_taus):
        return self.solve([self.column(tau) for tau in np.exp(log_taus)])[0]

    def best(self):
        """(cost, taus, coefficients)"""
        columns = [self.column(tau) for tau in TAUS_S]
        pairs = sorted((self.solve([columns[i], columns[j]])[0], i, j)
                       for i in range(len(TAUS_S)) for j in range(i + 2, len(TAUS_S)))
        found = []
        for cost, i, j in pairs[:3]:
            start = np.log([TAUS_S[i], TAUS_S[j]])
            polished = minimize(self.cost_at, start, method="Nelder-Mead", bounds=[np.log(TAUS_S[[0, -1]])] * 2,
                                options={"xatol": 0.01, "fatol": 1e-4 * cost, "maxfev": 40,
                                         "initial_simplex": start - 0.15 * np.array([[0, 0], [1, 0], [0, 1]])})
            found.append((polished.fun, polished.x))
        cost, x = min(found, key=lambda f: f[0])
        taus = np.exp(x)
        return cost, taus, self.solve([self.column(t) for t in taus])[1]


class Rival:
    def __init__(self, recordings):
        answers = [(*problem.best(), problem) for problem in (Problem(recordings, c) for c in (straight, spline))]
        self.cost, self.taus, self.x, problem = min(answers, key=lambda a: a[0])
        self.curve, self.recordings = problem.curve, len(recordings)

    def predicted(self, rows):
        return np.column_stack([self.curve(rows.soc), -rows.current * rows.warm,
                                *(-rows.branch(tau) for tau in self.taus)]) @ self.x

    def facts(self):
        n = len(POINTS)
        return {"recordings": self.recordings, "ocv": self.curve.__name__, "fit_rms_mv": 1e3 * float(self.cost) ** 0.5,
                "tau_s": self.taus.tolist(), "resistance_mohm": (1e3 * self.x[n:]).tolist(),
                "ocv_v": self.x[:n].tolist()}
