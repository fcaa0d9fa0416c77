# SPDX-License-Identifier: Apache-2.0
"""The command line as its users meet it: results, files, messages, exit codes."""
import gzip
import hashlib
import json
import os
import pathlib
import re
import signal
import subprocess
import time

import pytest

BINARY = pathlib.Path(os.environ["VOLTLAP_BUILD_DIR"]) / "bin" / "voltlap"
DATA = pathlib.Path(__file__).resolve().parents[3] / "plant_sim" / "data"


def voltlap(*arguments, folder=None):
    return subprocess.run([BINARY, *map(str, arguments)], cwd=folder, capture_output=True, text=True, timeout=300)


def endurance(tmp_path, *arguments, code=0):
    """The JSON result of a run."""
    path = tmp_path / "result.json"
    run = voltlap("endurance", "--json", path, *arguments)
    assert run.returncode == code, run.stderr
    return json.loads(path.read_text())


def test_version_is_one_line():
    assert re.fullmatch(r"voltlap \d+\.\d+\.\d+\n", voltlap("--version").stdout)


@pytest.mark.parametrize("command", ["endurance", "lap", "list"])
def test_help_ends_well_and_names_the_flags(command):
    run = voltlap(command, "--help")
    assert run.returncode == 0
    assert "--vehicle" in run.stdout and "--set" in run.stdout


def test_lists_hold_what_the_project_ships():
    assert voltlap("list", "vehicles").stdout.split() == ["amk_4wd", "vtm16e", "vtm17e"]
    assert {"michigan_2014", "michigan_2015"} <= set(voltlap("list", "tracks").stdout.split())
    keys = voltlap("list", "keys").stdout
    assert re.search(r"^vehicle\.mass_kg +kg +20 \.\. 3000 +243 ", keys, re.MULTILINE)
    assert "battery.cells.<n>.capacity_scale" in keys


@pytest.mark.parametrize(("what", "numbers"), [("motors", 8), ("cells", 5)])
def test_parts_are_listed_by_name_and_then_by_number(what, numbers):
    title, *rows = voltlap("list", what).stdout.splitlines()
    shipped = sorted(path.stem for path in DATA.glob(f"{what}/*.toml"))
    assert [row.split()[0] for row in rows] == shipped
    assert all(len(row.split()) == len(title.split()) == 1 + numbers for row in rows)


def test_a_motor_and_a_cell_are_listed_with_what_their_files_say():
    def row(what, name):
        title, *rows = (line.split() for line in voltlap("list", what).stdout.splitlines())
        return dict(zip(title, next(values for values in rows if values[0] == name), strict=True))

    motor, cell = row("motors", "emrax_228_hv"), row("cells", "molicel_p42a")
    assert [motor[k] for k in ("torque_nm", "at_v", "nm_per_a", "max_v")] == ["230.0", "600", "1.1", "670"]
    assert 96 < float(motor["efficiency_%"]) < 98 and 95 < float(motor["power_kw"]) < 120
    assert [cell[k] for k in ("capacity_ah", "nominal_v", "mass_g")] == ["4.2", "3.69", "70"]
    assert float(cell["wh_per_kg"]) == pytest.approx(4.2 * 3.7 / 0.07, rel=0.03)


def test_lap_writes_time_speed_and_length(tmp_path):
    path = tmp_path / "lap.json"
    assert voltlap("lap", "--json", path).returncode == 0
    lap = json.loads(path.read_text())
    assert set(lap) == {"lap_time_s", "max_speed_mps", "length_m", "closing_gap_m"}
    assert lap["length_m"] == pytest.approx(814.1, abs=0.1)


def test_one_seed_gives_one_trace_and_noise_depends_on_the_seed(tmp_path):
    noisy = ("--laps", 1, "--set", "sensors.noise=true")
    first, again = endurance(tmp_path, *noisy), endurance(tmp_path, *noisy)
    other = endurance(tmp_path, *noisy, "--seed", 2)
    assert first["trace_hash"] == again["trace_hash"]
    assert first["trace_hash"] != other["trace_hash"]
    assert first["hash_plant"] != other["hash_plant"]


def test_weak_cell_shows_as_the_lowest(tmp_path):
    assert endurance(tmp_path, "--laps", 2, "--set", "battery.cells.7.capacity_scale=0.92")["min_cell"] == 7


def test_nominal_laps_are_those_of_the_reference_study(tmp_path):
    assert endurance(tmp_path, "--cells", "representative")["laps"] == 27
    assert endurance(tmp_path, "--cells", "representative", "--track", "michigan_2014")["laps"] == 29


def test_reference_row_stands_beside_the_run_it_belongs_to():
    nominal = voltlap("endurance", "--lap-start", "standing", "--cells", "representative")
    assert "row nominal_2015" in nominal.stdout and "28.0" in nominal.stdout
    assert "row nominal" not in voltlap("endurance", "--laps", 1, "--lap-start", "standing").stdout


def test_set_takes_several_values_at_once_or_one_by_one(tmp_path):
    wanted = {"vehicle.mass_kg": 230, "powertrain.final_drive": 2.75}
    words = [f"{key}={value}" for key, value in wanted.items()]
    together = endurance(tmp_path, "--set", *words, "--laps", 1)
    apart = endurance(tmp_path, "--set", words[0], "--laps", 1, "--set", words[1])
    assert {key: together["parameters"][key] for key in wanted} == wanted
    assert together["trace_hash"] == apart["trace_hash"]


def test_failed_run_is_written_with_time_and_cause(tmp_path):
    result = endurance(tmp_path, "--laps", 2, "--set", "assertions.battery_temperature_max_c=27.2", code=3)
    assert result["status"] == "failed"
    assert result["failure"]["time_s"] > 0
    assert "battery" in result["failure"]["cause"]


def frames_hash(lines):
    """The trace hash taken from a candump log alone, for the senders that the ids belong to."""
    digest = hashlib.sha256()
    master = {0x0A1, 0x0C2}
    bms = {0x0A0, 0x0C0, 0x0C1, 0x036, 0x6B0, 0x6B1}
    for line in lines:
        at, _, frame = line.split()
        tick = round(float(at.strip("()")) * 100)
        name, _, data = frame.partition("#")
        number, payload = int(name, 16), bytes.fromhex(data)
        sender = 2 if number in master else 1 if number in bms else 0
        head = tick.to_bytes(4, "little") + bytes([sender]) + number.to_bytes(4, "little") + bytes([len(payload)])
        digest.update(head + payload)
    return digest.hexdigest()


def test_candump_holds_every_frame_of_the_trace(tmp_path):
    log = tmp_path / "run.log"
    result = endurance(tmp_path, "--laps", 1, "--candump", log)
    lines = log.read_text().splitlines()
    assert len(lines) == result["frames"]
    assert frames_hash(lines) == result["trace_hash"]


def test_time_series_is_the_same_compressed_and_plain(tmp_path):
    for name in ("a.csv", "a.csv.gz"):
        assert voltlap("endurance", "--laps", 1, "--csv", tmp_path / name).returncode == 0
    plain = (tmp_path / "a.csv").read_text()
    assert gzip.open(tmp_path / "a.csv.gz", "rt").read() == plain
    rows = [line.split(",") for line in plain.splitlines() if not line.startswith("#")]
    assert rows[0][0] == "time_s" and "cell_24_voltage_v" in rows[0]
    assert len(rows) > 700 and len({len(row) for row in rows}) == 1


def test_recorded_drive_replaces_the_track(tmp_path):
    drive = tmp_path / "drive.csv"
    drive.write_text("time_s,speed_mps\n0,0\n5,5\n20,5\n25,1\n")
    result = endurance(tmp_path, "--drive", drive)
    assert result["status"] == "finished"
    assert result["total_time_s"] == pytest.approx(25.0, abs=0.1)
    assert result["distance_m"] == pytest.approx(102.5, abs=3.0)


def test_result_on_standard_output_leaves_the_summary_to_standard_error():
    lap = voltlap("lap", "--json", "-")
    assert json.loads(lap.stdout)["length_m"] > 800 and "lap time" in lap.stderr
    run = voltlap("endurance", "--laps", 1, "--json", "-")
    assert json.loads(run.stdout)["laps"] == 1 and "Finished" in run.stderr
    series = voltlap("endurance", "--laps", 1, "--csv", "-")
    assert series.stdout.startswith("# voltlap") and "Finished" not in series.stdout


@pytest.mark.parametrize("number, code", [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 129)])
def test_interrupted_run_says_so_and_leaves_the_files_as_they_were(tmp_path, number, code):
    (tmp_path / "a.json").write_text("earlier")
    arguments = [BINARY, "endurance", "--laps", "5000", "--json", "a.json", "--csv", "a.csv", "--candump", "a.log",
                 "--report", "a.html"]
    run = subprocess.Popen(arguments, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    while not any(part.stat().st_size for part in tmp_path.glob("a.log.part-*")):  # frames of the race
        assert run.poll() is None
        time.sleep(0.01)
    run.send_signal(number)
    shown, said = run.communicate(timeout=300)
    assert run.returncode == code
    assert re.search(r"Interrupted after [\d.]+ s of the race; no result file was written", said) and shown == ""
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {"a.json": "earlier"}
