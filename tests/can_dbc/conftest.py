# SPDX-License-Identifier: Apache-2.0
"""A bus that can be broken in one place: the negative controls of the check edit the text of the DBC files."""
import sys
from pathlib import Path

import pytest

CAN_DBC = Path(__file__).resolve().parents[2] / "can_dbc"
sys.path.insert(0, str(CAN_DBC))

import check  # noqa: E402
import model  # noqa: E402


class Bench:
    def __init__(self, folder):
        self.files = {}
        for name in ("car.dbc", "orion.dbc", "charger.dbc", "pm100.dbc", "amk.dbc", "lockstep.dbc"):
            self.files[name] = folder / name
            self.files[name].write_text((CAN_DBC / name).read_text())

    def replace(self, name, old, new):
        text = self.files[name].read_text()
        assert old in text, f"{old!r} is not in {name}: the control would control nothing"
        self.files[name].write_text(text.replace(old, new, 1))

    def replace_all(self, name, old, new):
        text = self.files[name].read_text()
        assert old in text
        self.files[name].write_text(text.replace(old, new))

    @property
    def car_files(self):
        return [self.files[name] for name in ("car.dbc", "orion.dbc", "charger.dbc", "pm100.dbc", "amk.dbc")]

    @property
    def arguments(self):
        """As the build hands the files to check.py and generate.py."""
        return ["--lockstep", str(self.files["lockstep.dbc"]), *map(str, self.car_files)]

    def findings(self):
        bus = model.load(self.car_files)
        return check.check(bus) + check.check_lockstep(model.load([self.files["lockstep.dbc"]]), bus)


@pytest.fixture
def bench(tmp_path):
    return Bench(tmp_path)
