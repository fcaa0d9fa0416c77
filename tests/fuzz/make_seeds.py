#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes small valid files of every kind that the project reads, one folder for each target of target.cpp.

    make_seeds.py FOLDER

NAME.dict beside the folders has the words of the seeds and the keywords that no seed has, for libFuzzer.
"""
import contextlib
import gzip
import io
import json
import math
import pathlib
import re
import shutil
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
DATA = ROOT / "plant_sim/data"

# zstd frame of "a,b\n1,2\n3,4\n", as its one raw block: no package is needed to make it.
TABLE = b"a,b\n1,2\n3,4\n"
ZSTD_TABLE = b"\x28\xb5\x2f\xfd\x20" + bytes([len(TABLE)]) + (len(TABLE) << 3 | 1).to_bytes(3, "little") + TABLE

PACK_DBC = """\
BO_ 256 Pack: 8 X
 SG_ I : 7|16@0- (0.1,0) [0|0] "A" X
 SG_ U : 23|16@0+ (0.1,0) [0|0] "V" X
 SG_ Count : 35|4@0+ (1,0) [0|0] "" X
 SG_ Sum : 63|8@0+ (1,0) [0|0] "" X
BO_ 257 Cell: 8 X
 SG_ Id : 7|8@0+ (1,0) [0|0] "" X
 SG_ V : 15|16@0+ (0.0001,0) [0|0] "V" X
BO_ 258 Many: 8 X
 SG_ Mux M : 7|8@0+ (1,0) [0|0] "" X
 SG_ Cell01 m0 : 15|16@0+ (0.0001,0) [0|0] "V" X
 SG_ Cell02 m1 : 15|16@0+ (0.0001,0) [0|0] "V" X
BO_ 2566844672 Long: 64 X
 SG_ F : 0|32@1- (1,0) [0|0] "" X
 SG_ D : 64|64@1- (1,0) [0|0] "" X
 SG_ W : 130|64@1+ (0.5,-3) [0|100] "A" X
SIG_VALTYPE_ 2566844672 F : 1;
SIG_VALTYPE_ 2566844672 D : 2;
VAL_ 256 U 65535 "Invalid" ;
"""
PACK_MAP = """\
[roles]
current = {frame = 0x100, signal = "I", dbc = "pack.dbc", counter = "Count", checksum = "orion", unit = "A"}
pack_voltage = {frame = 0x100, signal = "U", dbc = "pack.dbc", min = 10, max = 900, invalid = [6553.5]}
"cell_voltage_<n>" = {frame = 0x101, signal = "V", index = "Id", first = 0, dbc = "pack.dbc", unit = "V"}
"""
TABLE_MAP = """\
match = ["t,I,U,T"]
[roles]
time = {column = "t", unit = "s"}
current = {column = "I", unit = "mA", discharge = "auto", scale = 2, offset = 0.5}
voltage = {column = "U", unit = "V", invalid = [0, 65535]}
temperature = {column = "T", unit = "degF", shift_s = 1.5, min = -40, max = 300}
"""
CAN = {
    "candump": "(1436509052.249713) vcan0 044#2A36\n(1436509052.349713) vcan0 18FF50E5##12A36 T\n"
               "(1436509053.0) can1 123#R4\n(1436509054.0) can1 20000080#0000000000000000\n",
    "screen": "(0.000) vcan0  044   [2]  2A 36\n(0.100)  vcan0  18FF50E5   [8]  01 02 03 04 05 06 07 08   '........'\n"
              "(0.300)  vcan0  123   [4]  remote request\n",
    "bare_screen": "vcan0  100   [2]  2A 36\nvcan0  101   [1]  01\n" * 4,
    "asc": "date Mon Jun 1 10:00:00.000 2020\nbase hex  timestamps absolute\ninternal events logged\n"
           "   0.002014 1  1FFFFFF0x       Rx   d 8 01 00 00 05 0C 00 00 63\n"
           "   0.003 2  123             Tx   d 2 0A 0B\n   0.004 CANFD   1 Rx 300 name 1 0 d 12 12 "
           "00 01 02 03 04 05 06 07 08 09 0A 0B 0 0 0\n   0.005 1  ErrorFrame\n",
    "asc_decimal": "base dec  timestamps relative\n   0.5 1  100             Rx   d 3 1 20 255\n"
                   "   0.5 1  4096x           Rx   r\n",
    "raw_hex": "0000026Bx000005220108160000000000\n0000026Cx000005230108160000000001\n",
    "analyser": "Analyser, exported\nFlags\tCh\tT/R\tTime\tCAN ID\tLen\tData\tParser\n"
                "1\t0\tRX\t12.5\t0x000001db\t4\t0xee c0 c3 0a \tdefault\n",
    "savvycan": "Time Stamp,ID,Extended,Dir,Bus,LEN,D1,D2,D3,D4,D5,D6,D7,D8\n"
                "2500000,00000123,true,Rx,1,2,0A,FF,,,,,,\n2600000,00000124,false,Rx,0,1,0A,,,,,,,\n",
    "slcan": "t6B380050000551178EE0071F\nT18FF50E5401020304EA60\nr1230\nt10021122\n",
}


def drive_frames():
    lines = []
    for k in range(120):
        on = k // 20 % 2
        data = bytes([0, 200 * on, 3, 0xE8 - 20 * on, (k % 16) << 4 >> 0 & 0xFF, 0, 0])
        lines.append(f"({1000 + 0.01 * k:.3f}) can0 100#{data.hex().upper()}{(0x108 + sum(data)) & 0xFF:02X}")
        lines.append(f"({1000.004 + 0.01 * k:.3f}) can0 101#{k % 8:02X}{36000 + k:04X}0000000000")
    return "\n".join(lines) + "\n"


def cell_rows():
    rows = ["t,I,U,T"]
    for k in range(80):
        current = 20000 if k // 10 % 2 else 0
        rows.append(f"{k},{current},{3.9 - 1e-6 * current - 0.001 * k:.4f},{80 + 0.01 * k:.2f}")
    return "\n".join(rows) + "\n"


def plain_log():
    rows = ["time_s,current_a,voltage_v,temperature_c"]
    rows += [f"{0.5 * k:g},{10 * (k // 8 % 2)},{3.8 - 0.02 * (k // 8 % 2):.3f},25" for k in range(60)]
    return "\n".join(rows) + "\n"


def circle(points=40, radius=20.0):
    return [(radius * math.cos(math.tau * k / points), radius * math.sin(math.tau * k / points)) for k in range(points)]


def gpx(element):
    places = "\n".join(f'<{element} lat="{48 + 1e-5 * y:.7f}" lon="{11 + 1.4e-5 * x:.7f}"><ele>400</ele></{element}>'
                       for x, y in circle())
    return f'<?xml version="1.0"?>\n<gpx version="1.1">\n<trk><trkseg>\n{places}\n</trkseg></trk>\n</gpx>\n'


def run_json(**changes):
    channels = ["distance_m", "time_s", "speed_mps", "power_kw", "power_mean_500ms_kw", "soc_pct",
                "cell_voltage_min_v", "battery_temperature_c", "motor_temperature_c", "longitudinal_mps2",
                "lateral_mps2"]
    results = ["total_time_s", "distance_m", "end_soc_pct", "energy_out_kwh", "max_power_kw",
               "max_power_mean_500ms_kw", "max_battery_current_a", "min_pack_voltage_v", "min_cell_voltage_v",
               "max_battery_temp_c", "max_motor_temp_c", "max_speed_mps"]
    run = {"status": "finished", "version": "0.1.0", "vehicle": "vtm16e", "course": "a course", "course_length_m": 10.0,
           "lap_start": "flying", "cells": "all", "seed": 7, "settings": ["vehicle.mass_kg=200"], "laps_asked": 2,
           "laps": 2, "parameters": {"vehicle.mass_kg": "200", "tyres.radius_m": 0.2}, "limit_active_s": {"power": 1.5},
           "lap_rows": [{"lap": k, "time_s": 5.0, "energy_kwh": 0.1, "end_soc_pct": 90} for k in (1, 2)],
           "trace": {name: [0.5 * k for k in range(6)] for name in channels}, **{name: 1.5 for name in results},
           **changes}
    run["trace"]["lateral_mps2"] = [None] * 6
    return json.dumps(run, indent=1)


def dbc_json(path):
    from voltlap_logs import dbc_json as module
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        assert module.main([str(path)]) == 0, path
    return out.getvalue()


def texts_of(pattern):
    return {path.name: path.read_text() for path in sorted(ROOT.glob(pattern))}


def settings_of(vehicle):
    section, out = "", []
    for line in vehicle.splitlines():
        if match := re.match(r"\[([\w.]+)\]", line):
            section = match[1] + "."
        elif match := re.match(r"(\w+) *= *([^#]*)", line):
            out.append(f"{section}{match[1]}={match[2].strip()}")
    return "\n".join(out) + "\n"


def packed(seeds):
    """The first of the seeds gzipped as well, whole and cut short."""
    data = next(iter(seeds.values())).encode()
    whole = gzip.compress(data, mtime=0)
    return {**seeds, "packed.gz": whole, "broken.gz": whole[:-9]}


def tables():
    return {"plain": "a,b\n1,2\n3,4\n", "crlf": "a,b\r\n1,2\r\n3,4\r\n", "cr": "a,b\r1,2\r3,4\r",
            "quoted": '\ufeff# a comment\n"a" , b\n"1", 2\n\n3,\n4,word\n5', "zstd": ZSTD_TABLE,
            "numbers": "a,b\n-1e300,nan\n0x10,inf\n+.5,1_0\n"}


def dialects():
    stamps = "".join(f"2024-03-0{1 + k // 9} 23:59:5{k % 10}.{k % 7},{k % 5},{3.7 - 0.01 * k:.3f}\n" for k in range(12))
    return {"german": "Zeit;Strom;Spannung\ns;A;V\n0,5;1,25;3,701\n1,0;-1,25;3,699\n1,5;1.250,5;#DIV/0!\n",
            "preamble": "Maker of testers\nSerial,17\n\nStep,Time(h:m:s.ms),Current(A),Voltage(V)\n"
                        "1,0:00:01.000,1.5,3.7\n1,0:00:02.000,1.5,3.69\n2,1:00:02.500,-1.5,3.71\n",
            "stamps": "Date Time,Current/A,Ecell/V\n" + stamps,
            "american": 'Time,I (mA),U\n01/31/2024 11:59:59 PM,"1,250.5",3.7\n02/01/2024 12:00:00 AM,"1,251",3.6\n',
            "nested": "Cycle,Mode,,\n,Step,Time,Voltage\n1,CC,,\n,1,0.5,3.7\n,2,1.0,3.6\n,3,1.5,3.5\n",
            "tabs": "time/s\tI/mA\tEwe/V\n1.000E+000\t2.5E+001\t3.7E+000\n2.000E+000\t2.5E+001\t3.6E+000\n",
            "blanks": "t  I   U\n0  1.5 3.7\n1  1.5 3.6\n2  1.4 3.5\n"}


def courses():
    points = [f"{x:.3f},{y:.3f}" for x, y in circle()]
    return {**texts_of("docs/tracks/paddock.csv"), **texts_of("docs/tracks/paddock_gates_ft.csv"),
            "circle": "x_m,y_m\n" + "\n".join(points) + "\n", "headless": "\n".join(points).replace(",", " ") + "\n",
            "decimal_comma": "x [m];y [m]\n" + "\n".join(p.replace(",", ";").replace(".", ",") for p in points) + "\n",
            "gps": "time_s,latitude,longitude\n" + "\n".join(
                f"{k},{48 + 1e-5 * y:.7f},{11 + 1e-5 * x:.7f}" for k, (x, y) in enumerate(circle() * 2)) + "\n",
            "curvature": "s_m,curvature_1pm\n0,0\n10,0.1\n20,0.1\n30,0\n40,-0.05\n",
            "segments": "type,section_length_m,corner_radius_m\nStraight,20,0\nLeft,10,5\nRight,3,7\n",
            "units": "x,y\nft,ft\n1,2\n3,5\n8,13\n4,4\n"}


def all_seeds(scratch):
    (scratch / "pack.dbc").write_text(PACK_DBC)
    dbc = {"pack.json": dbc_json(scratch / "pack.dbc")}
    dbc.update((path.stem, dbc_json(path)) for path in sorted((ROOT / "can_dbc").glob("*.dbc")))
    segments = {"angle": "straight_m,corner_radius_m,corner_angle_deg,grade_pct\n10,5,90,1\n0,7,-45,-2.5\n",
                "types": courses()["segments"]}
    vehicles = texts_of("plant_sim/data/vehicles/*.toml")
    maps = {**texts_of("plant_sim/data/maps/*.toml"), "frames": PACK_MAP, "columns": TABLE_MAP}
    cell_logs = {"mapped": f"{TABLE_MAP}\n%%\n{cell_rows()}", "plain": plain_log(),
                 "frames": f"{PACK_MAP}\n%%\n{drive_frames()}", **dialects()}
    return {
        "lines": packed({"lf": "a\nb\n\nc", "crlf": "a\r\nb\r\n", "cr": "a\rb\r", "zstd": ZSTD_TABLE}),
        "measured_table": packed({**tables(), **dialects()}), "input_table": packed(tables()),
        "can": packed(CAN), "dbc": dbc, "role_map": maps, "drive_log": cell_logs, "cell_log": cell_logs,
        "track": {**texts_of("plant_sim/data/tracks/*.csv"), **segments}, "course": courses(),
        "gpx": {element: gpx(element) for element in ("trkpt", "rtept", "wpt")},
        "course_import": {name: text[:1900].rsplit("\n", 1)[0] + "\n" for name, text in courses().items()},
        "drive": {"speed": "time_s,speed_mps\n0,0\n1,5\n2.5,8\n", "pedals":
                  "time_s,speed_mps,accelerator,brake\n0,0,1,0\n1,5,0.5,0\n2,4,0,0.25\n"},
        "run": {"finished": run_json(), "drive": run_json(lap_start="drive", course_length_m=None),
                "failed": run_json(status="failed", failure={"time_s": 3.5, "cause": "cell 7 is empty"})},
        "vehicle": vehicles, "cell": texts_of("plant_sim/data/cells/*.toml"),
        "settings": {"vtm17e": settings_of(vehicles["vtm17e.toml"]), "cells":
                     "battery.cells.3.capacity_ah=9\nmotor.model=emrax_208_mv\nbattery.cell=sony_vtc6\n"},
        "plan": texts_of("plant_sim/data/bench/*.toml"),
    }


# What the readers know and no seed has.
KEYWORDS = {
    "can": ["timestamps relative", "timestamps absolute", "base dec", "base hex", "ErrorFrame", "CANFD", "Rx", "Tx",
            "remote request", "ERRORFRAME", "[64]", "##F", "(", "x", "Begin TriggerBlock", "1e308", "FFFFFFFF"],
    "role_map": ["bus", "counter", "period_s", "extended", "match_frames", "0x1FFFFFFF", "auto", "<n>",
                 "\\x0a[roles]\\x0a"],
    "vehicle": ["base", "inf", "nan", "1e400", "-0.0", "[[", "]]", "battery.cells", "[", "{"],
    "gpx": ["rtept", "wpt", "lat=", "lon=", "/>", "<!--", "-->", "&quot;", "'", "-180", "90"],
    "lines": ["\\x1f\\x8b\\x08", "\\x28\\xb5\\x2f\\xfd", "\\x0d\\x0a", "\\x0d"],
}
KEYWORDS["drive_log"] = KEYWORDS["cell_log"] = KEYWORDS["role_map"] + KEYWORDS["can"] + ["\\x0a%%\\x0a", "1970-01-01"]
KEYWORDS["cell"] = KEYWORDS["plan"] = KEYWORDS["vehicle"]


def dictionary(target, seeds):
    words = {}
    for text in seeds:
        if not isinstance(text, str):
            continue  # packed
        for word in re.findall(r"[A-Za-z_][\w.]{2,30}|-?\d[\d.eE+-]{2,12}", re.sub(r"#.*", "", text), re.ASCII):
            words[word] = words.get(word, 0) + 1
    common = sorted(words, key=lambda word: (-words[word], word))[:400]
    return "".join(f'"{word}"\n' for word in [*KEYWORDS.get(target, []), *common])


def main(folder):
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    sys.path.insert(0, str(ROOT / "plant_sim/python"))
    for target, seeds in all_seeds(folder).items():
        (folder / target).mkdir()
        for name, seed in seeds.items():
            data = seed if isinstance(seed, bytes) else seed.encode()
            (folder / target / name).write_bytes(data)
        (folder / f"{target}.dict").write_text(dictionary(target, seeds.values()))
    (folder / "made").touch()


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]))
