# SPDX-License-Identifier: Apache-2.0
import pytest

from voltlap_hil.errors import HilError
from voltlap_hil.frame import Frame


def test_signals_of_several_messages_are_seen_together(trace, dbc):
    t = trace(("VehicleIo", 0, {"AirPlusAux": 1}), ("BmsStatus", 0, {"State": "Idle"}),
              ("VehicleIo", 10, {"AirPlusAux": 0}), ("BmsStatus", 10, {"State": "Fault"}))
    signals = [dbc.signal("VehicleIo.AirPlusAux"), dbc.signal("BmsStatus.State")]
    assert list(t.states(signals)) == [(0, {"VehicleIo.AirPlusAux": 1, "BmsStatus.State": "Idle"}),
                                       (10, {"VehicleIo.AirPlusAux": 0, "BmsStatus.State": "Fault"})]


def test_nothing_is_said_before_every_message_was_heard(trace, dbc):
    t = trace(("VehicleIo", 0, {}), ("VehicleIo", 10, {}), ("BmsStatus", 20, {"State": "Idle"}))
    times = [time for time, _ in t.states([dbc.signal("VehicleIo.AirPlusAux"), dbc.signal("BmsStatus.State")])]
    assert times == [20]


def test_a_message_that_is_silent_keeps_its_last_value(trace, dbc):
    t = trace(("BmsStatus", 0, {"State": "Idle"}), ("VehicleIo", 0, {}), ("VehicleIo", 10, {"AirPlusAux": 1}))
    *_, last = t.states([dbc.signal("VehicleIo.AirPlusAux"), dbc.signal("BmsStatus.State")])
    assert last == (10, {"VehicleIo.AirPlusAux": 1, "BmsStatus.State": "Idle"})


def test_frames_are_counted_in_a_window_without_its_start(trace):
    t = trace(*(("Pedals", time, {}) for time in (0, 10, 10, 20, 30)))
    assert t.count("Pedals", 0, 20) == 3


def test_a_frame_of_the_wrong_length_says_nothing(trace, dbc):
    t = trace(("VehicleIo", 0, {"AirPlusAux": 1}))
    t.extend([Frame(dbc.message("VehicleIo").id, b"", 10.0)])
    assert [time for time, _ in t.states([dbc.signal("VehicleIo.AirPlusAux")])] == [0]


def test_a_clock_that_goes_back_is_told(trace):
    t = trace(("Pedals", 20, {}))
    with pytest.raises(HilError, match="went back from 20 ms to 10 ms"):
        t.extend([Frame(0xB1, bytes(8), 10.0)])
