# SPDX-License-Identifier: Apache-2.0
"""What is proposed for recordings of real cells and cars, against roles that were chosen by hand."""
import os
import subprocess
import tomllib
from pathlib import Path

import pytest

BIN = Path(os.environ["VOLTLAP_BUILD_DIR"]) / "tests/bin"
DATA = os.environ.get("VOLTLAP_DATA")
pytestmark = pytest.mark.skipif(not DATA, reason="VOLTLAP_DATA is not set")

CELL = {"time": "t_s", "current": "i_a", "voltage": "v_v"}
PACK = {"time": "t_s", "current": "i_a", "pack_voltage": "v_v"}
UWFE_TABLE = {"time": "t_s", "current": "i_ivt_a", "pack_voltage": ("u1_bus_v", "v_ams_sum_v")}
UWFE = {"current": "IVT_I", "pack_voltage": ("IVT_U1", "IVT_U2", "AMS_PackVoltage")}
LEAF = {"current": "LB_Current", "pack_voltage": "LB_Total_Voltage"}
ORION2 = {"current": "HvBatteryCurrent", "pack_voltage": "HvBatteryVoltage"}
UWFE_DBC = "uwfe_canlogs/2024CAR.dbc"
LEAF_DBC = "dbc/leaf/EV-can_ZE1.dbc"
ORION2_DBC = "orion2_conversion_candump/ZeroEvDBC_onlyBMS_DU.dbc"
ORION_DBC = str(Path(__file__).parents[4] / "can_dbc/orion.dbc")

# Recording, its DBC file, and the roles that are right; of several either.
RECORDINGS = [
    ("ksu_ks6e_fsae/fsae_michigan_ev_2023_endurance_stint1.csv.gz", None, PACK),
    ("ucd_fe6_fsae/fsae_lincoln_2019_endurance_stint1.csv.gz", None, PACK),
    ("ut23_fsae/fsae_michigan_2023_endurance_first_850s.csv.gz", None,
     {"time": "t_s", "current": "i_pack_a_derived", "pack_voltage": "v_pack_v"}),
    ("leaf_canlogs/leaf62_drive_2_pack_100hz.csv.gz", None, PACK),
    *[(f"leaf_cell_ornl/{name}.csv.gz", None, CELL)
      for name in ("cycling_c15_10C_24C_40C", "discharge_1C", "discharge_2C", "hppc_25C")],
    *[(f"leaf_cell_ornl/pack6s2p_discharge_{rate}c.csv.gz", None,
       {"time": "t_s", "current": "i_a", "pack_voltage": "v_pack_v"}) for rate in ("0_3", "1_0")],
    *[(f"panasonic_18650pf/{name}.csv.gz", None, CELL | {"temperature_1": "temp_c"})
      for name in ("dis_1c_25C_end_of_life_of_test", "dis_1c_25C_start", "hppc_10C", "hppc_25C",
                   "hppc_25C_discharges_between", "la92_25C", "mix1_25C", "ocv_c20_25C", "us06_0C", "us06_25C")],
    *[(f"plett_a123/a123_{name}.csv.gz", None, CELL)
      for name in ("dyn_50_p25", "dyn_50_p45", "ocv_p05", "ocv_p25", "ocv_p45")],
    *[(f"uwfe_cellfuse/cell_{n}_pulse_250hz.csv.gz", None, CELL) for n in (1, 100, 250, 400, 556, 700, 850, 950)],
    *[(f"uwfe_canlogs/{name}_main_20hz.csv.gz", None, UWFE_TABLE)
      for name in ("A_postregen_193", "B_pitt_autox_24", "F_april2025_glitchy_11")],
    ("uwfe_canlogs/A_postregen_193.candump.log.gz", UWFE_DBC, UWFE),
    ("uwfe_canlogs/A_postregen_193.TXT.gz", UWFE_DBC, UWFE),
    ("uwfe_canlogs/B_pitt_autox_24.candump.log.gz", UWFE_DBC, UWFE),
    ("uwfe_canlogs/F_april2025_glitchy_11.TXT.gz", UWFE_DBC, UWFE),
    ("leaf_canlogs/leaf62_drive_2.candump.log.gz", LEAF_DBC, LEAF),
    ("leaf_canlogs/leaf62_startup.candump.log.gz", LEAF_DBC, LEAF),
    ("leaf_canlogs/raw_leaf62_drive_2.log.gz", LEAF_DBC, LEAF),
    ("orion2_conversion_candump/candump-2025-11-05_214230.log.gz", ORION2_DBC, ORION2),
    ("orion2_conversion_candump/can0_2025-11-01.asc.gz", ORION2_DBC, ORION2),
    ("orion2_conversion_candump/candump-2025-11-22_161709.trc.gz", ORION2_DBC, ORION2),
    ("orion_fsae_slcan/orion_fsae_bench.slcan.txt.gz", ORION_DBC,
     {"current": "PackCurrent", "pack_voltage": "PackVoltage"}),
]


def proposal_for(recording, dbc):
    command = [BIN / "show_proposal", Path(DATA) / recording, *([Path(DATA) / dbc] if dbc else [])]
    result = subprocess.run(command, capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
    verdict, draft = result.stdout.split("\n", 1)
    return verdict, tomllib.loads(draft).get("roles", {}), draft


def disagreements(roles, expected):
    """A role that is proposed at all must be right, be the rest refused or not."""
    either = {"voltage": "pack_voltage", "pack_voltage": "voltage"}
    for role in ("time", "current", "voltage", "pack_voltage"):
        if role not in roles:
            continue
        right = expected.get(role, expected.get(either.get(role)))
        found = roles[role].get("column", roles[role].get("signal"))
        if right is None or found not in ((right,) if isinstance(right, str) else right):
            yield f"{role}: {found} instead of {right}"
    for role, right in expected.items():
        if role.startswith("temperature") and roles.get(role, {"column": right})["column"] != right:
            yield role


def test_three_of_four_drafts_need_no_edit_and_none_is_wrong():
    complete = 0
    for recording, dbc, expected in RECORDINGS:
        verdict, roles, draft = proposal_for(recording, dbc)
        assert not list(disagreements(roles, expected)), f"{recording}\n{draft}"
        if verdict == "complete":
            assert "current" in roles and ("voltage" in roles or "pack_voltage" in roles), recording
        complete += verdict == "complete"
        print(f"{verdict:9} {recording}")
    print(f"{complete} of {len(RECORDINGS)} need no edit")
    assert complete >= 0.75 * len(RECORDINGS)


@pytest.mark.parametrize("name", ["discharge_1C_thermocouples", "discharge_2C_thermocouples"])
def test_a_table_without_a_battery_is_refused(name):
    verdict, roles, draft = proposal_for(f"leaf_cell_ornl/{name}.csv.gz", None)
    assert verdict == "open" and "current" not in roles
    assert "current is missing" in draft
