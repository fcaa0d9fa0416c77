# SPDX-License-Identifier: Apache-2.0
"""Recordings of real cars (VOLTLAP_DATA): each is replayed or refused for a stated reason, and no frame goes
uncounted."""
import json
import os
import subprocess
from pathlib import Path

import pytest

BUILD = Path(os.environ["VOLTLAP_BUILD_DIR"])
DATA = os.environ.get("VOLTLAP_DATA")
pytestmark = pytest.mark.skipif(not DATA, reason="VOLTLAP_DATA names no folder of measured data")

UWFE = """name = "uwfe"
[battery]
cell = "molicel_p42a"
cells_in_series = 140
cells_in_parallel = 6
[bms]
discharge_current_max_a = 235
charge_current_max_a = 60
"""
LEAF = UWFE.replace("140", "96").replace("235", "500")
UWFE_LOG, LEAF_LOG = "uwfe_canlogs", "leaf_canlogs"
# folder, pattern, map, pack, words of the refusal; none: it is replayed
LOGS = [
    (UWFE_LOG, "[AB]_*.candump.log.gz", "uwfe_can_bms", UWFE, None),
    (UWFE_LOG, "A_*.TXT.gz", None, None, None),
    (UWFE_LOG, "F_*.TXT.gz", "uwfe_can_bms", UWFE, "no current"),  # its shunt was not there
    (UWFE_LOG, "F_*.TXT.gz", "uwfe_inverter_current", UWFE, None),
    (LEAF_LOG, "*.log.gz", None, LEAF, None),
    (LEAF_LOG, "leaf62_drive_2.candump.log.gz", None, None, "no cell voltage, and no pack"),
    ("orion2_conversion_candump", "*.asc.gz", None, None, None),
    ("orion2_conversion_candump", "candump-2025-11-05*.log.gz", None, None, None),
    ("orion2_conversion_candump", "*.trc.gz", "orion2_conversion_can", UWFE.replace("140", "72"), None),
    ("orion2_conversion_candump", "*.trc.gz", None, None, "no shipped map fits"),
    ("orion_fsae_slcan", "*.slcan.txt.gz", None, None, "no shipped map fits"),
    ("kona_bms_asc", "*.asc.gz", None, None, "no shipped map fits"),
]


def replayed(folder, log, role_map, pack, *arguments):
    command = [BUILD / "bin/voltlap", "replay", log, "--json", folder / "out.json", *arguments]
    if role_map:
        command += ["--map", role_map]
    if pack:
        (folder / "pack.toml").write_text(pack)
        command += ["--pack", folder / "pack.toml"]
    return subprocess.run(command, capture_output=True, text=True, timeout=300)


@pytest.mark.parametrize("folder, pattern, role_map, pack, refusal", LOGS)
def test_each_log_is_replayed_or_refused_for_a_reason(folder, pattern, role_map, pack, refusal, tmp_path):
    logs = sorted((Path(DATA) / folder).glob(pattern))
    assert logs
    for log in logs:
        run = replayed(tmp_path, log, role_map, pack)
        if refusal:
            assert run.returncode == 2 and refusal in run.stderr, (log, run.stderr)
            continue
        assert run.returncode == 0, (log, run.stderr)
        out = json.loads((tmp_path / "out.json").read_text())
        assert out["frames"] == sum(out["frames_by_verdict"].values()) > 10_000, log
        assert out["frames_by_verdict"]["used"] > 1000 and out["duration_s"] > 0.0, log


def test_the_weakest_cell_would_have_been_limited_before_it_sagged(tmp_path):
    """uwfe A: cell 31 reads 2.19 V under 185 A at 44.6 s. A second before the firmware allows much less, for one of the
    weak cells."""
    log = next((Path(DATA) / UWFE_LOG).glob("A_*.candump.log.gz"))
    assert replayed(tmp_path, log, "uwfe_can_bms", UWFE).returncode == 0
    out = json.loads((tmp_path / "out.json").read_text())
    worst = min(out["limit_violations"], key=lambda entry: entry["voltage_v"])
    assert worst["cell"] == 31 and worst["voltage_v"] < 2.2
    cut = [entry for entry in out["over_limits"] if worst["time_s"] - 2.0 < entry["begin_s"] < worst["time_s"]]
    assert cut and cut[0]["limit_a"] < 0.75 * cut[0]["current_a"] and cut[0]["reason"] == "CellVoltage"


def test_a_soc_that_jumps_is_told_from_charge(tmp_path):
    """uwfe B: the battery unit's SOC moves by 24 points within seconds; the charge of these seconds is none."""
    log = next((Path(DATA) / UWFE_LOG).glob("B_*.candump.log.gz"))
    assert replayed(tmp_path, log, "uwfe_can_bms", UWFE).returncode == 0
    jump = json.loads((tmp_path / "out.json").read_text())["soc_jump"]
    assert abs(jump["to_pct"] - jump["from_pct"]) == pytest.approx(24.0, abs=1.0)
    assert abs(jump["charge_ah"]) < 0.25  # a point of 25 Ah


def test_corrupt_frames_never_close_the_contactors(tmp_path):
    """uwfe F: cells of 1.02 and 4.4 V that no checksum betrays. Nothing that can be believed says that the car may
    drive, and each frame has its verdict."""
    log = next((Path(DATA) / UWFE_LOG).glob("F_*.TXT.gz"))
    assert replayed(tmp_path, log, "uwfe_inverter_current", UWFE).returncode == 0
    out = json.loads((tmp_path / "out.json").read_text())
    assert out["never_ready"] and set(out["series"]["state"]) <= {"Invalid", "Open", "Fault", "Opening"}, out["series"]
    assert {"CellVoltageLow", "CellImplausible"} <= {fault["id"] for fault in out["faults"]}
    assert out["frames_by_verdict"]["corrupt"] > 500 and not any(out["series"]["discharge_limit_a"])
