# SPDX-License-Identifier: Apache-2.0
"""The pages of can_dbc/doc say what the DBC files say."""
import re
import subprocess
import sys

import cantools
import pytest
from conftest import CAN_DBC

PROGRAM = CAN_DBC / "reference.py"
FILES = ("car.dbc", "orion.dbc", "charger.dbc", "pm100.dbc", "amk.dbc", "lockstep.dbc")


def reference(*arguments):
    return subprocess.run([sys.executable, PROGRAM, *map(str, arguments)], capture_output=True, text=True)


def test_committed_pages_are_up_to_date():
    run = reference("--check")
    assert run.returncode == 0, run.stderr


@pytest.mark.parametrize("name, old, new", [
    ("car.dbc", "SG_ DischargeLimit : 0|16@1+ (0.1,0) [0|1000]", "SG_ DischargeLimit : 0|16@1+ (0.2,0) [0|1000]"),
    ("car.dbc", 'BA_ "VL_TimeoutMs" BO_ 192 50;', 'BA_ "VL_TimeoutMs" BO_ 192 60;'),
    ("orion.dbc", "Index of the cell from 0.", "Number of the cell from 0."),
    ("lockstep.dbc", "SG_ Stop : 48|1@1+", "SG_ Stop : 49|1@1+")])
def test_change_of_a_dbc_makes_its_page_old(bench, name, old, new):
    bench.replace(name, old, new)
    run = reference("--check", "--dbc", bench.files[name].parent)
    assert run.returncode == 1
    assert f"{name.removesuffix('.dbc')}.md is not what the DBC files say" in run.stderr


def test_missing_page_is_named(tmp_path):
    run = reference("--check", "--out", tmp_path)
    assert run.returncode == 1
    assert len(run.stderr.splitlines()) == len(FILES) + 1


@pytest.mark.parametrize("name", FILES)
def test_every_message_and_signal_stands_on_its_page(name):
    text = (CAN_DBC / "doc" / name.replace(".dbc", ".md")).read_text()
    sections = dict(re.findall(r"^## (\S+)[^\n]*\n(.*?)(?=^## |\Z)", text, re.MULTILINE | re.DOTALL))
    for message in cantools.database.load_file(CAN_DBC / name).messages:
        group = re.sub(r"_\d\d$", "_00", message.name)
        section = sections[message.name if message.name in sections else group]
        for signal in message.signals:
            row = re.search(rf"^\| {signal.name} \|.*$", section, re.MULTILINE)[0]
            assert f"| {signal.start}, {signal.length}" in row
            assert f"| {signal.unit or ''} |" in row
            if signal.choices and set(map(str, signal.choices.values())) != {"invalid"}:
                assert all(f"{raw} {word}" in row for raw, word in signal.choices.items() if str(word) != "invalid")
            elif signal.unit:
                assert f"| {signal.scale} |" in row


@pytest.mark.parametrize("name", FILES)
def test_picture_has_every_bit_of_every_signal_once(name):
    text = (CAN_DBC / "doc" / name.replace(".dbc", ".md")).read_text()
    for picture in re.findall(r"<table>.*?</table>", text, re.DOTALL):
        rows = re.findall(r"<tr><th>\d</th>(.*?)</tr>", picture)
        assert len(rows) == 8
        for row in rows:
            assert sum(map(int, re.findall(r'colspan="(\d)"', row))) == 8


def test_picture_of_both_byte_orders():
    car, orion = ((CAN_DBC / "doc" / name).read_text() for name in ("car.md", "orion.md"))
    whole = '<td colspan="8" align="center">'
    assert f"<tr><th>0</th>{whole}PackCurrent 7..0</td></tr>" in car
    assert f"<tr><th>2</th>{whole}PackCurrent 23..16</td></tr>" in car
    assert f"<tr><th>0</th>{whole}PackCurrent 15..8</td></tr>" in orion
    assert ('<tr><th>3</th><td colspan="1" align="center">CellBalancing</td>'
            '<td colspan="7" align="center">CellResistance 14..8</td></tr>') in orion


def test_links_lead_to_headings():
    doc = CAN_DBC / "doc"
    headings = {page.name: {heading.lower().replace(" ", "-")
                            for heading in re.findall(r"^## (.+)$", page.read_text(), re.MULTILINE)}
                for page in doc.glob("*.md")}
    for page in doc.glob("*.md"):
        links = re.findall(r"\]\((\w*\.?m?d?)#([^)]+)\)", page.read_text())
        assert links
        for target, anchor in links:
            assert anchor in headings[target or page.name]
