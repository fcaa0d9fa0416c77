# SPDX-License-Identifier: Apache-2.0
"""voltlap limit-test as its users meet it: states with their marks, what is written, messages for bad input."""
import json
import os
import pathlib
import subprocess

import pytest

BUILD = pathlib.Path(os.environ["VOLTLAP_BUILD_DIR"])


def limit_test(*arguments):
    return subprocess.run([BUILD / "bin" / "voltlap-learn", "limit-test", *map(str, arguments)], capture_output=True,
                          text=True, timeout=600)


@pytest.fixture(scope="module")
def some_states(tmp_path_factory):
    path = tmp_path_factory.mktemp("limits") / "limits.json"
    run = limit_test("--states", 60, "--seed", 8, "--only", "states", "--json", path)
    assert run.returncode == 0, run.stderr
    return run.stdout, json.loads(path.read_text())


def ends(result, method, horizon):
    return [m[method]["inside_v"] for m in result["moments"]
            if m["direction"] == "discharge" and m["horizon_s"] == horizon and m[method]["by_voltage"]
            and m[method]["limit_a"] > 1]


def test_every_state_is_asked_in_both_directions_for_each_horizon(some_states):
    text, result = some_states
    assert result["states"] == 60 and len(result["moments"]) == 360 and result["races"] == []
    assert "60 states of drawn drives (seed 8)" in text
    for name in ("ahead", "equation", "table", "discharge, 10 s", "charge, 30 s"):
        assert name in text


def test_a_limit_that_looks_ahead_ends_at_the_bound(some_states):
    result = some_states[1]
    assert result["bisection_off_at_most"] < 0.005
    for horizon in (1.0, 10.0, 30.0):
        ahead = ends(result, "ahead", horizon)
        assert len(ahead) >= 10
        assert -0.020 < min(ahead) and max(ahead) < 0.030, (horizon, min(ahead), max(ahead))


def test_the_equation_is_far_off_where_cells_have_aged(some_states):
    equation = ends(some_states[1], "equation", 10.0)
    assert min(equation) < -0.1 or max(equation) > 0.1


def test_the_same_seed_gives_the_same_states(some_states, tmp_path):
    again = limit_test("--states", 60, "--seed", 8, "--only", "states", "--json", tmp_path / "again.json")
    assert again.returncode == 0 and json.loads((tmp_path / "again.json").read_text()) == some_states[1]


@pytest.mark.parametrize("arguments, words", [
    (["--states", "0"], ["--states", "0"]),
    (["--only", "nothing"], ["--only", "nothing"]),
    (["--vehicle", "nowhere"], ["nowhere"]),
    (["--set", "bms.limit_horizon_s=2"], ["bms.limit_horizon_s", "1, 10 or 30 s"]),
    (["--only", "states", "--set", "battery.initial_soc=0.5"], ["battery.initial_soc", "Leave it out"]),
    (["--only", "races", "--set", "bms.limit_method=table"], ["bms.limit_method", "Leave it out"]),
    (["--set", "bms.cell_voltage_min_v=3"], ["bms.cell_voltage_min_v", "Leave it out"]),
    (["--json", "/nowhere/limits.json"], ["/nowhere"]),
])
def test_bad_input_is_named(arguments, words):
    run = limit_test(*arguments)
    assert run.returncode == 2 and run.stdout == ""
    for word in words:
        assert word in run.stderr


def test_a_limit_that_looks_ahead_needs_a_filter():
    run = subprocess.run([BUILD / "bin" / "voltlap", "endurance", "--set", "bms.limit_method=ahead"],
                         capture_output=True, text=True, timeout=60)
    assert run.returncode == 2
    for word in ("bms.limit_method", "bms.soc_method", "ekf"):
        assert word in run.stderr


def test_it_explains_itself():
    run = limit_test("--help")
    assert run.returncode == 0
    for word in ("--states", "--seed", "--only", "--json", "Exit code"):
        assert word in run.stdout
