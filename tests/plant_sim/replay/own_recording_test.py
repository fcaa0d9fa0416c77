# SPDX-License-Identifier: Apache-2.0
"""A candump of our own endurance, replayed: the same frames of BMS and master controller, byte for byte; and whatever
is not the same is found where it is."""
import json
import os
import subprocess
from pathlib import Path

import pytest

BUILD = Path(os.environ["VOLTLAP_BUILD_DIR"])


def voltlap(*arguments):
    return subprocess.run([BUILD / "bin/voltlap", *map(str, arguments)], capture_output=True, text=True, timeout=300)


@pytest.fixture(scope="module")
def race(tmp_path_factory):
    """A lap with a tight limit, so that the limits move."""
    log = tmp_path_factory.mktemp("race") / "race.log"
    run = voltlap("endurance", "--laps", 1, "--set", "bms.discharge_current_max_a=120", "--candump", log)
    assert run.returncode == 0, run.stderr
    return log


def replayed(log, folder, *arguments):
    out = folder / "replay.json"
    run = voltlap("replay", log, "--set", "bms.discharge_current_max_a=120", *arguments, "--json", out)
    return run, json.loads(out.read_text())


def changed(race, folder, change):
    """The lines of the race after `change(lines)`."""
    lines = race.read_text().splitlines()
    log = folder / "changed.log"
    log.write_text("\n".join(change(lines)) + "\n")
    return log


def place_of(lines, time, identifier):
    return next(k for k, line in enumerate(lines) if line.startswith(f"({time:.6f}) vcan0 {identifier}#"))


def test_both_nodes_answer_byte_for_byte(race, tmp_path):
    run, out = replayed(race, tmp_path)
    assert run.returncode == 0, run.stdout
    assert "byte for byte" in run.stdout
    lines = race.read_text().splitlines()
    sent = {"bms": ("036#", "0A0#", "0C0#", "0C1#", "6B0#", "6B1#"), "master": ("0A1#", "0C2#")}
    for node, identifiers in sent.items():
        count = sum(line.split()[2].startswith(identifiers) for line in lines)
        assert count > 5000
        assert out["comparison"][node] == {"recorded": count, "same": count, "different": 0, "missing": 0, "extra": 0}


def test_no_frame_goes_uncounted(race, tmp_path):
    log = changed(race, tmp_path, lambda lines: lines + ["(90.000000) vcan0 7A0#0102", "no frame at all"])
    _, out = replayed(log, tmp_path)
    verdicts = out["frames_by_verdict"]
    assert out["frames"] == sum(verdicts.values()) == len(race.read_text().splitlines()) + 2
    assert (verdicts["ignored"], verdicts["corrupt"]) == (1, 1)
    assert verdicts["stale"] < 30  # the first frame of each message


def test_a_bit_of_an_answer_is_found_where_it_is(race, tmp_path):
    def flip(lines):
        at = place_of(lines, 30.0, "0C0")
        return lines[:at] + [lines[at][:-6] + "FFFFFF"] + lines[at + 1:]

    run, out = replayed(changed(race, tmp_path, flip), tmp_path)
    assert run.returncode == 1
    first = out["comparison"]["first_difference"]
    assert (first["time_s"], first["message"], first["node"]) == (pytest.approx(30.0), "BmsLimits", "BMS")
    assert first["recorded"].endswith("FFFFFF")
    assert out["comparison"]["bms"]["different"] == 1
    assert "first difference at 30.000 s, BmsLimits of the BMS" in run.stdout


def test_another_sensor_frame_gives_another_answer(race, tmp_path):
    """Negative control: the nodes live from the frames of the plant."""
    def drop(lines):
        return [line for line in lines if not (line.startswith("(40.") and " 0B0#" in line)]

    run, out = replayed(changed(race, tmp_path, drop), tmp_path)
    assert run.returncode == 1
    assert out["comparison"]["first_difference"]["time_s"] == pytest.approx(40.05, abs=0.051)
    assert "CurrentMeasurementLost" in {fault["id"] for fault in out["faults"]}


def test_another_configuration_gives_another_answer(race, tmp_path):
    run = voltlap("replay", race)
    assert run.returncode == 1
    assert "first difference" in run.stdout
    assert "--set those of the run" in run.stdout


def test_what_the_firmware_says_stands_beside_what_it_said_then(race, tmp_path):
    run, out = replayed(race, tmp_path, "--csv", tmp_path / "rows.csv")
    assert out["soc_end_pct"] == out["soc_logged_end_pct"] < out["soc_start_pct"]
    rows = (tmp_path / "rows.csv").read_text().splitlines()
    assert len(rows) - 1 == pytest.approx(10 * out["duration_s"], abs=2)
    assert out["faults"] == [] and out["limit_violations"] == []


def test_a_log_that_begins_later_is_told_so(race, tmp_path):
    run, out = replayed(changed(race, tmp_path, lambda lines: lines[5000:]), tmp_path)
    assert run.returncode == 1
    assert "does the log begin at power-on?" in run.stdout
