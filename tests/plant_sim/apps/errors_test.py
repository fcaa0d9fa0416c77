# SPDX-License-Identifier: Apache-2.0
"""Every error that a person can make or meet: the message says where, what was found, what was expected and what to do;
the exit code is 2; the output folder is as it was."""
import dataclasses
import json
import os
import pathlib
import re
import resource
import shlex
import subprocess

import pytest

BINARY = pathlib.Path(os.environ["VOLTLAP_BUILD_DIR"]) / "bin" / "voltlap"
OUTPUTS = {"--json": "../out/run.json", "--csv": "../out/run.csv.gz", "--candump": "../out/run.log",
           "--report": "../out/run.html"}

CORNERS = "straight_m,corner_radius_m,corner_angle_rad\n"
SECTIONS = "type,section_length_m,corner_radius_m\n"
DRIVE = "time_s,speed_mps\n"
CAR = 'base = "vtm16e"\n'
TRACKS = "a track (michigan_2014, michigan_2015) or the path of a .csv file"
VEHICLES = "a vehicle (amk_4wd, vtm16e, vtm17e) or the path of a .toml file"
MASS = "a number in kg from 20 to 3000"
ROWS = "a header line with column names and at least one row below it"
TOML = "key = value under [section] headings, each key once"
WRITABLE = "a path in an existing folder that you may write to, on a disk with room"
MAKE_ROOM = "Choose another path or make room"
PATH = "Correct the name or the path."
NUMBER = "a finite number"


@dataclasses.dataclass
class Error:
    arguments: str
    where: str
    found: str
    expected: str
    remedy: str
    files: dict = dataclasses.field(default_factory=dict)
    command: str = "endurance"
    outputs: dict = dataclasses.field(default_factory=lambda: OUTPUTS)
    disk_bytes: int = 0  # a file may not grow beyond this; 0: as the machine has it


def track(text, *message, **more):
    return Error("--track t.csv", *message, files={"t.csv": text}, **more)


def drive(text, *message):
    return Error("--drive d.csv", *message, files={"d.csv": text})


def car(text, *message, **more):
    return Error("--vehicle v.toml", *message, files={"v.toml": text, **more})


ERRORS = {
    # names
    "unknown track": Error("--track michigan_2016", "--track", '"michigan_2016", neither', TRACKS,
        "Did you mean michigan_2014? " + PATH),
    "track that resembles nothing": Error("--track lincoln", "--track", '"lincoln", neither', TRACKS, PATH),
    "missing track file": Error("--track gone/t.csv", "--track", '"gone/t.csv", neither', TRACKS, PATH),
    "folder for a track": Error("--track .", "--track", '".", a folder', TRACKS, PATH),
    "folder for a drive": Error("--drive .", ".", "a folder", "a CSV file", "Check the path"),
    "missing drive": Error("--drive gone.csv", "gone.csv", "No such file or directory", "a CSV file", "Check the path"),
    "unknown vehicle": Error("--vehicle vtm16", "--vehicle", '"vtm16", neither', VEHICLES,
        "Did you mean vtm16e? " + PATH),
    "folder for a vehicle": Error("--vehicle ../out", "--vehicle", '"../out", a folder', VEHICLES, PATH),
    "unknown cell": Error("--set battery.cell=leaf", "--set battery.cell", '"leaf", neither', "a cell (aesc_e5_2p, ",
        PATH),
    "unknown motor": Error("--set motor.model=emrax_228", "--set motor.model", '"emrax_228", neither',
        "a motor (amk_dd5_14_10_pow, ", PATH),
    "unknown base": car('base = "vtm99"\n', "v.toml:1, base", '"vtm99", neither', VEHICLES, PATH),
    "bases in a circle": car('base = "w.toml"\n', "w.toml:2, base", "a circle: v.toml is built on this file",
        "ends in one without base", "Remove one of the base lines", **{"w.toml": '\nbase = "v.toml"\n'}),
    "base that is itself": car('base = "v.toml"\n', "v.toml:1, base", "a circle", "without base", "Remove one"),
    # track and drive files
    "row with a field missing": track(CORNERS + "10,5,1\n10,5\n", "t.csv:3", "2 fields",
        "3 (straight_m,corner_radius_m,", "Give the row a field for each column"),
    "row with a field too many": track(SECTIONS + "Left,5,5,5\n", "t.csv:2", "4 fields", "3 (type,", "Give the row"),
    "word for a number": track(CORNERS + "\n10,five,1\n", "t.csv:3, corner_radius_m", '"five"', NUMBER,
        "Correct the field"),
    "decimal comma": track(CORNERS + '"1,5",5,1\n', "t.csv:2", "4 fields", "3 (", "separated by commas"),
    "NaN in a file": track(CORNERS + "nan,5,1\n", "t.csv:2, straight_m", '"nan"', NUMBER, "Correct the field"),
    "infinity in a file": track(CORNERS + "10,5,-inf\n", "t.csv:2, corner_angle_rad", '"-inf"', NUMBER,
        "Correct the field"),
    "negative radius": track(CORNERS + "10,-5,1\n", "t.csv:2, corner_radius_m", "-5", "more than 0 metres",
        "the sign of the angle"),
    "negative radius of a section": track(SECTIONS + "Left,10,-5\n", "t.csv:2, corner_radius_m", "-5", "more than 0",
        "without sign"),
    "negative length": track(CORNERS + "-10,5,1\n", "t.csv:2, straight_m", "-10", "0 or more metres",
        "Correct the length"),
    "unknown section": track(SECTIONS + "Chicane,10,5\n", "t.csv:2, type", '"Chicane"', "Straight, Left or Right",
        "Choose"),
    "missing column": track("# a course\nstraight_m,radius\n10,5\n", "t.csv:2", "the columns straight_m,radius",
        "a column corner_radius_m", "correct its name in the header line"),
    "columns split by semicolons": track("straight_m;corner_radius_m\n1;2\n", "t.csv:1", "straight_m;corner_radius_m",
        "a column straight_m", "commas separate columns"),
    "empty file": track("", "t.csv", "an empty file", ROWS, "Fill the file in"),
    "file without rows": track(CORNERS + "# 1,2,3\n", "t.csv", "a header line and no row", ROWS, "Fill the file in"),
    "short track": track(CORNERS + "1,5,1\n", "t.csv", "a track of 6 m", "10 to 1000000 m", "Check the lengths"),
    "endless track": track(CORNERS + "1e12,5,1\n", "t.csv", "a track of 1e+12 m", "10 to 1000000 m",
        "Check the lengths"),
    "corner that the car cannot drive": track(CORNERS + "10,5,1\n10,0.5,1\n", "track t, t.csv:3",
        "a corner of 0.5 m radius, which the car cannot", "more than 0.595 m", "Widen the corner"),
    "car that cannot move off": Error("--set tyres.rolling_resistance=0.2 tyres.pacejka_d=0.1",
        "car vtm16e on track michigan_2015", "it does not move off", "exceeds the rolling resistance",
        "Check motor"),
    "pack that only feeds the low voltage": Error("--set bms.discharge_current_max_a=5",
        "car vtm16e on track michigan_2015", "it does not move off", "670 W of low_voltage.power_w",
        "bms.discharge_current_max_a"),
    "drive that runs back in time": drive(DRIVE + "0,0\n2,1\n1,1\n", "d.csv:4, time_s", "1 after 2", "increases",
        "Sort the rows"),
    "drive faster than sense": drive(DRIVE + "0,0\n2,300\n", "d.csv:3, speed_mps", "300", "0 to 150 m/s",
        "divided by 3.6"),
    "drive of one row": drive(DRIVE + "0,0\n", "d.csv", "one row", "two or more", "Add rows"),
    "pedal in percent": drive("time_s,speed_mps,accelerator,brake\n0,0,50,0\n1,1,1,0\n", "d.csv:2, accelerator", "50",
        "a pedal from 0 to 1", "divided by 100"),
    # vehicle and cell files
    "unknown key": Error("--set vehicle.mas_kg=1", "--set vehicle.mas_kg", 'the unknown key "vehicle.mas_kg"',
        "`voltlap list keys`", 'Did you mean "vehicle.mass_kg"?'),
    "unknown key in a file": car(CAR + "[vehicle]\nmas_kg = 3\n", "v.toml:3", '"vehicle.mas_kg"', "`voltlap list keys`",
        '"vehicle.mass_kg"?'),
    "value for a section": car("vehicle = 3\n" + CAR, "v.toml:1", '"vehicle"', "`voltlap list keys`",
        'Did you mean "vehicle.'),
    "wrong type": Error("--set vehicle.mass_kg=heavy", "--set vehicle.mass_kg", "'heavy'", MASS, "Correct the value"),
    "wrong type in a file": car(CAR + "[vehicle]\nmass_kg = true\n", "v.toml:3, vehicle.mass_kg", "true", MASS,
        "Correct the value"),
    "number for a name": car("base = 3\n", "v.toml:1, base", "3", "a word in quotes", "Put it in quotes"),
    "fraction for a count": Error("--set battery.cells_in_series=23.5", "battery.cells_in_series", "23.5",
        "a whole number", "Correct"),
    "value out of range": Error("--set vehicle.mass_kg=19.9", "--set vehicle.mass_kg", "19.9", MASS,
        "Correct the value"),
    "value out of range in a file": car(CAR + "[vehicle]\nmass_kg = -3\n", "v.toml:3, vehicle.mass_kg", "-3", MASS,
        "Correct"),
    "NaN in a vehicle": car(CAR + "[vehicle]\nmass_kg = nan\n", "v.toml:3, vehicle.mass_kg", "nan", MASS,
        "Correct the value"),
    "infinity in a vehicle": car(CAR + "[vehicle]\nmass_kg = inf\n", "v.toml:3, vehicle.mass_kg", "inf", MASS,
        "Correct the value"),
    "key given twice": car(CAR + "[vehicle]\nmass_kg = 240\nmass_kg = 250\n", "v.toml:4", "cannot redefine", TOML,
        "Correct this line"),
    "vehicle that is no TOML": car("mass 3\n", "v.toml:1", "no valid TOML", TOML, "Correct this line"),
    "missing key": car('[vehicle]\n[battery]\ncell = "aesc_e5_2p"\n', "v.toml", "no vehicle.driver_mass_kg",
                       "a number in kg from 0 to 200",
                       'base = "vtm16e"'),
    "two masses": car('base = "vtm16e"\n[vehicle]\nmass_kg = 240\nmass_without_pack_kg = 190\n',
                       "v.toml", "two masses", "either vehicle.mass_kg", "Keep one of the two"),
    "key of an earlier version": Error("--set tyres.friction=1.2", "--set tyres.friction", 'the key "tyres.friction"',
        "a key of today", "tyres.pacejka_d is its grip"),
    "setting without a value": Error("--set vehicle.mass_kg", "--set vehicle.mass_kg", "no key=value",
        "--set vehicle.mass_kg=219", "Write the key"),
    "cell beyond the pack": Error("--set battery.cells.25.capacity_scale=0.9", "battery.cells.25", "cell 25",
        "a cell from 1 to 24", "Name a cell"),
    "table not monotone": Error("--set motor.curve_speed_rpm=[0,100,50]", "--set motor.curve_speed_rpm", "50 after 100",
        "each value greater than the one before", "Put the points in order"),
    "table not monotone in a file": car(CAR + "[motor]\ncurve_speed_rpm = [0, 100, 50]\n",
        "v.toml:3, motor.curve_speed_rpm", "50 after 100", "greater than the one before", "Put the points in order"),
    "cell table too short": Error("--set cell.r0.value=[0.001,0.002]", "--set cell.r0.value", "2 values",
        "16, one for each point", "Give one value for every point"),
    "cell table with rows of two lengths": Error("--set cell.r0.table=[[0.1,0.1],[0.1]]", "cell.r0.table",
        "a list of 1 beside one of 2", "one length on each level", "Complete the table"),
    "cell table on its side"
        : Error(
        "--set cell.breakpoints.soc=[0,1] cell.breakpoints.temperature_c=[10,20,30] cell.breakpoints.current_a=[1] "
        "cell.r1.value=[1,1] cell.r2.value=[1,1] cell.tau1.value=[1,1] cell.tau2.value=[1,1] cell.r0.value=[] "
        "cell.r0.table=[[[1],[1]],[[1],[1]],[[1],[1]]]", "--set cell.r0.table", "a table of 3 x 2 x 1",
        "2 x 3 x 1, SOC points", "Arrange the values so"),
    "curve with inner brackets": Error("--set motor.curve_speed_rpm=[[0],[100]]", "motor.curve_speed_rpm",
        "a table of 2 x 1", "a list of numbers", "Remove the inner brackets"),
    "falling open-circuit voltage": Error("--set cell.ocv.polynomial_v=[4,-1]", "cell aesc_e5_2p, ocv.polynomial_v",
        "a voltage that falls", "does not fall", "Correct the curve"),
    "too few thermistors": Error("--set battery.cells_in_series=96", "--set battery.cells_in_series",
        "sensors.temperature_count = 6, which is not at least 20, a fifth of battery.cells_in_series = 96", "EV.7.5",
        "Change one of the two"),
    "limits out of order": Error("--set bms.temperature_derating_start_c=60", "--set bms.temperature_derating_start_c",
        "which is not below bms.temperature_max_c = 60 degC", "the BMS accepts", "Change one of the two"),
    "more power than the rules allow": Error("--set master.power_max_kw=81", "--set master.power_max_kw",
        "master.power_max_kw = 81 kW, which is not at most 80 kW", "EV.3.3", "Correct the value"),
    "inverter beyond the bus": Error("--set inverter.current_max_a=600", "--set inverter.current_max_a",
        "600 A (from inverter.current_max_a), which is not at most 550 A",
        "what the master controller can ask of all motors",
        "Correct the value"),
    "cells that differ, one simulated": Error("--cells representative --set battery.cells.1.capacity_scale=0.9",
        "--cells representative", "settings of single cells", "all equal", "Use --cells all"),
    # flags
    "no laps": Error("--laps 0", "--laps", "0", "a whole number from 1 to 10000",
        "Correct the number, or leave the flag out"),
    "laps that are no number": Error("--laps many", "--laps", "many", "a whole number", "Correct the number"),
    "half a lap": Error("--laps 1.5", "--laps", "1.5", "a whole number", "Correct the number"),
    "negative seed": Error("--seed -1", "--seed", "-1", "a whole number from 0", "Correct the number"),
    "unknown flag": Error("--lapps 3", "endurance", "the unknown flag --lapps", "`voltlap endurance --help`",
        "Did you mean --laps?"),
    "unknown flag with a value": Error("--lapps=3", "endurance", "the unknown flag --lapps",
        "`voltlap endurance --help`", "--laps?"),
    "stray word": Error("fast", "endurance", '"fast"', "flags and their values", "Leave it out"),
    "flag without its value": Error("--vehicle", "--vehicle", "no value", "one behind it", "Add it", outputs={}),
    "unknown choice": Error("--lap-start flyin", "--lap-start", '"flyin"', "flying, standing", "Did you mean flying?"),
    "unknown list": Error("tracs", "what", '"tracs"', "vehicles, tracks, cells, motors, bench, keys",
        "Did you mean tracks?", command="list", outputs={}),
    "no list named": Error("", "what", "no value", "one behind it", "Add it", command="list", outputs={}),
    "unknown command": Error("", "command line", '"endurence"', "endurance", "Did you mean endurance?",
        command="endurence", outputs={}),
    "no command": Error("", "command line", "no command", "endurance", "See `voltlap --help`", command="", outputs={}),
    "track and drive": Error("--track michigan_2014 --drive x.csv", "--track", "together with --drive",
        "one of the two", "Leave one out"),
    "rate without csv": Error("--rate 5", "--rate", "without --csv", "both", "Add --csv, or leave --rate out",
        outputs={}),
    "pace without a bus": Error("--pace 2", "--pace", "without --bus", "both", "Add --bus, or leave --pace out"),
    "real time without a bus": Error("--realtime", "--realtime", "without --bus", "both", "Add --bus"),
    "bus without a name": Error("--bus ''", "--bus", "an empty name", "the name of a CAN interface", "Give one"),
    "pace of nothing": Error("--bus vcan0 --pace 0", "--pace", "0", "a number from 0.01 to 1000", "Correct the number"),
    "unknown member": Error("--bus vcan0 --members bms,mastr", "--members", '"mastr"', "bms, master, logger, hil",
        "Did you mean master?", command="plant", outputs={}),
    "no interface named": Error("bms", "--bus", "no value", "one behind it", "Add it", command="ecu", outputs={}),
    "rate between samples": Error("--rate 3", "--rate", "3 Hz", "10 Hz or an even part", "Choose one of these"),
    "rate of nothing": Error("--rate 0", "--rate", "0", "a number above 0", "Correct the number"),
    # outputs
    "missing folder": Error("", "gone/x.json", "No such file or directory", WRITABLE, MAKE_ROOM, outputs={**OUTPUTS,
        "--json": "gone/x.json"}),
    "missing folder for the series": Error("", "gone/x.csv", "No such file or directory", WRITABLE, MAKE_ROOM,
        outputs={**OUTPUTS, "--csv": "gone/x.csv"}),
    "missing folder for the log": Error("", "gone/x.log", "No such file or directory", WRITABLE, MAKE_ROOM,
        outputs={**OUTPUTS, "--candump": "gone/x.log"}),
    "missing folder for the report": Error("", "gone/x.html", "No such file or directory", WRITABLE, MAKE_ROOM,
        outputs={**OUTPUTS, "--report": "gone/x.html"}),
    "folder for the report": Error("", "../out", "Is a directory", WRITABLE, MAKE_ROOM,
        outputs={**OUTPUTS, "--report": "../out"}),
    "missing folder for a lap": Error("", "gone/x.json", "No such file or directory", WRITABLE, MAKE_ROOM,
        command="lap", outputs={"--json": "gone/x.json"}),
    "file for a folder": Error("", "t.csv/x.json", "Not a directory", WRITABLE, MAKE_ROOM, files={"t.csv": ""},
        outputs={**OUTPUTS, "--json": "t.csv/x.json"}),
    "folder for a file": Error("", "../out", "Is a directory", WRITABLE, MAKE_ROOM, outputs={**OUTPUTS,
        "--json": "../out"}),
    "file without a name": Error("--json ''", "--json", "an empty name", "a path, or - for standard output",
        "Give one", outputs={}),
    "one file for two": Error("", "--json, --csv", "one file for two results", "a file for each",
        "Give different names", outputs={"--json": "x", "--csv": "x"}),
    "full device": Error("--laps 1", "/dev/full", "No space left on device", WRITABLE, MAKE_ROOM, outputs={**OUTPUTS,
        "--csv": "/dev/full"}),
    "full disk while the log is written": Error("--laps 1", "run.log", "File too large", WRITABLE, MAKE_ROOM,
        disk_bytes=100_000),
    "full disk while the series is written": Error("--laps 1", "run.csv.gz", "File too large", WRITABLE, MAKE_ROOM,
        disk_bytes=30_000, outputs={name: OUTPUTS[name] for name in ("--json", "--csv")}),
    "full disk for the report": Error("--laps 1", "run.html", "File too large", WRITABLE, MAKE_ROOM, disk_bytes=50_000,
        outputs={name: OUTPUTS[name] for name in ("--json", "--report")}),
    "full device for the report, written last": Error("--laps 1", "/dev/full", "No space left on device", WRITABLE,
        MAKE_ROOM, outputs={**OUTPUTS, "--report": "/dev/full"}),
    "full disk for the result": Error("--laps 1", "run.json", "File too large", WRITABLE, MAKE_ROOM, disk_bytes=1000,
        outputs={"--json": OUTPUTS["--json"]}),
    "full disk for a lap": Error("", "run.json", "File too large", WRITABLE, MAKE_ROOM, disk_bytes=10, command="lap",
        outputs={"--json": OUTPUTS["--json"]}),
}


@pytest.fixture
def folders(tmp_path):
    """An input folder to work in, and an output folder with the results of an earlier run."""
    (tmp_path / "in").mkdir()
    (tmp_path / "out").mkdir()
    for name in OUTPUTS.values():
        (tmp_path / "in" / name).write_text("earlier")
    return tmp_path / "in", tmp_path / "out"


def voltlap(folder, arguments, disk_bytes=0, **streams):
    def limit():
        resource.setrlimit(resource.RLIMIT_FSIZE, (disk_bytes, disk_bytes))
    return subprocess.run([BINARY, *arguments], cwd=folder, text=True, timeout=300,
                          preexec_fn=limit if disk_bytes else None, **(streams or {"capture_output": True}))


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.mark.parametrize("error", ERRORS.values(), ids=ERRORS.keys())
def test_message_says_where_what_and_how_to_mend_it(folders, error):
    inputs, outputs = folders
    for name, text in error.files.items():
        (inputs / name).write_text(text)
    before = contents(inputs), contents(outputs)
    flags = [word for pair in error.outputs.items() for word in pair]
    run = voltlap(inputs, [*error.command.split(), *flags, *shlex.split(error.arguments)], error.disk_bytes)
    assert run.returncode == 2, run.stderr
    assert run.stdout == ""
    message = re.fullmatch(r"voltlap: (.*?)(?:: found |, found )(.*?); expected (.*?)([.?] .*|\? ?)\n", run.stderr)
    assert message, run.stderr
    where, found, expected, remedy = message.groups()
    parts = (error.where, where), (error.found, found), (error.expected, expected + remedy), (error.remedy, remedy)
    assert [part for part, text in parts if part not in text] == [], run.stderr
    assert (contents(inputs), contents(outputs)) == before


def test_table_of_errors_has_a_limit_that_a_good_run_does_not_meet(folders):
    inputs, outputs = folders
    flags = [word for pair in OUTPUTS.items() for word in pair]
    assert voltlap(inputs, ["endurance", "--laps", "1", *flags], disk_bytes=10**9).returncode == 0
    written = contents(outputs)
    assert len(written) == len(OUTPUTS) and b"earlier" not in written.values()


@pytest.mark.parametrize("arguments", ["lap", "list keys", "endurance --laps 1 --csv -"])
def test_standard_output_that_is_full_is_an_error(folders, arguments):
    with open("/dev/full", "w") as full:
        run = voltlap(folders[0], arguments.split(), stdout=full, stderr=subprocess.PIPE)
    assert run.returncode == 2
    assert re.match(r"voltlap: standard output: .*found .*; expected .*\. .*room", run.stderr.splitlines()[-1])


def test_reader_that_went_away_is_an_error_and_leaves_no_file(folders):
    reader, writer = os.pipe()
    os.close(reader)
    arguments = ["endurance", "--laps", "1", "--csv", "-", "--candump", "frames.log"]
    run = voltlap(folders[0], arguments, stdout=writer, stderr=subprocess.PIPE)
    os.close(writer)
    assert run.returncode == 2 and "Broken pipe" in run.stderr
    assert contents(folders[0]) == {}


def test_memory_that_runs_out_is_told_apart(folders):
    inputs, _ = folders
    (inputs / "big.csv").write_text(CORNERS + "10,5,0.5\n" * 1_000_000)
    run = subprocess.run([BINARY, "lap", "--track", "big.csv"], cwd=inputs, capture_output=True, text=True, timeout=300,
                         preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (100_000_000, 100_000_000)))
    assert run.returncode == 70, run.stderr
    assert "the memory ran out" in run.stderr


@pytest.mark.parametrize("name, text", [
    ("t.csv", "\ufeff" + CORNERS + "10,5,1\n"),
    ("t.csv", (CORNERS + "10,5,1\n").replace("\n", "\r\n")),
    ("t.csv", ("\ufeff# a course\n\n" + CORNERS + " 10 , 5 ,1").replace("\n", "\r\n")),
], ids=["byte order mark", "Windows line ends", "both, comment, blanks, no last line end"])
def test_what_spreadsheets_write_is_read(folders, name, text):
    inputs, _ = folders
    (inputs / name).write_bytes(text.encode())
    run = voltlap(inputs, ["lap", "--track", name])
    assert run.returncode == 0, run.stderr
    assert "course: 15.0 m" in run.stdout


def test_file_name_that_is_no_text_still_gives_a_result(folders):
    inputs, _ = folders
    name = b"caf\xe9.toml"
    (inputs / os.fsdecode(name)).write_text(CAR)
    arguments = ["endurance", "--laps", "1", "--vehicle", name, "--json", "result"]
    run = voltlap(inputs, arguments, stdout=subprocess.DEVNULL)
    assert run.returncode == 0
    assert json.loads((inputs / "result").read_text(encoding="utf-8"))["vehicle"] == "caf\ufffd"
