# SPDX-License-Identifier: Apache-2.0
"""The faults of a PM100, every row; a car with another inverter is told that they are not about it."""
import json
import subprocess
import sys
from pathlib import Path

HIL = Path(__file__).resolve().parents[1]


def driven(tmp_path, *arguments):
    out = tmp_path / "rows.json"
    done = subprocess.run([sys.executable, HIL / "faults.py", "--table", HIL / "faults_pm100.yaml", "--json", out,
                           *arguments], capture_output=True, text=True, timeout=300)
    return done, json.loads(out.read_text())["rows"] if out.exists() else []


def test_every_row_passes_with_a_pm100(tmp_path):
    done, rows = driven(tmp_path, "--set", "inverter.protocol=pm100")
    assert done.returncode == 0, done.stdout + done.stderr
    assert len(rows) >= 15 and len({row["id"] for row in rows}) == len(rows)


def test_rows_say_nothing_of_a_car_with_another_inverter(tmp_path):
    done, _ = driven(tmp_path, "--row", "pm100_silent")
    assert done.returncode == 3
    assert "it is about a car with inverter.protocol pm100; this one has phase_current" in done.stdout + done.stderr
