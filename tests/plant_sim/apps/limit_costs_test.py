# SPDX-License-Identifier: Apache-2.0
"""What limits cost: exactly the difference of two runs that a person makes by hand."""
import json
import os
import pathlib
import random
import subprocess

import pytest

BUILD = pathlib.Path(os.environ["VOLTLAP_BUILD_DIR"])
TIGHT = ["bms.discharge_current_max_a=90", "master.power_max_kw=8.6"]


def endurance(folder, settings, *flags):
    sets = [word for setting in settings for word in ("--set", setting)]
    done = subprocess.run([BUILD / "bin" / "voltlap", "endurance", "--laps", "2", "--json", "run.json", *sets, *flags],
                          cwd=folder, capture_output=True, text=True, timeout=300)
    return done, json.loads((folder / "run.json").read_text())


def lifted_settings(row):
    return [f"{lifted['key']}={lifted['value']}" for lifted in row["lifted"]]


def test_cost_is_the_difference_of_two_runs_by_hand(tmp_path):
    seed = random.randrange(1 << 30)
    draw = random.Random(seed)
    settings = [f"bms.discharge_current_max_a={draw.randrange(70, 110)}", f"master.power_max_kw={draw.randrange(6, 9)}",
                f"battery.initial_soc={draw.uniform(0.5, 1.0):.3f}"]
    _, run = endurance(tmp_path, settings, "--limit-costs")
    reasons = [row["reason"] for row in run["limit_costs"]]
    assert reasons and (len(reasons) == 1 or reasons[-1] == "all"), f"seed {seed}: {settings} gives {reasons}"
    for row in run["limit_costs"]:
        _, without = endurance(tmp_path, settings + lifted_settings(row))
        found = (row["time_s"], row["soc_points"])
        by_hand = (run["total_time_s"] - without["total_time_s"], run["end_soc_pct"] - without["end_soc_pct"])
        assert found == by_hand, f"seed {seed}: {settings}, {row}"


def test_every_limit_that_bound_has_a_row_and_all_together_one_more(tmp_path):
    done, run = endurance(tmp_path, TIGHT, "--limit-costs")
    bound = {reason for reason, seconds in run["limit_active_s"].items() if seconds >= 0.5}
    assert len(bound) > 1
    assert {row["reason"] for row in run["limit_costs"]} == bound | {"all"}
    for row in run["limit_costs"]:
        assert f"    {row['reason']} " in done.stdout
        said = done.stdout.split(f"    {row['reason']} ")[1].split("\n")
        faster = f"{abs(row['time_s']):.2f} s {'slower' if row['time_s'] < 0 else 'faster'}"
        charge = f"{abs(row['soc_points']):.2f} points of SOC {'more' if row['soc_points'] < 0 else 'less'}"
        assert f"lifted, the race is {faster} and ends with {charge}" in said[0]
        for lifted in row["lifted"] if row["reason"] != "all" else []:
            assert f"{lifted['key']} {lifted['from']:.4g} -> {lifted['value']:.4g}" in said[1]


def test_the_ceiling_of_the_rules_says_from_what_to_what_it_is_raised(tmp_path):
    done, run = endurance(tmp_path, ["master.power_max_kw=8.6"], "--limit-costs")
    (row,) = run["limit_costs"]
    assert "master.power_max_kw 8.6 -> 80 kW (EV.3.3 allows no more)" in done.stdout
    # Lifting a limit wins time and costs charge: this is what the sentence says.
    assert row["time_s"] > 0 and "s faster" in done.stdout


def test_run_that_fails_without_the_limit_says_of_what(tmp_path):
    done, run = endurance(tmp_path, ["bms.soc_derating_start=0.5", "battery.initial_soc=0.04"], "--limit-costs")
    (row,) = run["limit_costs"]
    assert row["reason"] == "soc_low" and row["time_s"] is None and row["soc_points"] is None
    assert "is empty" in row["failure"]
    assert f"without it the run fails: {row['failure']}" in done.stdout


def test_without_a_limit_nothing_costs(tmp_path):
    done, run = endurance(tmp_path, [], "--limit-costs")
    assert run["limit_costs"] == [] and "no limit cost anything" in done.stdout


def test_nobody_asked(tmp_path):
    done, run = endurance(tmp_path, TIGHT)
    assert run["limit_costs"] is None and "limits cost" not in done.stdout


def test_report_has_the_table_and_the_run_itself_is_the_same(tmp_path):
    _, plain = endurance(tmp_path, TIGHT)
    _, reported = endurance(tmp_path, TIGHT, "--report", "run.html")
    page = (tmp_path / "run.html").read_text()
    assert "What the limits cost" in page and "master.power_max_kw 8.6 -&gt; 80 kW" in page
    assert plain["trace_hash"] == reported["trace_hash"]


@pytest.mark.parametrize("flags", [["--bus", "vcan9"]])
def test_not_on_an_interface(tmp_path, flags):
    done = subprocess.run([BUILD / "bin" / "voltlap", "endurance", "--limit-costs", *flags], cwd=tmp_path,
                          capture_output=True, text=True, timeout=60)
    assert done.returncode == 2 and "--limit-costs" in done.stderr
