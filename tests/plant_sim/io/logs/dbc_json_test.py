# SPDX-License-Identifier: Apache-2.0
"""voltlap_logs.dbc_json: what is in a DBC file, what of it cannot be used, and what is no DBC file."""
import json
import os
import random
import subprocess
import sys
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[4]
sys.path.insert(0, str(ROOT / "plant_sim/python"))
from voltlap_logs.dbc_invalid_codes import says_no_value  # noqa: E402
from voltlap_logs.dbc_json import main  # noqa: E402

GOOD = 'BO_ 2 Good: 8 X\n SG_ T : 0|8@1+ (1,0) [0|0] "" X\n'


@pytest.fixture
def read(tmp_path, capsys):
    """The JSON of a file with this content, or the message of its refusal."""
    def run(content, name="a.dbc"):
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        code = main([str(path)])
        out, err = capsys.readouterr()
        assert code in (0, 2)
        return json.loads(out) if code == 0 else err
    return run


def signal(text, tail="", length=8):
    return f'BO_ 1 F: {length} X\n SG_ S : {text} X\n{tail}'


def invalid(read, text, tail):
    found = read(signal(text, tail))
    assert not found["refused"], found["refused"]
    return found["messages"][0]["signals"][0]["invalid"]


ORION_EXPORT = ('BU_: BMS Third_Party_Device\n\nBO_ 1713 MSGID_0X6B1: 8 BMS\n'
                ' SG_ Pack_DCL : 7|16@0+ (1.0,0) [0|0] "Amps" Third_Party_Device\n'
                ' SG_ Pack_Current : 23|16@0+ (0.1,0) [0|0] "Amps" Third_Party_Device\n'
                ' SG_ High_Temperature : 39|8@0+ (1.0,0) [0|0] "Celsius" Third_Party_Device\n'
                ' SG_ Low_Temperature : 47|8@0- (1.0,0) [0|0] "Celsius" Third_Party_Device\n'
                ' SG_ CRC_Checksum : 63|8@0+ (1.0,1721) [0|0] "" Third_Party_Device\n\n')


def test_known_faults_of_the_orion_exporter_are_mended_and_said(read):
    found = read(ORION_EXPORT)
    signs = {row["name"]: row["signed"] for row in found["messages"][0]["signals"]}
    assert signs == {"Pack_DCL": False, "Pack_Current": True, "High_Temperature": True, "Low_Temperature": True,
                     "CRC_Checksum": False}
    assert [note["line"] for note in found["notes"]] == [5, 6, 8]
    assert all("Orion's exporter" in note["text"] for note in found["notes"])
    for other in (ORION_EXPORT.replace("Third_Party_Device", "Gateway"), ORION_EXPORT.replace("MSGID_0X", "Msg")):
        found = read(other)
        assert not found["notes"] and not found["messages"][0]["signals"][2]["signed"]


def test_everything_of_a_signal(read):
    found = read('BO_ 2147483905 F: 16 ECU\n SG_ M M : 0|8@1+ (1,0) [0|0] "" X\n'
                 ' SG_ S m2 : 15|12@0- (0.5,-40) [-40|100] "degC" X\n'
                 'CM_ SG_ 2147483905 S "of the \\"hot\\" cell";\nVAL_ 2147483905 S 1 "one" 2 "two" ;\n'
                 'BA_DEF_ BO_ "GenMsgCycleTime" INT 0 65535;\nBA_DEF_DEF_ "GenMsgCycleTime" 0;\n'
                 'BA_ "GenMsgCycleTime" BO_ 2147483905 100;\nSG_MUL_VAL_ 2147483905 S M 2-4, 9-9;\n')
    message, = found["messages"]
    assert (message["id"], message["extended"], message["length"], message["line"]) == (257, True, 16, 1)
    assert (message["cycle_time_ms"], message["senders"]) == (100, ["ECU"])
    row = message["signals"][1]
    assert row == {"name": "S", "line": 3, "start": 15, "length": 12, "big_endian": True, "signed": True,
                   "float": False, "scale": 0.5, "offset": -40.0, "min": -40.0, "max": 100.0, "unit": "degC",
                   "comment": 'of the "hot" cell', "choices": [[1, "one"], [2, "two"]], "invalid": [],
                   "is_multiplexer": False, "multiplexer": "M", "cases": [[2, 4], [9, 9]]}


@pytest.mark.parametrize("encode", [lambda t: t.encode(), lambda t: t.encode("utf-8-sig"), lambda t: t.encode("cp1252"),
                                    lambda t: t.encode("utf-16"), lambda t: t.replace("\n", "\r\n").encode(),
                                    lambda t: t.replace("\n", "\r").encode(),
                                    lambda t: t.replace(" ", "\t").encode()])
def test_encodings_and_ends_of_line(read, encode):
    found = read(encode(GOOD.replace('""', '"°C"')))
    assert found["messages"][0]["signals"][0]["unit"] == "°C"
    assert found["messages"][0]["signals"][0]["line"] == 2


@pytest.mark.parametrize("bad, line, reason", [
    ('BO_ 1 F: 8 X\n SG_ S : 0|65@1+ (1,0) [0|0] "" X\n', None, ""),
    ('BO_ 1 F: 8 X\n SG_ S : 0|0@1+ (1,0) [0|0] "" X\n', 3, ""),
    ('BO_ 1 F: 2 X\n SG_ S : 8|16@1+ (1,0) [0|0] "" X\n', 4, "ends in byte 2"),
    ('BO_ 1 F: 8 X\n SG_ S : 0|24@1+ (1,0) [0|0] "" X\nSIG_VALTYPE_ 1 S : 1;\n', 4, "floating point with 24 bits"),
    ('BO_ 1 F: 8 X\n SG_ S : 0|8@1+ (1,0) [0|0] "" X\n SG_ S : 8|8@1+ (1,0) [0|0] "" X\n', 5, "second time"),
    ('BO_ 1 F: 8 X\nBO_ 1 F: 8 X\n', 4, "second time"),
    ('BO_ 1 F: 100 X\n SG_ S : 0|8@1+ (1,0) [0|0] "" X\n', 3, "100 bytes"),
    ('BO_ 1 F: 8 X\n SG_ S : zero|8@1+ (1,0) [0|0] "" X\n', 3, "cannot read"),
    ('BO_ 1 F: 8 X\n SG_ S m1 : 0|8@1+ (1,0) [0|0] "" X\n', 4, "several multiplexers"),
    ('BO_ 1 F: 8 X\n SG_ S : 0|8@1+ (1,0) [0|0] "" X\nSIG_VALTYPE_ 1 S : one;\n', 5, "cannot read"),
    ('BO_ 1 F: 8 X\n SG_ M M : 0|32@1+ (1,0) [0|0] "" X\n SG_ S m1 : 32|8@1+ (1,0) [0|0] "" X\n'
     'SG_MUL_VAL_ 1 S M 0-4000000000;\n', 6, "65536 values"),
    ('BO_ 4096 F: 8 X\n', 3, "more than 11 bits"),
])
def test_frame_that_cannot_be_used_is_refused_alone(read, bad, line, reason):
    found = read(GOOD + bad + 'CM_ "the rest";\n')
    assert [message["name"] for message in found["messages"]] == ["Good"]
    assert found["refused"]
    assert reason in found["refused"][0]["found"]
    assert line is None or found["refused"][0]["line"] == line


@pytest.mark.parametrize("noise", ["some words\n", 'CM_ SG_ 2 T "5" wide";\n', "}{\n", 'CM_ "never closed\n', "BA_ ;\n",
                                   'VAL_ 2 T one "two" ;\n', 'VAL_ 77 None 1 "one" ;\n', "SIG_VALTYPE_ 77 None : 1;\n",
                                   'BA_ "Unknown" 5;\n', "BO_ what\n", "\x01\x02\n"])
def test_noise_hides_no_frame(read, noise):
    found = read(GOOD + noise + GOOD.replace("BO_ 2 Good", "BO_ 3 Late"))
    assert {"Good", "Late"} <= {message["name"] for message in found["messages"]}


@pytest.mark.parametrize("seed", range(12))
def test_torn_file_gives_what_is_left_or_a_reason(read, seed):
    generator = random.Random(seed)
    text = (ROOT / "can_dbc/orion.dbc").read_text()
    for _ in range(generator.randrange(1, 4)):
        begin = generator.randrange(len(text))
        insert = "".join(generator.choice('";|:@\n SG_BO01') for _ in range(generator.randrange(4)))
        text = text[:begin] + insert + text[begin + generator.randrange(30):]
    found = read(text)
    assert isinstance(found, dict) or "expected a DBC file" in found, (seed, found)


def test_too_much_that_cannot_be_read_ends_in_time(read, monkeypatch):
    monkeypatch.setattr("voltlap_logs.dbc_statements.SECONDS", 0.2)
    begin = time.process_time()
    text = read("".join(f'BO_ {k} F: 8 X\n SG_ S : zero|8@1+ (1,0) [0|0] "" X\n' for k in range(3000)))
    assert "too much that cantools cannot read" in text
    assert time.process_time() - begin < 10


def test_what_is_no_dbc_is_told(read, tmp_path, capsys):
    assert "an empty file" in read(b" \n")
    assert "a binary file" in read(bytes(range(256)) * 10)
    assert "no frame (BO_)" in read("time,current\n0,1\n")
    assert "a KCD file" in read("<xml>", "a.kcd")
    assert main([str(tmp_path / "none.dbc")]) == 2
    assert "cannot be read" in capsys.readouterr().err
    large = tmp_path / "large.dbc"
    with open(large, "wb") as file:
        file.truncate(100_000_000)
    assert main([str(large)]) == 2
    assert "100 MB" in capsys.readouterr().err


def test_kcd_is_read_as_well(read):
    found = read('<NetworkDefinition xmlns="http://kayak.2codeornot2code.org/1.0"><Document/><Bus name="b">'
                 '<Message id="0x10" length="8" name="F"><Signal name="S" offset="8" length="16"><Value slope="0.5"/>'
                 '</Signal></Message></Bus></NetworkDefinition>', "a.kcd")
    assert found["messages"][0]["signals"][0]["scale"] == 0.5


@pytest.mark.parametrize("name, expected", [
    ("SNA", True), ("Not available", True), ("SignalNotAvailable", True), ("invalid", True), ("Sensor_Error", True),
    ("NaN", True), ("reserved", True), ("Init", True), ("unknown", True), ("Undefined", True), ("n/a", True),
    ("No value", True), ("NoError", False), ("no fault", False), ("Not_Invalid", False), ("valid", False),
    ("available", False), ("on", False), ("Initiator", False), ("Snare", False), ("100 %", False)])
def test_names_of_values_that_are_none(name, expected):
    assert says_no_value(name) is expected


@pytest.mark.parametrize("text, comment, codes", [
    ('0|16@1+ (0.1,0) [0|0] "V"', "0xFFFF = invalid", [65535]),
    ('0|16@1+ (0.1,0) [0|0] "V"', "65535: not available", [65535]),
    ('0|8@1+ (1,0) [0|0] "V"', "FF means error", [255]),
    ('0|8@1+ (1,0) [0|0] "V"', "254 is a sensor fault", [254]),
    ('0|16@1- (1,0) [0|0] "V"', "invalid: 0x8000", [0x8000]),
    ('0|16@1- (1,0) [0|0] "V"', "-32768 is invalid", [0x8000]),
    ('0|16@1+ (1,0) [0|0] "V"', "SNA (0xFFFE), error = 65535", [0xFFFE, 0xFFFF]),
    ('0|16@1+ (0.01,0) [0|0] "V"', "655.35 = not available", [65535]),
    ('0|8@1+ (1,0) [0|0] "V"', "7Fh: sensor not connected", [127]),
    ('0|8@1+ (1,0) [0|0] "V"', "255 = 100 %", []),
    ('0|8@1+ (1,0) [0|0] "V"', "counts errors, 0 = no error", []),
    ('0|8@1+ (1,0) [0|0] "V"', "Resolution 0.5 V, 0 to 100", []),
    ('0|8@1+ (1,0) [0|0] "V"', "valid from 10 to 200", [])])
def test_codes_in_comments(read, text, comment, codes):
    assert [first for first, _ in invalid(read, text, f'CM_ SG_ 1 S "{comment}";\n')] == codes


@pytest.mark.parametrize("text, names, codes", [
    ('0|8@1+ (1,0) [0|0] ""', '0 "Off" 1 "Ready" 2 "Fault" 3 "Init"', []),  # states: the fault is one of them
    ('0|8@1+ (1,0) [0|0] ""', '255 "SNA" 254 "Error"', [254, 255]),
    ('0|8@1+ (0.5,0) [0|0] "V"', '0 "Off" 1 "Low" 255 "Invalid"', [255])])
def test_names_of_states_are_values_and_names_of_codes_are_none(read, text, names, codes):
    assert [first for first, _ in invalid(read, text, f"VAL_ 1 S {names};\n")] == codes


def test_j1939_has_its_own_ranges_where_the_file_says_so(read):
    protocol = ('BA_DEF_ "ProtocolType" STRING ;\nBA_DEF_DEF_ "ProtocolType" "";\nBA_ "ProtocolType" "J1939";\n')

    def extended(text):
        found = read(f'BO_ 2566844926 F: 8 ECU\n SG_ S : {text} X\n{protocol}')
        return found["messages"][0]["signals"][0]["invalid"]

    assert extended('0|16@1+ (1,0) [0|0] ""') == [[0xFE00, 0xFFFF]]
    assert extended('0|16@1- (1,0) [0|0] ""') == []
    # Plain frames of 11 bits beside them have nothing of the protocol.
    assert invalid(read, '0|8@1+ (0.4,0) [0|0] "%"', protocol) == []
    assert invalid(read, '0|8@1+ (1,0) [0|0] ""', 'CM_ BO_ 1 "SPN 84 of J1939-71";\n') == [[0xFE, 0xFF]]
    assert invalid(read, '0|16@1+ (1,0) [0|0] ""', "") == []


def test_command_prints_json_and_says_what_is_wrong(tmp_path):
    path = tmp_path / "a.dbc"
    path.write_text(GOOD)
    command = [sys.executable, "-m", "voltlap_logs.dbc_json"]
    surroundings = os.environ | {"PYTHONPATH": str(ROOT / "plant_sim/python")}
    run = subprocess.run([*command, path], capture_output=True, text=True, env=surroundings)
    assert run.returncode == 0 and json.loads(run.stdout)["messages"][0]["name"] == "Good"
    assert subprocess.run(command, capture_output=True, env=surroundings).returncode == 2
