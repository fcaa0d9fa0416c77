# SPDX-License-Identifier: Apache-2.0
"""Clocks of tables that start anew, are set, or write single rows wrong: the rules of docs/recordings.md hold for rows
as for frames. The fault is drawn; the seed is printed."""
import os
import random

import pytest
from straight_pack import CELLS, RATE, replayed, rows

SEED = int(os.environ.get("VOLTLAP_TEST_SEED", "20261127"))
ROWS = 40 * RATE


def anew(rng, table, at):
    return [dict(row, time_s=row["time_s"] - (at / RATE if k >= at else 0.0)) for k, row in enumerate(table)]


def put_ahead(rng, table, at):
    hours = rng.uniform(25.0, 4000.0)
    return [dict(row, time_s=row["time_s"] + (3600.0 * hours if k >= at else 0.0)) for k, row in enumerate(table)]


def put_back(rng, table, at):
    seconds = rng.uniform(0.0, 1.0) * at / RATE
    return [dict(row, time_s=row["time_s"] + 1000.0 - (seconds if k >= at else 0.0)) for k, row in enumerate(table)]


def swapped(rng, table, at):
    out = list(table)
    out[at], out[at + 3] = out[at + 3], out[at]
    return out


def one_far_ahead(rng, table, at):
    ahead = rng.uniform(20.0, 1e7)
    return [dict(row, time_s=row["time_s"] + (ahead if k == at else 0.0)) for k, row in enumerate(table)]


def one_far_behind(rng, table, at):
    return [dict(row, time_s=row["time_s"] + 1000.0 - (rng.uniform(20.0, 900.0) if k == at else 0.0))
            for k, row in enumerate(table)]


@pytest.mark.parametrize("fault", [anew, put_ahead, put_back, swapped, one_far_ahead, one_far_behind],
                         ids=lambda fault: fault.__name__)
def test_a_clock_that_is_wrong_costs_no_row_but_its_own(tmp_path, fault):
    rng = random.Random(f"{SEED} {fault.__name__}")
    at = rng.randrange(11 * RATE, ROWS - 11 * RATE)
    about = f"seed {SEED}, {fault.__name__} at row {at}"
    sound = list(rows(40))
    run, out = replayed(tmp_path, fault(rng, sound, at))
    verdicts, alone = out["frames_by_verdict"], fault in (one_far_ahead, one_far_behind)
    assert out["frames"] == sum(verdicts.values()) == ROWS * (CELLS + 4), about
    assert verdicts["stale"] == (CELLS + 4 if alone else 0), about
    assert out["duration_s"] == pytest.approx(40.0, abs=0.1), about
    assert out["soc_end_pct"] == pytest.approx(100 * sound[-1]["soc"], abs=0.1), f"{about}\n{run.stdout}"
    assert out["faults"] == [], about
    said = " ".join(out["notes"] + [defect["text"] for defect in out["defects"]])
    assert {"anew": "starts anew", "put_ahead": "was set", "put_back": "was set", "swapped": "out of order, sorted",
            "one_far_ahead": "far ahead", "one_far_behind": "far behind"}[fault.__name__] in said, f"{about}\n{said}"
    assert f"row {at + 1}" in said or fault is swapped, f"{about}\n{said}"


@pytest.mark.parametrize("period", [0.013, 0.9, 2.6, 3.0, 4.9, 7.0, 11.0, 30.0])
def test_rows_at_any_interval_are_all_used(tmp_path, period):
    """Rows three seconds apart were once all called far from those around them."""
    table = [dict(row, time_s=k * period, current_a=0.0) for k, row in enumerate(rows(0.8))]
    _, out = replayed(tmp_path, table, pack=None)
    assert out["frames_by_verdict"]["used"] == out["frames"] == len(table) * (CELLS + 4)
    assert out["duration_s"] == pytest.approx(period * (len(table) - 1), abs=0.02)
