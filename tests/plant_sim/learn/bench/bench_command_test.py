# SPDX-License-Identifier: Apache-2.0
"""voltlap bench-test as its users meet it: a rehearsal, a campaign on disk, messages."""
import csv
import gzip
import json
import os
import pathlib
import subprocess

import pytest

BINARY = pathlib.Path(os.environ["VOLTLAP_BUILD_DIR"]) / "bin" / "voltlap"
BRIEF = ("random_resistors", "--set", "load.resistors=[4, 2]")


def bench(*arguments, folder=None):
    return subprocess.run([BINARY, "bench-test", *map(str, arguments)], cwd=folder, capture_output=True, text=True,
                          timeout=300)


def test_dry_run_tells_duration_and_coverage_and_writes_nothing(tmp_path):
    run = bench("pulse_15", "--cell", "aesc_e5_2p", "--dry-run", "--out", "data", folder=tmp_path)
    assert run.returncode == 0, run.stderr
    assert "Plan pulse_15: 15 tests" in run.stdout and "on the bench" in run.stdout
    assert "days with 14 h of charge and rest" in run.stdout
    assert "nodes visited" in run.stdout and "time constants" in run.stdout
    assert "On the bench, seed" not in run.stdout
    assert list(tmp_path.iterdir()) == []


def test_dry_run_gives_its_forecast_as_json(tmp_path):
    assert bench("hppc", "--dry-run", "--json", tmp_path / "f.json").returncode == 0
    result = json.loads((tmp_path / "f.json").read_text())
    assert result["tests"] == []
    assert len(result["forecast"]["tests"]) == 1
    assert result["forecast"]["bench_s"] == pytest.approx(result["forecast"]["tests"][0]["duration_s"])


def test_forecast_stands_before_the_result():
    run = bench(*BRIEF)
    assert run.stdout.index("Plan random_resistors") < run.stdout.index("On the bench, seed 1")
    assert "nothing was written" in run.stdout


def test_campaign_is_on_disk_with_the_index(tmp_path):
    run = bench(*BRIEF, "--out", tmp_path / "data", "--gz", "--truth", tmp_path / "truth.csv.gz",
                "--json", tmp_path / "i.json")
    assert run.returncode == 0, run.stderr
    index = json.loads((tmp_path / "data" / "campaign.json").read_text())
    assert index == json.loads((tmp_path / "i.json").read_text())
    for name in index["tests"][0]["files"]:
        with gzip.open(tmp_path / "data" / name, "rt") as lines:
            rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
        assert list(rows[0]) == ["time_s", "current_a", "voltage_v", "temperature_c", "ambient_c"]
        assert len(rows) == int(index["tests"][0]["duration_s"])
    with gzip.open(tmp_path / "truth.csv.gz", "rt") as lines:
        assert next(lines).startswith("# voltlap") and next(lines).startswith("test,time_s,current_a,cell_1_voltage_v")


def test_same_seed_same_files_and_another_seed_other_noise(tmp_path):
    for folder, seed in (("a", 1), ("b", 1), ("c", 2)):
        assert bench(*BRIEF, "--seed", seed, "--out", tmp_path / folder).returncode == 0
    table = lambda folder: (tmp_path / folder / "30c_random_cell1.csv").read_text()
    assert table("a") == table("b") != table("c")
    assert (tmp_path / "a" / "campaign.json").read_text() == (tmp_path / "b" / "campaign.json").read_text()


def test_cell_may_be_a_file_and_its_keys_be_set(tmp_path):
    source = pathlib.Path(__file__).resolve().parents[4] / "plant_sim" / "data" / "cells" / "aesc_e5_2p.toml"
    (tmp_path / "mine.toml").write_text(source.read_text().replace('"aesc_e5_2p"', '"mine"'))
    run = bench("pulse_15", "--dry-run", "--cell", "mine.toml", "--set", "cell.capacity_ah=27.6", "test.current_a=100",
                "test.temperature_c=30", folder=tmp_path)
    assert run.returncode == 0, run.stderr
    assert "4 cells mine in series" in run.stdout
    assert "29." in run.stdout.split("30c_100a")[1].splitlines()[0]


@pytest.mark.parametrize("arguments, parts", [
    ((), ("plan: found no plan", "hppc, pulse_15")),
    (("pulse_16",), ("plan", "pulse_15")),
    (("pulse_15", "--cell", "leaf"), ("--cell", "leaf", "aesc_e5_2p")),
    (("pulse_15", "--set", "test.current_a=900"), ("--set test.current_a", "900 A", "507 A")),
    (("pulse_15", "--set", "cell.capacity_ah=-1"), ("cell.capacity_ah", "-1", "0.1 to 1000")),
    (("pulse_15", "--dry-run", "--truth", "t.csv"), ("--truth", "dry run")),
    (("pulse_15", "--json", "x", "--truth", "x"), ("--json, --truth", "a file for each")),
    (("pulse_15", "--dry-run", "--json", "gone/x.json"), ("gone/x.json", "an existing folder")),
])
def test_bad_command_lines_say_what_is_wrong(tmp_path, arguments, parts):
    run = bench(*arguments, folder=tmp_path)
    assert run.returncode == 2
    assert [part for part in parts if part not in run.stderr] == [], run.stderr
    assert list(tmp_path.iterdir()) == []


def test_fifteen_tests_take_seconds():
    begin = os.times().children_user
    assert bench("pulse_15").returncode == 0
    assert os.times().children_user - begin < 30  # of processor time; about 1 s
