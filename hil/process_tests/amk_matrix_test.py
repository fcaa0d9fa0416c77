# SPDX-License-Identifier: Apache-2.0
"""The faults of four AMK inverters, every row, and every row of the usual table that is not about another inverter."""
import json
import subprocess
import sys
from collections import Counter
from pathlib import Path

HIL = Path(__file__).resolve().parents[1]
CAR = ("--vehicle", "amk_4wd")


def driven(tmp_path, *arguments, table="faults_amk.yaml"):
    out = tmp_path / "rows.json"
    done = subprocess.run([sys.executable, HIL / "faults.py", "--table", HIL / table, "--json", out, *arguments],
                          capture_output=True, text=True, timeout=900)
    return done, json.loads(out.read_text())["rows"] if out.exists() else []


def test_every_row_passes_with_four_amk_inverters(tmp_path):
    done, rows = driven(tmp_path, *CAR)
    assert done.returncode == 0, done.stdout + done.stderr
    assert len(rows) >= 20 and len({row["id"] for row in rows}) == len(rows)


def test_the_usual_rows_pass_with_four_amk_inverters(tmp_path):
    done, rows = driven(tmp_path, *CAR, table="faults.yaml")
    assert done.returncode == 0, done.stdout + done.stderr  # some are about another inverter, and say so
    verdicts = Counter(row["verdict"] for row in rows)
    assert not verdicts["failed"], verdicts
    assert verdicts["passed"] > 0.9 * len(rows), verdicts


def test_rows_say_nothing_of_a_car_with_another_inverter(tmp_path):
    done, _ = driven(tmp_path, "--row", "amk_silent_front_left")
    assert done.returncode == 3
    assert "it is about a car with inverter.protocol amk; this one has phase_current" in done.stdout + done.stderr
