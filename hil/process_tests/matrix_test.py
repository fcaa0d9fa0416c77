# SPDX-License-Identifier: Apache-2.0
"""The fault matrix is driven whole, and docs/fault_matrix.md says what comes of it."""
import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

PROJECT = Path(__file__).resolve().parents[2]
FAULTS = [sys.executable, str(PROJECT / "hil" / "faults.py")]
DOCUMENT = PROJECT / "docs" / "fault_matrix.md"
TICK_MS = 10.0


def voltlap_faults(*arguments):
    return subprocess.run([*FAULTS, *map(str, arguments)], capture_output=True, text=True, timeout=900)


@pytest.fixture(scope="module")
def measured(tmp_path_factory):
    folder = tmp_path_factory.mktemp("faults")
    done = voltlap_faults("--json", folder / "rows.json", "--report", folder / "rows.html")
    rows = json.loads((folder / "rows.json").read_text())
    return done, rows, (folder / "rows.html").read_text()


def documented():
    """id -> (cells of its row)."""
    rows = [line.strip("| \n").split(" | ") for line in DOCUMENT.read_text().splitlines() if line.startswith("| ")]
    return {c[0]: c for c in rows if re.fullmatch(r"[a-z0-9_]+", c[0]) and len(c) == 8 and c[0] != "row"}


def numbers(text):
    return [float(n) for n in re.findall(r"\d+(?:\.\d+)?", text)]


def test_no_row_fails_that_is_not_known_to(measured):
    done, rows, _ = measured
    bad = {row["id"]: [r for r in row["results"] if not r["held"]] + [row["sound_car"], row["error"]]
           for row in rows["rows"] if row["verdict"] == "failed"}
    assert bad == {}
    assert len(rows["rows"]) >= 120
    assert done.returncode == (1 if any(row["verdict"] == "known" for row in rows["rows"]) else 0), done.stderr


def test_a_known_failure_still_fails_and_has_its_reason(measured):
    known = [row for row in measured[1]["rows"] if row["known"]]
    assert [row["id"] for row in known if row["verdict"] != "known"] == [], "it passes: take `known` off the row"


def test_the_document_has_every_row_with_its_times_to_a_tick(measured):
    """Written by `./voltlap faults --report docs/fault_matrix.md`."""
    told = documented()
    assert sorted(told) == sorted(row["id"] for row in measured[1]["rows"])
    for row in measured[1]["rows"]:
        cells = told[row["id"]]
        assert cells[1] == row["what"]
        assert cells[2] == ", ".join([*row["rule"], *row["proves"]])
        assert cells[7] == row["verdict"]
        for cell, took, bound in ((cells[3], row["seen_ms"], "seen"),
                                  (cells[4], row["torque_zero_ms"], "torque_zero_within"),
                                  (cells[5], row["contactors_open_ms"], "contactors_open_within")):
            if bound not in row["bounds_ms"]:
                assert cell == ""
                continue
            expected = [*([] if took is None else [took]), float(row["bounds_ms"][bound])]
            assert numbers(cell)[-1] == expected[-1]
            assert len(numbers(cell)) == len(expected)
            assert abs(numbers(cell)[0] - expected[0]) <= TICK_MS, row["id"]


def test_the_page_stands_alone_and_has_every_row(measured):
    _, rows, page = measured
    assert all(f'class="id">{row["id"]};' in page for row in rows["rows"])
    assert "prefers-color-scheme: dark" in page and "<svg" in page
    assert not re.search(r"(?:src|href)=|url\(", page)


def test_a_seed_repeats_what_is_drawn(tmp_path):
    times = []
    for seed in (7, 7):
        voltlap_faults("--row", "apps1_noise_large", "--row", "all_loss_2", "--seed", seed, "--jobs", 1,
                       "--json", tmp_path / "a.json")
        rows = json.loads((tmp_path / "a.json").read_text())["rows"]
        times.append([{k: v for k, v in row.items() if k != "wall_s"} for row in rows])
    assert times[0] == times[1]


def test_a_row_that_fails_is_told_first_and_by_the_exit_code(tmp_path):
    table = (PROJECT / "hil" / "faults.yaml").read_text()
    (tmp_path / "t.yaml").write_text(re.sub(r"(id: apps1_open,.*)seen_within: 110 ms", r"\1seen_within: 100 ms", table))
    done = voltlap_faults("--table", tmp_path / "t.yaml", "--row", "apps1_short", "--row", "apps1_open")
    assert done.returncode == 1
    lines = done.stdout.splitlines()
    assert lines[1].startswith("failed  apps1_open")
    assert "110 ms, bound 100 ms" in lines[2]
    assert "2 faults: 1 passed, 1 failed" in lines[-1]


def test_a_check_that_holds_without_the_fault_fails_its_row(tmp_path):
    table = (PROJECT / "hil" / "faults.yaml").read_text()
    (tmp_path / "t.yaml").write_text(re.sub(r"(id: apps1_open,.*)sees: MasterStatus.Faults has AppsRange",
                                            r"\1sees: BmsStatus.State = TsActive", table))
    done = voltlap_faults("--table", tmp_path / "t.yaml", "--row", "apps1_open")
    assert done.returncode == 1
    assert "shows it without the fault: BmsStatus.State = TsActive" in done.stdout


@pytest.mark.parametrize(("arguments", "said"), [
    (["--row", "apps1_opened"], "no such row. Did you mean apps1_open"),
    (["--group", "brakes"], "no such group. Did you mean brake"),
    (["--json", "out.txt"], "found .txt, expected .json"),
    (["--report", "/nowhere/out.html"], "no folder /nowhere"),
    (["--far", "vcan1"], "--far goes with --bus"),
    (["--bus", "vcan0", "--row", "apps1_short"], "none of these rows says vcan: true"),
    (["--table", "/nowhere/t.yaml"], "/nowhere/t.yaml"),
])
def test_a_mistake_on_the_command_line_is_told(arguments, said):
    done = voltlap_faults(*arguments)
    assert done.returncode == 2
    assert said in done.stderr


def test_a_document_without_marks_is_left_alone(tmp_path):
    (tmp_path / "notes.md").write_text("mine\n")
    done = voltlap_faults("--row", "apps1_open", "--report", tmp_path / "notes.md")
    assert done.returncode == 2
    assert "without the marks" in done.stderr
    assert (tmp_path / "notes.md").read_text() == "mine\n"
