# SPDX-License-Identifier: Apache-2.0
import pytest

from voltlap_hil.frame import EXTENDED, Frame
from voltlap_hil.frame_bits import frame_bits
from voltlap_hil.bus_state import BusState
from voltlap_hil.inverter_names import AMK_WHEELS


@pytest.fixture
def bus(dbc):
    return BusState(dbc)


@pytest.fixture
def every_10_ms(frame):
    """every_10_ms("BmsLimits", 0, 1000, DischargeLimit=100.0): frames with counters that follow each other."""
    def made(message, first_ms, end_ms, **values):
        return [frame(message, float(t), counter=t // 10, **values) for t in range(first_ms, end_ms, 10)]
    return made


def sync(dbc, tick, bus_ms):
    row = dbc.message("Sync")
    return Frame(row.id, row.encode({"Tick": tick}), bus_ms)


def test_nothing_heard_is_nobody_alive(bus):
    snapshot = bus.snapshot()
    assert {row["state"] for row in snapshot["nodes"].values()} == {"never"}
    assert set(snapshot["nodes"]) == {"BMS", "MASTER", "PLANT"}
    assert snapshot["limits"][0]["value"] is None and snapshot["bus_load_pct"] == 0.0


def test_limits_come_with_their_reason_and_cell(bus, frame):
    bus.update([frame("BmsLimits", 0.0, DischargeLimit=87.5, DischargeReason="CellVoltage", LimitingCell=7,
                          ChargeLimit=0.0, ChargeReason="SocLow")])
    discharge, charge = bus.snapshot()["limits"]
    assert discharge == {"what": "discharge", "value": 87.5, "unit": "A", "reason": "CellVoltage", "cell": 7}
    assert charge == {"what": "charge", "value": 0.0, "unit": "A", "reason": "SocLow", "cell": None}


def test_no_limiting_cell_is_none(bus, frame):
    bus.update([frame("BmsLimits", 0.0, LimitingCell=255)])
    assert bus.snapshot()["limits"][0]["cell"] is None


def test_states_and_faults_have_their_names(bus, dbc, frame):
    faults = 1 << dbc.signal("BmsStatus.Faults").bit("PrechargeTimeout")
    bus.update([frame("BmsStatus", 0.0, State="Fault", Faults=faults),
                    frame("MasterStatus", 0.0, TorqueReason="Power")])
    states = bus.snapshot()["states"]
    assert states["BMS"] == {"state": "Fault", "faults": ["PrechargeTimeout"]}
    assert states["MASTER"]["TorqueReason"] == "Power"


@pytest.mark.parametrize("age_ms, state", [(25, "fresh"), (26, "late"), (50, "late"), (51, "lost")])
def test_a_node_is_as_fresh_as_its_stalest_message(bus, frame, age_ms, state):
    bus.update([frame("BmsLimits", 0.0), frame("BmsStatus", float(age_ms))])  # timeout 50 ms
    snapshot = bus.snapshot()
    assert snapshot["messages"]["BmsLimits"]["state"] == state
    assert snapshot["messages"]["BmsStatus"]["state"] == "fresh"
    assert snapshot["nodes"]["BMS"]["state"] == state
    assert snapshot["nodes"]["BMS"]["lost"] == (["BmsLimits"] if state == "lost" else [])
    assert snapshot["nodes"]["BMS"]["age_ms"] == 0.0


def test_silence_of_all_is_seen_when_time_passes(bus, frame):
    bus.update([frame("BmsLimits", 0.0)])
    bus.pass_time(60.0)
    assert bus.snapshot()["nodes"]["BMS"]["state"] == "lost"


def test_frame_with_a_bad_crc_is_counted_and_says_nothing(bus, frame):
    good = frame("BmsLimits", 0.0, DischargeLimit=100.0)
    bad = frame("BmsLimits", 10.0, counter=1, DischargeLimit=200.0)
    bus.update([good, bad._replace(data=bad.data[:7] + bytes([bad.data[7] ^ 1]))])
    snapshot = bus.snapshot()
    row = snapshot["messages"]["BmsLimits"]
    assert (row["frames"], row["bad_seals"], row["age_ms"]) == (2, 1, 10.0)
    assert snapshot["limits"][0]["value"] == 100.0


def test_counter_that_skips_or_stands_is_a_gap(bus, frame):
    for time_ms, counter in enumerate([14, 15, 16, 17, 19, 19, 20, 254, 255, 0, 1]):
        bus.update([frame("Pedals", time_ms * 10.0, counter=counter)])
    assert bus.snapshot()["messages"]["Pedals"]["counter_gaps"] == 3


def test_rates_and_load_are_those_of_the_last_second(bus, every_10_ms):
    frames = every_10_ms("Pedals", 0, 5000)
    bus.update(frames)
    snapshot = bus.snapshot()
    assert snapshot["frames_per_s"] == 100.0 and snapshot["messages"]["Pedals"]["per_s"] == 100.0
    bits = sum(frame_bits(f.id, f.data) for f in frames if 3900 <= f.time_ms < 4900)
    assert snapshot["bus_load_pct"] == pytest.approx(100 * bits / 500_000, abs=0.01)
    bus.pass_time(7000.0)
    assert bus.snapshot()["frames_per_s"] == 0.0


def test_rates_of_a_short_time_are_not_those_of_a_second(bus, every_10_ms):
    bus.update(every_10_ms("Pedals", 0, 310))
    assert bus.snapshot()["frames_per_s"] == 100.0


def test_cells_and_temperatures_are_summed_up_with_their_places(bus, frame):
    bus.update([frame("CellVoltages_00", 0.0, Cell0=3.9, Cell1=3.8, Cell2=4.0),
                    frame("CellVoltages_01", 0.0, Cell0=4.1, Cell1=None, Cell2=None),
                    frame("Temperatures_00", 0.0, Temperature0=30.0, Temperature1=31.5, Temperature2=None)])
    snapshot = bus.snapshot()
    assert snapshot["cells"] == {"count": 4, "unit": "V", "least": 3.8, "least_at": 1, "most": 4.1, "most_at": 3}
    assert snapshot["temperatures"]["most_at"] == 1 and snapshot["temperatures"]["count"] == 2


def test_unknown_identifiers_and_lengths_are_named_and_count_for_the_load(bus):
    bus.update([Frame(0x123, b"\x01", 0.0), Frame(0x18FF0001 | EXTENDED, b"", 1.0), Frame(0x0C0, b"\x01", 2.0)])
    snapshot = bus.snapshot()
    assert snapshot["unknown_ids"] == {"0x123": 1, "0x0C0": 1, "0x18FF0001": 1}
    assert snapshot["frames"] == 3 and snapshot["bus_load_pct"] > 0.0


def test_in_lockstep_time_is_that_of_the_ticks(bus, dbc, frame):
    for tick in range(200):  # twenty times real time
        bus.update([frame("Pedals", tick * 0.5, counter=tick), sync(dbc, tick, tick * 0.5)])
    snapshot = bus.snapshot()
    assert (snapshot["clock"], snapshot["time_s"], snapshot["pace"]) == ("lockstep", 1.99, 20.0)
    assert snapshot["frames_per_s"] == pytest.approx(100.0, abs=10.0)
    assert "Sync" not in snapshot["messages"] and snapshot["frames"] == 200
    bus.pass_time(1e6)  # a run that stands still does not age
    assert bus.snapshot()["nodes"]["PLANT"]["state"] == "fresh"


def test_next_run_begins_again(bus, dbc, frame):
    bus.update([sync(dbc, 5000, 0.0), frame("Pedals", 0.0), sync(dbc, 0, 100.0), frame("Pedals", 100.0, counter=1)])
    assert bus.snapshot()["time_s"] == 0.0
    assert bus.snapshot()["nodes"]["PLANT"]["state"] == "fresh"


def test_four_amk_inverters_are_as_the_worst_of_them(bus, frame):
    on = {"SystemReady": 1, "DcOn": 1, "QuitDcOn": 1, "InverterOn": 1, "QuitInverterOn": 1}
    worse = {"Enabled": on, "Disabled": {**on, "QuitInverterOn": 0}, "Off": {"SystemReady": 1}, "Fault": {"Error": 1}}
    bus.update([frame(f"AmkActual1{wheel}", 0.0, **on) for wheel in AMK_WHEELS])
    for k, (said, bits) in enumerate(worse.items(), start=1):
        bus.update([frame("AmkActual1RearLeft", 10.0 * k, **bits)])
        assert bus.snapshot()["states"]["INVERTER"]["state"] == said


@pytest.mark.parametrize("signals, said", [({"Enabled": 1}, "Enabled"), ({}, "Disabled"), ({"Lockout": 1}, "Lockout")])
def test_a_pm100_says_its_state_in_bits(bus, frame, signals, said):
    bus.update([frame("Pm100States", 0.0, **signals), frame("Pm100Faults", 0.0)])
    assert bus.snapshot()["states"]["INVERTER"]["state"] == said
    bus.update([frame("Pm100Faults", 10.0, RunHigh=1)])
    assert bus.snapshot()["states"]["INVERTER"]["state"] == "Fault"
