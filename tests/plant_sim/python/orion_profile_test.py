# SPDX-License-Identifier: Apache-2.0
"""Profiles that are no profiles: damaged, hostile, or of a battery that cannot be. Each is refused with its place, in
one line, and no result is left behind."""
import contextlib
import io
import random
import sys

import pytest
from orion_profiles import PROJECT, SEED, drawn_profile, orion, profile_text

sys.path.insert(0, str(PROJECT / "plant_sim/python"))
from voltlap_orion import __main__ as command  # noqa: E402

WHOLE, TABLES, CELLS = drawn_profile(random.Random(1))
GOOD = profile_text(WHOLE, TABLES, CELLS)
DTD = GOOD.replace("<java ", '<!DOCTYPE java [<!ENTITY a "a&a;">]>\n<java ', 1)


def called(*words):
    """Exit code and the two outputs of the program in this process: faster, and an exception goes through."""
    out, errors = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(errors):
        code = command.main([str(word) for word in words])
    return code, out.getvalue(), errors.getvalue()


def refused(tmp_path, text):
    profile, pack = tmp_path / "car.o2bms", tmp_path / "pack.toml"
    profile.write_bytes(text if isinstance(text, bytes) else text.encode())
    code, out, errors = called("import", profile, "--output", pack)
    assert (code, out) == (2, ""), errors
    assert not pack.exists() and errors.startswith(str(profile)) and len(errors.splitlines()) == 1
    assert "found" in errors and "expected" in errors
    return errors


@pytest.mark.parametrize(("text", "words"), [
    ("", ["1", "no element found"]),
    ("<", ["car.o2bms:1"]),
    (GOOD[:len(GOOD) // 2], ["XML that cannot be read"]),
    (DTD, ["car.o2bms:2", "document type"]),
    (GOOD.replace("<java ", '<!DOCTYPE java SYSTEM "file:///etc/passwd">\n<java ', 1), ["car.o2bms:2", "document"]),
    (GOOD.replace("<int>", "<int>&lol;", 1), ["undefined entity"]),
    (GOOD.replace("</object>", '<void method="exec"><string>x</string></void></object>'), ['method "exec"']),
    (GOOD.replace("</object>", '<void property="a"><object class="java.lang.ProcessBuilder"/></void></object>'),
     ["java.lang.ProcessBuilder"]),
    (GOOD.replace("bmsapp.DefaultProfile", "java.lang.Runtime"), ["java.lang.Runtime"]),
    ("<html><body/></html>", ["<html>"]),
    (GOOD.replace("<java ", "<java>" * 30 + "<java "), []),
    (GOOD.replace("</object>", '<void property="a">' * 20 + "</void>" * 20 + "</object>"), ["nested 17 deep"]),
    (GOOD.replace("</object>", '<void property="totalCells"><int>9</int></void></object>'), ["totalCells", "second"]),
    (GOOD.replace("</object>", '<void property="a b"><int>9</int></void></object>'), ['property "a b"']),
    (GOOD.replace("</object>", '<void index="-1"><int>9</int></void></object>'), ['index "-1"']),
    (GOOD.replace('encoding="UTF-8"', 'encoding="EBCDIC"'), []),
    (b"\x00\xff" * 100, []),
    (GOOD + " " * 4_000_001, ["more than 4 MB"]),
], ids=range(18))
def test_what_is_no_profile_is_refused_with_its_place(tmp_path, text, words):
    errors = refused(tmp_path, text)
    assert all(word in errors for word in words), errors


@pytest.mark.parametrize(("name", "value"), [
    ("totalCells", "0"), ("totalCells", "145"), ("totalCells", "1e9"), ("totalCells", "\u0663"), ("totalCells", "-4"),
    ("totalCells", "9" * 5000), ("totalAmphours", "0"), ("totalAmphours", "zwei"), ("minimumCellVoltage", "43000"),
    ("maximumCellVoltage", "65000"), ("maximumCellVoltage", "0x10"), ("maximumDCL", "0"), ("maximumDCL", "-1"),
    ("hotPackTemperature", "0"), ("hotPackTemperature", "200"), ("derateLowSOCStart", "101"),
    ("minimumBalanceVoltage", "70000"), ("intresDCMultiplier", "NaN")])
def test_a_value_that_cannot_be_is_refused_with_its_property(tmp_path, name, value):
    errors = refused(tmp_path, profile_text(WHOLE | {name: value}, TABLES))
    assert name in errors and len(errors) < 400


@pytest.mark.parametrize("name", ["totalCells", "totalAmphours", "minimumCellVoltage", "maximumCellVoltage"])
def test_a_needed_property_that_the_file_leaves_out_is_named(tmp_path, name):
    assert name in refused(tmp_path, profile_text({key: value for key, value in WHOLE.items() if key != name}, TABLES))


@pytest.mark.parametrize("points", [{20: 1.0}, {3: -1.0}, {3: "Infinity"}, {3: 1e300}])
def test_a_table_beyond_its_points_is_refused(tmp_path, points):
    errors = refused(tmp_path, profile_text(WHOLE, TABLES | {"dclTemperatureTable": points}))
    assert "dclTemperatureTable[" in errors


def test_two_places_that_give_another_number_of_cells_are_refused(tmp_path):
    errors = refused(tmp_path, profile_text(WHOLE | {"totalCells": 12}, TABLES, 11))
    assert "12" in errors and "11" in errors


PIECES = (b"<void>", b"</void>", b"&#0;", b"&amp;", b"<!--", b"1e400", b"<![CDATA[")


def mutated(text, source):
    """Bytes flipped, a stretch cut out, doubled or moved, or a number in it replaced."""
    data = bytearray(text.encode())
    for _ in range(source.choice((1, 1, 2, 5))):
        begin = source.randrange(len(data))
        end = min(len(data), begin + source.choice((1, 1, 3, 40, 400)))
        kind = source.randrange(4)
        if kind == 0:
            data[begin:end] = source.randbytes(end - begin)
        elif kind == 1:
            del data[begin:end]
        elif kind == 2:
            data[begin:begin] = data[begin:end]
        else:
            data[begin:end] = source.choice(PIECES)
        if not data:
            break
    return bytes(data)


def test_drawn_damage_is_read_or_refused_never_a_traceback(tmp_path):
    print(f"VOLTLAP_TEST_SEED={SEED}")
    source = random.Random(SEED)
    profile, pack = tmp_path / "car.o2bms", tmp_path / "pack.toml"
    codes = {0: 0, 2: 0}
    for _ in range(400):
        text = profile_text(*drawn_profile(source))
        profile.write_bytes(mutated(text, source))
        pack.unlink(missing_ok=True)
        code, _, errors = called("import", profile, "--output", pack)
        codes[code] += 1
        assert (code == 0) == pack.exists() == (errors == "")
        assert code == 0 or (len(errors.splitlines()) == 1 and errors.startswith(str(profile))), errors
        shown, _, why = called("show", "--all", profile)
        assert code == 2 or shown == 0, why
    assert codes[0] > 10 and codes[2] > 100, codes


def test_the_command_refuses_what_it_does_not_know_and_says_what_it_does(tmp_path):
    profile = tmp_path / "car.o2bms"
    profile.write_text(GOOD)
    assert orion().returncode == 2 and orion("export", profile).returncode == 2
    absent = orion("show", tmp_path / "no.o2bms")
    assert absent.returncode == 2 and "no.o2bms" in absent.stderr and "Traceback" not in absent.stderr
    assert orion("show", tmp_path).returncode == 2
    text = orion("--help").stdout
    assert all(word in text for word in ("import PROFILE", "show PROFILE", "--cell", "--output", "Exit code"))
