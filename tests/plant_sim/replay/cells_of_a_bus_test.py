# SPDX-License-Identifier: Apache-2.0
"""Cells that a team's DBC spreads over its frames as it likes are found, in their order; what is not used is named."""
import json
import os
import random
import struct

import pytest
from straight_pack import CELLS, PACK, rows, voltlap

SEED = int(os.environ.get("VOLTLAP_TEST_SEED", "20261127"))


def bus(rng, folder):
    """A DBC and a candump of it: so many cells a frame, identifiers of either width, not all behind each other."""
    per, extended, apart = rng.choice([1, 2, 3, 4]), rng.random() < 0.5, rng.choice([1, 1, 2, 7])
    name = rng.choice(["Cell{}_Voltage", "CellVoltage{}", "V_Cell_{}", "Zellspannung_{}"])
    first = 0x18FF0000 if extended else 0x400
    groups = [list(range(n, min(n + per, CELLS + 1))) for n in range(1, CELLS + 1, per)]
    ids = [first + apart * k for k in range(len(groups))]
    dbc = ['VERSION ""', "BS_:", "BU_: BMS", f"BO_ {0x100} Pack: 8 BMS",
           ' SG_ PackCurrent : 0|16@1- (0.1,0) [-3000|3000] "A" BMS',
           ' SG_ PackVoltage : 16|16@1+ (0.01,0) [0|600] "V" BMS',
           ' SG_ SelectedCellVoltage : 32|16@1+ (0.0001,0) [0|6] "V" BMS']
    for frame, group in zip(ids, groups):
        dbc.append(f"BO_ {frame | (0x80000000 if extended else 0)} Cells{frame:X}: 8 BMS")
        dbc += [f' SG_ {name.format(n)} : {16 * k}|16@1+ (0.0001,0) [0|6.5] "V" BMS' for k, n in enumerate(group)]
    (folder / "car.dbc").write_text("\n".join(dbc) + "\n")
    lines = []
    for row in rows(20, soc=0.40):
        volts = [row[f"cell_voltage_{n}_v"] - (0.08 if n == 5 else 0.0) for n in range(1, CELLS + 1)]
        mean = sum(volts) / CELLS
        pack = struct.pack("<hHHH", round(10 * row["current_a"]), round(100 * sum(volts)), round(1e4 * mean), 0)
        lines.append(f"({row['time_s']:.6f}) can0 100#{pack.hex().upper()}")
        for frame, group in zip(ids, groups):
            data = b"".join(struct.pack("<H", round(1e4 * volts[n - 1])) for n in group).ljust(8, b"\0")
            lines.append(f"({row['time_s'] + 0.001:.6f}) can0 {frame:0{8 if extended else 3}X}#{data.hex().upper()}")
    (folder / "drive.log").write_text("\n".join(lines) + "\n")
    return f"seed {SEED}: {per} cells a frame, extended {extended}, {apart} apart, {name}"


@pytest.mark.parametrize("case", range(6))
def test_all_cells_are_found_in_their_order(tmp_path, case):
    about = bus(random.Random(f"{SEED} {case}"), tmp_path)
    (tmp_path / "pack.toml").write_text(PACK)
    run = voltlap("replay", tmp_path / "drive.log", "--dbc", tmp_path / "car.dbc", "--pack", tmp_path / "pack.toml",
                  "--json", tmp_path / "o.json")
    assert run.returncode == 0, f"{about}\n{run.stderr}"
    out = json.loads((tmp_path / "o.json").read_text())
    assert {violation["cell"] for violation in out["limit_violations"]} == {5}, about
    assert not [text for text in out["assumptions"] if "no cell voltages" in text or "no reading" in text], about
    assert "signals that no role takes: 0x100 SelectedCellVoltage" in " ".join(out["notes"]), (about, out["notes"])
