# SPDX-License-Identifier: Apache-2.0
import random

import cantools
import pytest

from voltlap_hil.dbc import FILES, Dbc, can_dbc_folder, crc8_j1850
from voltlap_hil.errors import InputError


def test_every_signal_reads_as_cantools_reads_it(dbc):
    rng = random.Random(7)
    for file in FILES:
        for message in cantools.database.load_file(can_dbc_folder() / file).messages:
            for _ in range(30):
                data = rng.randbytes(8)
                expected = message.decode(data, decode_choices=False, scaling=False)
                signals = dbc.message(message.name).signals
                assert {name: s.raw(data) for name, s in signals.items()} == expected


def test_values_carry_scale_state_and_no_measurement(dbc):
    data = dbc.message("PackSensor").encode({"PackCurrent": -12.345, "PackVoltage": None})
    assert dbc.message("PackSensor").read(data) == {"PackCurrent": -12.345, "PackVoltage": None, "Counter": 0, "Crc": 0}
    assert dbc.signal("BmsStatus.State").read(dbc.message("BmsStatus").encode({"State": "Fault"})) == "Fault"


def test_encoding_over_a_payload_changes_only_what_is_named(dbc):
    pedals = dbc.message("Pedals")
    base = pedals.encode({"Apps1": 1.0, "BrakeFront": 20.0})
    read = pedals.read(pedals.encode({"Apps2": 0.5}, base))
    assert (read["Apps1"], read["Apps2"], read["BrakeFront"]) == (1.0, 0.5, 20.0)


def test_the_crc_is_that_of_sae_j1850():
    assert crc8_j1850(b"123456789") == 0x4B


@pytest.mark.parametrize("name", ["Pedals", "BmsStatus", "CellBroadcast", "LimitBroadcast"])
def test_a_sealed_frame_is_believed_and_one_flipped_bit_is_not(dbc, name):
    message = dbc.message(name)
    data = message.seal(bytes(range(8)), counter=11)
    assert message.sealed_ok(data)
    assert message.counter is None or message.counter_of(data) == 11
    for bit in range(64):
        flipped = bytearray(data)
        flipped[bit // 8] ^= 1 << bit % 8
        assert not message.sealed_ok(bytes(flipped))


def test_the_orion_checksum_counts_identifier_length_and_bytes(dbc):
    assert dbc.message("CellBroadcast").seal(bytes([1, 2, 3, 4, 5, 6, 7, 0]))[7] == (0x36 + 8 + 28) & 0xFF


def test_all_zero_data_is_not_believed(dbc):
    assert not dbc.message("BmsLimits").sealed_ok(bytes(8))


@pytest.mark.parametrize("name, complaint", [
    ("BmsLimit.DischargeLimit", "no message 'BmsLimit' in the DBC files. Did you mean BmsLimits"),
    ("BmsLimits.DischargeLimits", "BmsLimits has no signal 'DischargeLimits'. Did you mean DischargeLimit"),
    ("BmsLimits", "expected Message.Signal")])
def test_a_wrong_name_is_told_with_the_nearest_right_one(dbc, name, complaint):
    with pytest.raises(InputError, match=complaint):
        dbc.signal(name)


@pytest.mark.parametrize("message, values, complaint", [
    ("Pedals", {"Apps3": 1.0}, "Pedals has no signal 'Apps3'"),
    ("Pedals", {"Apps1": 9.0}, "cannot carry 9 V: it has 12 bits"),
    ("Pedals", {"Apps1": -0.1}, "cannot carry -0.1 V"),
    ("BmsStatus", {"State": "Faulty"}, "cannot be 'Faulty'. Did you mean Fault"),
    ("VehicleIo", {"AirPlusAux": None}, "no code for 'no measurement'")])
def test_what_a_signal_cannot_carry_is_refused(dbc, message, values, complaint):
    with pytest.raises(InputError, match=complaint):
        dbc.message(message).encode(values)


def test_messages_are_selected_by_name_group_and_node(dbc):
    assert [m.name for m in dbc.select(["Pedals"])] == ["Pedals"]
    assert len(dbc.select(["CellVoltages"])) == 48
    assert {"BmsStatus", "BmsLimits", "ContactorCommand"} <= {m.name for m in dbc.select(["BMS"])}
    assert not any(m.name.startswith("Done") for m in dbc.select(["BMS"]))
    with pytest.raises(InputError, match="no message, group of messages or node"):
        dbc.select(["Bms"])


def test_a_message_that_is_there_twice_is_refused():
    with pytest.raises(InputError, match="is there twice"):
        Dbc([can_dbc_folder() / "car.dbc", can_dbc_folder() / "car.dbc"])


def test_a_file_that_is_no_dbc_is_refused(tmp_path):
    (tmp_path / "x.dbc").write_text("BO_ nonsense")
    with pytest.raises(InputError, match="x.dbc"):
        Dbc([tmp_path / "x.dbc"])


def test_a_folder_without_dbc_files_is_told(tmp_path, monkeypatch):
    monkeypatch.setenv("VOLTLAP_CAN_DBC", str(tmp_path))
    with pytest.raises(InputError, match="no car.dbc in"):
        Dbc.of_project()


def test_a_crc_that_crosses_a_byte_is_refused(tmp_path):
    text = (can_dbc_folder() / "car.dbc").read_text()
    at = text.index("BO_ 177 Pedals")
    assert " SG_ Crc : 56|8@" in text[at:]
    wrong = text[at:].replace(" SG_ Counter : 48|8@", " SG_ Counter : 48|4@", 1)
    wrong = wrong.replace(" SG_ Crc : 56|8@", " SG_ Crc : 54|8@", 1)
    (tmp_path / "car.dbc").write_text(text[:at] + wrong)
    with pytest.raises(InputError, match="car.dbc: Pedals.Crc crosses a byte"):
        Dbc([tmp_path / "car.dbc"])


@pytest.mark.parametrize("right, wrong, complaint", [
    ("BO_ 54 CellBroadcast: 8", "BO_ 54 CellBroadcast: 999999999999", "orion.dbc:13: found the length or place 9999"),
    ("7|8@0+", "7|2147483648@0+", "orion.dbc:14: found the length or place 2147483648"),
    ("(0.0001,0)", "(0,0)", "has the factor 0"), ("(0.0001,0)", "(1e999,0)", "has the factor inf"),
    ("BO_ 54", "BO_ x", "no DBC file that can be read"), ('"mOhm"', '"mOhm', "no DBC file that can be read")])
def test_a_dbc_file_that_cannot_be_used_is_told(tmp_path, right, wrong, complaint):
    text = (can_dbc_folder() / "orion.dbc").read_text()
    assert right in text
    (tmp_path / "orion.dbc").write_text(text.replace(right, wrong, 1))
    with pytest.raises(InputError, match=complaint):
        Dbc([tmp_path / "orion.dbc"])


def test_any_damage_to_a_dbc_file_is_told_or_harmless(tmp_path):
    seed = random.randrange(2**32)
    draw, good, path = random.Random(seed), (can_dbc_folder() / "orion.dbc").read_bytes(), tmp_path / "orion.dbc"
    for number in range(60):
        data = bytearray(good[:draw.randrange(len(good))] if draw.random() < 0.3 else good)
        for _ in range(draw.choice((1, 3)) if data else 0):
            at = draw.randrange(len(data))
            data[at:at + 1] = draw.choice((b"", b"9" * 20, b"-", b'"', b"\xff", b"\0", b"SG_ ", bytes([data[at] ^ 1])))
        path.write_bytes(data)
        try:
            for message in Dbc([path]).messages.values():
                payload = draw.randbytes(message.dlc)
                message.read(payload)
                message.seal(payload, 3)
        except InputError:
            pass
        except Exception as error:
            raise AssertionError(f"seed {seed}, file {number}: {error!r} of {bytes(data)!r}") from error
