# SPDX-License-Identifier: Apache-2.0
"""A folder of logs against what the firmware made of them once (golden/): whatever the firmware says otherwise by
now is a readable difference. `python tests/plant_sim/replay/season_test.py --renew`, with VOLTLAP_BUILD_DIR set,
writes them anew: look at the difference first.
"""
import json
import os
import shutil
import sys
import tempfile
from pathlib import Path

import pytest
from straight_pack import MAP, PACK, current_at, rows, voltlap

GOLDEN = Path(__file__).resolve().parent / "golden"


def weak(table):
    return (dict(row, cell_voltage_5_v=row["cell_voltage_5_v"] - 0.08) for row in table)


def current_lost(table):
    return (dict(row, current_a=None) if 8.0 <= row["time_s"] < 9.0 else row for row in table)


def hot(table):
    return (dict(row, temperature_1_c=45.0 + row["time_s"]) for row in table)


LOGS = {
    "sound.csv": lambda: rows(30),
    "spring/weak_cell.csv": lambda: weak(rows(20, soc=0.40)),
    "spring/current_lost.csv": lambda: current_lost(rows(25)),
    "autumn/hot.csv": lambda: hot(rows(25, soc=0.6)),
    "autumn/in_mid_drive.csv": lambda: rows(20, current=lambda time: current_at(time) + 30.0),
}


def season(folder):
    """Map and pack beside the folder of logs; a file that is no log is in it, too."""
    (folder / "map.toml").write_text(MAP)
    (folder / "pack.toml").write_text(PACK)
    logs = folder / "logs"
    for name, table in LOGS.items():
        path = logs / name
        path.parent.mkdir(parents=True, exist_ok=True)
        table = list(table())
        lines = [",".join("" if value is None else f"{value:.5f}" for value in row.values()) for row in table]
        path.write_text("\n".join([",".join(table[0])] + lines) + "\n")
    (logs / "notes.md").write_text("spring was cold\n")
    return logs


def replayed(logs, *arguments):
    beside = logs.parent
    return voltlap("replay", logs, "--map", beside / "map.toml", "--pack", beside / "pack.toml", *arguments)


@pytest.fixture(scope="module")
def logs(tmp_path_factory):
    return season(tmp_path_factory.mktemp("season"))


def test_the_firmware_says_what_it_said(logs):
    run = replayed(logs, "--baseline", GOLDEN)
    assert run.returncode == 0, f"{run.stdout}{run.stderr}\nIf that is meant: {__doc__.split('.')[1]}"
    assert "5 logs: 5 replayed, 0 refused; 0 changed, 0 new, 0 gone" in run.stdout


PLANTED = [
    ("bms.discharge_current_max_a=60", ["sound.csv", "over_limits: new, discharge, ConfigMaximum", "of 150 points"]),
    ("bms.cell_voltage_min_v=3.2", ["spring/weak_cell.csv", "limit_violations, ", "limit_v 3.1 -> 3.2"]),
    ("bms.cell_voltage_min_v=3.0", ["spring/weak_cell.csv", "limit_violations: gone, ", "cell 5"]),
    ("bms.capacity_ah=8", ["soc_end_pct: ", " -> ", "series/soc_pct: differs in"]),
]


@pytest.mark.parametrize("setting, words", PLANTED)
def test_a_planted_change_is_seen_and_read(logs, setting, words):
    run = replayed(logs, "--baseline", GOLDEN, "--set", setting)
    assert run.returncode == 1
    assert [word for word in words if word not in run.stdout] == [], run.stdout


def test_each_log_has_its_file_and_none_is_lost(logs, tmp_path):
    run = replayed(logs, "--json", tmp_path / "out")
    assert run.returncode == 0, run.stderr
    written = {str(path.relative_to(tmp_path / "out")) for path in (tmp_path / "out").rglob("*") if path.is_file()}
    assert written == {f"{name}.json" for name in LOGS}
    assert "notes.md" not in run.stdout


def test_new_and_gone_and_refused_logs_are_told(logs, tmp_path):
    mine, baseline = tmp_path / "logs", tmp_path / "baseline"
    shutil.copytree(logs, mine)
    shutil.copytree(GOLDEN, baseline)
    for name in ("map.toml", "pack.toml"):
        shutil.copy(logs.parent / name, tmp_path / name)
    (mine / "sound.csv").rename(mine / "renamed.csv")
    (mine / "autumn/hot.csv").write_text("time_s,other\n0,1\n1,2\n")
    run = replayed(mine, "--baseline", baseline)
    assert run.returncode == 1
    assert "renamed.csv" in run.stdout and "new: the baseline has no renamed.csv.json" in run.stdout
    assert "sound.csv: gone, the baseline has it" in run.stdout
    assert "autumn/hot.csv: refused: " in run.stdout and "it was replayed before" in run.stdout
    assert "5 logs: 4 replayed, 1 refused; 1 changed, 1 new, 1 gone" in run.stdout
    earlier = tmp_path / "out/autumn/hot.csv.json"
    earlier.parent.mkdir(parents=True)
    earlier.write_text("{}")
    again = replayed(mine, "--json", tmp_path / "out")
    assert f"{earlier} is the result of an earlier run" in again.stdout, again.stdout


def test_a_baseline_of_another_recording_is_said(logs, tmp_path):
    mine = tmp_path / "logs"
    shutil.copytree(logs, mine)
    for name in ("map.toml", "pack.toml"):
        shutil.copy(logs.parent / name, tmp_path / name)
    lines = (mine / "sound.csv").read_text().splitlines()
    (mine / "sound.csv").write_text("\n".join(lines[:-200]) + "\n")
    run = replayed(mine, "--baseline", GOLDEN)
    assert run.returncode == 1 and run.stdout.count("the baseline is of another recording") == 1, run.stdout


def test_what_has_one_answer_a_log_is_refused_of_a_folder(logs, tmp_path):
    for flag in (("--csv", tmp_path / "a.csv"), ("--report", tmp_path / "a.html"), ("--what-if", "bms.capacity_ah=8")):
        run = replayed(logs, *flag)
        assert run.returncode == 2 and "a folder" in run.stderr and flag[0] in run.stderr, run.stderr
    empty = tmp_path / "empty"
    empty.mkdir()
    run = voltlap("replay", empty)
    assert run.returncode == 2 and "no log" in run.stderr


def test_what_if_stands_beside_in_the_report(logs, tmp_path):
    page = tmp_path / "a.html"
    run = voltlap("replay", logs / "sound.csv", "--map", logs.parent / "map.toml", "--pack", logs.parent / "pack.toml",
                  "--what-if", "bms.capacity_ah=8", "--report", page)
    assert run.returncode == 0, run.stderr
    assert "Changed since the run without it" in run.stdout and "soc_end_pct: " in run.stdout
    assert "with bms.capacity_ah=8" in page.read_text() and "soc_end_pct: " in page.read_text()


def test_one_file_for_two_results_is_refused_by_whatever_spelling(logs, tmp_path):
    run = voltlap("replay", logs / "sound.csv", "--map", logs.parent / "map.toml", "--json", tmp_path / "a.out",
                  "--report", f"{tmp_path}/./b/../a.out")
    assert run.returncode == 2 and "one file for two" in run.stderr and not (tmp_path / "a.out").exists()


def test_a_folder_that_links_to_itself_is_walked_once(logs, tmp_path):
    mine = tmp_path / "logs"
    shutil.copytree(logs, mine)
    (mine / "again").symlink_to(mine)
    (mine / "itself").symlink_to(mine / "itself")
    for name in ("map.toml", "pack.toml"):
        shutil.copy(logs.parent / name, tmp_path / name)
    run = replayed(mine, "--baseline", GOLDEN)
    assert run.returncode == 0 and "5 logs: 5 replayed" in run.stdout, run.stdout + run.stderr
    gone = replayed(mine, "--baseline", tmp_path / "nowhere")
    assert gone.returncode == 2 and "no folder" in gone.stderr and gone.stdout == ""


def test_firmware_of_no_commit_is_refused(logs):
    run = voltlap("replay", logs / "sound.csv", "--map", logs.parent / "map.toml", "--firmware", "nowhere")
    assert run.returncode == 2 and "--firmware nowhere" in run.stderr, run.stderr


def renew():
    with tempfile.TemporaryDirectory() as folder:
        shutil.rmtree(GOLDEN, ignore_errors=True)
        run = replayed(season(Path(folder)), "--json", GOLDEN)
    print(run.stdout, run.stderr)
    for path in GOLDEN.rglob("*.json"):
        result = json.loads(path.read_text())
        result.update(log=path.stem, map="map.toml", pack="pack.toml")
        path.write_text(json.dumps(result, indent=1) + "\n")
    return run.returncode


if __name__ == "__main__":
    assert sys.argv[1:] == ["--renew"] and os.environ["VOLTLAP_BUILD_DIR"], __doc__
    sys.exit(renew())
