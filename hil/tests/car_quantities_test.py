# SPDX-License-Identifier: Apache-2.0
"""Names in the table of faults stand for numbers of the car that is driven."""
from pathlib import Path

import pytest

from voltlap_hil.car import Car
from voltlap_hil.car_quantities import QUANTITIES, filled
from voltlap_hil.errors import InputError

PLACE = Path("faults.yaml")


class Other(Car):
    """A car of 96 cells and 307 A, as the program would say it."""

    keys = {"inverter.current_max_a": 307.0, "master.phase_current_max_a": 400.0, "battery.cells_in_series": 96.0}
    open_circuit_v, resistance_ohm = 4.18, 0.003


def test_the_example_car_has_the_numbers_that_stood_in_the_table(dbc):
    names = ("full_current", "driving_current", "current_beyond_trip", "dc_link_charged", "cell_to_limit",
             "cells_later")
    assert [filled(f"{{{name}}}", Car(dbc), PLACE) for name in names] == ["400", "100", "900", "96", "-1720", "0"]


def test_another_car_has_its_own(dbc):
    text = "{full_current} A, {dc_link_charged} V, {cells_later} ms"
    assert filled(text, Other(dbc), PLACE) == "223 A, 384 V, 140 ms"
    assert filled("{cell_to_limit}", Other(dbc), PLACE) == "-1730"


def test_every_name_gives_a_number(dbc):
    for name in QUANTITIES:
        float(filled(f"{{{name}}}", Other(dbc), PLACE))


def test_a_name_that_is_none_is_told_with_its_line(dbc):
    with pytest.raises(InputError, match=r"faults.yaml:2: no quantity of the car \{full_curent\}.*full_current"):
        filled("a\n{full_curent}", Car(dbc), PLACE)
