# SPDX-License-Identifier: Apache-2.0
"""./voltlap benchmark as a whole: a planted slowdown is found, two runs of one build are not.

These are tests of verdicts, not of times: the short rows, on a machine that may be busy."""
import json
import os
import pathlib
import re
import resource
import subprocess

import pytest

FOLDER = pathlib.Path(os.environ["VOLTLAP_BUILD_DIR"]) / "bin"
BINARY, SLOWED = FOLDER / "voltlap-benchmark", FOLDER / "voltlap-benchmark-slowed"
SHORT = ["--filter", "^(lap|cell_step|firmware_tick)$"]


def benchmark(*arguments, binary=BINARY, **more):
    return subprocess.run([binary, *map(str, arguments)], capture_output=True, text=True, timeout=300, **more)


@pytest.fixture(scope="module")
def earlier(tmp_path_factory):
    path = tmp_path_factory.mktemp("benchmark") / "earlier.json"
    run = benchmark(*SHORT, "--json", path)
    assert run.returncode == 0, run.stderr
    return path


def verdicts(text):
    return dict(re.findall(r"^(\w+) .*\.\. [\d.]+ +(as before|SLOWER|faster)$", text, re.MULTILINE))


def quietest(folder, wanted, tries=4, **more):
    """The first comparison with the wanted verdicts, else the last; each try measures both sides anew. A neighbour
    that begins or ends on the same core slows rows unequally, for seconds, and on either side; a slowdown of the
    build is there in every try."""
    for number in range(tries):
        before = folder / f"before_{number}.json"
        assert benchmark(*SHORT, "--json", before).returncode == 0
        run = benchmark(*SHORT, "--compare", before, **more)
        if verdicts(run.stdout) == wanted:
            break
    return run


def test_two_runs_of_one_build_are_as_before(tmp_path):
    wanted = dict.fromkeys(("cell_step", "firmware_tick", "lap"), "as before")
    run = quietest(tmp_path, wanted)
    assert verdicts(run.stdout) == wanted, run.stdout
    assert run.returncode == 0


def test_planted_twofold_slowdown_is_found_and_nothing_else(tmp_path):
    wanted = {"cell_step": "as before", "firmware_tick": "as before", "lap": "SLOWER"}
    run = quietest(tmp_path, wanted, binary=SLOWED)
    assert verdicts(run.stdout) == wanted, run.stdout
    assert run.returncode == 1


def test_slowdown_that_is_taken_out_again_is_faster_and_no_failure(earlier, tmp_path):
    benchmark("--filter", "^lap$", "--json", tmp_path / "slow.json", binary=SLOWED)
    run = benchmark("--filter", "^lap$", "--compare", tmp_path / "slow.json")
    assert verdicts(run.stdout) == {"lap": "faster"}, run.stdout
    assert run.returncode == 0


def test_file_tells_machine_and_rows(earlier):
    result = json.loads(earlier.read_text())
    assert set(result["machine"]) == {"cpu", "cores", "governor", "frequency", "compiler", "build_type", "flags",
                                      "version"}
    assert [row["name"] for row in result["benchmarks"]] == ["cell_step", "firmware_tick", "lap"]
    for row in result["benchmarks"]:
        assert row["ns"] > 0 and row["sim_s_per_s"] > 1 and row["spread"] >= 0
        assert 0 < row["relative_low"] <= row["relative_high"] and row["relative"] <= row["relative_high"]


def test_simulated_seconds_follow_from_the_time_of_an_operation(earlier):
    rows = {row["name"]: row for row in json.loads(earlier.read_text())["benchmarks"]}
    simulated = {name: row["sim_s_per_s"] * row["ns"] * 1e-9 for name, row in rows.items()}
    assert simulated["cell_step"] == pytest.approx(1e-3)
    assert simulated["firmware_tick"] == pytest.approx(10e-3)
    assert simulated["lap"] == pytest.approx(74.7, abs=0.2)  # the lap of vtm16e on Michigan 2015


def test_endurance_is_measured_too(tmp_path):
    run = benchmark("--quick", "--filter", "representative|plant", "--json", "-")
    rows = {row["name"]: row for row in json.loads(run.stdout)["benchmarks"]}
    assert set(rows) == {"plant_step", "endurance_representative"}
    race = rows["endurance_representative"]
    assert race["sim_s_per_s"] * race["ns"] * 1e-9 == pytest.approx(2021, abs=20)
    assert "endurance_representative" in run.stderr


def test_markdown_has_a_row_each(tmp_path):
    table = tmp_path / "table.md"
    assert benchmark("--quick", "--filter", "^lap$", "--markdown", table).returncode == 0
    assert re.search(r"^\| `lap` \| .* \| [\d.]+ [mu]s \| [\d ]+ \|$", table.read_text(), re.MULTILINE)


@pytest.mark.parametrize("arguments, words", [
    (["--compare", "absent.json"], ["--compare absent.json", "No such file", "benchmark --json"]),
    (["--compare", "."], ["a folder"]),
    (["--filter", "("], ["--filter (", "no regular expression"]),
    (["--filter", "nothing"], ["--filter nothing", "plant_step, cell_step"]),
    (["--jsn", "x"], ["unknown flag --jsn", "Did you mean --json?"]),
    (["--json", "absent/x.json"], ["absent/x.json", "existing folder"]),
])
def test_errors_say_what_is_wrong_before_anything_is_measured(tmp_path, arguments, words):
    run = benchmark(*arguments, cwd=tmp_path)
    assert run.returncode == 2
    assert [word for word in words if word not in run.stderr] == [], run.stderr
    assert list(tmp_path.iterdir()) == []


def test_full_disk_leaves_the_earlier_file(tmp_path):
    (tmp_path / "m.json").write_text("earlier")
    run = benchmark("--quick", "--filter", "^lap$", "--json", "m.json", cwd=tmp_path,
                    preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100)))
    assert run.returncode == 2 and "File too large" in run.stderr
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {"m.json": "earlier"}
