# SPDX-License-Identifier: Apache-2.0
"""The mirror hides what it says it hides, of the size that it says, and counts right."""

import os
import tomllib
from pathlib import Path

import numpy as np
import pytest
from bank.score import Judged
from bank.tool import Answer
from mirror import battery, cases, catalogue, drives, effects, marks, size, table, trial
from mirror.effects import Scene, hysteresis, lagged

BIN = Path(os.environ["VOLTLAP_BUILD_DIR"]) / "bin"
SIZES = {"ocv_shape": 0.004, "capacity": 0.03, "resistance_temperature": 8000.0, "resistance_current": 0.4,
         "resistance_soc": 0.5, "hysteresis": 0.006, "entropic_heat": 1e-4, "heat_capacity": 0.2}
OF_A_CELL = [effect for effect in catalogue.CELL if "cell" in effect.kinds]


@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    """A cell on a cycler, whose current does not depend on the cell; drives it with the keys of an effect."""
    folder = tmp_path_factory.mktemp("bench")
    car = drives.cell_on_bench(np.random.default_rng(3), noise=False)
    (folder / "cell.toml").write_text(car.text)
    simulator = drives.Simulator(BIN / "voltlap", BIN / "voltlap-learn")
    keys = ("schedule.step=0.2", "rest.seconds=300", "box.mode=free", "test.temperature_c=26",
            "stop.cell_voltage_min_v=3.2")
    settings = drives.Settings(1, keys, ("hppc",))

    def drive(name, extra=()):
        _, truth = simulator.drive(car, folder, settings, name, extra)
        return drives.read_truth(truth, car)

    return car, drive


@pytest.mark.parametrize("effect", OF_A_CELL, ids=lambda effect: effect.name)
def test_what_an_effect_adds_by_hand_is_what_the_simulator_adds(effect, bench):
    car, drive = bench
    sound = drive("sound")
    tau_s = 20.0 if effect.name == "polarization_resistance" else 400.0
    scene = Scene(car, sound, tau_s=tau_s, weights=(1.0, 0.4, -0.2))
    amount = SIZES.get(effect.name, 2e-4)
    driven = drive(effect.name, effect.keys(scene, amount))
    rows = min(len(sound), len(driven))
    other = np.abs(driven.current_a[:rows] - sound.current_a[:rows]) > 0.5
    rows = np.argmax(np.append(other, True))  # one of them ends earlier
    rho, channel = size.rho_of(effect, scene, amount)
    shown = {"voltage": driven.voltage_v[:rows] - sound.voltage_v[:rows],
             "temperature": driven.temperature_c[:rows] - sound.temperature_c[:rows]}[channel]
    by_hand = effect.adds(scene, amount)[channel][:rows]
    columns = size.starts(channel, scene)[:rows]
    shown, by_hand = size.refitted(shown, columns), size.refitted(by_hand, columns)
    assert rows > 10000 and rho > 0.5
    assert np.corrcoef(shown, by_hand)[0, 1] > 0.97
    near = 0.10 if channel == "voltage" else 0.35  # the air of the bench's box warms; here it does not
    assert np.sqrt(np.mean(by_hand**2)) == pytest.approx(np.sqrt(np.mean(shown**2)), rel=near)


OF_A_CAR = {"mass": 0.1, "drag_area": 0.4, "rolling_resistance": 1.0, "tyre_radius": 0.05, "motor_constant": 0.05,
            "inverter_efficiency": 1.0, "auxiliary_load": 200.0}


@pytest.fixture(scope="module")
def track(tmp_path_factory):
    """A sound car, and two laps of it with the keys of an effect."""
    folder = tmp_path_factory.mktemp("track")
    car = drives.draw_car(np.random.default_rng(8), "car", quick=True)
    (folder / "vehicle.toml").write_text(car.vehicle)
    simulator = drives.Simulator(BIN / "voltlap", BIN / "voltlap-learn")
    settings = drives.Settings(1, ("battery.initial_soc=0.9",), ("--laps", "2", "--track", "michigan_2015"))

    def drive(name, keys=()):
        _, truth = simulator.drive(car, folder, settings, name, keys)
        return Scene(car, drives.read_truth(truth, car))

    return car, drive


def unbalanced(scene, turning_kg=0.0):
    """Rows under power, and what the sound car's numbers leave of force [N] and power [W] there."""
    truth, kg = scene.truth, scene.car.masses_kg
    rows = truth.free & (truth.torque_a > 1.0)
    against = catalogue.drag(scene, 1.0) + catalogue.rolling(scene, 1.0) + (kg + turning_kg) * truth.acceleration
    return rows, {"force": (effects.pull(scene) - against)[rows],
                  "power": (truth.power_w - effects.motor_power(scene))[rows]}


@pytest.mark.parametrize("name", OF_A_CAR)
def test_what_an_effect_of_a_car_adds_by_hand_is_what_the_simulator_adds(name, track):
    _, drive = track
    sound = drive("sound")
    rows, left = unbalanced(sound)
    acceleration = sound.truth.acceleration[rows]
    turning_kg = float(left["force"] @ acceleration / (acceleration @ acceleration))  # wheels and motor
    effect = next(e for e in catalogue.CAR if e.name == name)
    scene = drive(name, effect.keys(sound, OF_A_CAR[name]))
    rows, shown = unbalanced(scene, turning_kg)
    shown["power"] = shown["power"] - left["power"].mean()
    for channel, values in effect.adds(scene, OF_A_CAR[name]).items():
        assert abs(shown[channel] @ values[rows]) / (values[rows] @ values[rows]) == pytest.approx(1.0, abs=0.25)


def square_wave():
    """A scene with a current of 100 A that is on for half a minute and off for half a minute."""
    current = np.tile(np.repeat([100.0, 0.0], 300), 10)
    cell = battery.Cell.named("aesc_e5_2p")
    soc = 0.8 - cell.drawn(current, 0.1)
    truth = drives.Truth(0.1, current, soc, np.full(len(current), 30.0), cell.ocv(soc) - 0.002 * current)
    car = drives.Car("pack", "", cell, 24, 1, 6, 26.85, noise=True, candump=True, whole=False)
    return Scene(car, truth)


def effect_of(name, form=""):
    return next(e for e in catalogue.ALL if e.name == name and e.form == form)


def test_rho_of_a_resistance_is_its_rms_over_a_millivolt():
    scene = square_wave()
    rho, channel = size.rho_of(effect_of("series_resistance"), scene, 1e-4)
    assert channel == "voltage"
    assert rho == pytest.approx(5.0, rel=0.15)  # 10 mV, half of the time: an RMS of 5 about its mean
    assert size.rho_of(effect_of("contact_resistance"), scene, 2e-3)[0] == pytest.approx(0.2 * 0.5**0.5 / 0.02)


def test_a_start_that_may_be_refitted_is_no_effect():
    scene = square_wave()
    offset = effect_of("voltage_offset", "one cell")
    assert size.rho_of(offset, scene, 0.01)[0] < 3.0  # of 10 mV most is what a cell's own charge makes


def test_size_has_the_wanted_rho_and_ends_at_what_happens_in_practice():
    scene = square_wave()
    effect = effect_of("weak_cell", "resistance")
    wanted = size.sized(effect, scene, 1, 4.0)
    assert size.rho_of(effect, scene, wanted)[0] == pytest.approx(4.0, rel=0.01)
    assert size.sized(effect, scene, 1, 1e6) == effect.most
    late = size.sized(effect_of("time_skew", "current"), scene, 1, 30.0)
    assert late == pytest.approx(0.01 * round(late / 0.01)) and late >= 0.01  # the simulator delays by whole steps


def test_heat_behind_coarse_steps_is_invisible_and_a_resistance_is_not():
    scene = square_wave()
    scene.truth.temperature_c = 28.0 + 0.3 * np.linspace(0.0, 1.0, len(scene.truth))
    rng = np.random.default_rng(1)
    assert not size.visible(effect_of("cooling"), scene, 0.1, rng)
    assert size.visible(effect_of("series_resistance"), scene, 5e-5, rng)
    assert not size.visible(effect_of("series_resistance"), scene, 1e-8, rng)
    scene.car.candump = False  # the CSV of the simulator has no steps
    assert size.visible(effect_of("ambient"), scene, 15.0, rng)


def test_lag_and_hysteresis_are_those_of_their_equations():
    answer = lagged(np.ones(1000), 10.0, 0.1)
    assert answer[99] == pytest.approx(1.0 - np.exp(-1.0), abs=0.01)
    there_and_back = np.concatenate([np.linspace(0.0, 0.5, 200), np.linspace(0.5, 0.0, 200)])
    state = hysteresis(there_and_back, 20.0, 0.0)
    assert state[199] == pytest.approx(1.0, abs=1e-3) and state[-1] == pytest.approx(-1.0, abs=1e-3)


def test_the_seed_draws_everything_and_nothing_else_does():
    plan = cases.Plan(5)
    first, again, other = (cases.draw_world(p, 3) for p in (plan, cases.Plan(5), cases.Plan(6)))
    assert first.car == again.car and first.cases == again.cases and first.references == again.references
    assert first.car != other.car
    assert {cases.kind_of(plan, number) for number in range(6)} == set(drives.KINDS)
    assert {cases.kind_of(cases.Plan(5, kinds=("cell",)), number) for number in range(6)} == {"cell"}


def test_each_world_has_sound_logs_and_effects_that_its_logs_can_hold():
    for number in range(30):
        world = cases.draw_world(cases.Plan(11), number)
        hidden = [case.hidden for case in world.cases if case.hidden]
        assert len(world.cases) == cases.PER_WORLD and len(hidden) == cases.PER_WORLD - cases.SOUND
        assert all(world.car.kind in h.effect.kinds for h in hidden)
        assert world.car.candump or not any(h.effect.sensor for h in hidden)
        tomllib.loads(world.car.text)
        assert "effects" not in world.car.text


def test_true_model_of_a_cell_is_its_file_with_what_was_hidden():
    car = drives.cell_on_bench(np.random.default_rng(3), noise=False)
    with_effect = tomllib.loads(drives.true_cell(car.text, ("cell.effects.ocv_change_v=[0.0,0.01]",)))
    assert with_effect["effects"] == {"ocv_change_v": [0.0, 0.01]}
    other = tomllib.loads(drives.true_cell(car.text, ("cell.capacity_ah=50.5",)))
    assert other["capacity_ah"] == 50.5 and "effects" not in other


def test_only_what_was_asked_for_is_hidden():
    world = cases.draw_world(cases.Plan(11, causes=("capacity",)), 0)
    assert {case.hidden.effect.name for case in world.cases if case.hidden} == {"capacity"}


def test_every_kind_of_cause_is_one_that_explain_knows():
    causes = Path(__file__).resolve().parents[2] / "plant_sim/explain/causes"
    assert set(catalogue.NAMES) <= {path.stem for path in causes.glob("*.cpp")}
    assert set(catalogue.TAU_S) <= set(catalogue.NAMES)


def outcome(number, verdict, said=(), truth=(), rho=5.0, visible=True, weight=1.0, references=0):
    label = {"number": number, "kind": "cell", "cells": "1s1p", "format": "CSV", "noise": True, "whole": True,
             "references": references, "d_prime": 0.0, "ask": "single" if truth else "sound", "rho": rho, "visible": visible,
             "channel": "voltage",
             "effects": [{"name": name, "parameters": {"change": 0.1}, "d_prime": 0.0} for name in truth]}
    causes = [{"name": name, "equivalent_to": [], "parameters": {
        "change": {"value": 0.11, "ci95_low": 0.09, "ci95_high": 0.13, "unit": "1"}}} for name in said]
    return trial.Outcome(label, {"one": Judged(str(number), label, Answer(verdict, causes))}, weight=weight)


def test_marks_count_by_rho_and_leave_out_what_no_log_can_show():
    said = marks.said_by("one", [
        outcome(0, "no_discrepancy"), outcome(1, "unknown"),
        outcome(2, "named", ["mass"], ["mass"]), outcome(3, "named", ["grip"], ["mass"]),
        outcome(4, "no_discrepancy", truth=["mass"], rho=2.0), outcome(5, "named", ["grip"], ["mass"], visible=False)])
    assert str(marks.alarms(said)).endswith("1/2")
    clear = marks.shares(marks.in_bin(marks.effects(said), 3.0, 1e9))
    assert {what: (s.hits, s.of) for what, s in clear.items()} == {
        "found": (2, 2), "named": (1, 2), "in the set": (1, 2), "misnamed": (1, 2)}
    assert marks.shares(marks.in_bin(marks.effects(said), 1.0, 3.0))["found"].of == 1
    error, covered = marks.sizes(marks.effects(said))
    assert error == pytest.approx(0.1) and (covered.hits, covered.of) == (1, 1)
    assert marks.instead(marks.effects(said)) == {"named + grip": 1, "no_discrepancy": 1}


def test_what_is_asked_with_references_is_counted_apart_from_what_is_asked_without():
    outcomes = [outcome(0, "unknown", references=3), outcome(1, "no_discrepancy"),
                outcome(2, "named", ["mass"], ["mass"], references=1),
                outcome(3, "named", ["mass"], ["mass"], references=3),
                outcome(4, "no_discrepancy", truth=["mass"])]
    lines = table.text_of(outcomes, ["one"], {"seed": 4}, str).splitlines()
    found = [line for line in lines if line.startswith("rho of 3 and more: found")]
    assert [line.split("]")[1].split()[0] for line in found] == ["2/2", "0/1"]
    assert [line.split()[-2] for line in found] == ["97", "95"]
    alarms = [line for line in lines if line.startswith("sound logs with")]
    assert [line.split("]")[1].split()[0] for line in alarms] == ["1/1", "0/1"]
    found = table.engine_json(marks.said_by("one", outcomes))
    assert [(found[key]["found"]["hits"], found[key]["found"]["of"]) for key in (
        "with_references", "without_references")] == [(2, 2), (0, 1)]


def test_smallest_failing_case_is_the_one_with_the_least_to_read():
    said = marks.said_by("one", [
        outcome(0, "unknown", weight=9.0), outcome(1, "named", ["grip"], ["mass"], weight=3.0),
        outcome(2, "no_discrepancy", truth=["mass"], rho=2.0, weight=1.0)])  # below three: not a failure
    assert marks.smallest_failing(said).label["number"] == 1
    assert marks.smallest_failing(said[2:]) is None


def test_gain_is_told_where_the_true_model_takes_most():
    promised = {"voltage": {"heldout_rms_before": 10.0, "heldout_rms_after": 1.0}}
    gain = trial.gain_of({"voltage": 8.0, "temperature": 1.0}, {"voltage": 4.0, "temperature": 1.0},
                         {"voltage": 2.0, "temperature": 0.9}, promised)
    assert gain["channel"] == "voltage" and gain["real"] == 0.75 and gain["true"] == pytest.approx(0.9375)
    assert gain["promised"] == pytest.approx(0.99)
    assert trial.gain_of({"voltage": 8.0}, {"voltage": 8.0}, {"voltage": 7.99}, promised) is None  # nothing to win
    promised["voltage"]["heldout_rms_before"] = 0.0  # no reading of it was kept back
    assert trial.gain_of({"voltage": 8.0}, {"voltage": 2.0}, {"voltage": 1.0}, promised) is None


def test_table_and_json_have_the_same_counts():
    outcomes = [outcome(0, "no_discrepancy"), outcome(1, "named", ["mass"], ["mass"])]
    text = table.text_of(outcomes, ["one"], {"seed": 4}, lambda number: f"again {number}")
    assert "sound logs: alarms" in text and "rho of 3 and more: named" in text and "again" not in text
    found = table.engine_json(marks.said_by("one", outcomes))
    assert found["rho"][2]["named"]["hits"] == 1 and found["smallest_failing_case"] is None
