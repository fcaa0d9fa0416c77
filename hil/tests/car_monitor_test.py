# SPDX-License-Identifier: Apache-2.0
"""The monitor with a car's own DBC files."""
import gzip
import json
import random
import struct
import time

import can
import cantools
import pytest

from voltlap_hil.car_dbc import CarDbc
from voltlap_hil.errors import InputError
from voltlap_hil.monitor import main

DBC = """VERSION ""

BU_: Bms X

BO_ 256 Pack: 8 Bms
 SG_ Voltage : 0|16@1+ (0.1,0) [0|1000] "V" X
 SG_ Current : 23|16@0- (0.1,0) [-3000|3000] "A" X
 SG_ State : 32|8@1+ (1,0) [0|5] "" X

BO_ 2566844416 Temps: 3 Bms
 SG_ Group M : 0|8@1+ (1,0) [0|1] "" X
 SG_ Front m0 : 8|8@1+ (1,-40) [-40|200] "degC" X
 SG_ Rear m1 : 8|8@1+ (1,-40) [-40|200] "degC" X

BO_ 768 Silent: 1 X
 SG_ Never : 0|8@1+ (1,0) [0|0] "" X

VAL_ 256 State 0 "Off" 1 "Precharge" 2 "Drive" 255 "Not available" ;
"""
TEMPS = 2566844416 & 0x1FFFFFFF


def pack(volts, amperes=0.0, state=2):
    return struct.pack("<H", round(volts * 10)) + struct.pack(">h", round(amperes * 10)) + bytes((state, 0, 0, 0))


def line(time_s, can_id, data, bus="can0"):
    return f"({time_s:.6f}) {bus} {can_id:0{8 if can_id > 0x7FF else 3}X}#{data.hex().upper()}\n"


@pytest.fixture
def car(tmp_path):
    path = tmp_path / "car.dbc"
    path.write_text(DBC)
    return path


@pytest.fixture
def log(tmp_path):
    path = tmp_path / "drive.log"
    lines = [line(0.1 * k, 0x100, pack(400 - k, -k)) for k in range(50)]
    lines += [line(0.1 * k + 0.01, TEMPS, bytes((k % 2, 60 + k, 0))) for k in range(20)]
    lines += [line(0.1 * k + 0.02, 0x555, b"\1") for k in range(7)]
    path.write_text("".join(sorted(lines, key=lambda text: float(text[1:text.index(")")]))))
    return path


def snapshot(capsys, *arguments):
    assert main([*map(str, arguments), "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def message(shown, name, bus=None):
    return next(row for row in shown["messages"] if row["message"] == name and bus in (None, row["bus"]))


def test_values_ranges_units_and_names_of_states(log, car, capsys):
    signals = message(snapshot(capsys, "--log", log, "--dbc", car), "Pack")["signals"]
    assert signals["Voltage"] == {"value": 351.0, "unit": "V", "least": 351.0, "most": 400.0}
    assert signals["Current"] == {"value": -49.0, "unit": "A", "least": -49.0, "most": 0}
    assert signals["State"]["value"] == "Drive" and signals["State"]["seen"] == ["Drive"]


def test_states_are_told_in_the_order_in_which_they_came(tmp_path, car, capsys):
    path = tmp_path / "a.log"
    path.write_text("".join(line(0.1 * k, 0x100, pack(400, 0, state)) for k, state in enumerate((0, 1, 2, 2, 0, 7))))
    state = message(snapshot(capsys, "--log", path, "--dbc", car), "Pack")["signals"]["State"]
    assert state["value"] == 7 and state["seen"] == ["Off", "Precharge", "Drive", 7]
    assert main(["--log", str(path), "--dbc", str(car)]) == 0
    assert "Off, Precharge, Drive, 7" in capsys.readouterr().out


def test_multiplexed_signals_keep_their_own_last_value(log, car, capsys):
    row = message(snapshot(capsys, "--log", log, "--dbc", car), "Temps")
    assert row["id"] == f"0x{TEMPS:08X}"
    assert row["signals"]["Front"]["value"] == 38 and row["signals"]["Rear"]["value"] == 39
    assert (row["signals"]["Front"]["least"], row["signals"]["Front"]["most"]) == (20, 38)


def test_rates_load_freshness_and_what_is_unknown(log, car, capsys):
    shown = snapshot(capsys, "--log", log, "--dbc", car)
    assert shown["unknown"] == {"0x555": 7} and shown["never_heard"] == ["Silent"]
    assert message(shown, "Pack")["state"] == "fresh" and message(shown, "Pack")["per_s"] == pytest.approx(10.0)
    assert message(shown, "Temps")["state"] == "lost"  # silent for 3 s after a frame each 0.1 s
    slow = snapshot(capsys, "--log", log, "--dbc", car, "--bit-rate", "125")
    assert slow["buses"]["can0"]["load_pct"] == pytest.approx(4 * shown["buses"]["can0"]["load_pct"], rel=0.05)


def test_a_code_for_no_measurement_is_no_value_and_no_extreme(tmp_path, car, capsys):
    car.write_text(DBC + 'VAL_ 256 Voltage 65535 "SNA" ;\n')
    path = tmp_path / "a.log"
    path.write_text(line(0.0, 0x100, pack(400)) + line(0.1, 0x100, b"\xff\xff" + pack(0)[2:]))
    assert message(snapshot(capsys, "--log", path, "--dbc", car), "Pack")["signals"]["Voltage"] == {
        "value": None, "unit": "V", "least": 400.0, "most": 400.0}


def test_a_state_of_fault_is_told_by_its_name(tmp_path, car, capsys):
    car.write_text(DBC.replace('2 "Drive"', '2 "Drive" 3 "Fault"'))
    path = tmp_path / "a.log"
    path.write_text(line(0.0, 0x100, pack(400, 0, 2)) + line(0.1, 0x100, pack(400, 0, 3)))
    state = message(snapshot(capsys, "--log", path, "--dbc", car), "Pack")["signals"]["State"]
    assert state["value"] == "Fault" and state["seen"] == ["Drive", "Fault"]


def test_buses_are_told_apart(tmp_path, car, capsys):
    path = tmp_path / "a.log"
    path.write_text("".join(line(0.1 * k, 0x100, pack(300 + 100 * (k % 2)), f"can{k % 2}") for k in range(20)))
    shown = snapshot(capsys, "--log", path, "--dbc", car)
    assert {bus: row["frames"] for bus, row in shown["buses"].items()} == {"can0": 10, "can1": 10}
    assert message(shown, "Pack", "can0")["signals"]["Voltage"]["value"] == 300.0
    assert message(shown, "Pack", "can1")["signals"]["Voltage"]["value"] == 400.0
    assert main(["--log", str(path), "--dbc", str(car)]) == 0
    assert "can1:Pack.Voltage" in capsys.readouterr().out


def test_from_and_at_are_a_stretch_of_the_recording(log, car, capsys):
    signals = message(snapshot(capsys, "--log", log, "--dbc", car, "--from", "1", "--at", "2"), "Pack")["signals"]
    assert (signals["Voltage"]["least"], signals["Voltage"]["most"]) == (380.0, 390.0)


def test_speed_plays_the_recording_in_its_time_and_ends_as_at_its_end(log, car, capsys):
    begin = time.monotonic()
    shown = snapshot(capsys, "--log", log, "--dbc", car, "--speed", "10")
    assert time.monotonic() - begin >= 0.45
    assert shown == snapshot(capsys, "--log", log, "--dbc", car)


def test_text_has_values_ranges_rates_and_counts(log, car, capsys):
    assert main(["--log", str(log), "--dbc", str(car)]) == 0
    text = capsys.readouterr().out
    for words in ("Pack.Voltage", "351", "400", "Drive", "lost", "unknown to the DBC files: 0x555 (7)", "never heard"):
        assert words in text
    assert "\x1b" not in text


def test_only_chosen_signals_are_shown(log, car, capsys):
    shown = snapshot(capsys, "--log", log, "--dbc", car, "--signals", "*volt*,Temps.Rear")
    assert [list(row["signals"]) for row in shown["messages"]] == [["Voltage"], ["Rear"]]
    shown = snapshot(capsys, "--log", log, "--dbc", car, "--signals", "Rear")
    assert [row["message"] for row in shown["messages"]] == ["Temps"]
    assert shown["unknown"] == {"0x555": 7} and shown["buses"]["can0"]["frames"] == 77


def test_several_files_are_one(tmp_path, log, car, capsys):
    more = tmp_path / "more.dbc"
    more.write_text('VERSION ""\n\nBU_: X\n\nBO_ 1365 Extra: 1 X\n SG_ Five : 0|8@1+ (1,0) [0|0] "" X\n')
    shown = snapshot(capsys, "--log", log, "--dbc", car, "--dbc", more)
    assert message(shown, "Extra")["signals"]["Five"]["value"] == 1 and shown["unknown"] == {}
    more.write_text(more.read_text().replace("BO_ 1365", "BO_ 256"))
    assert main(["--log", str(log), "--dbc", str(car), "--dbc", str(more)]) == 2
    assert "0x100 (Extra)" in capsys.readouterr().err


def test_a_frame_that_its_file_describes_wrongly_is_named_and_the_others_go_on(log, car, capsys):
    car.write_text(DBC + 'BO_ 1365 Wrong: 1 X\n SG_ S : 0|32@1+ (1,0) [0|0] "" X\n')
    shown = snapshot(capsys, "--log", log, "--dbc", car)
    assert shown["refused"] == {"0x555 Wrong": 7} and shown["unknown"] == {}
    assert any("0x555 Wrong is left out" in note for note in shown["notes"])
    assert message(shown, "Pack")["signals"]["Voltage"]["value"] == 351.0


def test_a_short_frame_gives_the_signals_that_fit(tmp_path, car, capsys):
    path = tmp_path / "a.log"
    path.write_text(line(0.0, 0x100, pack(400)[:3]))
    row = message(snapshot(capsys, "--log", path, "--dbc", car), "Pack")
    assert list(row["signals"]) == ["Voltage"] and row["short"] == 1


def test_what_is_no_frame_is_said(log, car, capsys):
    log.write_text(log.read_text() + "rubbish\n")
    assert "left out: 1 line that is no frame" in snapshot(capsys, "--log", log, "--dbc", car)["notes"]


@pytest.mark.parametrize("name", ["drive.blf", "drive.asc", "drive.trc", "drive.log.gz"])
def test_other_formats_say_the_same(tmp_path, log, car, capsys, name):
    expected = message(snapshot(capsys, "--log", log, "--dbc", car), "Pack")["signals"]
    path = tmp_path / name
    if name.endswith(".gz"):
        path.write_bytes(gzip.compress(log.read_bytes()))
    else:
        with can.Logger(str(path)) as logger:
            for text in log.read_text().splitlines():
                stamp, _, frame = text.split()
                can_id, _, data = frame.partition("#")
                logger(can.Message(timestamp=1.7e9 + float(stamp[1:-1]), arbitration_id=int(can_id, 16), channel=0,
                                   is_extended_id=len(can_id) > 3, data=bytes.fromhex(data)))
    assert message(snapshot(capsys, "--log", path, "--dbc", car), "Pack")["signals"] == expected


@pytest.mark.parametrize("arguments, complaint", [
    (["--dbc", "nowhere.dbc"], "nowhere.dbc"), (["--signals", "Pack*"], "give --dbc FILE too"),
    (["--from", "3", "--at", "2"], "not after --from"), (["--from", "999"], "found no frame"),
    (["--dbc", "{log}"], "drive.log"), (["--dbc", "{car}", "--signals", "Pakc"], "'Pakc'")])
def test_what_cannot_be_done_ends_with_a_reason(log, car, arguments, complaint, capsys):
    given = [argument.format(log=log, car=car) for argument in arguments]
    assert main(["--log", str(log), *given]) == 2
    told = capsys.readouterr().err
    assert complaint in told and "Traceback" not in told


@pytest.mark.parametrize("flag", ["--speed", "--from"])
def test_flags_of_a_recording_want_one(flag, capsys):
    assert main(["--bus", "vcan0", flag, "1"]) == 2
    assert "give --log FILE too" in capsys.readouterr().err


def test_signals_are_decoded_as_cantools_decodes_them(tmp_path):
    seed = random.randrange(2**32)
    draw = random.Random(seed)
    rows = []
    for k in range(60):
        length = draw.randint(1, 64)
        big = draw.random() < 0.5
        first = draw.randint(0, 64 - length)
        start = 8 * (first // 8) + 7 - first % 8 if big else first
        scale, offset = draw.choice(((1, 0), (0.1, -40), (0.0078125, 3), (2, 1)))
        rows.append(f"BO_ {k + 1} F{k}: 8 X\n SG_ S : {start}|{length}@{0 if big else 1}{draw.choice('+-')} "
                    f'({scale},{offset}) [0|0] "" X\n')
    path = tmp_path / "a.dbc"
    path.write_text('VERSION ""\n\nBU_: X\n\n' + "\n".join(rows))
    ours, theirs = CarDbc([path]), cantools.database.load_file(path)
    for k in range(60):
        data = draw.randbytes(8)
        signal = ours.by_id[k + 1].signals[0]
        value = signal.scaled(signal.number(ours.by_id[k + 1].decode(data)[0]))
        expected = theirs.decode_message(k + 1, data)["S"]
        assert value == pytest.approx(expected, rel=1e-9, abs=1e-9), f"seed {seed}, {rows[k]}"


def test_any_damage_to_a_dbc_file_is_told(tmp_path, log, car, capsys):
    seed = random.randrange(2**32)
    draw, good = random.Random(seed), DBC.encode()
    for number in range(40):
        data = bytearray(good[:draw.randrange(len(good))] if draw.random() < 0.2 else good)
        for _ in range(draw.choice((1, 3, 10)) if data else 0):
            at = draw.randrange(len(data))
            data[at:at + 1] = draw.choice((b"", b"9" * 20, b"|", b"m0", b"\xff", b'"', b"\n", bytes([data[at] ^ 1])))
        car.write_bytes(data)
        try:
            assert main(["--log", str(log), "--dbc", str(car), "--json"]) in (0, 2)
        except Exception as error:
            raise AssertionError(f"seed {seed}, file {number}: {error!r}") from error
        capsys.readouterr()


def test_an_identifier_in_two_files_must_mean_the_same(tmp_path, car):
    assert len(CarDbc([car, car]).by_id) == 3
    other = tmp_path / "other.dbc"
    other.write_text(DBC.replace("(0.1,0) [0|1000]", "(0.2,0) [0|1000]"))
    with pytest.raises(InputError, match="with other signals"):
        CarDbc([car, other])
