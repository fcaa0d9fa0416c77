# SPDX-License-Identifier: Apache-2.0
"""A log that begins under load: its SOC starts from the best that there is, and what that is is said."""
import os
import random
import secrets

import pytest
from straight_pack import replayed, rows

SEED = int(os.environ.get("VOLTLAP_TEST_SEED", secrets.randbelow(2**32)))
LOAD_A = 80.0  # 0.24 V of each cell, 24 points of its charge


def loaded(seconds, rest_from=1e9):
    """Pulses without an end above zero, then, where asked for, a rest."""
    def current(time):
        return 0.0 if time >= rest_from else LOAD_A if time % 10.0 < 6.0 else 40.0

    return rows(seconds, current=current)


def test_the_logs_own_soc_is_where_it_starts(tmp_path):
    run, out = replayed(tmp_path, loaded(30))
    assert out["soc_start_from"] == "the log's own SOC" and "(from the log's own SOC)" in run.stdout
    assert out["soc_start_pct"] == pytest.approx(80.0, abs=0.05)
    assert out["soc_end_pct"] == pytest.approx(out["soc_logged_end_pct"], abs=0.05)
    assert out["faults"] == []  # the step from rest to load has its sag


def test_a_later_rest_is_counted_back_from(tmp_path):
    """Its own SOC is 12 points off: the voltage of the rest decides."""
    table = (dict(row, soc=row["soc"] - 0.12) for row in loaded(100, rest_from=30.0))
    run, out = replayed(tmp_path, table)
    assert out["soc_start_from"] == "a later rest, counted back"
    assert out["soc_start_pct"] == pytest.approx(80.0, abs=0.05)
    assert any("12." in entry["what"] or "SOC" in entry["what"] for entry in out["disagreements"])


def test_a_jumping_soc_is_not_where_it_starts(tmp_path):
    table = (dict(row, soc=row["soc"] + (0.2 if row["time_s"] < 8.0 else 0.0)) for row in loaded(30))
    _, out = replayed(tmp_path, table)
    assert out["soc_start_from"] == "cells under load"
    assert out["soc_start_pct"] == pytest.approx(80.0, abs=0.1)  # the pack file has the true resistance
    assert any("its own SOC jumps" in text for text in out["assumptions"])


@pytest.mark.parametrize("length_s", [0.03, 3.0])
def test_a_moment_without_current_between_two_of_load_is_no_rest(tmp_path, length_s):
    def glitch(time):
        return 0.0 if time >= 30.0 or 0.1 <= time < 0.1 + length_s else LOAD_A

    _, out = replayed(tmp_path, rows(100, current=glitch))
    assert out["soc_start_from"] == "a later rest, counted back"
    assert out["soc_start_pct"] == pytest.approx(80.0, abs=0.05)


def test_a_rest_begins_where_the_voltage_has_come_up(tmp_path):
    """A filter that begins at nothing: for three seconds the cells and the pack read too little."""
    def rising(row):
        share = min(1.0, 0.75 + row["time_s"] / 12.0)
        return {name: value * share if "voltage" in name else value for name, value in row.items()}

    _, out = replayed(tmp_path, (rising(row) for row in rows(40, current=lambda t: LOAD_A if t > 8.0 else 0.0)))
    assert out["soc_start_from"] == "cells at rest"
    assert out["soc_start_pct"] == pytest.approx(80.0, abs=2.0)  # 0.5 % of the voltage is 19 mV, two points
    assert out["faults"] == []


@pytest.mark.parametrize("k", range(4))
def test_drawn_begins(tmp_path, k):
    """Wherever a sound log is cut, its SOC is that of the log, and nothing is complained of."""
    print(f"VOLTLAP_TEST_SEED={SEED}")
    draw = random.Random(SEED + k)
    soc, cut, begin = draw.uniform(0.65, 0.95), draw.uniform(0.0, 25.0), draw.uniform(0.0, 1e4)
    period, low, high = draw.uniform(4.0, 20.0), draw.uniform(10.0, 60.0), draw.uniform(60.0, 150.0)
    table = [dict(row, time_s=row["time_s"] + begin)
             for row in rows(50, soc=soc, current=lambda t: high if t % period < 0.6 * period else low)
             if row["time_s"] >= cut]
    _, out = replayed(tmp_path, table)
    assert out["faults"] == [], (soc, cut, period, low, high)
    assert out["soc_start_pct"] == pytest.approx(100.0 * table[0]["soc"], abs=0.1)
    assert out["soc_end_pct"] == pytest.approx(100.0 * table[-1]["soc"], abs=0.1)


@pytest.mark.parametrize("k", range(4))
def test_a_drawn_gap_of_the_recording_costs_no_charge_that_nobody_recorded(tmp_path, k):
    """Under load or charge, for seconds or hours: what flowed meanwhile is not in the log, so it is not counted. Half a
    second of the current before it is, until the firmware opens, and what the restart misses."""
    print(f"VOLTLAP_TEST_SEED={SEED}")
    draw = random.Random(SEED + 100 + k)
    soc, amps = draw.uniform(0.55, 0.7), draw.choice((-1, 1)) * draw.uniform(20.0, 60.0)
    gap = 10 ** draw.uniform(0.5, 4.0)
    table = [dict(row, time_s=row["time_s"] + (gap if row["time_s"] >= 20.0 else 0.0))
             for row in rows(40, soc=soc, current=lambda t: 0.0 if t < 5.0 else amps)]
    _, out = replayed(tmp_path, table)
    assert out["soc_end_pct"] == pytest.approx(100.0 * table[-1]["soc"], abs=100.0 * 4.0 * abs(amps) / 3600.0 / 9.0), (
        soc, amps, gap)
