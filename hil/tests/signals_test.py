# SPDX-License-Identifier: Apache-2.0
from voltlap_hil.frame import Frame
from voltlap_hil.signals import Signals


def test_a_reading_has_value_unit_and_age(dbc, frame):
    signals = Signals(dbc)
    signals.update(frame("BmsLimits", 20, DischargeLimit=123.4))
    signals.now_ms = 70
    assert signals["BmsLimits.DischargeLimit"] == (123.4, "A", 50)


def test_what_was_never_heard_has_neither_value_nor_age(dbc):
    assert Signals(dbc)["BmsLimits.DischargeLimit"] == (None, "A", None)


def test_no_measurement_has_no_value_but_an_age(dbc, frame):
    signals = Signals(dbc)
    signals.update(frame("Pedals", 10, Apps1=None))
    assert signals["Pedals.Apps1"] == (None, "V", 0)


def test_a_frame_of_the_wrong_length_is_no_reading(dbc):
    signals = Signals(dbc)
    signals.update(Frame(dbc.message("Pedals").id, b"\x01"))
    assert signals["Pedals.Apps1"].value is None


def test_set_bits_have_names(dbc, frame):
    signals = Signals(dbc)
    signals.update(frame("BmsStatus", 0, Faults=(1 << 14) | (1 << 1)))
    assert signals.bits("BmsStatus.Faults") == ["CellVoltageLow", "MasterLost"]


def test_writing_goes_over_what_was_seen_with_the_next_counter_and_a_good_crc(dbc, frame):
    signals, pedals = Signals(dbc), dbc.message("Pedals")
    signals.update(frame("Pedals", 0, counter=254, Apps1=1.0, BrakeFront=7.5))
    first, second = (signals.write("Pedals", {"Apps1": 4.5}) for _ in range(2))
    assert pedals.read(first.data)["BrakeFront"] == 7.5 and pedals.read(first.data)["Apps1"] == 4.5
    assert [pedals.counter_of(f.data) for f in (first, second)] == [255, 0]
    assert pedals.sealed_ok(first.data) and pedals.sealed_ok(second.data)
