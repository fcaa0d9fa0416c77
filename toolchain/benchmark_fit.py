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

from outputs import output_file

GOAL = 100.0
SAME = 1e-6  # relative difference of costs that counts as none
ROUTES = {
    "averaged": "voltlap, steady rows averaged",
    "all_rows": "voltlap, all rows",
    "both": "voltlap, averaged, then all rows",
}


def main():
    parser = argparse.ArgumentParser(prog="voltlap benchmark-fit", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter,
                                     epilog="Exit code: 0 at least 100 times faster at the same cost; 1 not; 2 usage.")
    parser.add_argument("--json", type=output_file, help="write the numbers")
    arguments = parser.parse_args()
    os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"  # read when numpy is loaded
    import numpy as np
    from fit_rival import Rival
    from scipy.optimize import least_squares
    build = Path(os.environ.get("VOLTLAP_BUILD_DIR", Path(__file__).resolve().parents[1] / "build" / "default"))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "problem.json"
        subprocess.run([build / "bin" / "voltlap-fit-problem", "--json", path], check=True)
        problem = json.loads(path.read_text())
    rival, start = Rival(problem), np.array(problem["start"])
    print("voltlap: scipy is at it, which takes a minute or more", file=sys.stderr)
    begin = time.process_time()
    theirs = least_squares(rival.residuals, start, method="trf", x_scale="jac", ftol=1e-8, xtol=1e-8, gtol=1e-12,
                           max_nfev=200)
    seconds, cost = time.process_time() - begin, 2 * theirs.cost
    print(f"{problem['rows']} rows, {problem['hours']:.2f} h at 1 Hz, {len(start)} parameters; start: cost "
          f"{rival.cost(start):.6e} V^2 s\n\n"
          f"{'':<36}{'time':>12}{'iterations':>12}{'cost':>18}{'faster':>10}")
    ours = {}
    for name, what in ROUTES.items():
        solved = problem[name]
        ours[name] = {"seconds": solved["seconds"], "cost": rival.cost(solved["p"]),
                      "factor": seconds / solved["seconds"]}
        print(f"{what:<36}{solved['seconds'] * 1e3:>9.0f} ms{solved['iterations']:>12}{ours[name]['cost']:>18.8e}"
              f"{ours[name]['factor']:>9.0f}x")
    print(f"{'scipy least_squares':<36}{seconds:>10.1f} s{theirs.njev:>12}{cost:>18.8e}\n"
          f"{'voltlap identify, smoothness and all':<36}{problem['identify_s'] * 1e3:>9.0f} ms{'':>30}"
          f"{seconds / problem['identify_s']:>9.0f}x")
    if arguments.json:
        arguments.json.write_text(json.dumps({
            "rows": problem["rows"], "parameters": len(start), "scipy_s": seconds, "scipy_cost": cost,
            "identify_s": problem["identify_s"], **ours}))
    return 0 if ours["both"]["factor"] >= GOAL and ours["both"]["cost"] <= cost * (1 + SAME) else 1


if __name__ == "__main__":
    sys.exit(main())
