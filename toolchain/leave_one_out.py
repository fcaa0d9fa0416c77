#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""One recording left out and predicted: `identify` from the others, several models, beside a fit by scipy.

    VOLTLAP_DATA=FOLDER python3 toolchain/leave_one_out.py [--only leaf --only car] [--rungs chosen,laws3]

Prints the table of docs/estimation_methods.md: RMS [mV] over the discharge strokes of the recording that was kept back,
weighted by time, as `validate` counts them. Of a car one drive is there: its second half is predicted from its first
(--window), and its odd minutes from the even ones (--blocks 60:even). All of the table takes an hour on one core.
"""
import argparse
import importlib.util
import json
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from outputs import output_file

VOLTLAP = Path(__file__).resolve().parent.parent / "build" / "default" / "bin" / "voltlap"
LIMIT_S = 900
BLOCK_S = 60
RUNGS = {
    "chosen": (), "constant1": ("--constant", "--rc", 1), "constant2": ("--constant", "--rc", 2),
    "laws2": ("--tables", "laws", "--rc", 2), "laws3": ("--tables", "laws", "--rc", 3), "tests": ("--tables", "tests"),
}


@dataclass(frozen=True)
class Recording:
    path: str
    map: str = ""
    temperature_c: float | None = None  # told, where there is no column

    def words(self, data):
        return [*(("--map", self.map) if self.map else ()),
                *(("--temperature", self.temperature_c) if self.temperature_c is not None else ()), data / self.path]


@dataclass(frozen=True)
class Row:
    name: str
    what: str
    fit: tuple
    kept: Recording
    series: int = 1
    half_s: float = 0.0  # only rows before it are fitted, only rows after it are judged
    blocks: bool = False  # even blocks are fitted, odd ones judged


def leaf():
    folder = "leaf_cell_ornl/"
    all_of = {"hppc": Recording(folder + "hppc_25C.csv.gz", "leaf_cell_ornl", 25),
              "1C": Recording(folder + "discharge_1C.csv.gz", "leaf_discharge_1c"),
              "2C": Recording(folder + "discharge_2C.csv.gz", "leaf_discharge_2c"),
              "C15": Recording(folder + "cycling_c15_10C_24C_40C.csv.gz", "leaf_cell_ornl", 24)}
    said = {"hppc": "pulses", "1C": "1C", "2C": "2C", "C15": "C/15 (behind a cable of 0.12 ohm)"}
    for name, kept in all_of.items():
        yield Row(f"leaf_{name}", f"Leaf, {said[name]}", tuple(r for n, r in all_of.items() if n != name), kept)
    for name in ("1C", "2C"):
        yield Row(f"leaf_{name}_pulses", f"Leaf, {name} from the pulses alone", (all_of["hppc"],), all_of[name])


def panasonic():
    def of(name):
        return Recording(f"panasonic_18650pf/{name}.csv.gz")
    names = {"hppc_25C": "pulses at 25 degC", "hppc_10C": "pulses at 10 degC", "la92_25C": "LA92 at 25 degC",
             "mix1_25C": "mixed at 25 degC", "us06_25C": "US06 at 25 degC", "us06_0C": "US06 at 0 degC"}
    every = (*names, "ocv_c20_25C", "dis_1c_25C_start")
    for name, said in names.items():
        yield Row(f"panasonic_{name}", f"Panasonic, {said}", tuple(of(n) for n in every if n != name), of(name))
    for name in ("la92_25C", "us06_25C", "us06_0C", "hppc_10C"):
        yield Row(f"panasonic_{name}_pulses", f"Panasonic, {names[name]} from the pulses at 25 degC alone",
                  (of("hppc_25C"),), of(name))


def a123():
    def of(name, t):
        return Recording(f"plett_a123/a123_{name}.csv.gz", "plett_a123", t)
    slow = (of("ocv_p25", 25), of("ocv_p45", 45))
    drive = {25: of("dyn_50_p25", 25), 45: of("dyn_50_p45", 45)}
    for t, other in ((25, 45), (45, 25)):
        yield Row(f"a123_dyn{t}", f"A123, drive at {t} degC", (drive[other], *slow), drive[t])


def cars():
    for name, said, path, series, half in (
            ("ucd", "UC Davis 2019", "ucd_fe6_fsae/fsae_lincoln_2019_endurance_stint1.csv.gz", 28, 480),
            ("ksu", "Kennesaw 2023", "ksu_ks6e_fsae/fsae_michigan_ev_2023_endurance_stint1.csv.gz", 72, 412),
            ("ut23", "Toronto 2023", "ut23_fsae/fsae_michigan_2023_endurance_first_850s.csv.gz", 115, 425)):
        drive = Recording(path)
        yield Row(f"car_{name}", f"Car {said}, second half from the first", (drive,), drive, series, half_s=half)
        yield Row(f"car_{name}_blocks", f"Car {said}, odd minutes from the even ones", (drive,), drive, series,
                  blocks=True)


ROWS = (*leaf(), *panasonic(), *a123(), *cars())


class Failed(Exception):
    pass


class Table:
    """Runs the commands of one row after the other; files stay in the folder."""

    def __init__(self, data, folder):
        self.data, self.folder, self.done = data, folder, set()

    def voltlap(self, command, *words):
        words = [str(w) for w in words]
        try:
            run = subprocess.run([str(VOLTLAP), command, *words], capture_output=True, text=True, timeout=LIMIT_S)
        except subprocess.TimeoutExpired:
            raise Failed(f"{command}: no end after {LIMIT_S} s") from None
        if run.returncode != 0:
            raise Failed(f"{command} ended with {run.returncode}: {run.stderr.strip()[-300:]}")

    def series(self, row):
        return ("--cells-in-series", row.series) if row.series > 1 else ()

    def fitted(self, row, rung):
        """Cell file and JSON of `identify`, once for the column and the rival."""
        cell, out = (self.folder / f"{row.name}_{rung}{end}" for end in (".toml", ".json"))
        if (row.name, rung) in self.done:
            return cell, json.loads(out.read_text())
        part = ("--window", f"0:{row.half_s:g}") if row.half_s else ()
        blocks = ("--blocks", f"{BLOCK_S}:even") if row.blocks else ()
        self.voltlap("identify", *RUNGS[rung], *self.series(row), *blocks, *part,
                     *(w for r in row.fit for w in r.words(self.data)), "--out", cell, "--json", out)
        self.done.add((row.name, rung))
        return cell, json.loads(out.read_text())

    def rows(self, row, cell, recording, name):
        """Rows of a recording with SOC and the model's voltage, as `validate` writes them, and its JSON."""
        table, out = self.folder / f"{row.name}_{name}.csv", self.folder / f"{row.name}_{name}.json"
        self.voltlap("validate", cell, *self.series(row), *recording.words(self.data), "--csv", table, "--json", out)
        from leave_one_out_rival import Rows
        return Rows(table, json.loads(out.read_text())["files"][0], recording.temperature_c)

    def judged(self, row, rows):
        """Which rows count."""
        used = rows.counts
        if row.half_s:
            used = used & (rows.t > row.half_s)
        return used & (rows.t // BLOCK_S % 2 == 1) if row.blocks else used

    def seen(self, row, rows):
        """Which rows a fit may see."""
        if row.half_s:
            return rows.t <= row.half_s
        return rows.t // BLOCK_S % 2 == 0 if row.blocks else rows.t > -1

    def rung(self, row, rung):
        cell, _ = self.fitted(row, rung)
        rows = self.rows(row, cell, row.kept, f"kept_{rung}")
        return rows.rms_mv(rows.model, self.judged(row, rows))

    def rival(self, row):
        """Of the recordings that `identify` kept, with the SOC that it counted in them."""
        from leave_one_out_rival import Rival
        cell, found = self.fitted(row, "chosen")
        used = {Path(file["file"]).name for test in found["tests"] for file in test["files"]}
        fit = [self.rows(row, cell, r, f"fit_{k}") for k, r in enumerate(row.fit) if Path(r.path).name in used]
        kept = self.rows(row, cell, row.kept, "kept_rival")
        rival = Rival([(rows, self.seen(row, rows)) for rows in fit])
        return kept.rms_mv(rival.predicted(kept), self.judged(row, kept)), rival.facts()


def shown(value):
    return "-" if value is None else f"{value:.1f}" if value < 99.95 else f"{value:.0f}"


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter,
                                     epilog="rows: " + ", ".join(row.name for row in ROWS)
                                     + "\nExit code: 0 every number is there; 1 one is not, and why is said; 2 usage.")
    parser.add_argument("--only", action="append", default=[], metavar="ROW",
                        help="only this row, or those that begin with it; may be repeated")
    parser.add_argument("--rungs", default=",".join((*RUNGS, "rival")), help="columns; default: %(default)s")
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="keep cell files, JSON and errors over time there")
    parser.add_argument("--json", type=output_file, metavar="FILE", help="write the numbers")
    parser.add_argument("--voltlap", type=Path, default=VOLTLAP, help="the program; default: the built one")
    given = parser.parse_args()
    given.rungs = given.rungs.split(",")
    if wrong := [r for r in given.rungs if r not in (*RUNGS, "rival")]:
        parser.error(f"--rungs {','.join(wrong)}: expected some of {', '.join((*RUNGS, 'rival'))}")
    if wrong := [o for o in given.only if not any(row.name.startswith(o) for row in ROWS)]:
        parser.error(f"--only {wrong[0]}: expected a row or its beginning, of {', '.join(row.name for row in ROWS)}")
    if not os.environ.get("VOLTLAP_DATA"):
        parser.error("VOLTLAP_DATA is not set: no measured recordings on this machine")
    if importlib.util.find_spec("scipy") is None:
        parser.error("scipy is not there; "
                     "pip install -r toolchain/requirements/fit.txt -r toolchain/requirements/test.txt")
    if not os.access(given.voltlap, os.X_OK):
        parser.error(f"{given.voltlap} is not there; run ./voltlap build, or name it with --voltlap")
    return given


def numbers(table, row, rungs):
    """{column: mV or None}, the rival's facts, [what failed]."""
    out, facts, failed = {}, None, []
    for rung in rungs:
        print(f"leave_one_out: {row.name}, {rung}", file=sys.stderr, flush=True)
        try:
            if rung == "rival":
                out[rung], facts = table.rival(row)
            else:
                out[rung] = table.rung(row, rung)
        except Failed as failure:
            out[rung] = None
            failed.append(f"{row.name}, {rung}: {failure}")
            print("leave_one_out: " + failed[-1], file=sys.stderr, flush=True)
    return out, facts, failed


def main():
    global VOLTLAP
    given = arguments()
    VOLTLAP = given.voltlap
    rows = [r for r in ROWS if not given.only or any(r.name.startswith(o) for o in given.only)]
    every, failures = [], []
    with tempfile.TemporaryDirectory() as scratch:
        folder = given.keep or Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        table = Table(Path(os.environ["VOLTLAP_DATA"]), folder)
        print("| predicted [mV] | " + " | ".join(given.rungs) + " |\n|---" + "|---" * len(given.rungs) + "|",
              flush=True)
        for row in rows:
            found, facts, failed = numbers(table, row, given.rungs)
            print(f"| {row.what} | " + " | ".join(shown(found[r]) for r in given.rungs) + " |", flush=True)
            every.append({"row": row.name, "what": row.what, "rms_mv": found, "rival": facts})
            failures += failed
    if given.json:
        given.json.write_text(json.dumps({"rows": every, "failed": failures}, indent=1) + "\n")
    return int(bool(failures))


if __name__ == "__main__":
    sys.exit(main())
