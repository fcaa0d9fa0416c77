# SPDX-License-Identifier: Apache-2.0
"""One drawn cell: its recordings, what identify makes of all but one, and how that one is predicted."""
import dataclasses
import json
import re
import subprocess
import time
from pathlib import Path

import numpy as np

from . import cell as cells
from . import logger as loggers
from . import program as programs
from . import reference

LIMIT_S = 600
BEGIN = (1.0, -1.0)  # of every program: full, and charged last
EMPTY = 0.03  # SOC below which nothing is scored: there the OCV falls by volts a percent


def rate_at(rng, temperature_c):
    return float(np.round(rng.uniform(1.0, 5.0 if temperature_c > 15 else 3.0 if temperature_c > 5 else 1.5), 2))


def plan(rng, cell, logger):
    """[(kind, degC, rate)], the last one unseen."""
    slow = abs(logger.offset_a) * 42.0 < 0.01 * cell.capacity_ah  # who would count for two days with a worse one
    base = float(rng.choice([20.0, 25.0, 25.0, 30.0]))
    others = [t for t in (-10.0, 0.0, 10.0, 40.0, 45.0) if abs(t - base) > 5]
    count = int(rng.integers(1, 4))
    temperatures = [base, *sorted(rng.choice(others, count - 1, replace=False))]
    if rng.random() < 0.75:
        out = [("hppc", t, rate_at(rng, t)) for t in temperatures]
        out += [("discharge", base, float(rng.choice([0.5, 1.0, 2.0])))] if rng.random() < 0.6 or count == 1 else []
        out += [("drive", float(rng.choice(temperatures)), rate_at(rng, base))] if rng.random() < 0.4 else []
        out += [("pair", base, 0.05)] if rng.random() < (0.5 if cell.chemistry == "lfp" else 0.2) and slow else []
    else:
        kind = str(rng.choice(["drive", "discharge"]))
        out = [(kind, t, rate_at(rng, t)) for t in temperatures]
        out += [("discharge", base, 1.0)]
        out += [(kind, base, rate_at(rng, base))] if count == 1 else []
    while True:
        t = float(np.round(rng.uniform(max(-10, min(temperatures) - 8), min(45, max(temperatures) + 8)), 0))
        if min(abs(t - x) for x in temperatures) >= 3:
            break
    kind = str(rng.choice(["drive", "drive", "discharge"]))
    rate = rate_at(rng, t) if kind == "drive" else float(np.round(rng.uniform(0.4, 2.5 if t > 10 else 1.0), 2))
    return [*out[:4], (kind, t, rate)]


class Trial:
    def __init__(self, tool, seed, number, folder):
        self.tool, self.folder, self.number = tool, folder, number
        rng = np.random.default_rng([seed, number])
        self.cell = cells.draw(rng)
        self.cell.surface_lag_s = max(0.0, np.random.default_rng([seed, number, 1]).uniform(-10.0, 30.0))
        self.logger = loggers.draw(rng, self.cell.capacity_ah)
        self.plan = plan(rng, self.cell, self.logger)
        self.told_capacity, self.told_body = rng.random() < 0.3, rng.random() < 0.5
        self.again = rng.random() < 0.2
        self.files, self.commands = [], []
        self.recs, self.recs_at_true = [], []  # with the recorded and with the true temperature
        self.driven = []  # (response, mask of the readings, degC of the air, rows)
        for k, (kind, t, rate) in enumerate(self.plan):
            made = programs.make(rng, self.cell, kind, t, rate, self.logger)
            answer, mask = programs.run(self.cell, made)
            rows = loggers.read(rng, self.logger, made, answer, mask)
            self.driven.append((answer, mask, t, rows))
            name = "unseen" if k == len(self.plan) - 1 else str(k + 1)
            path = folder / f"{name}_{kind}_{t:g}C_{rate:g}C.csv"
            loggers.write(path, rows)
            self.files.append(path)
            for recs, temperature in ((self.recs, reference.recorded_temperature(rows)),
                                      (self.recs_at_true, rows.true_temperature)):
                recs.append(reference.Recording(self.cell, self.logger, rows, temperature))
        self.found = {"cell": number, "chemistry": self.cell.chemistry, "branches": len(self.cell.r),
                      "charge_transfer": bool(self.cell.exchange_a), "sample_s": self.logger.sample_s,
                      "surface_lag_s": round(self.cell.surface_lag_s, 1),
                      "phase": self.logger.phase, "noise_mv": round(1e3 * self.logger.noise_v, 3),
                      "step_mv": 1e3 * self.logger.step_v, "thermometer": self.logger.temperature,
                      "instrument": "sound" if self.logger.offset_a == 0 else
                      "told" if self.logger.declared else "not told",
                      "plan": " ".join(f"{kind}@{t:g}C,{rate:g}C" for kind, t, rate in self.plan),
                      "failures": [], "rms_mv": None, "reference_mv": None, "ratio": None, "coverage": []}

    def run(self, *words):
        words = [str(w) for w in words]
        self.commands.append("voltlap " + " ".join(words))
        try:
            return subprocess.run([str(self.tool), *words], capture_output=True, text=True, timeout=LIMIT_S,
                                  check=False)
        except subprocess.TimeoutExpired:
            return subprocess.CompletedProcess(words, 124, "", f"no end after {LIMIT_S} s")

    def fail(self, kind, text):
        self.found["failures"].append([kind, " ".join(text.split())[:400]])

    def ended_well(self, what, done):
        if done.returncode == 0:
            return True
        crashed = done.returncode < 0 or done.returncode >= 124
        self.fail(f"{what} crashed" if crashed else f"{what} refused", f"code {done.returncode}: {done.stderr[-400:]}")
        return False

    def facts(self):
        out = ["--capacity", f"{self.cell.capacity_ah:.5g}"] if self.told_capacity else []
        if self.told_body:
            out += ["--mass", f"{self.cell.mass_kg:.4g}", "--size", self.cell.size, "--heat-capacity",
                    f"{self.cell.heat_j_per_kg_k:.4g}"]
        return out + loggers.error_flags(self.logger, self.cell.capacity_ah)

    def judged(self):
        """Everything about this cell."""
        model, out = self.folder / "cell.toml", self.folder / "cell.json"
        given = []
        for path, (_, t, _) in zip(self.files[:-1], self.plan):
            given += ["--temperature", f"{t:g}", path] if self.logger.temperature == "none" else [path]
        begun = time.monotonic()
        done = self.run("identify", *given, *self.facts(), "--out", model, "--json", out)
        self.found["seconds"] = round(time.monotonic() - begun, 1)
        (self.folder / "identify.txt").write_text(done.stdout + done.stderr)
        if not self.ended_well("identify", done):
            return self.found
        self.texts(done.stdout)
        try:
            found = json.loads(out.read_text(), parse_constant=lambda c: self.fail("no number in JSON", c))
            self.identified(found, done.stdout)
            if self.logger.temperature == "none":
                self.warm_with_stated_body({fact["key"]: fact["value"] for fact in found["facts"]})
        except (OSError, ValueError) as error:
            self.fail("JSON not read back", repr(error))
            return self.found
        self.predicted(model)
        if self.again:
            first = min(self.files[:-1], key=lambda p: p.stat().st_size)
            t = ["--temperature", f"{self.plan[self.files.index(first)][1]:g}"]
            self.ended_well("identify --ocv", self.run("identify", *t, first, "--ocv", model))
        return self.found

    def warm_with_stated_body(self, facts):
        """Where no thermometer was the reference knows the heat of its cell, and of its body what identify says."""
        stated = dataclasses.replace(self.cell, mass_kg=facts["mass_kg"],
                                     heat_j_per_kg_k=facts["heat_capacity_j_per_kg_k"],
                                     cooling_w_per_k=facts["convection_w_per_m2_k"] * facts["surface_area_m2"])
        self.recs = [reference.Recording(self.cell, self.logger, rows,
                                         cells.respond(stated, answer.t, answer.current, air, BEGIN).temperature[mask])
                     for answer, mask, air, rows in self.driven]

    def texts(self, said):
        for line in said.splitlines():
            if re.search(r"left out|contradict|no model shares|other capacity|another capacity|implausible", line) and \
                    "repeat a time" not in line:
                self.fail("a sound recording is doubted", line)

    def identified(self, found, said):
        test = found["tests"][0]
        self.found.update(found_branches=test["branches"], tests=len(found["tests"]),
                          fit_mv=round(1e3 * test["rms_v"], 2), found_capacity=found["capacity_ah"])
        bounds = [law["key"] for law in test.get("laws", []) if law["at_bound"]]
        if bounds and "at its bound" not in said:
            self.fail("at a bound without a word", ", ".join(bounds))
        self.stopped(test, said)
        for law in test.get("laws", []):
            there = {"exchange_current": self.cell.exchange_a, "hysteresis": self.cell.hysteresis_v}
            if law["origin"] == "measured" and not there.get(law["key"], True):
                self.fail("a law that is not there", f"{law['key']} {law['ci95_low']:.4g} to {law['ci95_high']:.4g}")
        for one in found["tests"]:
            for file in one["files"]:
                written, fit = 1e3 * file["rms_v_used_rows"], 1e3 * file["fit_rms_v_used_rows"]
                if written > 1.5 * fit + 0.5:
                    self.fail("cell file loses what was fitted", f"{Path(file['file']).name}: {written:.2f} mV by the "
                              f"file, {fit:.2f} mV in the fit, {len(found['tests'])} tables")
        for key, low, high, true in coverage_of(self, found, test):
            self.found["coverage"].append([key, low, high, true])

    def stopped(self, test, said):
        """Time constants that stop at one value are at a limit of the fit; a branch may be none at all."""
        r0 = np.array(test["parameters"]["r0_ohm"]["value"])
        for name, table in test["parameters"].items():
            value = np.array(table["value"])
            met = np.abs(value / value.max() - 1.0) < 1e-4
            if name.startswith("tau") and 2 <= met.sum() < len(value) and "bound" not in said:
                self.fail("at a bound without a word",
                          f"{name}: {met.sum()} of {len(value)} nodes at {value.max():.4g} s")
            if name[0] == "r" and name != "r0_ohm" and np.all(value < 0.01 * r0):
                self.fail("a branch that is not there", f"{name}: at most {1e3 * value.max():.3g} mOhm")

    def predicted(self, model):
        kind, t, _ = self.plan[-1]
        errors, out = self.folder / "errors.csv", self.folder / "validate.json"
        warm = ["--temperature", f"{t:g}"] if self.logger.temperature == "none" else []
        done = self.run("validate", model, *warm, self.files[-1], "--csv", errors, "--json", out)
        (self.folder / "validate.txt").write_text(done.stdout + done.stderr)
        if not self.ended_well("validate", done):
            return
        for line in done.stdout.splitlines():
            if "defect of the recording" in line:
                self.fail("validate finds a defect in a sound recording", line)
        try:
            file = json.loads(out.read_text())["files"][0]
            rows = np.genfromtxt(errors, delimiter=",", skip_header=3, usecols=(1, 2, 7))
        except (OSError, ValueError) as error:
            self.fail("JSON not read back", f"validate: {error!r}")
            return
        fit = reference.Fit(self.cell)
        rec, at_true = self.recs[-1], self.recs_at_true[-1]
        theirs = fit.model(fit.solve(self.recs[:-1]), rec) - rec.v
        knowing = fit.model(fit.solve(self.recs_at_true[:-1]), at_true) - rec.v
        used = rows[(rows[:, 1] > 0) & np.isfinite(rows[:, 2])]
        used = used[rec.z[np.clip(np.searchsorted(rec.t, used[:, 0] - 1e-4), 0, len(rec.t) - 1)] > EMPTY]
        weight = np.minimum(np.gradient(used[:, 0]), 60.0)
        place = np.clip(np.searchsorted(rec.t, used[:, 0] - 1e-4), 0, len(rec.t) - 1)

        def rms(e):
            return float(1e3 * np.sqrt(np.average(e ** 2, weights=np.maximum(weight, 0))))
        ours, best = rms(used[:, 2]), rms(theirs[place])
        self.found.update(rms_mv=round(ours, 3), said_mv=round(1e3 * file["rms_v"], 3), reference_mv=round(best, 3),
                          reference_at_true_temperature_mv=round(rms(knowing[place]), 3),
                          truth_mv=round(rms((fit.model(np.zeros(fit.size), at_true) - rec.v)[place]), 3),
                          ratio=round(ours / best, 3), soc_start=file["soc_start"])


def coverage_of(trial, found, test):
    """(what, low, high, true) of printed intervals that the truth can be held against."""
    cell, out = trial.cell, []
    if not trial.logger.sound:
        return out
    if found.get("capacity_ci95_ah"):
        out.append(("capacity", *found["capacity_ci95_ah"], cell.capacity_ah))
    energies = {"r0_activation_energy": cell.e0, "r1_activation_energy": cell.e_branch,
                "r2_activation_energy": cell.e_branch,
                "tau1_activation_energy": cell.e_tau,
                "tau2_activation_energy": cell.e_tau}
    for law in test.get("laws", []):
        true = energies.get(law["key"])
        if law["key"] == "r0_activation_energy" and cell.exchange_a and not any(
                "exchange" in x["key"] for x in test["laws"]):
            true = None  # then both are one
        if true is not None and law["origin"] == "measured":
            out.append((law["key"], law["ci95_low"], law["ci95_high"], true))
    if test["branches"] != len(cell.r) or cell.tau_s[0] < 3 * trial.logger.sample_s:
        return out
    for name, table in test["parameters"].items():
        if name not in ("r0_ohm", *(f"r{k + 1}_ohm" for k in range(len(cell.r)))):
            continue
        k = int(name[1]) - 1
        for soc, low, high, seen in zip(*(table[x] for x in ("soc", "ci95_low", "ci95_high", "excited"))):
            z = 1.0 - (1.0 - soc) * found["capacity_ah"] / cell.capacity_ah
            if seen and 0.04 < z < 0.96:
                out.append(("r0" if k < 0 else "r of a branch", low, high, true_resistance(cell, k, z, test)))
    return out


def true_resistance(cell, branch, z, test):
    """At the temperature of the table; R0 with its charge transfer at 1C, as printed."""
    t = test["temperature_c"]
    if branch >= 0:
        return float(cell.resistance(cell.r[branch], z) * cells.arrhenius(cell.e_branch, t))
    i = np.array([cell.capacity_ah])
    eta = cells.charge_transfer(cell, i, np.array([t]))[0]
    return float(cell.resistance(cell.r0, z) * cells.arrhenius(cell.e0, t) + eta / i[0])
