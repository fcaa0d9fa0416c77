# SPDX-License-Identifier: Apache-2.0
"""The catalogue of causes: what `voltlap list causes` prints is what docs/explain.md explains."""
import pathlib
import re

from drives import voltlap

DOCUMENT = (pathlib.Path(__file__).resolve().parents[3] / "docs" / "explain.md").read_text(encoding="utf-8")
FROM_THE_GATE = {"dropped_or_late_frames", "quantisation", "frozen_signal"}


def printed():
    """Parameters by cause."""
    lines = voltlap("list", "causes").stdout.splitlines()[1:]
    return {line.split()[0]: re.findall(r"(\w+) [-\d.e]+ \.\. ", line) for line in lines}


def documented():
    table = DOCUMENT.split("## The catalogue")[1].split("\n## ")[0]
    rows = [line.split("|")[1:3] for line in table.splitlines() if line.startswith("| `")]
    return {name: set(re.findall(r"`(\w+)`", parameters)) for names, parameters in rows
            for name in re.findall(r"`(\w+)`", names)}


def test_every_cause_is_documented_and_no_other():
    assert set(documented()) == set(printed()) | FROM_THE_GATE


def test_parameters_are_documented_by_their_names():
    known = documented()
    assert {name: [p for p in parameters if p not in known[name]] for name, parameters in printed().items()} == \
        {name: [] for name in printed()}
