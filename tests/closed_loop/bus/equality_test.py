# SPDX-License-Identifier: Apache-2.0
"""One lap as three processes on vcan0 is the lap of one process, frame by frame."""
import cantools
import pytest
from conftest import BUS, ROOT, result, run

HASHES = ("trace_hash", "hash_plant", "hash_bms", "hash_master")


@pytest.fixture(scope="module")
def laps(tmp_path_factory):
    """The same lap in one process and on the bus; noise makes every frame depend on the seed."""
    folder = tmp_path_factory.mktemp("laps")
    flags = ["endurance", "--laps", 1, "--seed", 7, "--set", "sensors.noise=true", "--bus-load"]
    out = {}
    for where, more in {"inside": [], "bus": ["--bus", BUS]}.items():
        done = run(*flags, *more, "--json", folder / f"{where}.json", "--candump", folder / f"{where}.log")
        assert done.returncode == 0, done.stderr
        out[where] = {"result": result(folder / f"{where}.json"), "log": folder / f"{where}.log",
                      "printed": done.stdout}
    return out


def test_hashes_over_what_was_read_back_equal_those_of_one_process(laps):
    for name in HASHES:
        assert laps["inside"]["result"][name] == laps["bus"]["result"][name], name
    assert laps["inside"]["result"]["frames"] == laps["bus"]["result"]["frames"] > 100_000


def test_another_seed_has_other_hashes(laps, tmp_path):
    done = run("endurance", "--laps", 1, "--seed", 8, "--set", "sensors.noise=true", "--bus", BUS,
               "--json", tmp_path / "o.json")
    assert done.returncode == 0, done.stderr
    other = result(tmp_path / "o.json")
    for name in HASHES[:3]:
        assert other[name] != laps["bus"]["result"][name], name


def test_summary_is_the_same_but_for_the_bus_and_the_clock(laps):
    def lines(where):
        return [line for line in laps[where]["printed"].splitlines()
                if "bus:" not in line and "computed in" not in line]
    assert lines("inside") == lines("bus")
    assert "bus: vcan0, lockstep" in laps["bus"]["printed"]


def test_nothing_is_foreign_missing_or_dropped(laps):
    bus = laps["bus"]["result"]["bus"]
    assert bus["interface"] == BUS and bus["pacing"] == "lockstep"
    assert not any(bus[name] for name in ("foreign_frames", "missing_frames", "dropped_frames", "error_frames"))
    assert laps["bus"]["result"]["lost_nodes"] == []


def test_log_equals_that_of_one_process_line_for_line(laps):
    assert laps["inside"]["log"].read_bytes() == laps["bus"]["log"].read_bytes()


def test_log_decodes_without_one_error(laps):
    database = cantools.database.Database()
    for name in ("car.dbc", "orion.dbc", "charger.dbc", "pm100.dbc", "amk.dbc"):
        database.add_dbc_file(str(ROOT / "can_dbc" / name))
    decoded = 0
    for line in laps["bus"]["log"].read_text().splitlines():
        identifier, data = line.split()[2].split("#")
        database.decode_message(int(identifier, 16), bytes.fromhex(data))
        decoded += 1
    assert decoded == laps["bus"]["result"]["frames"]


def short_drive(folder):
    (folder / "drive.csv").write_text("time_s,speed_mps\n0,0\n2,4\n4,4\n")
    return folder / "drive.csv"


def simulated_s(log):
    """From the first frame to the last [s]: start-up, drive and end."""
    return float(log.read_text().splitlines()[-1].split()[0].strip("()"))


def test_pace_bounds_the_run(tmp_path):
    drive = short_drive(tmp_path)
    fast = run("endurance", "--bus", BUS, "--drive", drive, "--json", tmp_path / "fast.json")
    slow = run("endurance", "--bus", BUS, "--drive", drive, "--pace", 4, "--json", tmp_path / "slow.json",
               "--candump", tmp_path / "slow.log")
    assert fast.returncode == slow.returncode == 0, slow.stderr
    a, b = result(tmp_path / "fast.json"), result(tmp_path / "slow.json")
    assert a["trace_hash"] == b["trace_hash"]
    assert simulated_s(tmp_path / "slow.log") > 4.0, "the drive alone takes as long"
    assert b["wall_s"] > simulated_s(tmp_path / "slow.log") / 4.0
    assert a["wall_s"] < b["wall_s"]
