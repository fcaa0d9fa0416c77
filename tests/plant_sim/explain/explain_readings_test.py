# SPDX-License-Identifier: Apache-2.0
"""The engine that holds each reading against the model at its own time, on the simulator's own logs as they are: drawn
drives, drawn sizes. VOLTLAP_TEST_SEED repeats a draw."""
import json
import os
import pathlib
import random
import subprocess

import pytest

VOLTLAP = pathlib.Path(os.environ["VOLTLAP_BUILD_DIR"]) / "bin" / "voltlap"
SEED = int(os.environ.get("VOLTLAP_TEST_SEED", random.SystemRandom().randrange(2**31)))
# key of the hidden effect, smallest and largest size, name, parameter that says it, what it says of this size
EFFECTS = [
    ("cell.effects.series_ohm={}", 1e-4, 5e-4, "series_resistance", "resistance_ohm", lambda x: x),
    ("cell.effects.exchange_current_change={}", 0.2, 0.5, "resistance_current", "exchange_current_change", lambda x: x),
    ("battery.contact_resistance_ohm={}", 1e-3, 5e-3, "contact_resistance", "resistance_ohm", lambda x: x),
    ("battery.cells.7.resistance_scale={}", 1.15, 1.6, "weak_cell", "resistance_change", lambda x: x - 1.0),
]


def run(*arguments):
    done = subprocess.run([VOLTLAP, *map(str, arguments)], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    return done.stdout


class Draw:
    def __init__(self, label):
        self.random = random.Random(f"{SEED}/{label}")
        print(f"VOLTLAP_TEST_SEED={SEED}")

    def drive(self, folder, *keys, candump=False):
        """A drawn drive of four laps; returns its log."""
        out = folder / f"drive{self.random.randrange(10**9)}"
        settings = [f"battery.initial_soc={self.random.uniform(0.5, 1.0):.3f}",
                    f"battery.initial_temperature_c={self.random.uniform(27.0, 34.0):.2f}",
                    f"driver.grip_use={self.random.uniform(0.85, 0.98):.3f}"]
        noise = ["sensors.noise=true", "sensors.quantisation=true"] if candump else []
        files = ["--csv", f"{out}.csv", *(["--candump", f"{out}.log"] if candump else [])]
        run("endurance", "--vehicle", "vtm16e", "--laps", 4, "--seed", self.random.randrange(2**31), *files, "--set",
            *settings, *noise, *keys)
        return f"{out}.log" if candump else f"{out}.csv"


def explained(folder, log, *arguments, model="vtm16e"):
    out = folder / "out.json"
    said = run("explain", log, "--model", model, "--json", out, "--set", "explain.engine=readings", *arguments)
    return json.loads(out.read_text()), said


@pytest.mark.parametrize("candump", [False, True])
def test_a_drive_as_the_model_has_it_shows_no_discrepancy(tmp_path, candump):
    draw = Draw(f"sound{candump}")
    answer, said = explained(tmp_path, draw.drive(tmp_path, candump=candump))
    assert answer["verdict"] == "no_discrepancy" and answer["causes"] == [], said


@pytest.mark.parametrize("effect", EFFECTS, ids=[e[3] for e in EFFECTS])
def test_what_was_hidden_is_named_with_its_size(tmp_path, effect):
    key, low, high, name, parameter, says = effect
    draw = Draw(name)
    size = float(f"{draw.random.uniform(low, high):.4g}")
    answer, said = explained(tmp_path, draw.drive(tmp_path, key.format(size)))
    assert answer["verdict"] == "named" and len(answer["causes"]) == 1, (size, said)
    cause = answer["causes"][0]
    assert name in (cause["name"], *cause["equivalent_to"]), (size, said)
    if cause["name"] == name:
        assert cause["parameters"][parameter]["value"] == pytest.approx(says(size), rel=0.1), (size, said)


def test_the_extended_model_leaves_nothing_and_keeps_what_was_promised(tmp_path):
    draw = Draw("extended")
    size = float(f"{draw.random.uniform(1.5e-4, 5e-4):.4g}")
    key = f"cell.effects.series_ohm={size}"
    extended, page = tmp_path / "extended.toml", tmp_path / "page.html"
    answer, said = explained(tmp_path, draw.drive(tmp_path, key), "--write-model", extended, "--report", page)
    promised = answer["gain"]["voltage"]
    other = draw.drive(tmp_path, key)
    before, _ = explained(tmp_path, other)
    after, told = explained(tmp_path, other, model=extended)
    assert after["verdict"] == "no_discrepancy", (size, said, told)
    real = 1 - (after["gain"]["voltage"]["heldout_rms_before"] / before["gain"]["voltage"]["heldout_rms_before"]) ** 2
    assert real == pytest.approx(1 - (promised["heldout_rms_after"] / promised["heldout_rms_before"]) ** 2, abs=0.1)
    assert "<html" in page.read_text(encoding="utf-8").lower()


def test_a_good_reference_changes_no_right_answer(tmp_path):
    draw = Draw("reference")
    size = float(f"{draw.random.uniform(1.5e-4, 5e-4):.4g}")
    log = draw.drive(tmp_path, f"cell.effects.series_ohm={size}")
    alone, _ = explained(tmp_path, log)
    beside, said = explained(tmp_path, log, "--reference", draw.drive(tmp_path))
    assert [c["name"] for c in beside["causes"]] == [c["name"] for c in alone["causes"]] != [], (size, said)
