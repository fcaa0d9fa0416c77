# SPDX-License-Identifier: Apache-2.0
"""Recordings as they come from a test that went wrong: each a clear error, or a repair that is said."""
import json
import math
import os
import pathlib
import random
import re
import secrets
import subprocess

import pytest

BINARY = pathlib.Path(os.environ["VOLTLAP_BUILD_DIR"]) / "bin" / "voltlap"
HEADER = "time_s,current_a,voltage_v"
SIGN_DECLARED = """[roles]
time = {column = "time_s", unit = "s"}
current = {column = "current_a", unit = "A", discharge = "+"}
voltage = {column = "voltage_v", unit = "V"}
"""


def ocv(soc):
    return 3.2 + 0.9 * soc - 0.25 * math.exp(-20 * soc)


def recording(pulses=10, rest_s=300, pulse_s=360, capacity_ah=10.0):
    """Rows of time, current and voltage: a pulse of 1C for a tenth of the charge, a rest, and so on."""
    rows, soc, slow = [], 1.0, 0.0
    for current, seconds in [(0.0, 60), *[(10.0, pulse_s), (0.0, rest_s)] * pulses]:
        for _ in range(seconds):
            soc -= current / 3600 / capacity_ah
            slow += (0.01 * current - slow) / 60
            rows.append([float(len(rows)), current, ocv(soc) - 0.01 * current - slow])
    return rows


def without_rests():
    return [[float(k), i, v] for k, (_, i, v) in enumerate(row for row in recording() if row[1] > 0)]


def written(folder, rows, name="test.csv", header=HEADER):
    lines = [",".join(value if isinstance(value, str) else f"{value:.6f}" for value in row) for row in rows]
    (folder / name).write_text("\n".join([header, *lines, ""]))


def voltlap(folder, *arguments):
    return subprocess.run([BINARY, *map(str, arguments)], cwd=folder, capture_output=True, text=True, timeout=300)


def changed(*changes, **how):
    """A recording with some values replaced: (row, column, value)."""
    rows = recording(**how)
    for row, column, value in changes:
        rows[row][column] = value
    return rows


REPAIRS = {
    "duplicate time": (lambda: changed((500, 0, 499.0)), "1 rows that repeat a time left out"),
    "backward time": (lambda: changed((500, 0, 480.0)), "1 rows with a time that goes back left out"),
    "current that is not a number": (lambda: changed((500, 1, "nan")), "1 rows without a time or current left out"),
    "empty time": (lambda: changed((500, 0, "")), "1 rows without a time or current left out"),
    "voltage that is not a number": (lambda: changed((500, 2, "NaN"), (501, 2, "")),
                                     "2 rows without a voltage are not used"),
    "voltage of no cell": (lambda: changed((500, 2, 65.535)), "1 rows with a voltage of no cell are not used"),
    "voltage in mV": (lambda: [[t, i, 1000 * v] for t, i, v in recording()], "voltage is in mV"),
    "one impossible current": (lambda: changed((500, 1, 1e308)), "1 of 6660 rows have an impossible current"),
    "newest row first": (lambda: recording()[::-1], "rows sorted by time"),
    "charge positive": (lambda: [[t, -i, v] for t, i, v in recording()], "sign of the current turned"),
}


@pytest.mark.parametrize("case", REPAIRS)
@pytest.mark.parametrize("command", ["identify", "validate"])
def test_what_can_be_mended_is_mended_and_said(command, case, tmp_path):
    make, words = REPAIRS[case]
    written(tmp_path, recording(), "good.csv")
    written(tmp_path, make())
    found = []
    for name in ("good.csv", "test.csv"):
        cell = [] if command == "identify" else ["aesc_e5_2p"]
        run = voltlap(tmp_path, command, *cell, name, "--json", "out.json", *(["--rc", "1"] if not cell else []))
        assert run.returncode == 0, run.stderr
        found.append((run.stdout, json.loads((tmp_path / "out.json").read_text())))
    assert words not in found[0][0] and words in found[1][0]
    if command == "identify":
        assert found[1][1]["capacity_ah"] == pytest.approx(found[0][1]["capacity_ah"], rel=1e-3)
    else:
        assert found[1][1]["files"][0]["rms_v"] == pytest.approx(found[0][1]["files"][0]["rms_v"], rel=0.02)


ERRORS = {
    "no rest and one current": (lambda: without_rests(), ("a current of 10 A that never changes", "rests")),
    "no rest through a resistor": (lambda: [[t, 10 * v / 4.1, v] for t, _, v in without_rests()],
                                   ("no step of the current", "pulse")),
    "a single pulse": (lambda: recording(pulses=1), ("one pulse", "--ocv")),
    "no current": (lambda: [[t, 0.0, v] for t, _, v in recording()], ("no current",)),
    "voltage of a pack": (lambda: [[t, i, 28 * v] for t, i, v in recording()], ("--cells-in-series",)),
    "no voltage at all": (lambda: [[t, i, "nan"] for t, i, _ in recording()], ("voltage",)),
    "too few rows": (lambda: recording()[:5], ("usable rows",)),
    "ten rows with a step": (lambda: recording()[56:66], ("10 rows with a voltage", "at least 30 rows")),
    "milliamperes named amperes": (lambda: [[t, 1000 * i, v] for t, i, v in recording()],
                                   ("for each cell", "current_ma")),
    "no rows": (lambda: [], ("header line without rows",)),
    "row of another length": (lambda: changed((500, 2, "3.9,3.9")), ("test.csv:502",)),
}


@pytest.mark.parametrize("case", ERRORS)
def test_what_cannot_be_mended_is_refused_in_words(case, tmp_path):
    make, words = ERRORS[case]
    written(tmp_path, make())
    run = voltlap(tmp_path, "identify", "test.csv", "--out", "cell.toml")
    assert run.returncode == 2, run.stdout
    assert run.stderr.count("found") == 1 and "expected" in run.stderr and "test.csv" in run.stderr
    for word in words:
        assert word in run.stderr
    assert not (tmp_path / "cell.toml").exists()


def test_charge_where_discharge_was_declared_is_refused(tmp_path):
    written(tmp_path, [[t, -i, v] for t, i, v in recording()])
    (tmp_path / "map.toml").write_text(SIGN_DECLARED)
    for command in (["identify"], ["validate", "aesc_e5_2p"]):
        run = voltlap(tmp_path, *command, "--map", "map.toml", "test.csv")
        assert run.returncode == 2 and "discharge was declared" in run.stderr


@pytest.mark.parametrize("content, words", [("", "an empty file"), ("time_s,current_a,voltage_v\n", "without rows"),
                                            ("\x89PNG\r\n\x1a\n", "expected"), ("a,b,c\n1,2,3\n", "role map")])
def test_file_that_is_no_recording_is_refused(content, words, tmp_path):
    (tmp_path / "test.csv").write_text(content)
    for command in (["identify"], ["validate", "aesc_e5_2p"]):
        run = voltlap(tmp_path, *command, "test.csv")
        assert run.returncode == 2 and words in run.stderr and "test.csv" in run.stderr


def test_known_capacity_makes_a_single_pulse_enough(tmp_path):
    written(tmp_path, recording(), "whole.csv")
    written(tmp_path, recording(pulses=1))
    assert voltlap(tmp_path, "identify", "whole.csv", "--rc", "1", "--out", "whole.toml").returncode == 0
    run = voltlap(tmp_path, "identify", "test.csv", "--rc", "1", "--ocv", "whole.toml", "--json", "one.json")
    assert run.returncode == 0, run.stderr
    assert json.loads((tmp_path / "one.json").read_text())["capacity_ah"] == pytest.approx(10.0, rel=0.02)


def test_size_that_cannot_hold_the_capacity_is_refused_and_nothing_written(tmp_path):
    written(tmp_path, [[t, 6 * i, v] for t, i, v in recording()])
    run = voltlap(tmp_path, "identify", "test.csv", "--rc", "1", "--size", "18650", "--out", "cell.toml")
    assert run.returncode == 2 and "Wh/L" in run.stderr and not (tmp_path / "cell.toml").exists()


@pytest.mark.parametrize("draw", range(4))
def test_a_capacity_that_the_recording_contradicts_is_refused_and_one_that_it_may_have_is_not(draw, tmp_path):
    seed = secrets.randbits(32)
    drawn = random.Random(seed)
    written(tmp_path, [[t, i, v + 0.1] for t, i, v in recording()])  # 10 Ah, from 4.2 V to empty
    for told in (drawn.uniform(1.0, 7.6), drawn.uniform(26.0, 200.0)):
        run = voltlap(tmp_path, "identify", "test.csv", "--capacity", told, "--out", "cell.toml", "--rc", "1")
        assert run.returncode == 2 and "Correct" in run.stderr and "--capacity" in run.stderr, f"seed {seed}: {run}"
        assert not (tmp_path / "cell.toml").exists()
    told = drawn.uniform(10.0, 12.0)
    run = voltlap(tmp_path, "identify", "test.csv", "--capacity", told, "--out", "cell.toml", "--rc", "1")
    assert run.returncode == 0, f"seed {seed}: {run.stderr}"


@pytest.mark.parametrize("draw", range(4))
def test_braking_pushes_a_cell_higher_than_its_full_charge_and_the_charge_is_full_all_the_same(draw, tmp_path):
    seed = secrets.randbits(32)
    drawn = random.Random(seed)
    rows, soc, slow, at = [], drawn.uniform(0.0, 0.03), 0.0, 0.0

    def go(current, seconds, step):
        nonlocal soc, slow, at
        for _ in range(int(seconds / step)):
            soc -= current * step / 36000
            slow += (0.01 * current - slow) * (1 - math.exp(-step / 60))
            at += step
            rows.append([at, current, ocv(soc) - 0.01 * current - slow])

    begin = soc
    go(0.0, 300, 10)
    go(-1.0, (1.0 - begin) * 36000, 20)  # C/10
    go(0.0, 900, 10)
    for _ in range(drawn.randrange(30, 60)):
        go(drawn.uniform(20.0, 40.0), 20, 1)
        go(-drawn.uniform(20.0, 30.0), 10, 1)
    assert max(row[2] for row in rows) > ocv(1.0) + 0.1
    written(tmp_path, rows)
    run = voltlap(tmp_path, "identify", "test.csv", "--out", "cell.toml", "--rc", "1")
    assert run.returncode == 0, f"seed {seed}: {run.stderr}"
    found = re.search(r"capacity +([0-9.]+) Ah +measured", run.stdout)
    assert found and float(found[1]) == pytest.approx(10.0 * (1.0 - begin), rel=0.01), f"seed {seed}: {run.stdout}"


@pytest.mark.parametrize("draw", range(3))
def test_a_recording_of_another_cell_is_not_validated_and_a_told_temperature_that_is_not_used_is_named(draw, tmp_path):
    seed = secrets.randbits(32)
    drawn = random.Random(seed)
    rows = [[t, i, v + 0.1] for t, i, v in recording()]
    written(tmp_path, [[*row, 24.0] for row in rows], header=HEADER + ",temperature_c")
    told = drawn.choice([drawn.uniform(-20.0, 18.0), drawn.uniform(30.0, 60.0)])
    made = voltlap(tmp_path, "identify", f"--temperature={told}", "test.csv", "--out", "cell.toml", "--rc", "1")
    assert made.returncode == 0 and "is not used: the recording has its own, 24.0 degC" in made.stdout, f"seed {seed}"
    times = drawn.uniform(4.0, 12.0)
    written(tmp_path, [[t, times * i, v] for t, i, v in rows], "other.csv")
    run = voltlap(tmp_path, "validate", "cell.toml", "other.csv", "--json", "out.json")
    assert run.returncode == 2 and "other.csv" in run.stderr, f"seed {seed}: {run.stdout}"
    assert "Ah moved by a cell of" in run.stderr and "--cells-in-parallel" in run.stderr
    assert not (tmp_path / "out.json").exists()
    assert voltlap(tmp_path, "validate", "cell.toml", "test.csv").returncode == 0


@pytest.mark.parametrize("draw", range(6))
def test_a_capacity_a_little_too_small_is_refused_or_makes_a_file_that_follows(draw, tmp_path):
    seed = secrets.randbits(32)
    drawn = random.Random(seed)
    rows, knee, deep = recording(), drawn.uniform(0.03, 0.1), drawn.uniform(0.0, 0.8)
    left = 10.0
    for row in rows:
        left -= row[1] / 3600
        row[2] += 0.1 - deep * max(0.0, 1.0 - left / 10.0 / knee)
    written(tmp_path, rows)
    run = voltlap(tmp_path, "identify", "test.csv", "--capacity", drawn.uniform(7.8, 9.6), "--out", "cell.toml", "--rc",
                  "1")
    if run.returncode == 0:
        missed = [float(one) for one in re.findall(r"RMS ([0-9.]+) mV over all rows", run.stdout)]
        assert missed and max(missed) < 60.0, f"seed {seed}: {run.stdout}"
        return
    assert run.returncode == 2 and "a state of charge from" in run.stderr, f"seed {seed}: {run.stderr}"
    assert "--capacity" in run.stderr and not (tmp_path / "cell.toml").exists()
