#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What voltlap explain says about the recordings in VOLTLAP_DATA: identifies their models, asks, prints a table.

    python3 toolchain/explain_recordings.py [--only ucd --only ksu] [--keep FOLDER]

With --keep the models, answers and reports stay in FOLDER. It takes half a minute.
"""

import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile
from dataclasses import dataclass

VOLTLAP = pathlib.Path(__file__).resolve().parent.parent / "build" / "default" / "bin" / "voltlap"
UCD = "ucd_fe6_fsae/fsae_lincoln_2019_endurance_stint1.csv.gz"
KSU = "ksu_ks6e_fsae/fsae_michigan_ev_2023_endurance_stint1.csv.gz"
A123 = "plett_a123/a123_dyn_50_p25.csv.gz"
STACK = "leaf_cell_ornl/pack6s2p_discharge_1_0c.csv.gz"
UWFE = "uwfe_canlogs/A_postregen_193"
UWFE_B = "uwfe_canlogs/B_pitt_autox_24"
PLAIN = ("--rc", 2, "--constant")


@dataclass(frozen=True)
class Row:
    name: str
    what: str
    identify: tuple  # arguments; a word that ends in .gz is a recording
    log: str
    explain: tuple


ROWS = (
    Row("ucd", "2019 endurance, 28 in series, plain", (UCD, "--cells-in-series", 28, *PLAIN, "--blocks", "60:even"),
        UCD,
        ("--set", "battery.cells_in_series=28")),
    Row("ksu", "2023 endurance, 72 in series, 8 in parallel, plain",
        (KSU, "--cells-in-series", 72, "--cells-in-parallel", 8, *PLAIN, "--blocks", "60:even"), KSU,
        ("--set", "battery.cells_in_series=72", "battery.cells_in_parallel=8")),
    Row("plett", "A123 dynamic test, 25 degC, tables over SOC",
        ("--temperature", 25, A123, "--rc", 2, "--blocks", "60:even"), A123, ()),
    Row("leaf", "Leaf stack 6s2p at 1C, cell from another cell's pulses",
        ("--temperature", 25, "leaf_cell_ornl/hppc_25C.csv.gz"), STACK,
        ("--set", "battery.cells_in_series=6", "battery.cells_in_parallel=2")),
    Row("uwfe_a", "2024 car, log A, table: published and bus voltage; plain, from the bus voltage",
        ("--window", "34:103", UWFE + "_main_20hz.csv.gz", "--map", "uwfe_bus", "--cells-in-series", 140, *PLAIN),
        UWFE + "_main_20hz.csv.gz", ("--set", "battery.cells_in_series=140")),
    Row("uwfe_a_can", "the same from CAN, with 140 cells",
        ("--window", "34:103", UWFE + "_main_20hz.csv.gz", "--map", "uwfe_bus", "--cells-in-series", 140, *PLAIN),
        UWFE + ".TXT.gz", ("--set", "battery.cells_in_series=140")),
    Row("uwfe_b", "2024 car, log B, from CAN",
        ("--window", "34:103", UWFE + "_main_20hz.csv.gz", "--map", "uwfe_bus", "--cells-in-series", 140, *PLAIN),
        UWFE_B + ".candump.log.gz", ("--set", "battery.cells_in_series=140")),
)


def voltlap(command, data, arguments):
    words = [str(data / word) if str(word).endswith(".gz") else str(word) for word in arguments]
    run = subprocess.run([str(VOLTLAP), command, *words], capture_output=True, text=True)
    if run.returncode != 0:
        sys.exit(f"voltlap {command} {' '.join(words)}: {run.stderr.strip()}")
    return run.stdout


def answer(row, data, folder, report=True):
    """The JSON of `explain`, and all that it printed."""
    model, out = folder / f"{row.name}.toml", folder / f"{row.name}.json"
    voltlap("identify", data, (*row.identify, "--out", model))
    said = voltlap("explain", data, (row.log, "--model", model, *row.explain, "--json", out,
                                     *(("--report", folder / f"{row.name}.html") if report else ())))
    return json.loads(out.read_text()), said


def size_of(cause):
    numbers = [f"{name} {p['value']:.4g} ({p['ci95_low']:.4g} to {p['ci95_high']:.4g}) {p['unit']}"
               for name, p in cause["parameters"].items() if p["unit"] not in ("name", "index")]
    where = [str(p["value"]) for p in cause["parameters"].values() if p["unit"] == "name"]
    return " ".join([cause["name"], *where, *numbers])


def row_text(row, found, said):
    rival = next((line.strip() for line in said.splitlines() if line.startswith("  runner-up")), "none")
    gain = "; ".join(f"{channel} {g['heldout_rms_before']:.4g} to {g['heldout_rms_after']:.4g}, "
                     f"floor {g['noise_floor']:.2g}" for channel, g in found.get("gain", {}).items())
    causes = "; ".join(size_of(cause) for cause in found["causes"]) or found.get("unknown_in") or "-"
    return f"| {row.what} | `{found['verdict']}` | {causes} | {gain or '-'} | {rival.removeprefix('runner-up ')} |"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", action="append", choices=[row.name for row in ROWS], default=[])
    parser.add_argument("--keep", type=pathlib.Path)
    given = parser.parse_args()
    if not os.environ.get("VOLTLAP_DATA"):
        sys.exit("VOLTLAP_DATA is not set: no measured recordings on this machine")
    data = pathlib.Path(os.environ["VOLTLAP_DATA"])
    with tempfile.TemporaryDirectory() as scratch:
        folder = given.keep or pathlib.Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        print("| recording, model | verdict | causes, size with its 95 % interval | RMS before to after, V or K "
              "| runner-up |")
        print("|---|---|---|---|---|")
        for row in ROWS:
            if not given.only or row.name in given.only:
                print(row_text(row, *answer(row, data, folder)), flush=True)


if __name__ == "__main__":
    main()
