# SPDX-License-Identifier: Apache-2.0
"""Car and firmware in one process: its gateway, a supply that fails, the driver's own laps, and what goes wrong."""
import subprocess

import pytest

from voltlap_hil.errors import HilError, InputError
from voltlap_hil.nodes import program


def ids_and_data(rig):
    return [(f.id, f.data, f.time_ms) for f in rig.trace.frames]


def test_a_gateway_that_does_nothing_changes_no_frame(open_rig):
    traces = []
    for gateway in (False, True):
        with open_rig(gateway=gateway) as rig:
            rig.start_up("ready_to_drive")
            rig.driver(accelerator=100)
            rig.run("1 s")
            traces.append(ids_and_data(rig))
    assert len(traces[0]) > 1000
    assert traces[0] == traces[1]


def test_only_the_ecu_behind_the_gateway_misses_a_frame(open_rig):
    for behind, fault in ((["bms"], "BmsStatus.Faults has VehicleIoLost"),
                          (["master"], "MasterStatus.Faults has VehicleIoLost")):
        with open_rig(gateway=True, behind=behind) as rig:
            rig.start_up("ready_to_drive")
            rig.gateway("drop", ["VehicleIo"])
            assert rig.wait(fault, within="200 ms") <= 120


def test_a_frame_of_the_harness_reaches_every_node(open_rig):
    for gateway in (False, True):
        with open_rig(gateway=gateway) as rig:
            rig.start_up("ready_to_drive")
            before = rig.trace.count("BmsLimits", 0, 1e9)
            rig.send("BmsLimits", DischargeLimit=0.0)
            rig.run("10 ms")
            assert rig.trace.count("BmsLimits", 0, 1e9) == before + 2


def test_a_reset_bms_forgets_all_but_its_memory(open_rig):
    with open_rig() as rig:
        rig.start_up("ready_to_drive")
        rig.plant("CellLost", index=5)
        rig.wait("BmsStatus.Faults has CellMeasurementLost", within="1 s")
        rig.plant("ClearAll")
        rig.reset("bms", "200 ms")
        quiet = rig.now_ms
        rig.run("150 ms")
        assert rig.trace.count("BmsStatus", quiet + 20, rig.now_ms) == 0
        rig.run("2 s")
        assert "CellMeasurementLost" in rig.signals.bits("BmsStatus.Faults")


def test_the_driver_of_the_plant_drives_and_gives_way(open_rig):
    with open_rig(automatic=True) as rig:
        rig.start_up("automatic")
        rig.drive(to_m=100, within="30 s")
        assert 100 <= rig.distance_m < 101
        rig.driver(accelerator=0, brake=50)
        rig.run("1 s")
        assert rig.signals["MasterStatus.PedalRequest"].value == 0
        rig.automatic()
        rig.wait("MasterStatus.PedalRequest > 20 %", within="10 s")


def test_what_the_bench_cannot_do_is_said(open_rig):
    with open_rig() as rig:
        with pytest.raises(InputError, match="no gateway"):
            rig.gateway("drop", ["Pedals"])
        with pytest.raises(InputError, match="without a driver"):
            rig.automatic()
        with pytest.raises(HilError, match="did not come to 5 m"):
            rig.drive(to_m=5, within="100 ms")


def test_a_car_that_is_refused_says_why(open_rig):
    with pytest.raises(HilError, match="no_such_car"):
        open_rig(arguments=["--vehicle", "no_such_car"])


@pytest.mark.parametrize(("sent", "said"), [
    (b"\xff\xff\xff\xff\0\0\0\0", "a batch of 4294967295 records"),
    (b"\1\0\0\0\0\0\0\0" + b"\1\0\0\0\x09\0\0\0" + bytes(8), "a frame of 9 bytes"),
    (b"\1\0\0\0\0\0\0\0" + b"\1\0", "ended inside a batch"),
])
def test_what_is_no_batch_ends_the_run_with_a_reason(sent, said):
    done = subprocess.run([program(), "rig"], input=sent, capture_output=True, timeout=60)
    assert done.returncode == 3
    assert said in done.stderr.decode()


def test_the_end_of_the_pipe_is_the_end_of_the_run():
    done = subprocess.run([program(), "rig"], input=b"", capture_output=True, timeout=60)
    assert (done.returncode, done.stdout, done.stderr) == (0, b"", b"")
