# SPDX-License-Identifier: Apache-2.0
"""Each invariant is broken by a written drive, and by that alone; a fault that voids it keeps it quiet."""
import pytest

from voltlap_hil.fault_table import TABLE, load_table
from voltlap_hil.frame import Frame
from voltlap_hil.invariants import Drive, broken
from voltlap_hil.trace import Trace

SOUND = {
    "Pedals": {"Apps1": 2.5, "Apps2": 1.25}, "MasterStatus": {"DriveState": "ReadyToDrive"},
    "BmsStatus": {"State": "TsActive"}, "InverterCommand": {"PhaseCurrent": 200.0},
    "PackSensor": {"PackCurrent": 50.0}, "BmsLimits": {"DischargeLimit": 100.0, "ChargeLimit": 50.0},
    "VehicleIo": {"AirPlusAux": 1, "AirMinusAux": 1, "PrechargeAux": 0},
}


@pytest.fixture(scope="module")
def rows():
    from voltlap_hil.dbc import Dbc
    return {row.id: row for row in load_table(TABLE, Dbc.of_project())}


def judge(dbc, changed, faults=(), loss=0):
    """2 s of a sound drive; `changed(ms)`: what differs, None for a message that is not sent."""
    frames = []
    for i in range(200):
        differs = changed(10 * i)
        for message, values in SOUND.items():
            if message in differs and differs[message] is None:
                continue
            row = dbc.message(message)
            frames.append(Frame(row.id, row.seal(row.encode({**values, **differs.get(message, {})}), i), 10.0 * i))
    return [text.partition(":")[0] for text in broken(Drive(dbc, Trace(dbc, frames), 100.0, True, loss, tuple(faults)))]


def later(**differs):
    return lambda ms: differs if ms >= 500 else {}


def test_a_sound_drive_breaks_nothing(dbc):
    assert judge(dbc, lambda ms: {}) == []


@pytest.mark.parametrize(("name", "differs", "voided_by"), [
    ("torque only when ready", later(MasterStatus={"DriveState": "TsActive"}), "inverter_command_bit"),
    ("never more than asked", later(Pedals={"Apps1": 0.5, "Apps2": 0.25}), "master_killed"),
    ("limit obeyed", later(PackSensor={"PackCurrent": 111.0}), "inverter_gives_more"),
    ("a trip opens", later(BmsStatus={"State": "Fault"}), "air_plus_welded"),
    ("nobody is stuck", later(BmsStatus=None), "bms_killed"),
])
def test_each_is_broken_by_what_it_is_about(dbc, rows, name, differs, voided_by):
    other = rows["thermistor_offset_3"] if name != "a sound car goes on" else rows["apps1_open"]
    assert name in judge(dbc, differs, [other])
    assert name not in judge(dbc, differs, [rows[voided_by]])


def test_a_sound_car_must_go_on_and_a_broken_one_need_not(dbc, rows):
    stops = later(MasterStatus={"DriveState": "LvOn"}, InverterCommand={"PhaseCurrent": 0.0})
    assert judge(dbc, stops) == ["a sound car goes on"]
    assert judge(dbc, stops, [rows["apps1_offset_8"]]) == ["a sound car goes on"]
    assert judge(dbc, stops, [rows["bms_limits_lost"]]) == []
    assert judge(dbc, later(BmsStatus={"Faults": 8})) == ["a sound car goes on"]


def test_what_is_found_in_time_is_no_breach(dbc):
    assert judge(dbc, lambda ms: {"Pedals": {"Apps1": 0.5, "Apps2": 0.25}} if 500 <= ms < 660 else {}) == []
    assert judge(dbc, lambda ms: {"PackSensor": {"PackCurrent": 200.0}} if 500 <= ms < 1000 else {}) == []
    open_all = {"VehicleIo": {"AirPlusAux": 0, "AirMinusAux": 0}}
    trip = {"BmsStatus": {"State": "Fault"}, "MasterStatus": {"DriveState": "Fault"},
            "InverterCommand": {"PhaseCurrent": 0.0}}
    fault = lambda ms: {} if ms < 500 else trip if ms < 740 else {**trip, **open_all}  # noqa: E731
    assert judge(dbc, fault) == ["a sound car goes on"]
