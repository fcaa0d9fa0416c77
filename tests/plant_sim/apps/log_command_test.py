# SPDX-License-Identifier: Apache-2.0
"""voltlap log: what it says of a recording, what it decodes and what it converts, read back by other means."""
import gzip
import json
import os
import random
import subprocess
from pathlib import Path

import cantools
import pytest

ROOT = Path(__file__).resolve().parents[3]
VOLTLAP = Path(os.environ["VOLTLAP_BUILD_DIR"]) / "bin/voltlap"
DATA = os.environ.get("VOLTLAP_DATA")
CAR, ORION = ROOT / "can_dbc/car.dbc", ROOT / "can_dbc/orion.dbc"
DBC = ["--dbc", CAR, "--dbc", ORION]


def voltlap(*arguments):
    return subprocess.run([VOLTLAP, *map(str, arguments)], capture_output=True, text=True)


def done(*arguments):
    result = voltlap(*arguments)
    assert result.returncode == 0, result.stderr + result.stdout
    return result.stdout


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Twenty seconds of our own simulator."""
    folder = tmp_path_factory.mktemp("run")
    done("endurance", "--laps", 1, "--candump", folder / "whole.log")
    lines = (folder / "whole.log").read_text().splitlines(keepends=True)
    log = folder / "run.log"
    log.write_text("".join(line for line in lines if float(line[1:line.index(")")]) < 20.0))
    return log


def frames(log):
    """(time, id, data) of a candump file, the bus left out."""
    out = []
    for line in log.read_text().splitlines():
        time, _, frame = line.split(" ")
        out.append((float(time[1:-1]), frame))
    return out


def test_info_says_what_is_in_it(run, tmp_path):
    text = done("log", "info", run, *DBC, "--json", tmp_path / "info.json")
    found = json.loads((tmp_path / "info.json").read_text())
    recorded = frames(run)
    assert found["frames_in_file"] == found["frames_used"] == len(recorded) == sum(f["count"] for f in found["frames"])
    assert found["findings"] == [] and found["format"] == "candump"
    pack = next(frame for frame in found["frames"] if frame["name"] == "PackSensor")
    assert pack["interval_s"] == pytest.approx(0.01, rel=1e-6)
    message = cantools.database.load_file(CAR).get_message_by_name("PackSensor")
    values = [message.decode(bytes.fromhex(frame.split("#")[1]))["PackVoltage"] for _, frame in recorded
              if frame.startswith(f"{message.frame_id:03X}#")]
    signal = next(signal for signal in pack["signals"] if signal["name"] == "PackVoltage")
    assert [signal["min"], signal["max"], signal["values"]] == pytest.approx([min(values), max(values), len(values)])
    assert signal["mean"] == pytest.approx(sum(values) / len(values))
    assert "PackSensor.PackVoltage" in text and "% of 500 kbit/s" in text


def test_check_finds_what_was_broken_and_the_frames_add_up(run, tmp_path):
    generator = random.Random(5)
    lines = run.read_text().splitlines()
    broken = {"line that is no frame": 0, "error frame": 0, "remote frame, without data": 0, "stamp that is no time": 0}
    for k in generator.sample(range(100, len(lines) - 100), 40):
        kind = generator.choice(sorted(broken))
        broken[kind] += 1
        time, bus, _ = lines[k].split(" ")
        lines[k] = {"line that is no frame": "rubbish", "error frame": f"{time} {bus} 20000004#0000000000000000",
                    "remote frame, without data": f"{time} {bus} 123#R",
                    "stamp that is no time": lines[k].replace(time, "(1e300)")}[kind]
    (tmp_path / "bad.log").write_text("\n".join(lines) + "\n")
    result = voltlap("log", "check", tmp_path / "bad.log", *DBC, "--json", tmp_path / "check.json")
    assert result.returncode == 1
    found = json.loads((tmp_path / "check.json").read_text())
    assert found["frames_left_out"] == {kind: count for kind, count in broken.items() if count}
    assert found["frames_in_file"] == len(lines) == found["frames_used"] + 40
    for kind, count in broken.items():
        assert not count or f"{count} x {kind}" in result.stdout


def test_check_finds_the_checksum_of_each_frame_and_what_breaks_it(run, tmp_path):
    lines = run.read_text().splitlines()
    sensors = [k for k, line in enumerate(lines) if " 0B0#" in line]
    for k in sensors[50:1500:50]:
        lines[k] = lines[k][:-1] + ("0" if lines[k][-1] != "0" else "1")
    (tmp_path / "bad.log").write_text("\n".join(lines) + "\n")
    result = voltlap("log", "check", tmp_path / "bad.log", "--json", tmp_path / "check.json")
    assert result.returncode == 1, result.stdout
    found = json.loads((tmp_path / "check.json").read_text())
    rules = {frame["id"]: frame["checksum"] for frame in found["frames"] if "checksum" in frame}
    assert "Orion" in rules[0x036]["rule"] and "J1850" in rules[0x200]["rule"]
    assert all(rule["breaks"] == 0 for identifier, rule in rules.items() if identifier != 0x0B0)
    assert rules[0x0B0] | {"rule": ""} == {"rule": "", "holds": len(sensors) - 29, "breaks": 29}
    assert [finding["kind"] for finding in found["findings"]] == ["checksum does not hold"]
    assert f"29 of {len(sensors)} frames break" in result.stdout and f"in line {sensors[50] + 1}" in result.stdout


def test_check_tells_gaps_and_values_out_of_range(run, tmp_path):
    lines = [line for line in run.read_text().splitlines() if not 5.0 < float(line[1:line.index(")")]) < 9.0]
    (tmp_path / "gap.log").write_text("\n".join(lines) + "\n")
    dbc = CAR.read_text().replace("[-32768", "[-1")
    result = voltlap("log", "check", tmp_path / "gap.log", *DBC)
    assert result.returncode == 1 and "silent for 4.0" in result.stdout, result.stdout
    assert dbc


def test_decoded_csv_is_what_cantools_decodes(run, tmp_path):
    done("log", "decode", run, *DBC, "--signals", "PackSensor.*", "--out", tmp_path / "pack.csv")
    header, *rows = (tmp_path / "pack.csv").read_text().splitlines()
    names = [name.split(" [")[0] for name in header.split(",")]
    assert "PackVoltage [V]" in header and names[0] == "time_s"
    message = cantools.database.load_file(CAR).get_message_by_name("PackSensor")
    recorded = [frame for frame in frames(run) if frame[1].startswith(f"{message.frame_id:03X}#")]
    assert len(rows) == len(recorded)
    for row, (time, frame) in zip(rows, recorded):
        values = dict(zip(names, map(float, row.split(","))))
        assert values.pop("time_s") == time
        expected = message.decode(bytes.fromhex(frame.split("#")[1]), decode_choices=False)
        assert values == pytest.approx({name: expected[name] for name in values}, abs=1e-9)


def test_rows_at_equal_times_hold_the_latest_value(run, tmp_path):
    done("log", "decode", run, *DBC, "--every", "0.5", "--signals", "PackSensor.PackVoltage",
         "--out", tmp_path / "grid.csv")
    done("log", "decode", run, *DBC, "--signals", "PackSensor.PackVoltage", "--out", tmp_path / "all.csv")
    every = [tuple(map(float, row.split(","))) for row in (tmp_path / "all.csv").read_text().splitlines()[1:]]
    for row in (tmp_path / "grid.csv").read_text().splitlines()[1:]:
        time, value = map(float, row.split(","))
        assert value == [v for t, v in every if t <= time + 1e-9][-1]


def test_mf4_mcap_and_parquet_have_the_same_values(run, tmp_path):
    asammdf, reader = pytest.importorskip("asammdf"), pytest.importorskip("mcap.reader")
    parquet = pytest.importorskip("pyarrow.parquet")
    done("log", "decode", run, *DBC, "--signals", "PackSensor.*,WheelSpeeds.FrontLeft", "--out", tmp_path / "a.csv")
    rows = [row.split(",") for row in (tmp_path / "a.csv").read_text().splitlines()]
    column = next(k for k, name in enumerate(rows[0]) if name.startswith("PackVoltage"))
    expected = [float(row[column]) for row in rows[1:] if row[column]]
    for suffix in ("mf4", "mcap", "parquet"):
        done("log", "decode", run, *DBC, "--signals", "PackSensor.*,WheelSpeeds.FrontLeft",
             "--out", tmp_path / f"a.{suffix}")
    with asammdf.MDF(tmp_path / "a.mf4") as mdf:
        signal = mdf.get("PackVoltage")
        assert signal.samples.tolist() == pytest.approx(expected, rel=1e-12) and signal.unit == "V"
    with open(tmp_path / "a.mcap", "rb") as file:
        summary = reader.make_reader(file).get_summary()
        assert summary.statistics.message_count == len(rows) - 1
    table = parquet.read_table(tmp_path / "a.parquet").to_pydict()
    name = next(name for name in table if name.endswith("PackVoltage"))
    assert [value for value in table[name] if value is not None] == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("suffix", ["log", "log.gz", "asc", "slcan", "blf", "trc", "mf4", "csv", "db"])
def test_frames_survive_every_format_and_back(run, tmp_path, suffix):
    there, back = tmp_path / f"there.{suffix}", tmp_path / "back.log"
    done("log", "convert", run, "--out", there)
    done("log", "convert", there, "--out", back)
    assert frames(back) == frames(run)


def test_buses_that_change_their_number_are_named_and_flags_of_fd_stay(run, tmp_path):
    log = tmp_path / "two.log"
    log.write_text("".join(f"({k / 10:.6f}) can{k % 2} 123##{k % 4}{k % 256:02X}\n" for k in range(40)))
    said = done("log", "convert", log, "--out", tmp_path / "two.blf")
    assert "can0 is channel 1" in said and "can1 is channel 2" in said
    done("log", "convert", tmp_path / "two.blf", "--out", tmp_path / "back.log")
    done("log", "convert", log, "--out", tmp_path / "same.log")
    assert (tmp_path / "same.log").read_text() == log.read_text()
    only = voltlap("log", "convert", log, "--bus", "can9", "--out", tmp_path / "none.log")
    assert only.returncode == 2 and "can0, can1" in only.stderr and not (tmp_path / "none.log").exists()


def test_faults_of_an_orion_export_are_named_and_its_cold_is_below_zero(tmp_path):
    """The names that stand twice, the frame that stands twice, and what is unsigned."""
    (tmp_path / "orion.dbc").write_text(
        "BU_: BMS Third_Party_Device\n\nBO_ 1713 MSGID_0X6B1: 2 BMS\n"
        ' SG_ Pack_Current : 7|8@0+ (0.1,0) [0|0] "Amps" Third_Party_Device\n'
        ' SG_ Low_Temperature : 15|8@0+ (1.0,0) [0|0] "Celsius" Third_Party_Device\n\n'
        "BO_ 1715 MSGID_0X6B3: 2 BMS\n"
        ' SG_ Blank : 7|8@0+ (1.0,0) [0|0] "" Third_Party_Device\n'
        ' SG_ Blank : 15|8@0+ (1.0,0) [0|0] "" Third_Party_Device\n\n'
        "BO_ 2550589172 MSGID_0X1806E6F4: 8 BMS\n\nBO_ 2550589172 MSGID_0X1806E6F4: 8 BMS\n")
    log = tmp_path / "cold.log"
    log.write_text("".join(f"({k / 10:.6f}) can0 6B1#{k - 20 & 255:02X}{k - 15 & 255:02X}\n" for k in range(30)))
    checked = voltlap("log", "check", log, "--dbc", tmp_path / "orion.dbc")
    words = ("0x6B3 MSGID_0X6B3 is not decoded: signal Blank for the second time", "0x1806E6F4 for the second time",
             "orion.dbc:4: MSGID_0X6B1.Pack_Current unsigned", "orion.dbc:5: MSGID_0X6B1.Low_Temperature unsigned")
    assert checked.returncode == 0 and all(word in checked.stdout for word in words), checked.stdout + checked.stderr
    done("log", "decode", log, "--dbc", tmp_path / "orion.dbc", "--out", tmp_path / "cold.csv")
    rows = [line.split(",") for line in (tmp_path / "cold.csv").read_text().splitlines()[1:]]
    assert [[float(value) for value in row[-2:]] for row in rows] == [
        [pytest.approx((k - 20) / 10), k - 15] for k in range(30)]


def test_frames_that_a_dbc_has_twice_are_not_called_unknown(run, tmp_path):
    text = CAR.read_text()
    first = text.index("BO_ ", text.index("PackSensor") - 20)
    end = text.index("\n\n", first)
    (tmp_path / "twice.dbc").write_text(text[:end] + "\n\n" + text[first:end] + text[end:])
    said = done("log", "decode", run, "--dbc", tmp_path / "twice.dbc", "--out", tmp_path / "a.csv")
    assert "that a DBC file has and that cannot be used" in said
    assert "0xB0 for the second time" in voltlap("log", "check", run, "--dbc", tmp_path / "twice.dbc").stdout


def test_what_breaks_off_is_kept_up_to_there_and_said(run, tmp_path):
    packed = gzip.compress(run.read_bytes())
    (tmp_path / "cut.log.gz").write_bytes(packed[:len(packed) // 2])
    result = voltlap("log", "convert", tmp_path / "cut.log.gz", "--out", tmp_path / "kept.log")
    assert result.returncode == 1 and "breaks off" in result.stdout
    kept = frames(tmp_path / "kept.log")
    assert kept == frames(run)[:len(kept)] and len(kept) > 100
    assert voltlap("log", "info", tmp_path / "cut.log.gz").returncode == 1


def test_one_frame_with_other_signals_in_two_dbc_files_is_refused(run, tmp_path):
    (tmp_path / "same.dbc").write_bytes(CAR.read_bytes())
    done("log", "info", run, *DBC, "--dbc", tmp_path / "same.dbc")
    (tmp_path / "other.dbc").write_text(CAR.read_text().replace(" PackVoltage :", " SomethingElse :", 1))
    refused = voltlap("log", "info", run, *DBC, "--dbc", tmp_path / "other.dbc")
    assert refused.returncode == 2 and "other.dbc" in refused.stderr and "with other signals" in refused.stderr


def test_what_a_format_cannot_hold_is_said(tmp_path):
    log, back = tmp_path / "fd.log", tmp_path / "back.log"
    log.write_text("".join(f"({k / 10:.6f}) can1 123##{k % 2}{k:02X}\n" for k in range(20)))
    assert "cannot hold" in done("log", "convert", log, "--out", tmp_path / "fd.csv")
    done("log", "convert", log, "--out", tmp_path / "fd.slcan")
    done("log", "convert", tmp_path / "fd.slcan", "--out", back)
    assert [frame for _, frame in frames(back)] == [frame for _, frame in frames(log)]


@pytest.mark.parametrize("arguments, words", [
    (["info", "absent.log"], ["absent.log", "no file"]),
    (["info", "table.csv"], ["table.csv", "no frame"]),
    (["decode", "run.log", "--out", "a.csv"], ["--dbc"]),
    (["decode", "run.log", "--dbc", str(CAR), "--out", "a.xlsx"], [".parquet"]),
    (["decode", "run.log", "--dbc", str(CAR), "--out", "run.log.csv", "--signals", "Nothing*"], ["Nothing*"]),
    (["decode", "run.log", "--dbc", "run.log", "--out", "a.csv"], ["run.log"]),
    (["decode", "run.log", "--dbc", str(CAR), "--every", "1", "--out", "a.mf4"], ["--every"]),
    (["convert", "run.log", "--out", "run.log"], ["run.log", "read"]),
    (["convert", "run.log", "--out", "./../here/run.log"], ["read"]),
    (["convert", "run.log", "--out", "a.xyz"], [".blf"]),
    (["convert", "bin.mat", "--out", "a.log"], ["MATLAB"]),
    (["record", "--candump", "a.log"], ["--bus"]),
    ([], ["record"]),
])
def test_what_cannot_be_done_is_said(run, tmp_path, arguments, words):
    here = tmp_path / "here"
    here.mkdir()
    (here / "run.log").write_bytes(run.read_bytes())
    (here / "table.csv").write_text("a,b\n1,2\n")
    (here / "bin.mat").write_bytes(b"MATLAB 5.0 MAT-file" + bytes(200))
    before = {file.name: file.read_bytes() for file in here.iterdir()}
    result = subprocess.run([VOLTLAP, "log", *arguments], capture_output=True, text=True, cwd=here)
    assert result.returncode == 2, result.stdout + result.stderr
    for word in words:
        assert word in result.stderr, result.stderr
    assert {file.name: file.read_bytes() for file in here.iterdir()} == before


@pytest.mark.skipif(not DATA, reason="VOLTLAP_DATA is not set")
def test_every_recording_of_real_buses_is_checked_and_its_frames_add_up(tmp_path):
    recordings = [path for pattern in ("**/*.log.gz", "**/*.asc.gz", "**/*.TXT.gz", "**/*.slcan.txt.gz", "**/*.trc.gz")
                  for path in sorted(Path(DATA).glob(pattern))]
    assert len(recordings) >= 15
    for path in recordings:
        result = voltlap("log", "check", path, "--json", tmp_path / "check.json")
        assert result.returncode in (0, 1), result.stderr
        found = json.loads((tmp_path / "check.json").read_text())
        assert found["frames_in_file"] == found["frames_used"] + sum(found["frames_left_out"].values()), path.name
        assert (result.returncode == 1) == bool(found["findings"]), path.name
        assert found["frames_used"] > 0.9 * found["frames_in_file"], path.name
