# SPDX-License-Identifier: Apache-2.0
"""The faults of a PM100, every row, and every row of the usual table that is not about another inverter."""
import json
import subprocess
import sys
from collections import Counter
from pathlib import Path

HIL = Path(__file__).resolve().parents[1]


def driven(tmp_path, *arguments, table="faults_pm100.yaml"):
    out = tmp_path / "rows.json"
    done = subprocess.run([sys.executable, HIL / "faults.py", "--table", HIL / table, "--json", out, *arguments],
                          capture_output=True, text=True, timeout=600)
    return done, json.loads(out.read_text())["rows"] if out.exists() else []


def test_every_row_passes_with_a_pm100(tmp_path):
    done, rows = driven(tmp_path, "--set", "inverter.protocol=pm100")
    assert done.returncode == 0, done.stdout + done.stderr
    assert len(rows) >= 15 and len({row["id"] for row in rows}) == len(rows)


def test_the_usual_rows_pass_with_a_pm100(tmp_path):
    done, rows = driven(tmp_path, "--set", "inverter.protocol=pm100", table="faults.yaml")
    assert done.returncode == 0, done.stdout + done.stderr  # some are about another inverter, and say so
    verdicts = Counter(row["verdict"] for row in rows)
    assert not verdicts["failed"] and verdicts["passed"] > 0.9 * len(rows), verdicts


def test_rows_say_nothing_of_a_car_with_another_inverter(tmp_path):
    for asked in (("--row", "pm100_silent"), ("--group", "pm100")):
        done, _ = driven(tmp_path, *asked)
        assert done.returncode == 3, asked
    assert "it is about a car with inverter.protocol pm100; this one has phase_current" in done.stdout + done.stderr
