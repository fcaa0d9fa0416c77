# SPDX-License-Identifier: Apache-2.0
"""The trial is blind, counts right, writes logs that say what was measured, and ends cleanly."""

import gzip
import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from bank import cases, models, packer, real, score, seal, table, tool
from bank.statistics import Share, median, share
from truth import effects, hide, world

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
BENCH = [sys.executable, HERE.parents[1] / "toolchain/explain_bench.py", "--tool", HERE / "stand_in.py"]


def test_interval_of_a_share_is_wilsons():
    assert Share(9, 10).interval == pytest.approx((0.5958, 0.9821), abs=1e-4)
    assert Share(0, 300).interval[1] == pytest.approx(0.01264, abs=1e-5)
    assert Share(0, 0).interval == (0.0, 1.0)
    assert share([True, False]).value == 0.5 and median([3, 1, 2]) == 2 and median([1, 2]) == 1.5


def test_label_that_was_changed_or_left_out_is_told(tmp_path):
    ledger = seal.Ledger(tmp_path)
    ledger.commit("a", {"effects": []})
    ledger.commit("b", {"effects": ["mass"]})
    assert "mass" not in ledger.commitments.read_text()
    assert ledger.reveal()["b"] == {"effects": ["mass"]}
    text = ledger.revealed.read_text()
    ledger.revealed.write_text(text.replace("mass", "grip"))
    with pytest.raises(ValueError, match="not the one"):
        seal.verify(ledger.commitments, ledger.revealed)
    ledger.revealed.write_text(text.splitlines()[0] + "\n")
    with pytest.raises(ValueError, match="left out"):
        seal.verify(ledger.commitments, ledger.revealed)


def test_same_label_has_another_hash_with_another_salt():
    assert seal.digest({"a": 1}, "x") != seal.digest({"a": 1}, "y")


def some_log(steps=50):
    rng = np.random.default_rng(0)
    log = {
        "current": rng.uniform(0, 100, steps),
        "pack_voltage": rng.uniform(25, 33, steps),
        "soc": rng.uniform(0, 1, steps),
        "cell_voltage_1": rng.uniform(3, 4, steps),
        "cell_voltage_12": rng.uniform(3, 4, steps),
        "temperature_1": rng.uniform(10, 40, steps),
        "speed": rng.uniform(0, 30, steps),
    }
    return log, rng


@pytest.mark.parametrize("seed", range(6))
def test_what_is_written_is_what_was_measured_in_any_unit_sign_and_order(seed, tmp_path):
    log, _ = some_log()
    logger = packer.logger_of(np.random.default_rng(seed), "pack", list(log))
    path = packer.write_log(tmp_path / ("log.csv.gz" if logger.packed else "log.csv"), logger, log, 0.1)
    with (gzip.open if logger.packed else open)(path, "rt") as lines:
        names = next(lines).strip().split(",")
        values = np.array([[float(field) for field in line.split(",")] for line in lines]).T
    assert sorted(names) == sorted(logger.name.values())
    for role, expected in log.items():
        scale, offset = packer.UNITS[packer.stem(role)][1].get(logger.unit.get(packer.stem(role), ""), (1.0, 0.0))
        got = (values[names.index(logger.name[role])] - offset) / scale
        if role == "current":
            expected = expected * logger.discharge_sign
        assert np.abs(got - expected).max() < 6e-3
    assert np.diff(values[names.index(logger.name["time"])]).min() > 0.0


def test_map_names_every_role_once_with_its_unit():
    log, rng = some_log()
    logger = packer.logger_of(rng, "pack", list(log))
    logger.mapped = True
    logger.unit = {packer.stem(role): "" for role in ["time", *log]}
    logger.unit["pack_voltage"] = "mV"
    text = packer.role_map(logger)
    assert text.startswith("[roles]\n") and text.count(" = {column") == len(log) + 1
    assert re.search(r'^pack_voltage = \{column = "[^"]+", unit = "mV"\}$', text, re.MULTILINE)
    assert re.search(r'^current = .*discharge = "auto"\}$', text, re.MULTILINE)


def test_lost_rows_are_not_written(tmp_path):
    log, rng = some_log()
    logger = packer.logger_of(rng, "pack", list(log))
    keep = rng.random(50) > 0.3
    path = packer.write_log(tmp_path / "log.csv", logger, log, 0.1, keep)
    assert len(path.read_text().splitlines()) == 1 + keep.sum()


def cause(name, alike=(), **parameters):
    return {
        "name": name,
        "equivalent_to": list(alike),
        "parameters": {
            key: {"value": value, "ci95_low": 0.9 * value, "ci95_high": 1.1 * value, "unit": "1"}
            for key, value in parameters.items()
        },
    }


def judged(verdict, said=(), truth=("mass",), ask="single", d_prime=20.0, alternatives=(), rho=5.0, **more):
    label = {
        "ask": ask,
        "kind": "car",
        "d_prime": d_prime,
        "rho": rho,
        "channel": "motor_torque",
        **more,
        "effects": [{"name": name, "d_prime": d_prime, "parameters": {"change": 0.1}} for name in truth],
    }
    return score.Judged("x", label, tool.Answer(verdict, list(said), list(alternatives)))


def test_naming_takes_every_effect_and_nothing_else():
    assert judged("named", [cause("mass")]).named
    assert judged("named", [cause("tyre_radius", ["mass"])]).named
    assert not judged("named", [cause("mass"), cause("wind")]).named
    assert not judged("named", [cause("mass")], truth=("mass", "wind")).named
    assert judged("named", [cause("mass"), cause("wind")], truth=("wind", "mass")).named
    assert not judged("named", [cause("mass", ["wind"])], truth=("wind", "mass")).named
    assert not judged("ambiguous", [cause("mass")]).named


def test_confident_misnaming_is_a_cause_that_is_not_there():
    assert judged("named", [cause("wind")]).misnamed
    assert judged("named", [cause("mass"), cause("wind")]).misnamed
    assert judged("named", [cause("wind")], truth=()).misnamed
    assert not judged("named", [cause("mass")]).misnamed
    assert not judged("ambiguous", [cause("wind")]).misnamed


def test_set_holds_causes_and_alternatives_and_equals_count_as_one():
    it = judged("ambiguous", [cause("wind", ["grade"])], alternatives=[["mass"], ["grade"], ["wind"]])
    assert it.in_set and len(it.reported) == 2
    assert not judged("unknown", [cause("mass")]).in_set


def test_parameter_error_and_cover_come_from_the_main_parameter():
    assert judged("named", [cause("mass", change=0.12)]).parameter() == (
        0.1,
        0.12,
        pytest.approx(0.108),
        pytest.approx(0.132),
    )
    assert judged("named", [cause("tyre_radius", ["mass"], change=0.12)]).parameter() is None


def test_each_mark_counts_its_own_cases():
    answers = [
        judged("no_discrepancy", truth=(), ask="clean"),
        judged("unknown", truth=(), ask="clean"),
        judged("named", [cause("mass", change=0.1)]),
        judged("no_discrepancy", d_prime=2.0),
        judged("named", [cause("wind")], ask="left_out"),
        judged("unknown", ask="left_out"),
        judged("named", [cause("mass"), cause("wind")], ("mass", "wind"), "pair", likeness=0.2),
        judged("no_discrepancy", (), ("mass", "grade"), "pair", likeness=0.99),
    ]
    shown = {mark.text: (mark.value, mark.cases) for mark in score.marks(answers)}
    assert shown["false alarms on clean logs"] == (0.5, 2)
    assert shown["named"] == (1.0, 1)
    assert shown["left out: confidently misnamed"] == (0.5, 2)
    assert shown["pairs: both named"] == (1.0, 1)
    assert shown["parameter error, median"] == (0.0, 1)
    assert [entry[2].of for entry in score.curve(answers)] == [0, 1, 0, 1, 0, 0]


def test_shares_by_rho_count_single_effects_alone_with_their_bounds():
    answers = [
        judged("named", [cause("mass")], rho=3.0),
        judged("named", [cause("wind")], rho=40.0),
        judged("no_discrepancy", rho=2.99),
        judged("unknown", rho=0.2),
        judged("named", [cause("mass")], ask="left_out"),
    ]
    rows = {low: marks for low, _, marks in score.by_rho(answers)}
    assert {low: marks["found"].cases for low, marks in rows.items()} == {0.0: 1, 1.0: 1, 3.0: 2}
    assert {name: mark.value for name, mark in rows[3.0].items()} == {
        "found": 1.0, "named": 0.5, "in the set": 0.5, "misnamed": 0.5}
    assert not rows[3.0]["misnamed"].met and rows[3.0]["found"].met and not rows[1.0]["found"].met
    text = table.text_of(answers, {"seed": 1, "seconds": 2.0})
    assert re.search(r"3 and more +found +100.0 % .* 2/2 +>= 0.95 +met", text)
    assert [row["cases"] for row in json.loads(table.json_of(answers, {}))["by_rho"]] == [1, 1, 2]


def test_gain_is_measured_against_the_same_drive_without_the_effect():
    gain = {
        "voltage": {"heldout_rms_before": 10.0, "heldout_rms_after": 5.0, "noise_floor": 0.1},
        "motor_speed": {"heldout_rms_before": 900.0, "heldout_rms_after": 900.0, "noise_floor": 1.0},
    }
    it = judged("named", [cause("mass")])
    it.answer.gain, it.answer.sound_rms = gain, {"voltage": 5.0, "motor_speed": 899.0}
    assert it.gain_share() == pytest.approx(1.0)
    it.answer.sound_rms = {"voltage": 2.0, "motor_speed": 899.0}
    assert it.gain_share() == pytest.approx(75.0 / 96.0)
    it.answer.sound_rms = {}
    assert it.gain_share() is None


def test_a_bent_curve_is_as_large_as_it_is_where_it_was_driven():
    fixed = {"first": np.array([0.0]), "second": np.array([0.0]), "third": np.array([-2.0])}
    hidden = hide.Hidden(effects.BY_NAME["ocv_shape"], np.array([0.02]), fixed)
    whole, shallow = {"soc": np.array([[1.0, 0.0]])}, {"soc": np.array([[1.0, 0.95]])}
    assert cases.bend_driven(hidden, whole) == pytest.approx(0.02, rel=0.01)
    charge = np.linspace(0.95, 1.0, 1000)
    there = 0.02 * np.sqrt(2.0) * np.sqrt(np.mean(np.sin(3.0 * np.pi * charge) ** 2))
    assert cases.bend_driven(hidden, shallow) == pytest.approx(there, rel=0.01)
    assert there < 0.01


def test_the_drive_without_the_effect_has_the_same_noise():
    made = cases.Maker(np.random.default_rng(1), "cell", 460.0, ["series_resistance", "initial_soc"], 0, 1, 0).make()
    assert [case.label["d_prime"] >= cases.CLEAR for case in made.cases] == [True, True]
    for case in made.cases:
        assert (case.sound["current"] == case.log["current"]).all()
        changed = "soc" if case.label["effects"][0]["name"] == "initial_soc" else "voltage"
        assert (case.sound[changed] != case.log[changed]).any()


def test_the_teams_heat_test_tells_how_far_a_surface_lags_and_that_one_mass_has_none():
    def made(family):
        cells = world.make(np.random.default_rng(3), "cell", 4, family).cells
        core, surface, within, air = (
            getattr(cells, name).mean(1) for name in ("core_j_per_k", "surface_j_per_k", "core_w_per_k", "air_w_per_k")
        )
        return core, surface, within, air, *models.heat_of(cells, family).T

    core, surface, within, air, capacity, conductance, lag = made("particle")
    # The two poles of core and surface, seen from the surface, are those of one mass and its lag.
    assert capacity * lag == pytest.approx(core * surface / within, rel=0.03)
    assert capacity + lag * conductance == pytest.approx(core * (1 + air / within) + surface, rel=0.003)
    assert conductance == pytest.approx(air, rel=1e-3)
    core, surface, _, air, capacity, conductance, lag = made("circuit")
    assert capacity == pytest.approx(core + surface, rel=1e-3) and conductance == pytest.approx(air, rel=1e-3)
    assert np.all((0.0 <= lag) & (lag < 0.01))


def test_a_failed_answer_is_neither_found_nor_an_answer_for_clean():
    it = score.Judged("x", judged("", truth=(), ask="clean").label, tool.Answer(failed="exit code 1"))
    assert score.marks([it])[0].value == 1.0 and "exit code 1" in table.text_of([it], {"seed": 1, "seconds": 1.0})


@pytest.mark.parametrize("change", [{"verdict": "sure"}, {"causes": None}])
def test_answer_that_breaks_the_contract_is_a_failure(change, tmp_path):
    whole = {
        "verdict": "named",
        "sentence": "",
        "causes": [],
        "unknown_in": None,
        "gain": {},
        "masked": [],
        "next_test": None,
        "extended_model": None,
        "mode": "reference",
        "seed": 1,
        "version": "x",
    }
    path = tmp_path / "answer.json"
    path.write_text(json.dumps(whole))
    assert not tool.read(path).failed
    broken = {**whole, **change}
    if broken["causes"] is None:
        del broken["causes"]
    path.write_text(json.dumps(broken))
    assert "contract" in tool.read(path).failed


@pytest.fixture(scope="module")
def small_trial(tmp_path_factory):
    out = tmp_path_factory.mktemp("trial")
    spy = out / "spy.py"
    spy.write_text(
        "#!/usr/bin/env python3\nimport os, subprocess, sys\n"
        f"with open({str(out / 'seen.txt')!r}, 'a') as to:\n"
        "    print(sys.argv[1], os.getcwd(), sorted(os.listdir('.')), dict(os.environ), *sys.argv[2:], file=to)\n"
        "    if sys.argv[1] == 'explain':\n"
        "        for name in os.listdir('..'):\n"
        "            path = os.path.join('..', name)\n"
        "            print('beside', name, os.path.isfile(path) and open(path).read(), file=to)\n"
        f"sys.exit(subprocess.run([sys.executable, {str(HERE / 'stand_in.py')!r}, *sys.argv[1:]]).returncode)\n"
    )
    spy.chmod(0o755)
    command = [
        sys.executable,
        HERE.parents[1] / "toolchain/explain_bench.py",
        "--tool",
        spy,
        "--quick",
        "--seed",
        "8",
        "--kind",
        "cell",
        "--jobs",
        "1",
        "--duration",
        "460",
        "--clean",
        "2",
        "--cause",
        "series_resistance",
        "--cause",
        "quantisation",
    ]
    result = subprocess.run(
        [
            *map(str, command),
            "--json",
            str(out / "marks.json"),
            "--csv",
            str(out / "cases.csv"),
            "--ledger",
            str(out / "ledger"),
        ],
        capture_output=True,
        text=True,
    )
    assert result.returncode == 0, result.stderr
    return out, result


def test_trial_finds_what_the_stand_in_can_and_writes_it_down(small_trial):
    out, result = small_trial
    marks = json.loads((out / "marks.json").read_text())
    assert marks["seed"] == 8 and marks["questions"] == len((out / "cases.csv").read_text().splitlines()) - 1 >= 3
    assert marks["causes"]["series_resistance"]["named"]["share"] == 1.0
    assert "quantisation" in marks["causes"]
    assert "NOT MET" in result.stdout and "no answer" not in result.stdout
    seal.verify(out / "ledger/commitments.txt", out / "ledger/revealed.jsonl")


def test_tool_sees_no_label(small_trial):
    """Neither the name of an effect nor its size in what the tool is given: folder, names, arguments, environment, and
    what lies beside the folder. The one exception is the cause that it is told to leave out."""
    out, _ = small_trial
    seen = (out / "seen.txt").read_text()
    assert seen.count("explain /") >= 3
    told = seen.replace("--set explain.without=series_resistance", "")
    for effect in effects.ALL:
        assert effect.name not in told, effect.name
    labels = [json.loads(line) for line in (out / "ledger/revealed.jsonl").read_text().splitlines()]
    for entry in labels:
        assert re.fullmatch("[0-9a-f]{16}", entry["name"])
        assert entry["salt"] not in seen
        for effect in entry["label"]["effects"]:
            for value in effect["parameters"].values():
                assert str(value) not in seen or len(str(value)) < 6
    for line in seen.splitlines():
        if line.startswith("beside"):
            assert re.match(r"beside ([0-9a-f]{16} False|commitments.txt )", line) or re.match(
                "[0-9a-f]{16} [0-9a-f]{64}", line
            )


def test_every_label_was_committed_before_the_first_question(small_trial):
    out, _ = small_trial
    names = {line.split()[0] for line in (out / "ledger/commitments.txt").read_text().splitlines()}
    first = (out / "seen.txt").read_text().split("explain /", 1)[1]
    assert all(name in first.split("explain /")[0] for name in names)


def recorded(noise_v=0.02, steps=6000):
    """Ten minutes of a pack of 0.1 ohm whose residual wanders."""
    rng = np.random.default_rng(2)
    time_s = np.arange(steps) * 0.1
    current = 50.0 + 40.0 * np.sign(np.sin(time_s / 3.0)) + rng.normal(0.0, 5.0, steps)
    return {"time": time_s, "current": current, "pack_voltage": 100.0 - 0.1 * current + rng.normal(0.0, noise_v, steps)}


def test_detectable_size_in_a_recording_is_its_standard_error():
    log = recorded()
    one = real.standard_error(log, real.contact(log, 0.01), 0.01, real.pack_voltage)
    assert one == pytest.approx(0.02 / np.sqrt((log["current"] ** 2).sum()), rel=0.5)
    more = real.standard_error(recorded(0.2), real.contact(recorded(0.2), 0.01), 0.01, real.pack_voltage)
    assert more == pytest.approx(10 * one, rel=0.3)


def test_injections_are_exact():
    log = recorded()
    assert (real.gain(log, 0.02)["current"] == 1.02 * log["current"]).all()
    assert (log["pack_voltage"] - real.contact(log, 0.01)["pack_voltage"]) == pytest.approx(0.01 * log["current"])
    late = real.skew(log, 0.2)["current"]
    assert late[2:] == pytest.approx(log["current"][:-2])
    assert real.dropped(log, 0.1)["time"].size == pytest.approx(5400, abs=100)
    assert set(np.round(real.quantised(log, 5.0)["current"] % 5.0, 9)) == {0.0}


def test_injection_that_was_reported_before_is_not_found_by_it():
    injection = next(it for it in real.INJECTIONS if it.kind == "time_skew")
    answer = tool.Answer("named", [cause("time_skew")])
    assert real.Outcome("x", injection, 3.0, 0.1, answer).right
    assert not real.Outcome("x", injection, 3.0, 0.1, answer, frozenset({"time_skew"})).right
    assert not real.Outcome("x", None, 0.0, 0.0, answer).right
    assert real.Outcome("x", None, 0.0, 0.0, tool.Answer("no_discrepancy")).right


def test_pieces_that_make_the_model_the_known_good_logs_and_the_questions_are_different_ones(tmp_path):
    log = recorded()
    shown = []
    for part in (real.third(0), real.third(1, 0), real.third(1, 1), real.third(1, 2), real.third(2)):
        real.write(tmp_path / "log.csv", log, part)
        rows = [line.split(",") for line in (tmp_path / "log.csv").read_text().splitlines()[1:]]
        assert len(rows) == 6000 and all(row[1] for row in rows)
        shown.append({int(float(row[0]) / 20.0 + 1e-9) for row in rows if row[2] and float(row[0]) >= 40.0})
    assert sorted(piece for pieces in shown for piece in pieces) == list(range(2, 30))
    assert [min(pieces) for pieces in shown] == [3, 10, 4, 7, 2]


def test_what_is_named_beside_an_injection_is_misnamed():
    injection = next(it for it in real.INJECTIONS if it.kind == "time_skew")
    other = tool.Answer("named", [cause("time_skew"), cause("capacity")])
    beside = real.Outcome("x", injection, 3.0, 0.1, other)
    assert beside.misnamed and not beside.named
    assert real.Outcome("x", injection, 3.0, 0.1, tool.Answer("named", [cause("time_skew")])).named
    assert not real.Outcome("x", injection, 3.0, 0.1, tool.Answer("ambiguous", [cause("capacity")])).misnamed


SOURCES = (".cpp", ".hpp", ".py", ".txt", ".cmake", ".toml", ".h")


def test_neither_side_knows_the_other():
    """No file of the tool names the truth's folder, and no file of the truth includes or imports the tool's."""
    for folder in ("plant_sim", "firmware", "can_dbc"):
        for file in (ROOT / folder).rglob("*"):
            if file.suffix in SOURCES and file.is_file():
                assert "tests/controls" not in file.read_text(errors="replace"), file
    tools = [f"plant_sim/{p.name}" for p in (ROOT / "plant_sim").iterdir() if p.is_dir()]
    for file in [*(HERE / "truth").glob("*.py"), *(HERE / "bank").glob("*.py")]:
        text = file.read_text()
        assert "#include" not in text and "ctypes" not in text and "sys.path" not in text, file
        assert not any(name in text for name in tools), file


def test_tool_holds_no_name_of_the_trial():
    binary = Path(os.environ["VOLTLAP_BUILD_DIR"]) / "bin/voltlap"
    if not binary.is_file():
        pytest.skip("voltlap is not built")
    content = binary.read_bytes()
    for word in (
        b"tests/controls",
        b"explain_bench",
        b"commitments.txt",
        b"revealed.jsonl",
        b"positive_potential",
        b"times_detectable",
    ):
        assert word not in content, word


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_interrupted_trial_ends_at_once_and_leaves_nothing(number, tmp_path):
    environment = dict(os.environ, TMPDIR=str(tmp_path))
    process = subprocess.Popen(
        [*map(str, BENCH), "--quick", "--seed", "1", "--kind", "cell", "--jobs", "1"],
        env=environment,
        stderr=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    end = time.monotonic() + 30.0
    while not list(tmp_path.glob("explain-bench-*")) and time.monotonic() < end:
        time.sleep(0.1)
    time.sleep(2.0)
    os.killpg(process.pid, number)
    _, errors = process.communicate(timeout=30)
    assert process.returncode == 130 and "nothing is kept" in errors
    assert "Traceback" not in errors
    assert list(tmp_path.glob("explain-bench-*")) == []


@pytest.mark.parametrize(
    "flags, words",
    [
        (["--seed", "-1"], "--seed -1"),
        (["--duration", "10"], "460 or more"),
        (["--tool", "/absent"], "./voltlap build"),
    ],
)
def test_wrong_flags_are_answered_in_one_line(flags, words):
    result = subprocess.run([*map(str, BENCH), *flags], capture_output=True, text=True)
    assert result.returncode == 2 and words in result.stderr and "Traceback" not in result.stderr
