# SPDX-License-Identifier: Apache-2.0
"""Cell files of one to four RC branches: they drive a car and close its energy; one with a gap is refused by name."""
import json
import os
import pathlib
import re
import subprocess

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[3]
BUILD = pathlib.Path(os.environ["VOLTLAP_BUILD_DIR"])
CELL = (ROOT / "plant_sim/data/cells/aesc_e5_2p.toml").read_text()
SECTION = r"\n\[{}\].*?(?=\n\[|\Z)"


def voltlap(*arguments, folder):
    return subprocess.run([BUILD / "bin" / "voltlap", *map(str, arguments)], cwd=folder, capture_output=True, text=True,
                          timeout=300)


def section(name):
    return re.search(SECTION.format(name), CELL, re.S).group(0)


def without(text, *names):
    for name in names:
        text = re.sub(SECTION.format(name), "", text, flags=re.S)
    return text


def copied(name, to):
    """The section of a branch under another number."""
    return section(name).replace(f"[{name}]", f"[{to}]") + "\n"


def cell_of(branches):
    if branches == 1:
        return without(CELL, "r2", "tau2")
    return CELL + "".join(copied("r1", f"r{k}") + copied("tau1", f"tau{k}") for k in range(3, branches + 1))


def faster(text, name):
    """The same with a fifth of that section's time constants: no two branches can stand for all."""
    part = re.search(SECTION.format(name), text, re.S).group(0)
    values = re.search(r"value = \[(.*?)\]", part, re.S).group(1)
    fifth = ", ".join(f"{float(value) / 5.0:g}" for value in values.replace("\n", " ").split(",") if value.strip())
    return text.replace(part, part.replace(values, fifth))


@pytest.mark.parametrize("branches", [1, 2, 3, 4])
def test_a_cell_of_one_to_four_branches_drives_a_lap(branches, tmp_path):
    (tmp_path / "own.toml").write_text(cell_of(branches))
    done = voltlap("endurance", "--laps", 1, "--cells", "all", "--set", "battery.cell=own.toml", "--json", "run.json",
                   folder=tmp_path)
    assert done.returncode == 0, done.stderr
    run = json.loads((tmp_path / "run.json").read_text())
    assert run["status"] == "finished" and abs(run["energy_ledger_error_pct"]) < 1e-6
    assert run["energy_ledger_kwh"]["battery_rc_heat"] > 0.0


def test_more_resistance_in_more_branches_costs_more(tmp_path):
    heat = []
    for branches in (1, 2, 3, 4):
        (tmp_path / "own.toml").write_text(cell_of(branches))
        voltlap("endurance", "--laps", 1, "--cells", "representative", "--set", "battery.cell=own.toml", "--json",
                "run.json", folder=tmp_path)
        heat.append(json.loads((tmp_path / "run.json").read_text())["energy_ledger_kwh"]["battery_rc_heat"])
    assert heat == sorted(heat) and len(set(heat)) == 4


BAD = {
    "no branch": (without(CELL, "r1", "tau1", "r2", "tau2"), "r1.table"),
    "second without first": (without(CELL, "r1", "tau1"), "r1.table"),
    "time constant missing": (without(CELL, "tau2"), "tau2.table"),
    "resistance missing": (CELL + copied("tau1", "tau3"), "r3.table"),
    "gap": (CELL + copied("r1", "r4") + copied("tau1", "tau4"), "RC branch 4 without branch 3"),
    "fifth": (CELL + copied("r1", "r5") + copied("tau1", "tau5"), "r5"),
    "another length": (CELL + copied("r1", "r3").replace("value = [0.0004, ", "value = [") + copied("tau1", "tau3"),
                       "r3.value"),
    "negative": (CELL + copied("r1", "r3") + copied("tau1", "tau3").replace("value = [96.0", "value = [-96.0"),
                 "tau3.value"),
}


@pytest.mark.parametrize("bad", BAD)
def test_a_cell_file_that_does_not_hold_together_is_refused_by_its_field(bad, tmp_path):
    text, words = BAD[bad]
    (tmp_path / "own.toml").write_text(text)
    done = voltlap("endurance", "--laps", 1, "--set", "battery.cell=own.toml", "--json", "run.json", folder=tmp_path)
    assert done.returncode == 2, done.stdout
    assert words in done.stderr and "own.toml" in done.stderr and "expected" in done.stderr
    assert not (tmp_path / "run.json").exists()


def test_the_header_for_a_bms_says_what_two_branches_cost(tmp_path):
    (tmp_path / "own.toml").write_text(faster(cell_of(4), "tau3"))
    done = voltlap("firmware-tables", "own.toml", "--out", "pack.hpp", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    said = re.search(r"2 in the place of 4\. After a step of 1C, 55\.2 A, .* at most ([\d.]+) mV", done.stdout)
    assert said and float(said.group(1)) > 0.0
    header = (tmp_path / "pack.hpp").read_text()
    assert said.group(0) in header
    for name in ("kSeriesResistance", "kBranch1Resistance", "kBranch1Time", "kBranch2Resistance", "kBranch2Time"):
        assert f"inline constexpr std::int32_t {name}[]" in header
