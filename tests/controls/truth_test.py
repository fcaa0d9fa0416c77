# SPDX-License-Identifier: Apache-2.0
"""The hidden truth obeys the laws it claims, hides what it is asked to, and knows nothing of the project."""
import ast
import copy
import dataclasses
from pathlib import Path

import numpy as np
import pytest
from truth import cell, circuit, drive, effects, hide, instruments, observer, world

HERE = Path(__file__).resolve().parent
DURATION_S = 460.0


def one_pack(cases=1, cells=1, **wrong):
    rng = np.random.default_rng(3)
    made = cell.design(rng, cases, cells, spread=0.0).widened((cases, cells))
    for name, value in wrong.items():
        setattr(made, name, np.zeros((cases, cells)) + value)
    return made


def held(made, current_a, duration_s, charge=0.8, temperature_k=cell.REFERENCE_K):
    steps = int(duration_s / drive.STEP_S)
    shape = made.capacity_ah.shape
    pack = cell.Pack(made, np.full(shape, charge), temperature_k)
    current = np.broadcast_to(np.asarray(current_a, float), (steps,))[None].repeat(shape[0], 0)
    air_k, standing = np.full(shape[0], temperature_k), np.zeros((shape[0], steps), bool)
    return pack, cell.run(pack, drive.STEP_S, air_k, standing, current)


def test_rest_stays_at_rest():
    _, history = held(one_pack(), 0.0, 100.0)
    assert np.ptp(history.voltage_v) < 1e-12 and np.ptp(history.surface_k) == 0.0
    assert history.voltage_v[0, 0, 0] == pytest.approx(cell.open_circuit(np.array(0.8)), abs=1e-12)


def test_charge_that_leaves_is_the_charge_that_is_gone():
    made = one_pack()
    pack, _ = held(made, 30.0, 360.0)
    gone = 30.0 * 360.0 / 3600.0 / made.capacity_ah[0, 0]
    assert 0.8 - pack.charge[0, 0] == pytest.approx(gone, rel=1e-9)
    volume = pack._volume[:, 0, 0] * 3.0
    filling = (volume * pack.negative[:, 0, 0]).sum()
    full, empty = cell.NEGATIVE_FULL, cell.NEGATIVE_EMPTY
    assert (filling - empty) / (full - empty) == pytest.approx(0.8 - gone, rel=1e-9)


def test_voltage_relaxes_to_that_of_the_charge_left():
    made = one_pack(air_w_per_k=0.0)
    current = np.r_[np.full(1200, 20.0), np.zeros(60000)]
    pack, history = held(made, current, current.size * drive.STEP_S)
    assert history.voltage_v[0, -1, 0] == pytest.approx(cell.open_circuit(pack.charge)[0, 0], abs=2e-4)


def test_heat_that_is_made_is_the_heat_that_is_there():
    made = one_pack(air_w_per_k=0.0)
    pack, history = held(made, 40.0, 300.0)
    charge = history.charge[0, :, 0]
    made_j = (40.0 * (cell.open_circuit(charge) - history.voltage_v[0, :, 0])).sum() * drive.STEP_S
    core_k, surface_k = pack.core - cell.REFERENCE_K, pack.surface - cell.REFERENCE_K
    kept_j = (made.core_j_per_k * core_k + made.surface_j_per_k * surface_k)[0, 0]
    assert kept_j == pytest.approx(made_j, rel=1e-9)


def test_small_currents_see_the_slope_of_butler_volmer():
    made = one_pack(film_ohm=0.0, electrolyte_ohm=0.0)
    _, history = held(made, 0.1, 0.2, charge=0.5)
    x = 0.5 * (cell.NEGATIVE_EMPTY + cell.NEGATIVE_FULL)
    y = 0.5 * (cell.POSITIVE_EMPTY + cell.POSITIVE_FULL)
    thermal = cell.GAS * cell.REFERENCE_K / cell.FARADAY
    slope = thermal * (1 / (2 * made.negative_exchange_a * np.sqrt(x * (1 - x)))
                       + 1 / (2 * made.positive_exchange_a * np.sqrt(y * (1 - y))))[0, 0]
    first = cell.open_circuit(np.array(0.5)) - history.voltage_v[0, 0, 0]
    width = 0.5 / cell.SHELLS  # the surface is half a shell away from the last node
    per_second = 0.1 / (3600.0 * made.capacity_ah[0, 0])
    dx = width * per_second * (cell.NEGATIVE_FULL - cell.NEGATIVE_EMPTY) / 3.0 * made.negative_diffusion_s[0, 0]
    dy = width * per_second * (cell.POSITIVE_EMPTY - cell.POSITIVE_FULL) / 3.0 * made.positive_diffusion_s[0, 0]
    diffusion = (cell.positive_potential(y) - cell.negative_potential(x)
                 - cell.positive_potential(y + dy) + cell.negative_potential(x - dx))
    assert first - diffusion == pytest.approx(0.1 * slope, rel=1e-3)


def test_circuit_obeys_charge_and_heat_as_the_particle_does():
    made = one_pack(air_w_per_k=0.0).widened((1, 1))
    pack = circuit.Circuit(made, np.full((1, 1), 0.8), cell.REFERENCE_K)
    current = np.r_[np.full(600, 30.0), np.zeros(20000)][None]
    history = cell.run(pack, drive.STEP_S, np.full(1, cell.REFERENCE_K), np.zeros(current.shape, bool), current)
    gone = 30.0 * 60.0 / 3600.0 / made.capacity_ah[0, 0]
    assert 0.8 - pack.charge[0, 0] == pytest.approx(gone, rel=1e-9)
    assert history.voltage_v[0, -1, 0] == pytest.approx(cell.open_circuit(pack.charge)[0, 0], abs=1e-6)
    lost_v = cell.open_circuit(history.charge[0, :, 0]) - history.voltage_v[0, :, 0]
    lost_j = (current[0] * lost_v).sum() * drive.STEP_S
    kept_j = ((made.core_j_per_k + made.surface_j_per_k) * (pack.core - cell.REFERENCE_K))[0, 0]
    assert kept_j == pytest.approx(lost_j, rel=1e-9)
    assert (pack.surface == pack.core).all()


@pytest.mark.parametrize("family", world.FAMILIES)
def test_a_weak_cell_has_as_much_more_resistance_as_it_says(family):
    sound = world.make(np.random.default_rng(4), "pack", 1, family)
    more, cell_number = 0.2, 3
    changed = copy.deepcopy(sound)
    effects.weak(changed, None, np.full(1, more), {"cell": np.full(1, cell_number), "by_capacity": np.zeros(1)})
    share = (cell.pulse_ohm(changed.pack, changed.cells, changed.shape)
             / cell.pulse_ohm(sound.pack, sound.cells, sound.shape))[0]
    # Its heat warms it by some hundredths of a kelvin within the pulse.
    assert share[cell_number - 1] == pytest.approx(1.0 + more, rel=3e-4)
    assert np.delete(share, cell_number - 1) == pytest.approx(1.0, rel=1e-6)


def test_closed_form_of_a_memory_is_its_recursion():
    kick, state = np.random.default_rng(1).standard_normal((2, 3000)), np.array([1.0, -2.0])
    quick = instruments.remembered(kick, 0.97, state)
    for k in range(3000):
        state = 0.97 * state + kick[:, k]
        assert quick[:, k] == pytest.approx(state, abs=1e-10)


def test_wander_has_the_memory_that_it_claims():
    rng = np.random.default_rng(0)
    noise = instruments.wander(rng, (200, 2000), 2.0, 10.0, 0.1)
    assert noise.std() == pytest.approx(2.0, rel=0.05)
    assert (noise[:, 100:] * noise[:, :-100]).mean() / 4.0 == pytest.approx(np.exp(-1.0), abs=0.05)


def test_every_world_has_a_logger_of_its_own():
    first, second = (world.make(np.random.default_rng(seed), "car", 1).instruments.noise for seed in (1, 2))
    for kind, noise in first.items():
        assert noise != second[kind]
        for low, number, high in zip(*map(dataclasses.astuple, (
                instruments.FINEST[kind], noise, instruments.COARSEST[kind]))):
            assert low <= number <= high


def noise_of_a_pack(rng, quiet, noises, current, fast, slow):
    """Noise (m, steps) of channels without resolution that follow a current read with that noise."""
    out = np.stack([instruments.noisy(rng, np.zeros(quiet.shape[1]), noise, drive.STEP_S) for noise in noises])
    out += np.outer(fast, current.white * rng.standard_normal(quiet.shape[1]))
    return out + np.outer(slow, instruments.wander(rng, (quiet.shape[1],), current.wander, current.memory_s,
                                                   drive.STEP_S))


def test_what_leaves_the_observers_filter_is_white_when_nothing_is_wrong():
    rng = np.random.default_rng(0)
    quiet = np.cumsum(rng.standard_normal((3, 6000)), 1)
    noises = [instruments.Noise(white, 2.0, 30.0, 0.0) for white in (1.0, 0.5, 2.0)]
    current, fast, slow = instruments.Noise(1.0, 0.5, 60.0, 0.0), np.array([1.0, 1.0, 8.0]), np.array([2.0, 2.0, 9.0])
    filter_ = observer.Filter(noises, quiet, current, observer.Sensitivity(fast, slow))
    white = filter_.apply(np.stack([noise_of_a_pack(rng, quiet, noises, current, fast, slow) for _ in range(20)]))
    white = white.reshape(20, 3, 6000)
    assert white.var((0, 2)) == pytest.approx(1.0, rel=0.03)
    assert np.einsum("ckt,cjt->kj", white, white) / (20 * 6000) == pytest.approx(np.eye(3), abs=0.03)
    assert (white[:, :, 1:] * white[:, :, :-1]).mean() == pytest.approx(0.0, abs=0.02)


def test_steps_that_no_noise_blurs_hide_what_is_slow():
    slow = np.linspace(0.0, 5.0, 6000)[None]
    current, none = instruments.Noise(0.1, 0.05, 60.0, 0.01), observer.Sensitivity(np.zeros(1), np.zeros(1))

    def told(step, white):
        noise = instruments.Noise(white, 1e-6, 60.0, step)
        return np.linalg.norm(observer.Filter([noise], slow, current, none).apply(np.full((1, 1, 6000), 0.1)))
    assert told(1.0, 0.02) < 0.1 * told(0.1, 0.02)
    assert told(1.0, 0.6) > told(1.0, 0.02)  # noise that blurs them tells more


def test_a_slope_that_nobody_sees_hides_a_steady_force():
    rng = np.random.default_rng(4)
    sound = world.make(rng, "car", 1)
    now = world.situation(rng, sound, DURATION_S)
    torque = np.zeros((1, 1, now.speed_mps.shape[1]))
    asks = observer.of_drive(sound.car, now.speed_mps, now.slope, drive.STEP_S)
    torque[0, 0] = 0.001 * asks["torque_nm"][:, 2]  # a slope of 0.1 % all the way
    noise, nothing = sound.instruments.noise["motor_torque"], np.zeros(1)

    def told(of_drive):
        sensitivity = observer.Sensitivity(nothing, nothing, of_drive)
        made = observer.Filter([noise], torque[0], sound.instruments.noise["current"], sensitivity)
        return np.linalg.norm(made.apply(torque))
    assert told(asks["torque_nm"][:, None, :]) < 1.5 < 5.0 < told(None)


@pytest.fixture(scope="module", params=["cell", "car"])
def bench(request):
    rng = np.random.default_rng(5)
    sound = world.make(rng, request.param, 1)
    sound.instruments.noise = instruments.FINEST  # a coarse logger sees no cooling in so short a drive
    now = world.situation(rng, sound, DURATION_S)
    return rng, hide.Bench(sound, now)


def test_no_effect_is_no_difference(bench):
    rng, it = bench
    chosen = [effects.BY_NAME[name] for name in ("series_resistance", "cooling", "current_gain")]
    nothing = [[hide.Hidden(effect, np.zeros(1), effect.fixed(rng, it.sound))] for effect in chosen]
    assert it.separations(nothing) == pytest.approx(0.0, abs=1e-6)


# Only the packer shows these: rows that are missing, values that are coarse or stand still under noise. A short
# drive neither comes near the empty end nor lets a leak add up.
NOT_HERE = ("dropped_or_late_frames", "quantisation", "frozen_signal", "resistance_soc", "self_discharge")


def test_every_effect_shows_at_its_largest(bench):
    rng, it = bench
    shown = [effect for effect in effects.ALL if it.sound.kind in effect.kinds and effect.name not in NOT_HERE]
    sizes = [effect.signs[0] * hide.largest(effect, it.sound) for effect in shown]
    seen = it.separations([[hide.Hidden(effect, size, effect.fixed(rng, it.sound))]
                           for effect, size in zip(shown, sizes)])
    assert {effect.name: row for effect, row in zip(shown, seen) if row < 1.0} == {}


def test_who_reads_a_log_knows_the_current_by_its_sensor_only(bench):
    _, it = bench
    wrong = hide.Hidden(effects.BY_NAME["current_gain"], np.array([0.02]), {})
    log = hide.shown([hide.with_effects(it.sound, it.now, [wrong])])[0]
    assert {name for name in log if not np.array_equal(log[name], it.quiet[name])} == {"current"}
    # Every cell would have shown another voltage: that is the change, and the filter takes no current as known.
    assert "current" not in it._channels(log)
    assert (it.changes([log]) ** 2).sum() > 1.0


def test_the_warmth_that_a_drive_begins_with_is_no_effect(bench):
    _, it = bench
    warmer = dataclasses.replace(it.now, temperature_k=it.now.temperature_k + 1.0)
    drives = [(it.sound, warmer)]
    logs = hide.shown(drives)
    assert it.separations_of(logs, drives)[0] < 0.2 * np.linalg.norm(it.changes(logs, drives))


def test_rho_grows_with_a_size_and_a_beginning_has_none(bench):
    _, it = bench
    other = [dataclasses.replace(it.now, temperature_k=it.now.temperature_k + 0.2),
             dataclasses.replace(it.now, charge=it.now.charge - 0.002)]
    drives = [(it.sound, begun) for begun in other]
    for rho, channel in it.sizes_of(hide.shown(drives), drives)[1]:
        assert rho < 0.3, channel  # as they are they would be about two
    effect = effects.BY_NAME["series_resistance"]
    large = hide.largest(effect, it.sound)
    made = [hide.with_effects(it.sound, it.now, [hide.Hidden(effect, share * large, {})]) for share in (0.1, 0.2)]
    separations, rhos = it.sizes_of(hide.shown(made), made)
    assert separations == pytest.approx(it.separations_of(hide.shown(made), made))
    (small, channel), (twice, _) = rhos
    assert twice == pytest.approx(2.0 * small, rel=0.1) and "voltage" in channel
    # What it adds is R I, in a pack in every cell, less what the beginning of the log can take of that.
    current = it.quiet["current"][0]
    assert small == pytest.approx(0.1 * large[0] * np.std(current) / hide.PRACTICAL_V, rel=0.35)


@pytest.mark.parametrize("bench", ["car"], indirect=True)
def test_a_force_is_told_in_proportion_to_its_size(bench):
    # From force to pedals a road asks as a drag does: where a pedal is released nothing more is told.
    _, it = bench
    for name in ("drag_area", "rolling_resistance", "grade", "mass"):
        effect = effects.BY_NAME[name]
        large = hide.largest(effect, it.sound)
        whole, small = it.separations([[hide.Hidden(effect, share * large, {})] for share in (1.0, 0.05)])
        assert 0.05 * whole == pytest.approx(small, rel=0.01), name


def test_noise_of_the_current_hides_a_resistance_of_all_cells(bench):
    _, it = bench
    size = 0.05 * hide.largest(effects.BY_NAME["series_resistance"], it.sound)
    wrong = hide.Hidden(effects.BY_NAME["series_resistance"], size, {})
    log = hide.shown([hide.with_effects(it.sound, it.now, [wrong])])
    quiet = copy.deepcopy(it.sound)
    quiet.instruments.noise["current"] = instruments.Noise(1e-4, 1e-4, 60.0, 1e-4)
    assert np.linalg.norm(it.changes(log)) < 0.9 * np.linalg.norm(hide.Bench(quiet, it.now).changes(log))


def test_original_stays_as_it_was(bench):
    _, it = bench
    before = it.sound.cells.extra_ohm.copy()
    hide.with_effects(it.sound, it.now, [hide.Hidden(effects.BY_NAME["series_resistance"], np.ones(1), {})])
    assert (it.sound.cells.extra_ohm == before).all()


def test_truth_imports_nothing_but_numpy_and_the_standard_library():
    allowed = {"numpy", "dataclasses", "copy", "collections"}
    for file in (HERE / "truth").glob("*.py"):
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.Import):
                assert {name.name.split(".")[0] for name in node.names} <= allowed, file.name
            elif isinstance(node, ast.ImportFrom) and node.level == 0:
                assert node.module.split(".")[0] in allowed, file.name
