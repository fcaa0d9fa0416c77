# SPDX-License-Identifier: Apache-2.0
import pytest

from voltlap_hil.condition import Condition
from voltlap_hil.errors import InputError


@pytest.mark.parametrize("text, value, expected", [
    ("PackSensor.PackCurrent > 100 A", 100.1, True),
    ("PackSensor.PackCurrent > 100 A", 100.0, False),
    ("PackSensor.PackCurrent >= 100 A", 100.0, True),
    ("PackSensor.PackCurrent < -3.5 A", -4.0, True),
    ("PackSensor.PackCurrent <= 0 A", 0.1, False),
    ("PackSensor.PackCurrent = 0 A", 0.0, True),
    ("PackSensor.PackCurrent != 0 A", 0.0, False),
    ("BmsStatus.State = Fault", "Fault", True),
    ("BmsStatus.State != Fault", "Fault", False),
    ("BmsStatus.Faults has MasterLost", 1 << 14, True),
    ("BmsStatus.Faults has MasterLost", 1 << 13, False),
    ("BmsStatus.Faults lacks MasterLost", 1 << 13, True),
    ("VehicleIo.AirPlusAux = 1", 1, True)])
def test_a_clause_compares_with_the_unit_of_its_signal(dbc, text, value, expected):
    condition = Condition.parse(text, dbc)
    assert condition.holds({condition.signals[0].name: value}) is expected


@pytest.mark.parametrize("text", ["PackSensor.PackCurrent != 0 A", "BmsStatus.State != Fault",
                                  "BmsStatus.Faults lacks MasterLost"])
def test_what_is_not_known_fulfils_nothing(dbc, text):
    condition = Condition.parse(text, dbc)
    assert not condition.holds({condition.signals[0].name: None})
    assert not condition.holds({})


def test_and_asks_for_all_clauses(dbc):
    both = Condition.parse("BmsStatus.State = Fault and  PackSensor.PackCurrent < 1 A", dbc)
    assert both.holds({"BmsStatus.State": "Fault", "PackSensor.PackCurrent": 0.0})
    assert not both.holds({"BmsStatus.State": "Fault", "PackSensor.PackCurrent": 2.0})
    assert not both.holds({"BmsStatus.State": "Idle", "PackSensor.PackCurrent": 0.0})


@pytest.mark.parametrize("text, complaint", [
    ("PackSensor.PackCurrent > 100", "found '100', expected a number with unit, such as '10 A'"),
    ("PackSensor.PackCurrent > 100 V", "found '100 V', expected a number with unit, such as '10 A'"),
    ("PackSensor.PackCurent > 100 A", "Did you mean PackCurrent"),
    ("BmsStatus.State = Broken", "Expected = or != and one of Invalid, Idle"),
    ("BmsStatus.State > Idle", "cannot be > 'Idle'"),
    ("BmsStatus.Faults has MasterLos", "Did you mean MasterLost"),
    ("BmsStatus.State", "expected a condition such as"),
    ("", "expected a condition such as")])
def test_a_mistake_says_what_was_found_and_expected(dbc, text, complaint):
    with pytest.raises(InputError, match=complaint):
        Condition.parse(text, dbc)
