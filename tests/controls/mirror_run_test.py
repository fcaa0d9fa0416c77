# SPDX-License-Identifier: Apache-2.0
"""`voltlap explain-mirror` as it is called: blind, repeatable, with two engines, and with a clean end.

Of the cases that were once wrong a third is asked, drawn by VOLTLAP_TEST_SEED; all with VOLTLAP_TEST_WHOLE=1: together
they take minutes.
"""

import json
import os
import random
import shlex
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

HERE = Path(__file__).resolve().parent
BIN = Path(os.environ["VOLTLAP_BUILD_DIR"]) / "bin"
MIRROR = [sys.executable, HERE.parents[1] / "toolchain/explain_mirror.py", "--bin", BIN]


def mirror(*arguments, code=0):
    run = subprocess.run([*map(str, MIRROR), *map(str, arguments)], capture_output=True, text=True, timeout=600)
    assert run.returncode == code, run.stderr
    return run


@pytest.fixture(scope="module")
def engines(tmp_path_factory):
    """Two programs: one always says nothing, the other always names a series resistance."""
    folder = tmp_path_factory.mktemp("engines")
    for name in ("silent", "named"):
        shutil.copy(HERE / "mirror_stand_in.py", folder / name)
    return folder


@pytest.fixture(scope="module")
def quick(tmp_path_factory):
    """The short form with this build's explain, as it is run after every change."""
    folder = tmp_path_factory.mktemp("quick")
    run = mirror("--quick", "--seed", 1, "--json", folder / "q.json", "--csv", folder / "q.csv")
    return run.stdout, json.loads((folder / "q.json").read_text()), (folder / "q.csv").read_text().splitlines()


def test_short_form_has_sound_logs_and_effects_and_its_counts_add_up(quick):
    text, found, lines = quick
    answered = [case for case in found["cases"] if not case["not_driven"]]
    assert len(found["cases"]) == 30 and len(lines) == 1 + len(answered) and len(answered) >= 27
    sound = [case for case in answered if case["ask"] == "sound"]
    effects = [case for case in answered if case["ask"] == "single" and case["visible"]]
    engine = found["engines"]["voltlap"]
    assert len(sound) == engine["sound"]["alarms"]["of"] == 6
    assert len(effects) == sum(entry["found"]["of"] for entry in engine["rho"]) >= 15
    assert engine["rho"][2]["found"]["of"] > 0 and engine["rho"][1]["found"]["of"] > 0
    assert engine["no_answer"] == 0, [case["answers"]["voltlap"]["failed"] for case in answered]
    assert {case["kind"] for case in answered} == {"car", "pack", "cell"}
    assert f"seed {found['seed']}: 30 cases" in text


def test_json_says_what_was_hidden_and_what_was_said(quick):
    _, found, _ = quick
    assert found.keys() == {"seed", "quick", "kinds", "causes", "rate", "engines", "invisible", "cases"}
    for case in found["cases"]:
        if case["ask"] != "single" or case["not_driven"]:
            continue
        assert len(case["effects"]) == 1 and case["effects"][0]["parameters"] and case["rho"] >= 0.0
        assert case["answers"]["voltlap"].keys() == {
            "verdict", "causes", "alternatives", "found", "named", "in_set", "misnamed", "failed", "gain"}
    share = found["engines"]["voltlap"]["rho"][2]["named"]
    assert share["hits"] <= share["of"] and 0.0 <= share["ci95_low"] <= share["ci95_high"] <= 1.0


@pytest.mark.parametrize(("seed", "case", "name"), [(11, 14, "log.csv"), (3, 14, "log.log")])
def test_a_slower_logger_writes_fewer_rows_of_the_same_drive(tmp_path, seed, case, name):
    """`--rate`: of a drive's CSV. Nothing else of the case is another."""
    for rate in (10, 2):
        mirror("--seed", seed, "--kind", "car", "--rate", rate, "--case", case, "--keep", tmp_path / str(rate))
    rows = {rate: [line for line in (tmp_path / rate / name).read_text().splitlines() if not line.startswith("#")]
            for rate in ("10", "2")}
    assert rows["2"] == ([rows["10"][0], *rows["10"][1::5]] if name == "log.csv" else rows["10"])
    assert (tmp_path / "2/model.toml").read_text() == (tmp_path / "10/model.toml").read_text()


def test_a_case_that_cannot_be_driven_is_refused_with_the_reason(tmp_path):
    run = mirror("--seed", 11, "--kind", "car", "--case", 4, "--keep", tmp_path / "kept", code=2)
    assert "explain-mirror: case 4 cannot be driven: exit code 3: FAILED car on michigan_2014" in run.stderr
    assert not (tmp_path / "kept").exists() and "Traceback" not in run.stderr


ONCE_WRONG = {
    (20270201, 63): "a pack voltage that is 10 ms late was said to be 4",
    (20270201, 139): "a cooling of five times was a part of an error, as the start was applied in the model that cools so",
    (20270201, 176): "a bend of the open-circuit voltage, likewise",
    (20271201, 88): "pulses from even to odd rows counted a charge that is not there: a hysteresis was nothing beside it",
    (20271201, 103): "a radius was a mass and losses of inverter and motor",
    (20271201, 112): "a hysteresis that settles with the first charge was a drive before the log",
    (20271205, 6): "resistances of the last minute alone, which the rest of the log foresees no part of, were nothing",
    (20271205, 16): "an open-circuit voltage was a drive before the log",
    (20271206, 39): "an idle below the floor of the tables kept the current of the row before: hysteresis beside a load",
    (20271211, 24): "noise of the current at rest asked for resistances: a voltage that reads too much beside the lag",
    (20271211, 28): "a slow relaxation, likewise, was a hysteresis",
    (20271213, 34): "a pedal that moved between rows hid the force of a car: a drag area was nothing beside references",
    (20271214, 122): "a mass, likewise",
    (20271213, 126): "a motor constant, of use in the power, of less than is asked in the speed, was its losses",
    (20271216, 45): "a gain of the current too small for a word without references was losses of the inverter",
    (20271214, 94): "how fast a temperature rose was told by steps of 1 K: a late thermistor was a resistance",
    (20271217, 132): "likewise",
    (20271217, 103): "without references more was asked for what rows had not told, that of pedals that moved as well",
    (20271217, 104): "a brake tapped between two rows was a reference's error: a mass was nothing",
    (20271219, 93): "a BMS began without the entropy: beside a reversible heat stood its charge as a curve",
    (20271213, 39): "a load, as an idle below the floor of the tables",
    (20271256, 282): "cells of 11 degC were as warm as a model without their reversible heat: it was told as air",
    (20271209, 125): "a curve with points where the model did not drive was no suspect, and the BMS's charge was wrong",
}
# What looks the same to within a quarter of what is worth a word stands beside them.
ONE_OF_TWO = {(20271201, 112), (20271205, 16), (20271209, 125), (20271217, 132)}
# What is too small for a word may be left unsaid, and is nothing else.
UNSAID = {(20271216, 45)}


def is_right(case, answer):
    if case in UNSAID and not answer["found"]:
        return True
    return answer["in_set" if case in ONE_OF_TWO else "named"]


def asked_again():
    """Those of this run, by the seed of their mirror."""
    drawn = sorted(ONCE_WRONG)
    if os.environ.get("VOLTLAP_TEST_WHOLE") != "1":
        seed = os.environ.get("VOLTLAP_TEST_SEED") or str(random.randrange(2**32))
        print(f"VOLTLAP_TEST_SEED={seed}")
        drawn = random.Random(seed).sample(drawn, (len(drawn) + 2) // 3)
    return {seed: sorted(number for of, number in drawn if of == seed) for seed in sorted({of for of, _ in drawn})}


@pytest.mark.parametrize("seed, numbers", asked_again().items())
def test_cases_that_were_once_wrong_are_right(tmp_path, seed, numbers):
    out = tmp_path / "again.json"
    mirror("--seed", seed, *(word for number in numbers for word in ("--case", number)), "--json", out)
    cases = {case["number"]: case for case in json.loads(out.read_text())["cases"]}
    wrong = {number: ONCE_WRONG[seed, number] for number, case in cases.items()
             if not is_right((seed, number), case["answers"]["voltlap"])}
    assert sorted(cases) == numbers and wrong == {}
    if 63 in cases:
        assert cases[63]["effects"][0]["parameters"]["delay_s"] == 0.01


def test_command_of_a_failing_case_repeats_it(quick, tmp_path):
    text, found, _ = quick
    number = found["engines"]["voltlap"]["smallest_failing_case"]
    if number is None:  # nothing fails any more: any case repeats
        words = ["./voltlap", "explain-mirror", "--seed", "1", "--quick", "--case", "20"]
    else:
        words = shlex.split(next(line for line in text.splitlines() if f"--case {number}" in line))
    assert words[:2] == ["./voltlap", "explain-mirror"]
    mirror(*words[2:], "--json", tmp_path / "again.json")
    again = json.loads((tmp_path / "again.json").read_text())["cases"]
    assert again == [case for case in found["cases"] if case["number"] == again[0]["number"]]


def test_two_engines_stand_side_by_side_and_a_seed_repeats_the_table(engines):
    words = ("--seed", 3, "--quick", "--count", 10, "--kind", "cell", "--engine", engines / "silent", "--engine",
             engines / "named")
    first = mirror(*words).stdout
    assert mirror(*words, "--jobs", 1).stdout == first
    assert mirror("--seed", 4, *words[2:]).stdout != first
    line = {text.split("  ")[0]: text for text in first.splitlines()}
    assert line["sound logs: alarms"].count("0/2") == 1 and line["sound logs: alarms"].count("2/2") == 1
    for engine in ("silent", "named"):  # each has a case to look at first
        assert any(text.startswith(f"{engine}: ") and "fail; the one with" in text for text in first.splitlines())


def test_an_engine_finds_log_model_and_references_alone(engines, tmp_path):
    run = mirror("--seed", 3, "--quick", "--kind", "pack", "--case", 4, "--keep", tmp_path / "kept")
    names = {path.name for path in (tmp_path / "kept").iterdir()}
    label = json.loads(run.stdout.splitlines()[0])
    expected = {"model.toml", *(f"reference_{k}" for k in range(label["references"])), "log"}
    assert {name if name == "model.toml" else name.split(".")[0] for name in names} == expected
    assert label["effects"][0]["name"] not in (tmp_path / "kept/model.toml").read_text()
    command = shlex.split(run.stdout.splitlines()[1].split("&&")[1])
    assert not any(label["effects"][0]["name"] in word or "--map" in word or "--set" in word for word in command)


@pytest.mark.parametrize("words, says", [
    (("--seed", -1), "--seed -1: expected 0 or more"),
    (("--count", 0), "--count 0: expected 1 or more"),
    (("--case", -2), "--case -2: expected 0 or more"),
    (("--cause", "gremlins"), "--cause gremlins: expected one of ambient,"),
    (("--cause", "mass", "--kind", "cell"), "--cause mass: no log of --kind cell can hold it"),
    (("--engine", "/nowhere/engine"), "/nowhere/engine is not a program"),
    (("--keep", "somewhere"), "--keep: expected one --case with it"),
])
def test_input_that_cannot_be_used_is_told_in_one_line(words, says):
    run = mirror(*words, code=2)
    assert says in run.stderr and len(run.stderr.splitlines()) == 1


def test_end_is_clean_when_it_is_interrupted(tmp_path):
    environment = {**os.environ, "TMPDIR": str(tmp_path)}
    process = subprocess.Popen([*map(str, MIRROR), "--seed", "3"], env=environment, stderr=subprocess.PIPE, text=True)
    until = time.monotonic() + 60.0
    while not any(tmp_path.glob("explain-mirror-*/world-*/*")) and time.monotonic() < until:
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 130 and "interrupted; nothing is kept" in errors and "Traceback" not in errors
    assert list(tmp_path.iterdir()) == []
