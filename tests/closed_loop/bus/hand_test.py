# SPDX-License-Identifier: Apache-2.0
"""Plant, control units and logger started by hand, and interfaces that cannot be used."""
import os
import signal
import struct
import subprocess
import time

import pytest
from conftest import BUS, HANG_S, Bus, children, result, run, start, wait_for, wait_for_listener, wait_for_tick

CONTACTOR_COMMAND, PLANT_MESSAGE, BMS_MESSAGE = 0x0A0, 0x0B0, 0x0C1
READY_BMS = 0x7E1
STOP_REQUEST, DRIVER_OVERRIDE, PLANT_FAULT = 0x7F1, 0x7F4, 0x7F5


@pytest.fixture
def drive(tmp_path):
    (tmp_path / "drive.csv").write_text("time_s,speed_mps\n0,0\n2,4\n4,4\n")
    return ["--drive", tmp_path / "drive.csv"]


@pytest.fixture
def started():
    """Starts processes and sees that none is left."""
    processes = []

    def begin(*arguments):
        processes.append(start(*arguments))
        return processes[-1]

    yield begin
    for process in processes:
        if process.poll() is None:
            process.kill()
        process.communicate()


def test_processes_by_hand_drive_the_run_of_one_process(tmp_path, drive, started):
    units = [started("ecu", which, "--bus", BUS) for which in ("master", "bms")]
    log = started("log", "record", "--bus", BUS, "--candump", tmp_path / "bus.log")
    plant = run("plant", "--bus", BUS, "--members", "bms,master,logger", *drive, "--json", tmp_path / "bus.json")
    assert plant.returncode == 0, plant.stderr
    assert [p.wait(HANG_S) for p in (*units, log)] == [0, 0, 0]
    inside = run("endurance", *drive, "--json", tmp_path / "in.json", "--candump", tmp_path / "in.log")
    assert inside.returncode == 0
    assert result(tmp_path / "bus.json")["trace_hash"] == result(tmp_path / "in.json")["trace_hash"]
    assert (tmp_path / "bus.log").read_bytes() == (tmp_path / "in.log").read_bytes()


def test_both_control_units_in_one_process_give_the_same_frames(tmp_path, drive, started):
    unit = started("ecu", "all", "--bus", BUS)
    plant = run("plant", "--bus", BUS, *drive, "--json", tmp_path / "bus.json")
    assert plant.returncode == 0, plant.stderr
    assert unit.wait(HANG_S) == 0
    assert run("endurance", *drive, "--json", tmp_path / "in.json").returncode == 0
    assert result(tmp_path / "bus.json")["trace_hash"] == result(tmp_path / "in.json")["trace_hash"]


def test_members_that_are_not_ready_are_named(drive, started):
    started("ecu", "bms", "--bus", BUS)
    with Bus([READY_BMS]) as bus:
        assert bus.receive(HANG_S)
    plant = run("plant", "--bus", BUS, *drive, "--ready-within", 3)
    assert plant.returncode == 2
    assert "found that master did not become READY within 3 s" in plant.stderr


def test_second_plant_is_refused_and_the_first_drives_on(tmp_path, started):
    first = started("endurance", "--laps", 1, "--bus", BUS, "--pace", 8, "--json", tmp_path / "first.json")
    wait_for_tick(10)
    second = run("endurance", "--laps", 1, "--bus", BUS)
    assert second.returncode == 2 and "somebody already drives there" in second.stderr
    assert first.wait(HANG_S) == 0
    assert result(tmp_path / "first.json")["lost_nodes"] == []


def test_control_unit_alone_goes_to_its_safe_state_and_ends(drive, started):
    units = [started("ecu", which, "--bus", BUS) for which in ("bms", "master")]
    plant = started("plant", "--bus", BUS, *drive, "--pace", 2)
    wait_for_tick(400)
    plant.kill()
    begin = time.monotonic()
    with Bus([CONTACTOR_COMMAND]) as bus:
        assert [unit.wait(HANG_S) for unit in units] == [3, 3]
        frames = bus.drain()
    assert time.monotonic() - begin > 6.0
    assert frames[-1][1][0] & 0b111 == 0 and len(frames) > 100
    for unit in units:
        assert "no word from the plant for 2 s after tick" in unit.stderr.read()


def test_waiting_control_unit_ends_with_ctrl_c(started):
    unit = started("ecu", "bms", "--bus", BUS)
    with Bus([READY_BMS]) as bus:
        assert bus.receive(HANG_S) == (READY_BMS, bytes([1, 0, 0, 0, 0, 0, 0, 0]))
    unit.send_signal(signal.SIGINT)
    assert unit.wait(HANG_S) == 130


@pytest.mark.parametrize("reason, code", ((2, 0), (1, 130)))
def test_harness_ends_a_standing_car(tmp_path, started, reason, code):
    started("ecu", "all", "--bus", BUS)
    plant = started("plant", "--bus", BUS, "--driver", "stand", "--json", tmp_path / "r.json")
    wait_for_tick(600)
    with Bus([]) as bus:
        bus.send(STOP_REQUEST, bytes([reason, 0, 0, 0, 0, 0, 0, 0]))
    assert plant.wait(HANG_S) == code
    assert (tmp_path / "r.json").exists() == (code == 0)


def test_nobody_in_the_car_and_a_duration(tmp_path, started):
    started("ecu", "all", "--bus", BUS)
    plant = run("plant", "--bus", BUS, "--driver", "none", "--duration", 3, "--json", tmp_path / "r.json")
    assert plant.returncode == 0, plant.stderr
    outcome = result(tmp_path / "r.json")
    assert outcome["total_time_s"] == pytest.approx(3.0) and outcome["distance_m"] == 0.0


def before_the_first_tick(started, *frames):
    """Sends to a plant that waits for its control units, and gives it those."""
    wait_for_listener()
    with Bus([]) as bus:
        for identifier, data in frames:
            bus.send(identifier, data)
    started("ecu", "all", "--bus", BUS)


def override(tick, accelerator=0xFF, brake=0xFF, ts_on=0, ready=0):
    return struct.pack("<IBBBB", tick, accelerator, brake, ts_on | ready << 2, 0)


def test_harness_powers_up_and_drives_off_where_nobody_sits(tmp_path, started):
    plant = started("plant", "--bus", BUS, "--driver", "none", "--duration", 9, "--json", tmp_path / "r.json")
    before_the_first_tick(started, *((DRIVER_OVERRIDE, frame) for frame in (
        override(0, 0, 200), override(60, 0, 200, ts_on=2), override(400, 0, 200, ready=2), override(460, 100, 0))))
    assert plant.wait(HANG_S) == 0
    assert result(tmp_path / "r.json")["distance_m"] > 10.0


def test_plant_fault_acts_at_its_tick(tmp_path, started):
    """Without its current reading the BMS opens the contactors, and the run fails by itself."""
    plant = started("plant", "--bus", BUS, "--laps", 1, "--json", tmp_path / "r.json")
    before_the_first_tick(started, (PLANT_FAULT, struct.pack("<IBBh", 1200, 9, 0, 0)))  # current reading lost
    assert plant.wait(HANG_S) == 3
    outcome = result(tmp_path / "r.json")
    assert outcome["status"] == "failed" and "left ready-to-drive" in outcome["failure"]["cause"]
    assert 8.0 < outcome["failure"]["time_s"] < 11.0  # of the race, which began some seconds after power-on


def test_error_frames_and_foreign_frames_are_counted_and_change_nothing(tmp_path, drive, started):
    started("ecu", "all", "--bus", BUS)
    plant = started("plant", "--bus", BUS, *drive, "--pace", 1, "--json", tmp_path / "r.json")
    wait_for_tick(100)
    with Bus([]) as bus:
        bus.send(0x20000004, bytes(8))
        bus.send(0x555, bytes(8))
        bus.send(0x0B1, bytes(8))  # the plant's identifier, from somebody else
    assert plant.wait(HANG_S) == 0
    assert run("endurance", *drive, "--json", tmp_path / "in.json").returncode == 0
    outcome = result(tmp_path / "r.json")
    assert outcome["bus"]["error_frames"] == 1 and outcome["bus"]["foreign_frames"] == 2
    assert outcome["trace_hash"] == result(tmp_path / "in.json")["trace_hash"]


def test_interface_that_goes_down_ends_everybody_with_the_reason(started):
    interface = "vcan1"
    done = started("endurance", "--laps", 5, "--bus", interface)
    wait_for_tick(100, interface)
    subprocess.run(["ip", "link", "set", interface, "down"], check=True)
    try:
        out, err = done.communicate(timeout=HANG_S)
        assert done.returncode == 3
        assert 'CAN interface "vcan1" went down or was removed' in out and "went down" in err
    finally:
        subprocess.run(["ip", "link", "set", interface, "up"], check=True)


def test_interfaces_that_cannot_be_used_are_named_with_the_way_out():
    subprocess.run(["ip", "link", "set", "vcan1", "down"], check=True)
    try:
        for command in (["endurance", "--laps", 1], ["plant"], ["ecu", "bms"],
                        ["log", "record", "--candump", "/dev/null"]):
            for interface, words in {"vcan7": ["no such interface", "ip link add dev vcan7 type vcan", "with-vcan"],
                                     "lo": ["no CAN interface"], "vcan1": ["is down", "ip link set vcan1 up"],
                                     "a-name-far-too-long": ["1 to 15 characters"]}.items():
                done = run(*command, "--bus", interface)
                assert done.returncode == 2, (command, interface)
                assert all(word in done.stderr for word in words), done.stderr
    finally:
        subprocess.run(["ip", "link", "set", "vcan1", "up"], check=True)


def test_real_time_run_takes_as_long_as_its_drive_and_reports_late_steps(tmp_path, drive):
    begin = time.monotonic()
    with Bus() as bus:
        done = run("endurance", "--bus", BUS, "--realtime", *drive, "--json", tmp_path / "r.json",
                   "--candump", tmp_path / "r.log")
        heard = bus.drain()
    took_s = time.monotonic() - begin
    outcome = result(tmp_path / "r.json")
    # A machine that is too slow fails the run, as a real node that is late would; then it says how late it was.
    assert done.returncode == 0 or outcome["bus"]["late_worst_s"] > 0.02, done.stdout
    assert took_s > (7.0 if done.returncode == 0 else 0.5) and outcome["bus"]["pacing"] == "realtime"
    assert "late steps" in done.stdout
    assert not [frame for frame in heard if 0x7E0 <= frame[0] <= 0x7FF]
    if done.returncode == 0:  # what it heard since it was awake: by the wall clock nobody waits for a logger
        assert len((tmp_path / "r.log").read_text().splitlines()) > 100


def test_dead_node_in_real_time_ends_the_run_with_its_name(tmp_path, drive):
    done = start("endurance", "--laps", 1, "--bus", BUS, "--realtime", "--json", tmp_path / "r.json")
    with Bus([PLANT_MESSAGE, BMS_MESSAGE]) as bus:  # plant and BMS have heard each other
        heard = set()
        wait_for(lambda: heard.update(identifier for identifier, _ in bus.drain()) or len(heard) == 2)
    os.kill(children(done.pid)["bms"], signal.SIGKILL)
    out, err = done.communicate(timeout=HANG_S)
    assert done.returncode == 3 and "node bms" in err and "FAILED" in out
    assert result(tmp_path / "r.json")["lost_nodes"][0]["node"] == "bms"


def test_control_unit_does_not_join_a_run_that_goes_on(tmp_path, drive, started):
    first = started("endurance", *drive, "--bus", BUS, "--pace", 8, "--json", tmp_path / "first.json")
    wait_for_tick(10)
    late = started("ecu", "bms", "--bus", BUS)
    assert first.wait(HANG_S) == 0
    assert late.poll() is None  # it waits for a plant of its own
    late.send_signal(signal.SIGTERM)
    assert late.wait(HANG_S) == 143
    inside = run("endurance", *drive, "--json", tmp_path / "in.json")
    assert inside.returncode == 0
    assert result(tmp_path / "first.json")["trace_hash"] == result(tmp_path / "in.json")["trace_hash"]
