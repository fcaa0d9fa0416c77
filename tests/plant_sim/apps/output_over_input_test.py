# SPDX-License-Identifier: Apache-2.0
"""No result is written over what a run reads, nor are two results written into one file, however they are spelled."""
import os
import pathlib
import shutil
import subprocess

import pytest

BUILD = pathlib.Path(os.environ["VOLTLAP_BUILD_DIR"])
PROJECT = pathlib.Path(__file__).resolve().parents[3]
CAR = 'base = "vtm16e"\nname = "mine"\n[battery]\ncell = "cell.toml"\n[motor]\nmodel = "motor.toml"\n'


def voltlap(folder, *words):
    return subprocess.run([BUILD / "bin" / "voltlap", *words], cwd=folder, capture_output=True, text=True, timeout=120)


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "car.toml").write_text(CAR)
    shutil.copy(PROJECT / "plant_sim/data/cells/aesc_e5_2p.toml", tmp_path / "cell.toml")
    shutil.copy(PROJECT / "plant_sim/data/motors/emrax_228_lv.toml", tmp_path / "motor.toml")
    shutil.copy(PROJECT / "docs/tracks/paddock.csv", tmp_path / "points.csv")
    assert voltlap(tmp_path, "track", "import", "points.csv", "--out", "course.csv").returncode == 0
    return tmp_path


RUN = ["--vehicle", "car.toml", "--track", "course.csv"]
SPELLINGS = [lambda folder, name: name, lambda folder, name: f"./{name}", lambda folder, name: str(folder / name),
             lambda folder, name: f"../{folder.name}/{name}"]


@pytest.mark.parametrize("spell", SPELLINGS, ids=["bare", "dot", "absolute", "around"])
@pytest.mark.parametrize("name", ["car.toml", "cell.toml", "motor.toml", "course.csv"])
@pytest.mark.parametrize("command", [["endurance", "--laps", "1", "--json"], ["endurance", "--laps", "1", "--csv"],
                                     ["endurance", "--laps", "1", "--report"], ["lap", "--json"]],
                         ids=lambda words: words[0] + words[-1])
def test_an_input_is_never_written_over(folder, command, name, spell):
    before = (folder / name).read_bytes()
    refused = voltlap(folder, *command, spell(folder, name), *RUN)
    assert refused.returncode == 2 and "a file that this run reads" in refused.stderr, refused.stderr
    assert (folder / name).read_bytes() == before


def test_the_source_of_a_course_is_kept(folder):
    before = (folder / "points.csv").read_bytes()
    refused = voltlap(folder, "track", "import", "points.csv", "--out", "./points.csv")
    assert refused.returncode == 2 and "a file that this run reads" in refused.stderr
    assert (folder / "points.csv").read_bytes() == before


@pytest.mark.parametrize("words", [
    ["endurance", "--laps", "1", "--json", "out", "--csv", "./out"],
    ["track", "import", "points.csv", "--out", "out", "--plot", "./out"]], ids=["endurance", "track"])
def test_two_results_do_not_share_a_file(folder, words):
    refused = voltlap(folder, *words)
    assert refused.returncode == 2 and "one file for two results" in refused.stderr, refused.stderr
    assert not (folder / "out").exists()
