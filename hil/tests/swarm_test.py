# SPDX-License-Identifier: Apache-2.0
"""What the swarm draws, and how it makes a failure smaller."""
import dataclasses

import pytest

from voltlap_hil.fault_table import TABLE, load_table
from voltlap_hil.swarm import Piece, draw, smallest, usable


@pytest.fixture(scope="module")
def rows():
    from voltlap_hil.dbc import Dbc
    return usable(load_table(TABLE, Dbc.of_project()))


def test_a_seed_draws_the_same_and_another_seed_something_else(rows):
    assert draw(5, rows) == draw(5, rows)
    assert draw(5, rows) != dataclasses.replace(draw(6, rows), seed=5)


def test_everything_is_drawn_sooner_or_later(rows):
    drawn = [draw(seed, rows) for seed in range(2000)]
    assert {name for one in drawn for name, _ in one.faults} == {row.id for row in rows}
    assert {len(one.faults) for one in drawn} == {0, 1, 2}
    assert {bool(one.foot) for one in drawn} == {one.noise for one in drawn} == {True, False}
    assert all(not (p.accelerator and p.brake) for one in drawn for p in one.foot)


def test_two_faults_share_the_side_of_the_gateway(rows):
    behind = {row.id: row.scenario.behind for row in rows}
    for seed in range(500):
        assert len({behind[name] for name, _ in draw(seed, rows).faults}) <= 1


def test_what_fails_is_shrunk_to_what_it_takes(rows):
    drawn = next(one for one in (draw(seed, rows) for seed in range(100)) if len(one.faults) == 2 and one.foot)
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
