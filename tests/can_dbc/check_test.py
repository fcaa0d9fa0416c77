# SPDX-License-Identifier: Apache-2.0
"""The check accepts the bus as it is, and every one of its findings is provoked once."""
import subprocess
import sys

import pytest
from conftest import CAN_DBC

import check
import model

UNSEALED = 'BA_ "VL_Unsealed" BO_ 2566869221 1;'
CONTROLS = {
    "id of the other file": ("orion.dbc", "BO_ 54 CellBroadcast", "BO_ 176 CellBroadcast", "is used by"),
    "signals overlap": ("car.dbc", "SG_ PackVoltage : 24|16", "SG_ PackVoltage : 23|16", "overlaps PackCurrent"),
    "signals overlap, big-endian": ("orion.dbc", "SG_ CellResistance : 30|15", "SG_ CellResistance : 31|15",
                                    "overlaps"),
    "signal into the counter": ("car.dbc", "SG_ Cell2 : 32|16", "SG_ Cell2 : 33|16", "overlaps"),
    "missing unit": ("car.dbc", '[-1000|1000] "A" BMS', '[-1000|1000] "" BMS', "PackCurrent has no unit"),
    "missing range": ("car.dbc", "(0.001,0) [-1000|1000]", "(0.001,0) [0|0]", "has no range"),
    "range beyond the bits": ("car.dbc", "(0.01,0) [0|650]", "(0.01,0) [0|660]", "does not fit"),
    "invalid code in range": ("car.dbc", 'VAL_ 176 PackVoltage 65535 "invalid"', 'VAL_ 176 PackVoltage 65000 "invalid"',
                              "inside the range"),
    "no code 0": ("car.dbc", 'VAL_ 193 State 0 "Invalid"', 'VAL_ 193 State 9 "Invalid"', "code 0"),
    "no CRC": ("car.dbc", 'BA_ "VL_Role" SG_ 176 Crc "crc";', "", "neither counter and CRC"),
    "no CRC, and not VL_Unsealed": ("charger.dbc", UNSEALED, "", "neither counter and CRC"),
    "VL_Unsealed, with a CRC": ("charger.dbc", UNSEALED,
                                UNSEALED + '\nBA_ "VL_Role" SG_ 2566869221 OutputCurrent "crc";',
                                "is VL_Unsealed and has a crc"),
    "CRC elsewhere": ("car.dbc", "SG_ Crc : 56|8@1+", "SG_ Crc : 40|8@1+", "not the last byte"),
    "short counter": ("car.dbc", "SG_ Counter : 48|8@1+", "SG_ Counter : 48|7@1+", "has 8 bits"),
    "counter across two bytes": ("car.dbc", "SG_ Counter : 48|8@1+", "SG_ Counter : 47|8@1+", "those of one byte"),
    "no sender": ("car.dbc", "BO_ 176 PackSensor: 8 PLANT", "BO_ 176 PackSensor: 8 Vector__XXX", "no sender"),
    "no cycle": ("car.dbc", 'BA_ "GenMsgCycleTime" BO_ 176 10;', "", "whole ticks"),
    "cycle between ticks": ("car.dbc", 'BA_ "GenMsgCycleTime" BO_ 176 10;', 'BA_ "GenMsgCycleTime" BO_ 176 15;',
                            "whole ticks"),
    "timeout of one cycle": ("car.dbc", 'BA_ "VL_TimeoutMs" BO_ 176 50;', 'BA_ "VL_TimeoutMs" BO_ 176 10;',
                             "does not survive"),
    "lockstep message of 4 bytes": ("lockstep.dbc", "BO_ 2033 StopRequest: 8", "BO_ 2033 StopRequest: 4", "8 bytes"),
    "lockstep message without a sender": ("lockstep.dbc", "StopRequest: 8 HIL", "StopRequest: 8 Vector__XXX",
                                          "a sender"),
    "lockstep message with a name of the car": ("lockstep.dbc", "BO_ 2033 StopRequest", "BO_ 2033 Pedals",
                                                "used twice"),
    "lockstep signals overlap": ("lockstep.dbc", "SG_ Brake : 40|8", "SG_ Brake : 39|8", "overlaps"),
    "lockstep message with a CRC": ("lockstep.dbc", 'BA_ "VL_Role" SG_ 2016 FramesSent "index"',
                                    'BA_ "VL_Role" SG_ 2016 FramesSent "checksum"', "neither counter nor CRC"),
}


def test_bus_is_accepted(bench):
    assert bench.findings() == []


@pytest.mark.parametrize("control", CONTROLS)
def test_broken_bus_is_refused(bench, control):
    name, old, new, expected = CONTROLS[control]
    bench.replace(name, old, new)
    findings = bench.findings()
    assert any(expected in finding for finding in findings), findings


def test_identifier_used_twice_is_refused(bench):
    bench.replace_all("car.dbc", " 176 ", " 177 ")
    assert any("id 0x0B1 is used by" in f for f in bench.findings())


@pytest.mark.parametrize("name, old, new, expected", [
    ("lockstep.dbc", " 2033 ", " 1999 ", "StopRequest: the identifier 0x7CF is not a lockstep one"),
    ("lockstep.dbc", " 2027 ", " 2026 ", "id 0x7EA is used by"),
    ("car.dbc", " 208 ", " 2047 ", "MotorTemperatures: the identifier 0x7FF is a lockstep one"),
])
def test_lockstep_and_car_keep_to_their_own_identifiers(bench, name, old, new, expected):
    bench.replace_all(name, old, new)
    assert any(expected in finding for finding in bench.findings())


def test_extended_identifier_is_refused(bench):
    bench.replace_all("car.dbc", " 176 ", f" {0x80000000 + 176} ")
    assert any("needs more than 11 bits" in f for f in bench.findings())


def test_load_above_60_percent_is_refused(bench):
    bench.replace("car.dbc", 'BA_ "VL_BitRate" 500000;', 'BA_ "VL_BitRate" 420000;')
    assert any("bus load" in f for f in bench.findings())


def test_load_just_below_60_percent_is_accepted(bench):
    bench.replace("car.dbc", 'BA_ "VL_BitRate" 500000;', 'BA_ "VL_BitRate" 433000;')
    found = bench.findings()
    assert [f for f in found if "pm100" not in f and "amk" not in f] == []
    assert any("bus load of 70.1 % with 48 cells and pm100.dbc, at most 61 %" in f for f in found), found
    assert any("bus load of 82.5 % with 48 cells and amk.dbc, at most 72 %" in f for f in found), found


def test_too_many_frames_in_one_tick_are_refused(bench):
    for group in range(1, 12):  # all temperatures in the first tick
        text = bench.files["car.dbc"].read_text()
        lines = [line for line in text.splitlines() if not line.startswith(
            f'BA_ "GenMsgStartDelayTime" BO_ {0x240 + group} ')]
        bench.files["car.dbc"].write_text("\n".join(lines) + "\n")
    findings = bench.findings()
    assert any("frames in one tick with 48 cells" in f for f in findings), findings
    assert any("frames in one tick with 144 cells" in f for f in findings), findings


def test_worst_case_length_of_a_frame():
    assert model.worst_case_bits(8) == 135  # Davis et al. 2007: 8 bytes, 11-bit identifier
    assert model.worst_case_bits(0) == 55
    assert model.worst_case_bits(8, extended=True) == 160


@pytest.mark.parametrize("cells", (1, 24, 48, 49, 96, 144))
def test_load_and_frames_hold_for_every_size_of_pack(bench, cells):
    usual, with_pm100, with_amk = model.load(bench.car_files).variants()
    assert check.load_pct(usual, cells) < 60 and check.load_pct(with_pm100, cells) < 61
    assert check.frames_per_tick(usual, cells) <= 22 and check.frames_per_tick(with_pm100, cells) <= 24
    assert check.load_pct(with_amk, cells) < 72 and check.frames_per_tick(with_amk, cells) <= 28
    assert 28 * model.worst_case_bits(8) < 0.8 * 5_000  # of a tick at 500 kbit/s


def test_command_reports_and_fails(bench):
    command = [sys.executable, str(CAN_DBC / "check.py")]
    good = subprocess.run([*command, "--cells", "48,144", *bench.arguments], capture_output=True, text=True)
    assert good.returncode == 0 and "bus load" in good.stdout
    bench.replace_all("car.dbc", " 176 ", " 177 ")
    bad = subprocess.run([*command, *bench.arguments], capture_output=True, text=True)
    assert bad.returncode == 1 and "0x0B1" in bad.stderr


def test_file_that_is_no_dbc_is_refused_with_its_name(tmp_path):
    (tmp_path / "broken.dbc").write_text("BO_ nonsense")
    result = subprocess.run([sys.executable, str(CAN_DBC / "check.py"), str(tmp_path / "broken.dbc")],
                            capture_output=True, text=True)
    assert result.returncode == 1 and "broken.dbc" in result.stderr and "Traceback" not in result.stderr
