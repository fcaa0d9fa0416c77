#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The full fit beside scipy: one problem, one start, one objective; processor time of one core.

The problem is a discharge test of one cell, four hours at 1 Hz, 129 parameters (16 breakpoints of R0, R1, R2, tau1,
tau2 and 49 nodes of the OCV), with the smoothness that the fit settled. The rival is scipy.optimize.least_squares with
numerical derivatives; its model is written for numpy: tables as matrices, and the branches' recursion as cumulative
sums over blocks of rows, without a loop over rows. Costs of both answers are computed by the rival's model.
"""
import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
import numpy as np  # noqa: E402
from scipy import sparse  # noqa: E402
from scipy.optimize import least_squares  # noqa: E402

GOAL = 100.0
SAME = 1e-4  # relative difference of costs that counts as none
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


def main():
    parser = argparse.ArgumentParser(prog="voltlap benchmark-fit", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter,
                                     epilog="Exit code: 0 at least 100 times faster at the same cost; 1 not; 2 usage.")
    parser.add_argument("--json", type=Path, help="write the numbers")
    arguments = parser.parse_args()
    build = Path(os.environ.get("VOLTLAP_BUILD_DIR", Path(__file__).resolve().parents[1] / "build" / "default"))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "problem.json"
        subprocess.run([build / "bin" / "voltlap-fit-problem", "--json", path], check=True)
        problem = json.loads(path.read_text())
    rival, start, ours = Rival(problem), np.array(problem["start"]), problem["ours"]
    print("voltlap: scipy is at it, which takes a minute or more", file=sys.stderr)
    begin = time.process_time()
    theirs = least_squares(rival.residuals, start, method="trf", x_scale="jac", ftol=1e-8, xtol=1e-8, gtol=1e-12,
                           max_nfev=200)
    seconds = time.process_time() - begin
    cost, factor = 2 * theirs.cost, seconds / ours["seconds"]
    own_cost = rival.cost(ours["p"])
    print(f"{problem['rows']} rows, {problem['hours']:.2f} h at 1 Hz, {len(start)} parameters; start: cost "
          f"{rival.cost(start):.6e} V^2 s\n\n"
          f"{'':<28}{'time':>12}{'iterations':>12}{'cost':>16}\n"
          f"{'voltlap, this problem':<28}{ours['seconds'] * 1e3:>9.0f} ms{ours['iterations']:>12}{own_cost:>16.6e}\n"
          f"{'scipy least_squares':<28}{seconds:>10.1f} s{theirs.njev:>13}{cost:>16.6e}\n"
          f"{'voltlap identify, whole':<28}{problem['identify_s'] * 1e3:>9.0f} ms\n\n"
          f"{factor:.0f} times faster on the same problem; the whole identification, smoothness and all, "
          f"{seconds / problem['identify_s']:.0f} times")
    if arguments.json:
        arguments.json.write_text(json.dumps({
            "rows": problem["rows"], "parameters": len(start), "voltlap_s": ours["seconds"], "scipy_s": seconds,
            "identify_s": problem["identify_s"], "voltlap_cost": own_cost, "scipy_cost": cost, "factor": factor}))
    return 0 if factor >= GOAL and own_cost <= cost * (1 + SAME) else 1


if __name__ == "__main__":
    sys.exit(main())
