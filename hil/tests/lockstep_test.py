# SPDX-License-Identifier: Apache-2.0
"""The harness in the barrier, against a plant that is a thread on a virtual bus; and the clock without a barrier."""
import threading

import pytest

from voltlap_hil.bus import Bus
from voltlap_hil.errors import HilError
from voltlap_hil.frame import Frame
from voltlap_hil.lockstep import BusClock, LockstepClock


class FakePlant:
    """Waits for ReadyHil, then gives `ticks` ticks of one car frame each, and waits for DoneHil after each."""

    def __init__(self, dbc, channel, ticks=5, frames=("VehicleIo",)):
        self.dbc, self.ticks, self.names = dbc, ticks, frames
        self.bus = Bus(channel, "virtual", dbc)
        self.heard = []
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def say(self, name, **values):
        row = self.dbc.message(name)
        self.bus.send([Frame(row.id, row.seal(row.encode(values)) if row.sealable else row.encode(values))])

    def wait_for(self, name):
        while True:
            for frame in self.bus.receive(5.0):
                message = self.dbc.by_id[frame.id]
                self.heard.append((message.name, message.read(frame.data)))
                if message.name == name:
                    return

    def _run(self):
        self.wait_for("ReadyHil")
        for tick in range(self.ticks):
            for name in self.names:
                self.say(name)
            self.say("Sync", Tick=tick)
            self.say("DoneMaster", Tick=tick)
            self.wait_for("DoneHil")
        self.say("Sync", Tick=self.ticks, Stop=1)

    def close(self):
        self._thread.join(60.0)
        self.bus.close()


@pytest.fixture
def plant(dbc, request):
    fake = FakePlant(dbc, request.node.name)
    yield fake
    fake.close()


@pytest.fixture
def clock(dbc, plant, request):
    clock = LockstepClock(request.node.name, dbc, None, interface="virtual", patience_s=60.0)
    yield clock
    while clock.tick < plant.ticks - 1:
        clock.advance()
    clock.stop()
    clock.close()


def test_time_goes_on_by_ten_milliseconds_a_call_and_frames_carry_it(dbc, clock):
    seen = [clock.advance() for _ in range(4)]
    assert clock.tick == 3 and clock.now_ms == 30
    assert [[(f.id, f.time_ms) for f in frames] for frames in seen] == [
        [(dbc.message("VehicleIo").id, t * 10.0)] for t in range(4)]


def test_the_plant_waits_while_the_harness_thinks(clock, plant):
    clock.advance()
    clock.advance()
    assert [values["Tick"] for name, values in plant.heard if name == "DoneHil"] == [0]


def test_what_is_told_takes_effect_in_the_next_tick_and_comes_before_done(clock, plant):
    clock.advance()
    clock.advance()
    clock.tell("DriverOverride", Accelerator=80, Brake=None, TsOn="On")
    clock.advance()
    after = plant.heard[-2:]
    assert [name for name, _ in after] == ["DriverOverride", "DoneHil"]
    assert after[0][1] == {"Tick": 2, "Accelerator": 80, "Brake": None, "TsOn": "On", "ReadyToDrive": "Automatic",
                           "Reset": "Automatic", "Shutdown": "Automatic"}


def test_frames_of_the_harness_are_counted_in_its_done(clock, plant, frame):
    clock.advance()
    clock.send([frame("Pedals"), frame("Pedals")])
    clock.advance()
    assert [v["FramesSent"] for n, v in plant.heard if n == "DoneHil"] == [2]


def test_a_node_that_is_dead_is_reported_as_a_member_lost(clock, plant):
    clock.advance()
    clock.lost("bms")
    clock.advance()
    assert ("MemberLost", {"Member": "Bms"}) in plant.heard


def test_the_end_of_the_run_is_told(dbc, request):
    plant = FakePlant(dbc, request.node.name, ticks=1)
    clock = LockstepClock(request.node.name, dbc, None, interface="virtual", patience_s=60.0)
    clock.advance()
    with pytest.raises(HilError, match="the plant ended the run at 0 ms"):
        clock.advance()
    clock.close()
    plant.close()


def test_a_bus_without_plant_is_told(dbc):
    clock = LockstepClock("nobody", dbc, None, interface="virtual", patience_s=0.3)
    with pytest.raises(HilError, match="plant or a member of its barrier is missing"):
        clock.advance()
    clock.close()


def test_a_process_that_dies_is_told_before_patience_ends(dbc):
    def died():
        raise HilError("bms ended with exit code 3")
    clock = LockstepClock("nobody", dbc, None, check_processes=died, interface="virtual")
    with pytest.raises(HilError, match="bms ended"):
        clock.advance()
    clock.close()


def test_without_sync_the_time_is_that_of_the_bus(dbc, request, frame):
    with Bus(request.node.name, "virtual", dbc) as car:
        clock = BusClock(request.node.name, dbc, None, "virtual")
        assert clock.advance() == [] and clock.now_ms == 10
        car.send([frame("Pedals"), frame("VehicleIo")])
        assert [f.id for f in clock.advance()] == [dbc.message("Pedals").id, dbc.message("VehicleIo").id]
        before = clock.now_ms
        clock.advance()
        assert clock.now_ms > before
        clock.close()


def test_at_a_real_car_a_person_is_asked(dbc, request):
    asked = []
    clock = BusClock(request.node.name, dbc, None, "virtual", operator=asked.append)
    clock.tell("DriverOverride", Accelerator=80, Brake=None, TsOn="On", Reset="Automatic")
    clock.close()
    assert asked == ["voltlap hil: please set at the car: DriverOverride: Accelerator 80, TsOn On"]


def test_a_plant_that_goes_on_without_the_harness_is_told(dbc, request):
    plant = FakePlant(dbc, request.node.name, ticks=0)
    clock = LockstepClock(request.node.name, dbc, None, interface="virtual")
    plant.say("DoneMaster", Tick=4)
    clock.advance()
    plant.say("DoneMaster", Tick=6)
    with pytest.raises(HilError, match="tick 6 came after tick 4"):
        clock.advance()
    clock.close()
    plant.close()
