# SPDX-License-Identifier: Apache-2.0
"""The names of an inverter of its own protocol, over the frames that a PM100 really sends."""
import random

import pytest

from voltlap_hil.car import Car
from voltlap_hil.dbc import Dbc
from voltlap_hil.errors import InputError
from voltlap_hil.fault_table import OF_INVERTER, TABLE, load_rows, load_table
from voltlap_hil.frame import Frame
from voltlap_hil.inverter_names import names_of_car
from voltlap_hil.sensor_faults import LyingSensors, SensorFault

PM100 = ("--set", "inverter.protocol=pm100")
AMK = ("--vehicle", "amk_4wd")


@pytest.fixture(scope="module")
def pm100():
    return names_of_car(Dbc.of_project(), PM100)


@pytest.fixture(scope="module")
def amk():
    return names_of_car(Dbc.of_project(), AMK)


def test_another_inverter_keeps_its_names():
    dbc = Dbc.of_project()
    assert names_of_car(dbc, ()) is dbc


def test_torque_is_told_as_the_current_that_the_firmware_takes_it_for(pm100):
    constant = Car(pm100, PM100).keys["master.motor_constant_nm_per_a"]
    torque, current = pm100.message("Pm100Command"), pm100.signal("InverterCommand.PhaseCurrent")
    random_torque = random.Random(7)
    for _ in range(50):
        newton_metres = round(random_torque.uniform(-100.0, 100.0), 1)
        data = torque.encode({"Torque": newton_metres})
        assert current.read(data) == pytest.approx(newton_metres / constant, abs=0.051 / constant)
    assert current.unit == "A" and current.message.id == torque.id


def test_what_it_does_not_say_is_told_with_what_it_says(pm100):
    with pytest.raises(InputError, match="inverter says no such thing; expected .*InverterStatus.MotorSpeed"):
        pm100.signal("InverterStatus.State")


def test_a_name_of_its_messages_is_all_of_them(pm100):
    assert {m.name for m in pm100.select(["InverterStatus"])} >= {"Pm100Torque", "Pm100Voltages", "Pm100States"}
    assert [m.name for m in pm100.select(["InverterCommand"])] == ["Pm100Command"]


def test_sensors_of_the_usual_names_lie_in_the_frames_of_the_pm100(pm100):
    """Beside them nothing changes."""
    message = pm100.message("Pm100MotorTemperatures")
    before = message.encode({"Motor": 61.0})
    fault = SensorFault(("MotorTemperatures.Motor",), "stuck", value=160.0)
    fault.check_fits(pm100)
    assert fault.ids(pm100) == {message.id}
    lied = LyingSensors(pm100, random.Random(1)).changed(fault, Frame(message.id, before), lambda _, __: None)
    now, then = message.read(lied.data), message.read(before)
    assert now["Motor"] == pytest.approx(160.0)
    assert {name for name in then if then[name] != now[name]} == {"Motor"}


def test_the_usual_table_is_read_for_it_and_rows_of_another_inverter_are_left_aside(pm100):
    rows = load_table(TABLE, pm100, PM100)
    aside = {row.id for row in rows if row.only_with}
    assert "inverter_fault" in aside and "current_zero" in aside
    assert len(aside) < 0.1 * len(rows)


@pytest.mark.parametrize("inverter", ["pm100", "amk"])
def test_beside_the_usual_rows_a_car_has_those_of_its_inverter(inverter, request):
    dbc, words = request.getfixturevalue(inverter), {"pm100": PM100, "amk": AMK}[inverter]
    rows = [row.id for row in load_rows(dbc, words)]
    own = [row.id for row in load_table(OF_INVERTER[inverter], dbc, words)]
    assert own and rows == [row.id for row in load_table(TABLE, dbc, words)] + own
    assert len(set(rows)) == len(rows)
    assert not set(own) & {row.id for row in load_rows(Dbc.of_project())}


def test_the_current_of_one_of_four_is_told_as_that_of_all_by_its_share(amk):
    keys = Car(amk, AMK).keys
    rear = 0.5 * (1.0 - keys["powertrain.front_torque_share"])
    status = amk.message("AmkActual1RearLeft").encode({"TorqueCurrent": 40.0})
    assert amk.signal("InverterStatus.PhaseCurrent").read(status) == pytest.approx(40.0 / rear, abs=0.02)
    command = amk.message("AmkSetpointsRearLeft").encode({"TorqueLimitPositive": 100.0})
    full_nm = keys["inverter.amk_nominal_torque_nm"]
    assert amk.signal("InverterCommand.PhaseCurrent").read(command) == pytest.approx(
        full_nm / keys["master.motor_constant_nm_per_a"] / rear, rel=1e-6)


def test_a_name_of_their_messages_is_those_of_all_four(amk):
    wheels = {"FrontLeft", "FrontRight", "RearLeft", "RearRight"}
    assert {m.name for m in amk.select(["InverterCommand"])} == {f"AmkSetpoints{wheel}" for wheel in wheels}
    assert {m.name for m in amk.select(["InverterStatus"])} == {"DcLinkSensor",
                                                                *(f"AmkActual1{wheel}" for wheel in wheels)}
    assert {m.name for m in amk.select(["MotorTemperatures"])} == {f"AmkActual2{wheel}" for wheel in wheels}


def test_the_usual_table_is_read_for_four_inverters_too(amk):
    rows = load_table(TABLE, amk, AMK)
    aside = {row.id for row in rows if row.only_with}
    assert {"inverter_fault", "inverter_status_corrupt"} <= aside and len(aside) < 0.1 * len(rows)
