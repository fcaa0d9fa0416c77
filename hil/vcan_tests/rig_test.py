# SPDX-License-Identifier: Apache-2.0
"""The rig with real nodes on a real bus, from plain pytest."""
import time

import can
import cantools
import pytest

from voltlap_hil import checks
from voltlap_hil.bus import Bus
from voltlap_hil.dbc import can_dbc_folder
from voltlap_hil.errors import HilError, InputError
from voltlap_hil.frame import EXTENDED, is_lockstep
from voltlap_hil.nodes import Nodes
from voltlap_hil.rig import Bench, Rig

FULL_PEDAL = "InverterStatus.PhaseCurrent > 400 A"


def lost_cell(rig):
    """Full pedal, a lost cell voltage; what was measured, and every frame."""
    rig.start_up()
    rig.driver(accelerator=100)
    rig.wait(FULL_PEDAL, within="1 s")
    event = rig.now_ms
    rig.plant("CellLost", index=5)
    rig.run("800 ms")
    torque = checks.torque_zero_within(rig.dbc, 600).measure(rig.trace, event)
    contactors = checks.contactors_open_within(rig.dbc, 750).measure(rig.trace, event)
    return (event, torque, contactors), rig.trace.frames


def test_a_run_repeats_to_the_last_bit_of_the_last_frame(open_rig):
    first = lost_cell(open_rig())
    for gateway in (False, True):
        rig = open_rig(gateway=gateway)
        assert lost_cell(rig) == first
        rig.close()
    (_, torque, contactors), frames = first
    assert torque.held and contactors.held and len(frames) > 1000


@pytest.fixture
def open_rig(open_rig):
    """One run at a time: the next closes the one before."""
    running = []

    def opened(**what):
        if running:
            running.pop().close()
        running.append(open_rig(**what))
        return running[0]
    return opened


def test_every_frame_of_the_nodes_is_heard_once_decodes_and_is_sealed(open_rig, dbc):
    with Bus("vcan0", dbc=dbc) as listener:
        rig = open_rig()
        rig.start_up("tractive_system")
        rig.close()
        heard = []
        while batch := listener.receive():
            heard += batch
    car = [f for f in heard if not is_lockstep(f.id)]
    frames = [(f.id, f.data) for f in rig.trace.frames]
    assert frames == [(f.id, f.data) for f in car][:len(frames)]
    marks = [dbc.by_id[f.id].read(f.data) for f in heard if dbc.by_id[f.id].name in ("Sync", "DoneBms", "DoneMaster")]
    assert sum(mark["FramesSent"] for mark in marks if not mark.get("Stop")) == len(car)
    assert all(dbc.by_id[i].sealed_ok(data) for i, data in frames)
    database = cantools.database.load_file(can_dbc_folder() / "car.dbc")
    for can_id, data in {(i, d) for i, d in frames if dbc.by_id[i].file == "car.dbc"}:
        database.decode_message(can_id, data)


@pytest.mark.parametrize("suffix", [".log", ".asc", ".blf"])
def test_a_recording_has_every_frame_with_simulated_time(open_rig, tmp_path, suffix):
    rig = open_rig(record=tmp_path / f"run{suffix}", watch=["BmsStatus.State"])
    rig.start_up("low_voltage")
    rig.close()
    messages = list(can.LogReader(tmp_path / f"run{suffix}"))
    read = [(m.arbitration_id | (EXTENDED if m.is_extended_id else 0), bytes(m.data)) for m in messages]
    assert read == [(f.id, f.data) for f in rig.trace.frames] and len({i for i, _ in read}) > 20
    assert messages[-1].timestamp - messages[0].timestamp == pytest.approx(rig.trace.end_ms / 1000)


def test_a_rig_listens_only_to_what_is_watched(open_rig, dbc):
    rig = open_rig(watch=["BmsStatus.State", "MasterStatus.DriveState"])
    rig.run("200 ms")
    assert {dbc.by_id[f.id].name for f in rig.trace.frames} == {"BmsStatus", "MasterStatus"}


def test_a_condition_that_does_not_come_says_what_was_seen(open_rig):
    rig = open_rig()
    seen = r"did not come within 100 ms; at \d+ ms BmsStatus.State = \w+, PackSensor.PackCurrent = .* A"
    with pytest.raises(HilError, match=seen):
        rig.wait("BmsStatus.State = TsActive and PackSensor.PackCurrent > 100 A", within="100 ms")


def test_a_plant_that_dies_ends_the_run_with_its_name(open_rig):
    rig = open_rig()
    rig.run("100 ms")
    rig.nodes._running["plant"].kill()
    with pytest.raises(HilError, match="plant ended with exit code -9"):
        rig.run("100 ms")


def test_a_wrong_argument_of_the_nodes_is_told_in_their_words(open_rig):
    with pytest.raises(HilError, match="ended with exit code 2: .*no_such.key"):
        open_rig(arguments=["--set", "no_such.key=1"])


def test_what_does_not_exist_is_refused(open_rig):
    rig = open_rig()
    for mistake in (lambda: rig.driver(clutch="On"), lambda: rig.start_up("ready"), lambda: rig.kill("inverter"),
                    lambda: rig.gateway("drop", ["Pedals"]), lambda: rig.plant("CellGone")):
        with pytest.raises(InputError):
            mistake()


def test_a_frame_of_the_harness_reaches_the_nodes(open_rig):
    """Frames two counts ahead of the plant's own, that say the shutdown circuit is open."""
    rig = open_rig()
    rig.start_up()
    rig.send("VehicleIo", ShutdownClosed=0)
    rig.step()
    rig.send("VehicleIo", ShutdownClosed=0)
    rig.wait("ContactorCommand.AirPlusClose = 0 and MasterStatus.DriveState = LvOn", within="50 ms")


def test_nodes_that_run_already_are_followed_by_the_time_of_the_bus(dbc):
    nodes, asked = Nodes(), []
    try:
        nodes.start("ecus", ["ecu", "all", "--bus", "vcan0", "--realtime"])
        nodes.start("plant", ["plant", "--bus", "vcan0", "--realtime", "--driver", "stand", "--duration", "600"])
        opened = time.monotonic()
        with Rig(Bench("vcan0", start=False, operator=asked.append), dbc=dbc) as rig:
            rig.driver(accelerator=0, shutdown="On")
            rig.wait("PackSensor.PackVoltage > 90 V and BmsStatus.State != Invalid", within="300 s")
            begin = rig.now_ms
            rig.run("500 ms")
            assert begin + 500 <= rig.now_ms <= (time.monotonic() - opened) * 1000 + 50
            times = [f.time_ms for f in rig.trace.frames]
            assert times == sorted(times)
        assert asked == ["voltlap hil: please set at the car: DriverOverride: Accelerator 0, Shutdown On"]
    finally:
        nodes.stop()
