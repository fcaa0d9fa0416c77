# SPDX-License-Identifier: Apache-2.0
"""The truth of toolchain/learn_bench.py against closed forms, and the fit that stands for what it allows."""
import pathlib
import sys
from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("scipy", reason="scipy is not there: pip install -r toolchain/requirements/fit.txt")
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[4] / "toolchain"))
from drawn_cells import cell as cells  # noqa: E402
from drawn_cells import logger as loggers  # noqa: E402
from drawn_cells import program as programs  # noqa: E402
from drawn_cells import reference  # noqa: E402

FLAT = np.ones(len(cells.NODES))
PERFECT = loggers.Logger(1.0, 0.0, False, 0.0, 1e-7, 0.0, 1e-7, 0.0, 1.0, "fine", False)


def plain(**changes):
    """10 Ah, 5 mOhm, a branch of 3 mOhm and 20 s; nothing moves with temperature or SOC but the OCV."""
    z, v, low, high = cells.CURVES["nmc"]
    base = cells.Cell("nmc", 10.0, low, high, np.array(z), np.array(v), 5e-3 * FLAT, [3e-3 * FLAT], np.array([20.0]),
                      0.0, 0.0, 0.0, 0.0, (), 0.0, 10.0, 0.0, 0.2, 1000.0, 0.5, "18650")
    return replace(base, **changes)


def load(cell, current, seconds, air_c=25.0):
    t = np.arange(0.0, seconds + 1.0)
    return cells.respond(cell, t, np.where(t > 0, current, 0.0), air_c)


def test_a_step_is_ohmic_and_then_exponential():
    cell = plain()
    r = load(cell, 20.0, 100)
    at = 1 - r.t * 20 / 36000
    assert r.v[1:] == pytest.approx((cell.ocv(at) - 0.1 - 0.06 * (1 - np.exp(-r.t / 20)))[1:], abs=1e-9)
    assert r.z[-1] == pytest.approx(1 - 100 * 20 / 36000)


def test_heat_warms_the_mass_until_the_air_takes_it_and_resistance_follows_arrhenius():
    cell = plain(e0=20e3, e_branch=20e3)
    r = load(cell, 20.0, 1200)
    k, dt = np.arange(1, len(r.t)), 1.0
    power = r.current * (cell.ocv(r.z) - r.v)
    rise = np.diff(r.temperature)
    towards = power[k] / 0.5 + 25.0 - r.temperature[k - 1]
    assert rise == pytest.approx(towards * (1 - np.exp(-dt * 0.5 / 200)), abs=1e-3)
    warm, cold = load(cell, 20.0, 1, 35.0), load(cell, 20.0, 1, 25.0)
    ratio = np.exp(20e3 / cells.GAS * (1 / 308.15 - 1 / 298.15))
    drop = [cell.ocv(x.z[1]) - x.v[1] for x in (warm, cold)]
    assert drop[0] / drop[1] == pytest.approx(ratio, rel=1e-3)
    assert drop[1] == pytest.approx(20.0 * 5e-3 + 20.0 * 3e-3 * (1 - np.exp(-1 / 20)), rel=1e-3)  # 25 degC: the tables


def test_charge_transfer_hysteresis_and_entropy_stand_in_the_voltage():
    two = plain(exchange_a=(5.0, 10.0))
    eta = 2 * cells.GAS * 298.15 / cells.FARADAY * (np.arcsinh(2.0) + np.arcsinh(1.0))
    assert load(plain(), 20.0, 1).v[1] - load(two, 20.0, 1).v[1] == pytest.approx(eta, rel=1e-3)
    # Full it comes from a charge: h goes from -1 to 1, M is added first and taken away later.
    lower = plain(hysteresis_v=0.01, hysteresis_rate=100.0)
    begin, end = (load(lower, 20.0, 500).v - load(plain(), 20.0, 500).v)[[0, -1]]
    assert begin == pytest.approx(0.01) and end == pytest.approx(-0.01, abs=1e-4)
    warm = plain(entropy_v_per_k=1e-4)
    assert load(warm, 0.0, 5, 35.0).v[-1] - load(plain(), 0.0, 5, 35.0).v[-1] == pytest.approx(1e-3)


def test_a_discharge_ends_at_the_limit_and_rests():
    cell = plain()
    rng = np.random.default_rng(1)
    made = programs.make(rng, cell, "discharge", 25.0, 1.0, PERFECT)
    answer, mask = programs.run(cell, made)
    rows = loggers.read(rng, PERFECT, made, answer, mask)
    assert cell.v_min - 0.05 < rows.v.min() < cell.v_min + 0.05
    assert rows.current[-1] == 0.0 and rows.t[-1] - rows.t[rows.current > 0][-1] == pytest.approx(900.0)
    assert np.diff(rows.t) == pytest.approx(1.0)


def recordings(cell, logger, seen_as):
    out = []
    for number, (kind, rate) in enumerate((("hppc", 2.0), ("drive", 2.5))):
        rng = np.random.default_rng([7, number])
        made = programs.make(rng, cell, kind, 25.0, rate, logger)
        rows = loggers.read(rng, logger, made, *programs.run(cell, made))
        out.append(reference.Recording(seen_as, logger, rows, rows.true_temperature))
    return out


def test_the_reference_finds_a_resistance_that_is_not_where_it_began():
    begin = plain()
    true = plain(r0=5.5e-3 * FLAT, tau_s=np.array([24.0]))
    fit = reference.Fit(begin)
    answer = fit.solve(recordings(true, PERFECT, begin))
    assert np.exp(answer[fit.r[0]])[2:-1] == pytest.approx(1.1, rel=0.01)
    assert np.exp(answer[fit.rest]) == pytest.approx(1.2, rel=0.02)


def test_the_reference_leaves_the_noise_and_no_more():
    cell, noisy = plain(), replace(PERFECT, noise_v=2e-3)
    *seen, unseen = recordings(cell, noisy, cell)
    fit = reference.Fit(cell)
    error = fit.model(fit.solve(seen), unseen) - unseen.v
    used = (unseen.z > 0.05) & (unseen.current > 0)
    assert 1.9e-3 < np.sqrt(np.mean(error[used] ** 2)) < 2.2e-3


def test_derivatives_of_the_reference_are_those_of_its_model():
    rng = np.random.default_rng(3)
    cell = cells.draw(rng)
    cell = replace(cell, exchange_a=(cell.capacity_ah, 2 * cell.capacity_ah))
    rec = recordings(cell, PERFECT, cell)[0]
    fit = reference.Fit(cell)
    p = 0.02 * rng.standard_normal(fit.size)
    _, columns = fit.rows(p, [rec])
    for place in range(0, fit.size, 5):
        q = p.copy()
        q[place] += 1e-4
        slope = (fit.model(q, rec) - fit.model(p, rec)) / 1e-4 / rec.sigma
        assert columns[:, place] == pytest.approx(slope, rel=0.02, abs=0.02 * np.abs(slope).max() + 1e-9)
