# SPDX-License-Identifier: Apache-2.0
"""toolchain/leave_one_out.py: its rival finds a known circuit; two cheap rows of a measured cell (VOLTLAP_DATA)."""
import json
import os
import pathlib
import subprocess
import sys

import numpy as np
import pytest

pytest.importorskip("scipy", reason="scipy is not there: pip install -r toolchain/requirements/fit.txt")
ROOT = pathlib.Path(__file__).resolve().parents[4]
DATA = os.environ.get("VOLTLAP_DATA")
sys.path.insert(0, str(ROOT / "toolchain"))
import leave_one_out_rival as rivals  # noqa: E402

HEAD = ("# voltlap\n# file 1\n"
        "file,time_s,counts,soc,current_a,voltage_v,model_v,error_v,temperature_c,model_temperature_c\n")


def run(*words, code=0, **environment):
    done = subprocess.run([sys.executable, ROOT / "toolchain/leave_one_out.py", *map(str, words)], capture_output=True,
                          text=True, timeout=1200, env={**os.environ, **environment})
    assert done.returncode == code, done.stdout + done.stderr
    return done


def circuit(path, pulse_s, temperature_c):
    """Rows of a known 2-RC circuit, as `validate` writes them: 2 and 1 mOhm, 12 and 300 s, R0 3 mOhm, 20 kJ/mol."""
    t = np.arange(0.0, 12 * (pulse_s + 400))
    i = np.where(np.mod(t, pulse_s + 400) < pulse_s, 30.0, 0.0)
    soc = 1 - np.cumsum(i) / np.sum(i)
    warm = np.exp(20e3 / 8.314462618 * (1 / (temperature_c + 273.15) - 1 / 298.15))
    v = 3.4 + 0.5 * soc - warm * 3e-3 * i
    for r, tau in ((2e-3, 12.0), (1e-3, 300.0)):
        u, out = 0.0, []
        for amps in i:
            u += (r * amps - u) * (1 - np.exp(-1 / tau))
            out.append(u)
        v = v - warm * np.array(out)
    with path.open("w") as file:
        file.write(HEAD)
        for k in range(len(t)):
            file.write(f"1,{t[k]},{int(i[k] > 0)},{soc[k]},{i[k]},{v[k]},{v[k] + 0.01},0.01,,25\n")
    return rivals.Rows(path, {"current_hold": "of each row held since the one before"}, temperature_c)


def test_the_rival_finds_a_known_circuit_and_predicts_it_elsewhere(tmp_path):
    seen = [circuit(tmp_path / "a.csv", 60, 25), circuit(tmp_path / "b.csv", 200, 10)]
    rival = rivals.Rival([(rows, rows.t >= 0) for rows in seen])
    assert rival.taus == pytest.approx([12, 300], rel=0.03)
    assert rival.facts()["resistance_mohm"] == pytest.approx([3, 2, 1], rel=0.02)
    unseen = circuit(tmp_path / "c.csv", 120, 40)
    assert unseen.rms_mv(rival.predicted(unseen), unseen.counts) < 0.2
    assert unseen.rms_mv(unseen.model, unseen.counts) == pytest.approx(10.0)


def test_the_rival_sees_only_what_it_is_given(tmp_path):
    rows = circuit(tmp_path / "a.csv", 60, 25)
    rows.v[rows.t > 3000] += 0.1
    rival = rivals.Rival([(rows, rows.t <= 3000)])
    assert rows.rms_mv(rival.predicted(rows), rows.counts & (rows.t < 3000)) < 0.5


def test_rows_and_columns_that_are_not_there_are_refused():
    folder = {"VOLTLAP_DATA": "/nowhere"}
    assert "expected a row" in run("--only", "leaf_3C", code=2, **folder).stderr
    assert "expected some of chosen" in run("--rungs", "best", code=2, **folder).stderr
    assert "VOLTLAP_DATA is not set" in run(code=2, VOLTLAP_DATA="").stderr


def test_a_number_that_is_not_there_is_said(tmp_path):
    tool = pathlib.Path(os.environ["VOLTLAP_BUILD_DIR"]) / "bin" / "voltlap"
    done = run("--voltlap", tool, "--only", "leaf_1C_pulses", "--rungs", "chosen", code=1, VOLTLAP_DATA=str(tmp_path))
    assert "| Leaf, 1C from the pulses alone | - |" in done.stdout
    assert "leave_one_out: leaf_1C_pulses, chosen: identify ended with" in done.stderr


@pytest.mark.skipif(not DATA, reason="VOLTLAP_DATA is not set: no measured recordings on this machine")
def test_two_rows_of_a_measured_cell(tmp_path):
    tool = pathlib.Path(os.environ["VOLTLAP_BUILD_DIR"]) / "bin" / "voltlap"
    run("--voltlap", tool, "--only", "leaf_1C_pulses", "--only", "leaf_2C_pulses", "--rungs", "chosen,rival",
        "--json", tmp_path / "rows.json")
    first, second = (row["rms_mv"] for row in json.loads((tmp_path / "rows.json").read_text())["rows"])
    assert 2.0 < first["chosen"] < 10.0 and 5.0 < second["chosen"] < 22.0
    assert 5.0 < first["rival"] < 15.0 and 15.0 < second["rival"] < 40.0  # weaker were no rival
