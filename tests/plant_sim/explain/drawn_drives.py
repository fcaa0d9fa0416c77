# SPDX-License-Identifier: Apache-2.0
"""Drawn drives of the simulator, with or without a hidden effect, and what is explained of their logs.
VOLTLAP_TEST_SEED repeats a draw."""
import json
import os
import pathlib
import random
import subprocess

VOLTLAP = pathlib.Path(os.environ["VOLTLAP_BUILD_DIR"]) / "bin" / "voltlap"
SEED = int(os.environ.get("VOLTLAP_TEST_SEED", random.SystemRandom().randrange(2**31)))
# key of the hidden effect, smallest and largest size, name, parameter that says it, what it says of this size
EFFECTS = [
    ("cell.effects.series_ohm={}", 1e-4, 5e-4, "series_resistance", "resistance_ohm", lambda x: x),
    ("cell.effects.exchange_current_change={}", 0.2, 0.5, "resistance_current", "exchange_current_change", lambda x: x),
    ("cell.effects.exchange_current_change={}", -0.75, -0.55, "resistance_current", "exchange_current_change",
     lambda x: x),
    ("battery.contact_resistance_ohm={}", 1e-3, 5e-3, "contact_resistance", "resistance_ohm", lambda x: x),
    ("battery.cells.7.resistance_scale={}", 1.15, 1.6, "weak_cell", "resistance_change", lambda x: x - 1.0),
]


def run(*arguments):
    done = subprocess.run([VOLTLAP, *map(str, arguments)], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    return done.stdout


class Draw:
    def __init__(self, label, seed=SEED):
        self.random = random.Random(f"{seed}/{label}")
        print(f"VOLTLAP_TEST_SEED={seed}")

    def drive(self, folder, *keys, candump=False, laps=4, vehicle="vtm16e", rate=10):
        """A drawn drive; returns its log, of a CSV with `rate` rows a second."""
        out = folder / f"drive{self.random.randrange(10**9)}"
        soc = f"{self.random.uniform(0.5, 1.0):.3f}"
        self.began_c = f"{self.random.uniform(27.0, 34.0):.2f}"  # of the last drive
        settings = [f"battery.initial_soc={soc}", f"battery.initial_temperature_c={self.began_c}",
                    f"driver.grip_use={self.random.uniform(0.85, 0.98):.3f}"]
        noise = ["sensors.noise=true", "sensors.quantisation=true"] if candump else []
        files = ["--csv", f"{out}.csv", "--rate", rate, *(["--candump", f"{out}.log"] if candump else [])]
        run("endurance", "--vehicle", vehicle, "--laps", laps, "--seed", self.random.randrange(2**31), *files, "--set",
            *settings, *noise, *keys)
        return f"{out}.log" if candump else f"{out}.csv"


def explained(folder, log, *arguments, model="vtm16e"):
    out = folder / "out.json"
    said = run("explain", log, "--model", model, "--json", out, *arguments)
    return json.loads(out.read_text()), said


def rows_of(path):
    lines = [line for line in pathlib.Path(path).read_text().splitlines() if not line.startswith("#")]
    names = lines[0].split(",")
    return names, [line.split(",") for line in lines[1:]]


def write(path, names, rows):
    path.write_text("\n".join(",".join(row) for row in [names, *rows]) + "\n")
    return path
