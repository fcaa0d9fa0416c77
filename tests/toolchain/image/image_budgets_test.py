# SPDX-License-Identifier: Apache-2.0
"""What the firmware takes of a microcontroller is within its budgets, and what docs/microcontroller.md says of it."""
import re
import shutil
import time

import pytest
from image_tools import ROOT, tool

import image_budgets
import image_build

DOCUMENT = ROOT / "docs" / "microcontroller.md"
CLOSE = 0.02  # of a size, between this tree and the table: `./voltlap image-budgets --write` renews that


def document_rows(columns):
    """First columns -> the others, of the rows with so many columns between the marks of the document."""
    text = DOCUMENT.read_text()
    inside = text[text.index(image_budgets.BEGIN):text.index(image_budgets.END)]
    rows = [[cell.strip(" `") for cell in line.strip("|\n ").split("|")] for line in inside.splitlines()
            if line.startswith("| ")]
    return [row for row in rows if len(row) == columns and re.search(r"\d", "".join(row[1:]))]


def lap(run):
    if shutil.which("qemu-system-arm") is None:
        pytest.skip("qemu-system-arm is not installed")
    return image_budgets.drive(run, 1)


def test_24_cells_keep_the_marks(kind_of):
    kind_of(24)
    assert image_budgets.broken_sizes() == []


def test_a_mark_that_is_not_kept_is_said(kind_of, monkeypatch):
    kind_of(24)
    monkeypatch.setattr(image_budgets, "FLASH_MOST", 50_000)
    monkeypatch.setattr(image_budgets, "RAM_MOST", 10_000)
    monkeypatch.setattr(image_budgets, "STACK_MOST", 500)
    assert [word for line in image_budgets.broken_sizes() for word in ("flash", "RAM", "stack") if word in line] == [
        "flash", "RAM", "stack"]


SHORT = [run for run in image_budgets.RUNS if run.label in ("24", "144")]


@pytest.mark.parametrize("run", SHORT, ids=lambda run: run.label)
def test_a_step_keeps_its_mark(kind_of, run):
    kind_of(run.image_cells)
    result = lap(run)
    assert image_budgets.broken_step(run, result) == []
    tight = image_budgets.Run(run.label, run.cells, run.image_cells, step_most=20_000)
    assert "at most 20000 are allowed" in image_budgets.broken_step(tight, result)[0]
    told = {row[0]: row for row in document_rows(6)}
    worst = result["ecu"]["instructions_per_step"]["bms"]["worst"]
    assert worst <= int(told[run.label][2]) * (1 + CLOSE)  # a whole endurance has this lap in it


def test_the_fault_matrix_costs_no_more_than_the_document_says(kind_of):
    if shutil.which("qemu-system-arm") is None:
        pytest.skip("qemu-system-arm is not installed")
    kind_of(image_budgets.MATRIX.image_cells)
    result = image_budgets.drive_faults(image_budgets.MATRIX, 3)
    assert image_budgets.broken_step(image_budgets.MATRIX, result) == []
    told = {row[0]: row for row in document_rows(6)}[image_budgets.MATRIX.label]
    assert result["ecu"]["instructions_per_step"]["bms"]["worst"] <= int(told[2]) * (1 + CLOSE)
    assert result["ecu"]["instructions_per_step"]["master"]["worst"] <= int(told[4]) * (1 + CLOSE)


def test_the_document_has_the_sizes_of_this_tree(kind_of):
    told = {tuple(row[:3]): [int(word) for word in row[3:]] for row in document_rows(6) if row[0].startswith("cortex")}
    for cells in (24, None):
        for name in ("bms_node", "master_node", "both_nodes"):
            size = image_build.size_of(kind_of(cells).image(name))
            found = [size.flash, size.ram, size.stack]
            for was, now in zip(told["cortex-m4", str(cells or 144), name], found, strict=True):
                assert abs(now - was) <= CLOSE * was, f"{name}: {found}; ./voltlap image-budgets --write {DOCUMENT}"


def test_the_table_goes_between_the_marks_and_nowhere_else(tmp_path):
    path = tmp_path / "page.md"
    path.write_text(f"before\n{image_budgets.BEGIN}\nold\n{image_budgets.END}\nafter\n")
    image_budgets.write_into(path, "new")
    assert path.read_text() == f"before\n{image_budgets.BEGIN}\nnew\n{image_budgets.END}\nafter\n"


@pytest.mark.parametrize("name, words", [("bare.md", "expected both"), ("nothere.md", "no such file"),
                                         ("", "an empty name")])
def test_a_document_that_cannot_take_the_table_is_told_before_the_work(tmp_path, name, words):
    (tmp_path / "bare.md").write_text("nothing")
    begin = time.monotonic()
    done = tool("image_budgets.py", "--laps", 1, "--write", name, cwd=tmp_path)
    assert done.returncode == 2 and words in done.stderr and "Traceback" not in done.stderr
    assert time.monotonic() - begin < 30.0 and not done.stdout  # the work takes minutes


def test_laps_that_are_none_are_refused():
    for flag in ("--laps", "--rows"):
        result = tool("image_budgets.py", flag, "0")
        assert result.returncode == 2 and f"{flag} 0" in result.stderr
