# SPDX-License-Identifier: Apache-2.0
"""Recordings of real cars through the shipped maps: what is in them, found by other means, and how fast."""
import gzip
import os
import subprocess
import time
from pathlib import Path

import pytest

BIN = Path(os.environ["VOLTLAP_BUILD_DIR"]) / "tests/bin"
DATA = os.environ.get("VOLTLAP_DATA")
ROOT = Path(__file__).parents[4]
MAPS = ROOT / "plant_sim/data/maps"
pytestmark = pytest.mark.skipif(not DATA, reason="VOLTLAP_DATA is not set")


def show(recording, map_name=""):
    """{role: (samples, begin, end, lowest, highest)}, and the lines about defects and decisions."""
    arguments = [BIN / "show_log", Path(DATA) / recording] + ([map_name] if map_name else [])
    result = subprocess.run(arguments, capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
    channels, words = {}, []
    for line in result.stdout.splitlines():
        if line.startswith("channel "):
            _, role, *numbers = line.split(" ")
            channels[role] = tuple(float(number) for number in numbers)
        else:
            words.append(line)
    return channels, words


def frames_of(recording, identifier):
    with gzip.open(Path(DATA) / recording, "rt") as lines:
        return [bytes.fromhex(line.split("#")[1]) for line in lines if line.split(" ")[2].startswith(identifier + "#")]


def test_race_car_with_140_cells_a_shunt_and_an_inverter():
    log = "uwfe_canlogs/A_postregen_193.candump.log.gz"
    channels, words = show(log)
    current = [int.from_bytes(f[2:6], "little", signed=True) / 1000 for f in frames_of(log, "521")]
    assert channels["current"][0] == len(current)
    assert channels["current"][4] == pytest.approx(max(current))  # discharge is positive in this car
    cells = [role for role in channels if role.startswith("cell_voltage_")]
    assert len(cells) == 140
    assert channels["cell_voltage_31"][3] == pytest.approx(2.19, abs=0.01)
    assert any("not what is measured" in line for line in words)  # published voltage rises with the current
    assert any("lost frames by the counter" in line for line in words)


def test_raw_hex_without_lengths_gives_what_its_candump_conversion_gives():
    raw, _ = show("uwfe_canlogs/A_postregen_193.TXT.gz")
    converted, _ = show("uwfe_canlogs/A_postregen_193.candump.log.gz")
    assert raw.keys() == converted.keys()
    for role, (samples, begin, _, lowest, highest) in raw.items():
        assert (samples, lowest, highest) == (converted[role][0], *converted[role][3:]), role
        assert begin - 0.619 == pytest.approx(converted[role][1], abs=1e-6)


def test_glitchy_recording_is_read_and_says_what_is_wrong():
    channels, words = show("uwfe_canlogs/F_april2025_glitchy_11.TXT.gz", "uwfe_can")
    assert "motor_speed" in channels
    for kind in ("identifier beyond 29 bits", "impossible value", "invalid code"):
        assert any(kind in line for line in words), kind


def test_leaf_counts_charge_as_positive_and_the_map_says_so():
    channels, _ = show("leaf_canlogs/leaf62_drive_2.candump.log.gz")
    assert channels["current"][4] == pytest.approx(482.5)
    assert channels["pack_voltage"][3:] == (367.5, 393.5)


def test_orion_cells_pass_their_checksum_in_candump_and_asc():
    for log in ("candump-2025-11-05_214230.log.gz", "can0_2025-11-01.asc.gz"):
        channels, words = show("orion2_conversion_candump/" + log)
        cells = [value for role, value in channels.items() if role.startswith("cell_voltage_")]
        assert len(cells) > 60
        assert all(4.0 < cell[3] <= cell[4] < 4.1 for cell in cells)
        assert not any("checksum" in line for line in words)


@pytest.mark.parametrize(("name", "excerpt", "whole", "recordings"), [
    ("uwfe_can", "dbc/uwfe_2024.dbc", "uwfe_canlogs/2024CAR.dbc",
     ["uwfe_canlogs/A_postregen_193.candump.log.gz", "uwfe_canlogs/B_pitt_autox_24.candump.log.gz",
      "uwfe_canlogs/F_april2025_glitchy_11.TXT.gz"]),
    ("uwfe_can_bms", "dbc/uwfe_2024_bms.dbc", "uwfe_canlogs/2024CAR.dbc",
     ["uwfe_canlogs/A_postregen_193.candump.log.gz", "uwfe_canlogs/B_pitt_autox_24.candump.log.gz"]),
    ("uwfe_inverter_current", "dbc/uwfe_2024_inverter.dbc", "uwfe_canlogs/2024CAR.dbc",
     ["uwfe_canlogs/F_april2025_glitchy_11.TXT.gz"]),
    ("leaf_ze1_can", "dbc/leaf_ze1.dbc", "dbc/leaf/EV-can_ZE1.dbc",
     ["leaf_canlogs/leaf62_drive_2.candump.log.gz", "leaf_canlogs/leaf62_startup.candump.log.gz"]),
    ("orion2_conversion_can", "dbc/orion2_conversion.dbc", "orion2_conversion_candump/ZeroEvDBC_onlyBMS_DU.dbc",
     ["orion2_conversion_candump/candump-2025-11-05_214230.log.gz",
      "orion2_conversion_candump/can0_2025-11-01.asc.gz"])])
def test_the_excerpt_beside_a_map_decodes_what_the_whole_dbc_decodes(name, excerpt, whole, recordings, tmp_path):
    text = (MAPS / f"{name}.toml").read_text()
    assert "VOLTLAP_DATA" not in text
    with_whole = tmp_path / "whole.toml"
    text = text.replace(excerpt, f"{DATA}/{whole}").replace("../../../can_dbc", str(ROOT / "can_dbc"))
    with_whole.write_text(text.replace('"dbc/', f'"{MAPS}/dbc/'))
    for recording in recordings:
        assert show(recording, name) == show(recording, with_whole)


def test_tables_with_groups_and_with_a_second_file():
    channels, _ = show("leaf_cell_ornl/pack6s2p_discharge_1_0c.csv.gz")
    assert {"cell_voltage_6", "temperature_3", "pack_voltage", "current"} <= channels.keys()
    channels, words = show("leaf_cell_ornl/discharge_1C.csv.gz", "leaf_discharge_1c")
    assert channels["ambient"][0] == 22043
    assert any("joined on time" in line for line in words)


def test_bus_recording_is_decoded_at_10_mb_a_second_at_least(tmp_path):
    with gzip.open(Path(DATA) / "uwfe_canlogs/A_postregen_193.candump.log.gz", "rb") as packed:
        text = packed.read()
    log = tmp_path / "long.log"
    log.write_bytes(text)
    begin = time.process_time_ns(), os.times().children_user
    show(log)
    seconds = os.times().children_user - begin[1]
    print(f"{len(text) / 1e6 / seconds:.0f} MB/s of candump text, decoded to 288 channels")
    assert len(text) / 1e6 / seconds > 10
