# SPDX-License-Identifier: Apache-2.0
"""What the swarm draws, and how it makes a failure smaller."""
import dataclasses

import pytest

from voltlap_hil.dbc import Dbc
from voltlap_hil.fault_table import load_rows
from voltlap_hil.inverter_names import names_of_car
from voltlap_hil.swarm import CARS, Piece, draw, smallest, usable


@pytest.fixture(scope="module")
def usable_of():
    dbc = Dbc.of_project()
    pm100 = names_of_car(dbc, CARS["vtm16e with a PM100"])
    return {"vtm16e": usable(load_rows(dbc)),
            "vtm16e with a PM100": usable(load_rows(pm100, CARS["vtm16e with a PM100"]))}


def test_a_seed_draws_the_same_and_another_seed_something_else(usable_of):
    assert draw(5, usable_of) == draw(5, usable_of)
    assert draw(5, usable_of) != dataclasses.replace(draw(6, usable_of), seed=5)


def test_everything_is_drawn_sooner_or_later(usable_of):
    drawn = [draw(seed, usable_of) for seed in range(5000)]
    for car, rows in usable_of.items():
        assert {name for one in drawn for name, _ in one.faults if one.vehicle == car} == {row.id for row in rows}
    assert {len(one.faults) for one in drawn} == {0, 1, 2}
    assert {bool(one.foot) for one in drawn} == {one.noise for one in drawn} == {True, False}
    assert all(not (p.accelerator and p.brake) for one in drawn for p in one.foot)


def test_two_faults_share_the_side_of_the_gateway(usable_of):
    behind = {row.id: row.scenario.behind for rows in usable_of.values() for row in rows}
    for seed in range(500):
        assert len({behind[name] for name, _ in draw(seed, usable_of).faults}) <= 1


def test_a_car_gets_the_faults_of_its_inverter_and_of_no_other(usable_of):
    of_pm100 = {row.id for row in usable_of["vtm16e with a PM100"]}
    assert "pm100_run_fault" in of_pm100 and "pm100_run_fault" not in {row.id for row in usable_of["vtm16e"]}
    assert not any(row.only_with for rows in usable_of.values() for row in rows)


def test_what_fails_is_shrunk_to_what_it_takes(usable_of):
    drawn = next(one for one in (draw(seed, usable_of) for seed in range(100)) if len(one.faults) == 2 and one.foot)
    needed, _ = drawn.faults[1]
    asked = []

    def fails(one):
        asked.append(one)
        return needed in dict(one.faults) and any(p.accelerator > 50 for p in one.foot)

    drawn = dataclasses.replace(drawn, foot=(*drawn.foot, Piece(100, 80, 0)))
    least = smallest(drawn, fails)
    assert [name for name, _ in least.faults] == [needed]
    assert len(least.foot) == 1 and least.foot[0].accelerator > 50
    assert (least.noise, least.loss, least.vehicle) == (False, 0, "vtm16e")
    assert len(asked) < 100
