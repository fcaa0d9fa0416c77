# SPDX-License-Identifier: Apache-2.0
"""Processes that die, hang or are interrupted in the middle of a lap."""
import os
import re
import signal
import struct
import time

import pytest
from conftest import BUS, HANG_S, Bus, children, is_gone, kill_at, result, start, wait_for, wait_for_tick

DRIVING_TICK = 1500  # 15 s after power-on: the car drives
CONTACTOR_COMMAND, INVERTER_COMMAND = 0x0A0, 0x0A1


def lap(folder, *more, laps=3):
    """Longer than any of these tests needs: a listener on a loaded machine lags behind the run."""
    return start("endurance", "--laps", laps, "--bus", BUS, "--json", folder / "r.json", *more)


def finish(process):
    out, err = process.communicate(timeout=HANG_S)
    return process.returncode, out, err


@pytest.mark.parametrize("role", ("bms", "master"))
def test_dead_control_unit_stops_the_car_in_time_and_is_named(tmp_path, role):
    run = lap(tmp_path)
    pid = kill_at(run, role, DRIVING_TICK)
    code, out, err = finish(run)
    assert code == 3
    assert f"node {role} (process {pid}) was killed by signal 9" in err
    assert "FAILED" in out and f"node {role} was lost" in out
    [row] = result(tmp_path / "r.json")["lost_nodes"]
    assert row["node"] == role and DRIVING_TICK * 0.01 <= row["time_s"]
    assert row["torque_zero_s"] <= 0.1
    assert row["contactors_open_s"] <= 0.25


def test_hanging_control_unit_is_lost_after_the_wall_time_and_the_other_stays(tmp_path):
    run = lap(tmp_path, "--lost-after", 3)
    begin = time.monotonic()
    kill_at(run, "bms", DRIVING_TICK, signal.SIGSTOP)
    code, out, err = finish(run)
    assert code == 3 and "node bms was lost" in out
    assert "by the wall clock" not in err  # the plant showed life while it waited
    assert [row["node"] for row in result(tmp_path / "r.json")["lost_nodes"]] == ["bms"]
    assert time.monotonic() - begin > 3


def test_dead_logger_does_not_end_the_race_but_the_run_is_not_whole(tmp_path):
    run = lap(tmp_path, "--candump", tmp_path / "r.log", laps=1)
    kill_at(run, "log", DRIVING_TICK // 10)
    code, out, err = finish(run)
    assert code == 3 and "node logger" in err and "Finished" in out
    assert result(tmp_path / "r.json")["status"] == "finished"
    assert [row["node"] for row in result(tmp_path / "r.json")["lost_nodes"]] == ["logger"]
    assert not (tmp_path / "r.log").exists()


def test_dead_plant_leaves_the_control_units_to_their_safe_state(tmp_path):
    run = lap(tmp_path)
    kill_at(run, "plant", DRIVING_TICK)
    with Bus([CONTACTOR_COMMAND, INVERTER_COMMAND]) as bus:
        code, _, err = finish(run)
        last = dict(bus.drain())
    assert code == 3
    last_tick = re.search(r"node plant \(process \d+\) was killed by signal 9 \(Killed\) at tick (\d+)", err)
    assert last_tick and int(last_tick[1]) >= DRIVING_TICK
    assert "no word from the plant for 2 s" in err
    assert "contactors commanded open: yes, torque command zero: yes" in err
    assert last[CONTACTOR_COMMAND][0] & 0b111 == 0
    assert struct.unpack_from("<hB", last[INVERTER_COMMAND]) == (0, 0)
    assert not (tmp_path / "r.json").exists()


@pytest.mark.parametrize("number, code", ((signal.SIGINT, 130), (signal.SIGTERM, 143)))
def test_interrupted_run_leaves_no_process_and_no_file(tmp_path, number, code):
    run = lap(tmp_path, "--candump", tmp_path / "r.log")
    wait_for_tick(100)
    pids = children(run.pid)
    assert sorted(pids) == ["bms", "log", "master", "plant"]
    run.send_signal(number)
    assert finish(run)[0] == code
    assert all(is_gone(pid) for pid in pids.values())
    assert list(tmp_path.iterdir()) == []


def test_killed_supervisor_takes_everybody_with_it(tmp_path):
    run = lap(tmp_path)
    wait_for_tick(100)
    pids = children(run.pid)
    run.kill()
    run.wait()
    wait_for(lambda: all(is_gone(pid) for pid in pids.values()))


def test_interrupt_before_the_first_tick_leaves_nothing_either(tmp_path):
    run = lap(tmp_path, "--candump", tmp_path / "r.log")
    pids = wait_for(lambda: len(children(run.pid)) == 4 and children(run.pid))
    run.send_signal(signal.SIGINT)
    assert finish(run)[0] == 130
    assert all(is_gone(pid) for pid in pids.values())
    assert list(tmp_path.iterdir()) == []


def test_second_death_is_told_too(tmp_path):
    run = lap(tmp_path)
    wait_for_tick(DRIVING_TICK)
    pids = children(run.pid)
    for role in ("bms", "master"):
        os.kill(pids[role], signal.SIGKILL)
    code, _, err = finish(run)
    assert code == 3 and "node bms" in err and "node master" in err
    assert sorted(row["node"] for row in result(tmp_path / "r.json")["lost_nodes"]) == ["bms", "master"]
