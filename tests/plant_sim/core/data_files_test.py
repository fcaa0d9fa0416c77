# SPDX-License-Identifier: Apache-2.0
"""Every number of the data files says its unit and where it comes from."""
import pathlib
import re

import pytest

DATA = pathlib.Path(__file__).resolve().parents[3] / "plant_sim" / "data"
NUMBER = re.compile(r"^(\w+)\s*=\s*(-?[\d.]|\[)")
SOURCE = re.compile(r"reference study|calibrated|assumed|data sheet|rules|reading of|as printed|LEM|Orion|car\.dbc|"
                    r"is the 2p pair|follows|FreedomCAR|estimated")


def unexplained(text):
    """Lines with a number but without `# unit; source` behind it."""
    wrong = []
    for number, line in enumerate(text.splitlines(), 1):
        if not NUMBER.match(line):
            continue
        comment = line.partition("#")[2]
        unit, separator, source = comment.partition(";")
        if not (separator and unit.strip() and SOURCE.search(source)):
            wrong.append(f"{number}: {line}")
    return wrong


PATHS = sorted(path for kind in ("vehicles", "cells", "motors", "bench") for path in DATA.glob(f"{kind}/*.toml"))


@pytest.mark.parametrize("path", PATHS, ids=lambda p: p.stem)
def test_every_number_has_unit_and_source(path):
    assert unexplained(path.read_text()) == []


@pytest.mark.parametrize("line", ["mass_kg = 3.0", "mass_kg = 3.0  # kg", "mass_kg = 3.0  # kg; from somewhere",
                                  "mass_kg = 3.0  # ; assumed"])
def test_a_number_without_unit_or_source_is_found(line):
    assert unexplained(line)
