# SPDX-License-Identifier: Apache-2.0
"""The generator is repeatable and refuses what it cannot say exactly."""
import subprocess
import sys

import pytest
from conftest import CAN_DBC


def generate(bench, out):
    return subprocess.run([sys.executable, str(CAN_DBC / "generate.py"), "--out", str(out),
                           *bench.arguments], capture_output=True, text=True)


def test_same_files_give_the_same_text_and_unchanged_files_stay_untouched(bench, tmp_path):
    assert generate(bench, tmp_path / "a").returncode == 0
    before = {f.name: (f.read_text(), f.stat().st_mtime_ns) for f in (tmp_path / "a" / "can_dbc").iterdir()}
    assert sorted(before) == ["amk.hpp", "car.hpp", "charger.hpp", "lockstep.hpp", "orion.hpp", "pm100.hpp",
                              "tables.hpp"]
    assert generate(bench, tmp_path / "a").returncode == 0
    assert before == {f.name: (f.read_text(), f.stat().st_mtime_ns) for f in (tmp_path / "a" / "can_dbc").iterdir()}


def test_bus_that_the_check_refuses_gets_no_codec(bench, tmp_path):
    bench.replace("car.dbc", '[-1000|1000] "A" BMS', '[-1000|1000] "" BMS')
    result = generate(bench, tmp_path / "out")
    assert result.returncode != 0 and "has no unit" in result.stderr
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("old, new, expected", [
    ('[-1000|1000] "A" BMS', '[-1000|1000] "kA" BMS', "unit 'kA' is unknown"),
    ("SG_ PackCurrent : 0|24@1- (0.001,0)", "SG_ PackCurrent : 0|24@1- (0.0013,0)", "no whole number"),
    ("SG_ PackCurrent : 0|24@1- (0.001,0)", "SG_ PackCurrent : 0|24@1- (0.001,5)", "has an offset"),
    ("SG_ Cell1 : 16|16@1+", "SG_ Cell1 : 17|15@1+", "does not"),
])
def test_what_integers_cannot_say_is_refused(bench, tmp_path, old, new, expected):
    bench.replace("car.dbc", old, new)
    result = generate(bench, tmp_path / "out")
    assert result.returncode != 0 and expected in result.stderr


def test_shape_of_a_group_must_not_vary(bench, tmp_path):
    text = bench.files["car.dbc"].read_text()
    start = text.index("CellVoltages_05")
    changed = text[:start] + text[start:].replace("SG_ Cell2 : 32|16", "SG_ Cell9 : 32|16", 1)
    bench.files["car.dbc"].write_text(changed.replace("VAL_ 517 Cell2", "VAL_ 517 Cell9"))
    result = generate(bench, tmp_path / "out")
    assert result.returncode != 0 and "does not continue its group" in result.stderr


def test_lockstep_messages_get_codecs_and_stand_in_no_table(bench, tmp_path):
    assert generate(bench, tmp_path / "out").returncode == 0
    assert "struct Sync {" in (tmp_path / "out" / "can_dbc" / "lockstep.hpp").read_text()
    assert "0x7E0" not in (tmp_path / "out" / "can_dbc" / "tables.hpp").read_text()
    bench.replace("lockstep.dbc", "BO_ 2016 Sync", "BO_ 16 Sync")
    assert generate(bench, tmp_path / "other").returncode == 1
