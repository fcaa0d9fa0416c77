# SPDX-License-Identifier: Apache-2.0
"""Recordings without a map on the command line: used as they are where everything is clear, refused with a draft that
needs no more than a choice where it is not."""
import csv
import os
import re
import subprocess
from pathlib import Path

import pytest

BUILD = Path(os.environ["VOLTLAP_BUILD_DIR"])
CAR_DBC = Path(__file__).parents[3] / "can_dbc/car.dbc"


def voltlap(*arguments):
    return subprocess.run([BUILD / "bin/voltlap", *map(str, arguments)], capture_output=True, text=True, timeout=300)


@pytest.fixture(scope="module")
def race(tmp_path_factory):
    folder = tmp_path_factory.mktemp("race")
    candump, series = folder / "race.log", folder / "race.csv"
    voltlap("endurance", "--laps", 1, "--candump", candump, "--csv", series)
    return candump, series


def validated(*arguments):
    return voltlap("validate", "molicel_p45b", "--cells-in-series", 24, "--cells-in-parallel", 5, *arguments)


def table(path, series, columns):
    """Some columns of the race under other names."""
    rows = list(csv.DictReader(line for line in series.read_text().splitlines() if line[0] != "#"))
    lines = [",".join(columns.values())] + [",".join(row[key] for key in columns) for row in rows]
    path.write_text("\n".join(lines) + "\n")
    return path


def test_what_endurance_writes_is_read_as_it_is(race):
    for recording in race:
        run = validated(recording)
        assert run.returncode == 0, run.stderr


def test_a_bus_with_its_dbc_needs_no_map_and_the_map_is_kept(race, tmp_path):
    written = tmp_path / "map.toml"
    first = validated(race[0], "--dbc", CAR_DBC, "--write-map", written)
    assert first.returncode == 0, first.stderr
    assert "current = {frame = 0x0B0" in written.read_text()
    again = validated(race[0], "--map", written)
    assert again.returncode == 0, again.stderr
    assert list(tmp_path.iterdir()) == [written]


def test_a_choice_that_is_open_is_refused_and_the_draft_needs_only_the_choice(race, tmp_path):
    two = table(tmp_path / "two.csv", race[1],
                {"time_s": "x [s]", "pack_current_a": "y [A]", "pack_voltage_v": "z1 [V]",
                 "dc_link_v": "z2 [V]"})
    draft = tmp_path / "draft.toml"
    run = validated(two, "--write-map", draft)
    assert run.returncode == 2 and "several could be it" in run.stderr and str(draft) in run.stderr
    text = draft.read_text()
    chosen = re.sub(r'^#(\w+ = \{column = "z1 \[V\]".*)$', r"\1", text, flags=re.MULTILINE)
    assert chosen != text
    draft.write_text(chosen)
    run = validated(two, "--map", draft)
    assert run.returncode == 0, run.stderr


def test_a_flag_that_would_do_nothing_is_refused(race, tmp_path):
    run = validated(race[1], "--map", "voltlap_endurance_csv", "--write-map", tmp_path / "map.toml")
    assert run.returncode == 2 and "--write-map" in run.stderr
    run = validated(race[0], "--dbc", tmp_path / "none.dbc")
    assert run.returncode == 2 and "none.dbc" in run.stderr
    assert not list(tmp_path.iterdir())


def test_a_recording_is_never_written_over(race):
    before = race[1].read_bytes()
    run = validated(race[1], "--write-map", race[1])
    assert run.returncode == 2 and race[1].read_bytes() == before
