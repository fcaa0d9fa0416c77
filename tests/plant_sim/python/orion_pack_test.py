# SPDX-License-Identifier: Apache-2.0
"""A pack file made from a profile says what the profile says, and our programs take it."""
import os
import pathlib
import random
import subprocess

import pytest
from orion_profiles import PROJECT, SEED, drawn_profile, orion, profile_text

try:
    import tomllib
except ModuleNotFoundError:  # Python before 3.11
    import tomli as tomllib

BUILD = pathlib.Path(os.environ["VOLTLAP_BUILD_DIR"])
DATA = pathlib.Path(os.environ.get("VOLTLAP_DATA", "/nowhere"))
CONVERSION = DATA / "orion2_conversion_candump"
needs_data = pytest.mark.skipif(not CONVERSION.is_dir(), reason="VOLTLAP_DATA has no orion2_conversion_candump")


def pack_of(profile, *flags):
    pack = profile.parent / "pack.toml"
    done = orion("import", profile, "--output", pack, *flags)
    assert done.returncode == 0, done.stderr
    return pack


def program(name, *words):
    return subprocess.run([BUILD / "bin" / name, *map(str, words)], capture_output=True, text=True, timeout=120)


def test_drawn_profiles_come_back_out_of_their_packs(tmp_path):
    print(f"VOLTLAP_TEST_SEED={SEED}")
    source = random.Random(SEED)
    profile = tmp_path / "car.o2bms"
    for _ in range(12):
        whole, tables, cells = drawn_profile(source)
        profile.write_text(profile_text(whole, tables, cells))
        pack = tomllib.loads(pack_of(profile).read_text())
        battery, bms = pack["battery"], pack["bms"]
        top, start_c = tables["dclTemperatureTable"][19], whole["derateHighTempDCLStart"]
        hot_c = min(whole["hotPackTemperature"], whole["maxDclTemperature"],
                    start_c + top / whole["derateHighTempDCLAmperage"])
        assert battery["cells_in_series"] == whole["totalCells"]
        assert battery["cells_in_parallel"] * battery["capacity_ah"] == pytest.approx(whole["totalAmphours"] / 100)
        assert bms["discharge_current_max_a"] == min(whole["maximumDCL"], top)
        assert bms["charge_current_max_a"] == min(whole["maximumCCL"], max(tables["cclTemperatureTable"].values()))
        assert bms["cell_voltage_min_v"] == pytest.approx(whole["minimumCellVoltage"] / 1e4)
        assert bms["cell_voltage_max_v"] == pytest.approx(whole["maximumCellVoltage"] / 1e4)
        assert bms["temperature_max_c"] == pytest.approx(hot_c)
        assert bms["temperature_derating_start_c"] == start_c
        assert bms["soc_derating_start"] == pytest.approx(whole["derateLowSOCStart"] / 100)
        assert bms["balancing_voltage_min_v"] == pytest.approx(whole["minimumBalanceVoltage"] / 1e4)
        assert bms["balancing_difference_v"] == pytest.approx(whole["balanceDeltaVoltage"] / 1e4)
        line = [bms["resistance_ohm"] * (1 + bms["resistance_per_kelvin"] * (at_c - 25)) for at_c in range(10, 56, 5)]
        table = [1e-5 * 1.2 * tables["resistanceTable"][k] for k in range(10, 20)]
        excess = [ours - theirs for ours, theirs in zip(line, table, strict=True)]
        assert min(excess) == pytest.approx(0.0, abs=1e-8) and max(excess) < 0.5 * table[0]
        assert pack["sensors"]["temperature_count"] * 5 >= whole["totalCells"]


def test_the_car_drives_with_a_drawn_pack(tmp_path):
    print(f"VOLTLAP_TEST_SEED={SEED}")
    source = random.Random(SEED)
    profile = tmp_path / "car.o2bms"
    for _ in range(5):
        whole, tables, _ = drawn_profile(source)
        whole |= {"maximumCellVoltage": 42000, "minimumCellVoltage": 25000, "totalCells": source.randrange(60, 145),
                  "totalAmphours": source.randrange(1500, 30001), "maximumDCL": 300, "maximumCCL": 100}
        tables |= {"dclTemperatureTable": dict.fromkeys(range(20), 300.0),
                   "cclTemperatureTable": dict.fromkeys(range(20), 100.0),
                   "resistanceTable": {k: round(500 * 0.95**k) for k in range(25)}}
        profile.write_text(profile_text(whole, tables, whole["totalCells"]))
        done = program("voltlap", "endurance", "--vehicle", pack_of(profile), "--laps", 1)
        assert done.returncode == 0, done.stderr + done.stdout


def test_a_cell_is_named_or_a_file_and_nothing_that_is_read_is_overwritten(tmp_path):
    profile = tmp_path / "car.o2bms"
    profile.write_text(profile_text(*drawn_profile(random.Random(1))))
    own = tmp_path / "own cell.toml"
    own.write_text((PROJECT / "plant_sim/data/cells/sony_vtc6.toml").read_text())
    assert tomllib.loads(pack_of(profile).read_text())["battery"]["cell"] == "molicel_p42a"
    assert tomllib.loads(pack_of(profile, "--cell", "sony_vtc6").read_text())["battery"]["cell"] == "sony_vtc6"
    pack = pack_of(profile, "--cell", own)
    assert tomllib.loads(pack.read_text())["battery"]["cell"] == str(own)
    assert "# by --cell" in pack.read_text() and orion("import", profile).stdout.count("assumed") >= 2
    (tmp_path / "link.toml").symlink_to(own)
    before = profile.read_text(), own.read_text()
    for output in (profile, own, tmp_path / "link.toml", tmp_path / "." / "car.o2bms", tmp_path, tmp_path / "no" / "a"):
        done = orion("import", profile, "--cell", own, "--output", output)
        assert done.returncode == 2 and "--output" in done.stderr and "Traceback" not in done.stderr
    assert (profile.read_text(), own.read_text()) == before
    done = orion("import", profile, "--cell", "no_such_cell")
    assert done.returncode == 2 and "molicel_p42a" in done.stderr
    no_capacity = "[x]\ncapacity_ah = 4\nreference_temperature_c = 25\n"
    for text in ("capacity_ah = -1\n", "", "capacity_ah = 1e\n", no_capacity):
        own.write_text(text)
        done = orion("import", profile, "--cell", own)
        assert done.returncode == 2 and "capacity_ah" in done.stderr and "Traceback" not in done.stderr
    own.write_bytes(b"\xff\xfe\x00")
    assert orion("import", profile, "--cell", own).stderr.count("no text") == 1
    assert sorted(path.name for path in tmp_path.iterdir()) == ["car.o2bms", "link.toml", "own cell.toml", "pack.toml"]


def test_a_cell_that_can_hardly_be_the_cars_is_doubted(tmp_path):
    profile = tmp_path / "car.o2bms"
    whole, tables, _ = drawn_profile(random.Random(1))
    for high, doubted in ((36500, True), (41500, False)):
        profile.write_text(profile_text(whole | {"maximumCellVoltage": high, "minimumCellVoltage": 25000}, tables))
        done = orion("import", profile, "--output", tmp_path / "pack.toml")
        assert done.returncode == 0 and ("another kind of cell?" in done.stdout) == doubted, done.stderr
        assert ("another kind of cell?" in (tmp_path / "pack.toml").read_text()) == doubted


def test_a_pack_that_cannot_be_written_whole_leaves_the_one_before(tmp_path):
    profile = tmp_path / "car.o2bms"
    profile.write_text(profile_text(*drawn_profile(random.Random(1))))
    pack = pack_of(profile)
    before = pack.read_text()
    profile.write_text("<java/>")
    assert orion("import", profile, "--output", pack).returncode == 2
    assert pack.read_text() == before


def test_what_is_not_understood_is_listed_and_counted(tmp_path):
    profile = tmp_path / "car.o2bms"
    whole, tables, cells = drawn_profile(random.Random(1))
    profile.write_text(profile_text(whole | {"fluxCapacitor": 88}, tables, cells))
    brief, whole_text = orion("show", profile).stdout, orion("show", profile, "--all").stdout
    assert "1 properties not understood" in brief and "fluxCapacitor" not in brief
    row = next(line for line in whole_text.splitlines() if "fluxCapacitor" in line)
    assert '"88"' in row and "line " in row
    assert "fluxCapacitor" not in orion("import", profile).stdout


@needs_data
@pytest.mark.parametrize(("file", "cells", "capacity_ah", "limits"), [
    ("orion2_conversion_candump/UpdatedProfile.o2bms", 72, 156.0, (100, 3.2, 4.15)),
    ("dbc/orion/ksu_current_ks6e.o2bms", 72, 20.0, (500, 2.5, 4.2)),
    ("dbc/orion/ksu_9-18-2023.o2bms", 72, 20.0, (500, 2.5, 4.2)),
    ("dbc/orion/ksu_KS5e_BMS_profile_11-16-22.o2bms", 60, 20.0, (500, 2.5, 4.2))])
def test_profiles_of_cars_give_packs_that_drive(tmp_path, file, cells, capacity_ah, limits):
    pack_path = tmp_path / "pack.toml"
    assert orion("import", DATA / file, "--output", pack_path).returncode == 0
    pack = tomllib.loads(pack_path.read_text())
    assert pack["battery"]["cells_in_series"] == cells
    assert pack["battery"]["cells_in_parallel"] * pack["battery"]["capacity_ah"] == pytest.approx(capacity_ah, rel=1e-6)
    assert (pack["bms"]["discharge_current_max_a"], pack["bms"]["cell_voltage_min_v"],
            pack["bms"]["cell_voltage_max_v"]) == limits
    assert program("voltlap", "endurance", "--vehicle", pack_path, "--laps", 1).returncode == 0


@needs_data
def test_limits_stand_beside_those_of_the_cars_own_unit_on_its_log(tmp_path):
    """22 November: the log's own limits are 104 and 10 A nearly throughout; ours have the ceiling of the profile."""
    pack, out = tmp_path / "pack.toml", tmp_path / "replay.json"
    assert orion("import", CONVERSION / "UpdatedProfile.o2bms", "--output", pack).returncode == 0
    done = program("voltlap", "replay", CONVERSION / "candump-2025-11-22_161709.trc.gz", "--map",
                   "orion2_conversion_can", "--pack", pack, "--csv", tmp_path / "replay.csv", "--json", out)
    assert done.returncode == 0, done.stderr
    rows = [line.split(",") for line in (tmp_path / "replay.csv").read_text().splitlines()]
    settled = [dict(zip(rows[0], row, strict=True)) for row in rows[20:]]
    assert len(settled) > 250
    assert {float(row["discharge_limit_logged_a"]) for row in settled} == {104.0, 105.0}
    assert {float(row["charge_limit_logged_a"]) for row in settled} == {9.0, 10.0}
    assert {float(row["discharge_limit_a"]) for row in settled} == {100.0}
    assert all(11.0 < float(row["charge_limit_a"]) < 12.5 for row in settled)
    assert all(row["charge_reason"] == "CellVoltage" for row in settled)
