# SPDX-License-Identifier: Apache-2.0
"""Logs with the defects that real ones have: read, masked with the reason, counted, and judged all the same."""
import json
import re

import pytest
from drives import Drives, explained, voltlap, write

IDS = ("6B0", "6B1", "036")


def checksum(identifier, data):
    return (identifier + 8 + sum(data[:7])) & 0xFF


@pytest.fixture(scope="module")
def frames(tmp_path_factory):
    """[(time, id, bytes)] of the battery of a car that drives two laps."""
    log = tmp_path_factory.mktemp("bus") / "drive.log"
    voltlap("endurance", "--laps", 2, "--candump", log)
    out = []
    for line in open(log, encoding="ascii"):
        time, identifier, data = re.match(r"\((\S+)\) \S+ (\w+)#(\w*)", line).groups()
        if identifier in IDS:
            out.append((float(time), int(identifier, 16), bytes.fromhex(data)))
    return out


@pytest.fixture(scope="module")
def drive(tmp_path_factory):
    return Drives(tmp_path_factory.mktemp("drives"))


def candump(frames):
    return "".join(f"({t:.6f}) can0 {i:0{8 if i > 0x7FF else 3}X}#{d.hex().upper()}\n" for t, i, d in frames)


def vector_asc(frames):
    head = "date Sun Nov 22 10:00:00.000 am 2026\nbase hex  timestamps absolute\nno internal events logged\n"
    return head + "".join(f"{t:11.6f} 1  {i:X}{'x' if i > 0x7FF else ''}  Rx   d {len(d)} {d.hex(' ').upper()}\n"
                          for t, i, d in frames)


def raw_hex(frames):
    return "".join(f"{round(1000 * t):08X}x{i:08X}{d.hex().upper()}\n" for t, i, d in frames)


def told(folder, text, name="drive.log", roles="orion_factory_can", report=False):
    """The answer, and all that was said of the log."""
    log, out = folder / name, folder / "out.json"
    log.write_text(text, encoding="ascii")
    page = folder / "r.html"
    run = voltlap("explain", log, "--model", "vtm16e", "--map", roles, "--json", out,
                  *(("--report", page) if report else ()))
    answer = json.loads(out.read_text())
    answer["said"] = run.stdout
    assert not report or all(m["reason"] in page.read_text() for m in answer["masked"][:50])
    return answer


def reasons(answer, channel):
    return {m["reason"] for m in answer["masked"] if m["channel"] == channel}


@pytest.mark.parametrize("form, name", [(candump, "drive.log"), (vector_asc, "drive.asc"), (raw_hex, "DRIVE.TXT")])
def test_three_forms_of_a_bus_log_give_one_answer_with_cells_at_their_own_time(tmp_path, frames, form, name):
    answer = told(tmp_path, form(frames), name)
    assert answer["verdict"] == "no_discrepancy", answer["sentence"]
    assert "read in turn" in answer["said"]
    assert answer["gain"]["voltage"]["heldout_rms_before"] < 5e-3  # held without regard to their age: 45 mV


def changed(frames, change):
    return [change(k, *frame) for k, frame in enumerate(frames)]


def with_cells(frames, volts, cell=2):
    """Every 50th reading of a cell is impossible."""
    turn = iter(range(10**9))

    def change(_, t, i, d):
        if i != 0x036 or d[0] != cell or next(turn) % 50:
            return t, i, d
        data = bytes([d[0]]) + round(volts * 1e4).to_bytes(2, "big") + d[3:7]
        return t, i, data + bytes([checksum(i, data)])

    return changed(frames, change)


@pytest.mark.parametrize("volts", [0.0, 0.51, 4.48, 6.55])
def test_cells_that_read_what_no_cell_has_are_masked(tmp_path, frames, volts):
    answer = told(tmp_path, candump(with_cells(frames, volts)), report=volts == 0.51)
    assert any("impossible" in why or "no reading" in why for why in reasons(answer, "cell_voltage_3")), volts
    assert answer["verdict"] != "bad_data"


def test_a_clock_that_jumps_back_once_is_said(tmp_path, frames):
    middle = len(frames) // 2
    back = changed(frames, lambda k, t, i, d: (t - 0.995 if middle <= k < middle + 40 else t, i, d))
    answer = told(tmp_path, candump(back))
    assert "40 x out of order, sorted" in answer["said"]


def test_frames_with_a_wrong_checksum_are_counted(tmp_path, frames):
    bad = changed(
        frames, lambda k, t, i, d: (t, i, d[:2] + bytes([d[2] ^ 0x40]) + d[3:] if k % 997 == 0 else d))
    assert "checksum" in told(tmp_path, candump(bad))["said"]


def test_frames_of_all_ones_and_frames_that_are_too_short_are_not_values(tmp_path, frames):
    ones = changed(frames, lambda k, t, i, d: (t, i, b"\xff" * 8) if k % 501 == 0 else (t, i, d))
    assert re.search("checksum|invalid", told(tmp_path, candump(ones))["said"])
    short = changed(frames, lambda k, t, i, d: (t, i, d[:3]) if k % 501 == 0 else (t, i, d))
    assert re.search("checksum|short", told(tmp_path, candump(short))["said"])


def test_lines_that_are_cut_or_no_frames_are_counted(tmp_path, frames):
    lines = candump(frames).splitlines()
    lines[1000:1000] = ["(12.3) can0 6B0", "garbage", "(12.4) can0 6B0#12345"]
    said = told(tmp_path, "\n".join(lines) + "\n(99.1) can0 6B")["said"]
    assert re.search(r"lines?", said), said


COUNTED = """VERSION ""
BU_: BMS
BO_ {identifier} PACK: 8 BMS
 SG_ Current : 7|16@0- (0.1,0) [-3276.8|3276.7] "A" BMS
 SG_ Voltage : 23|16@0+ (0.1,0) [0|6553.5] "V" BMS
 SG_ Counter : 39|8@0+ (1,0) [0|255] "" BMS
"""


def test_lost_frames_are_told_by_a_counter_on_an_extended_identifier(tmp_path, frames):
    identifier = 0x18FF06B0
    (tmp_path / "team.dbc").write_text(COUNTED.format(identifier=identifier | 0x80000000))
    (tmp_path / "team.toml").write_text("[roles]\n" + "".join(
        f'{role} = {{frame = {identifier:#x}, signal = "{signal}", dbc = "team.dbc", counter = "Counter", '
        f'unit = "{unit}"}}\n'
        for role, signal, unit in (("current", "Current", "A"), ("pack_voltage", "Voltage", "V"))))
    pack = [(t, identifier, d[:4] + bytes([k & 0xFF]) + d[5:]) for k, (t, _, d) in
            enumerate(frame for frame in frames if frame[1] == 0x6B0)]
    kept = [frame for k, frame in enumerate(pack) if not 5000 <= k < 5020]
    answer = told(tmp_path, candump(kept), roles=tmp_path / "team.toml")
    assert "lost frames by the counter" in answer["said"] and "lost frames by the counter" in reasons(answer, "current")


# ---- tables ----

def test_a_frozen_cell_is_said_in_words(tmp_path, drive):
    rows = drive()
    held = {"cell_voltage_3_v": rows[1000]["cell_voltage_3_v"]}
    answer = explained(tmp_path, [{**row, **held} if 1000 <= k < 1300 else row for k, row in enumerate(rows)])
    assert "frozen" in " ".join(reasons(answer, "cell_voltage_3"))
    assert "cell_voltage" not in answer["sentence"]


def test_a_clock_that_stands_or_jumps_back_a_gap_and_empty_cells_are_said(tmp_path, drive):
    rows = [dict(row) for row in drive()]
    rows[2000]["time_s"] = rows[1999]["time_s"]
    rows[2100]["time_s"] -= 0.995
    rows = rows[:3000] + rows[3080:]
    log = write(tmp_path / "log.csv", rows)
    lines = log.read_text().splitlines()
    for k in range(500, 520):
        parts = lines[k].split(",")
        parts[4] = ""
        lines[k] = ",".join(parts)
    log.write_text("\n".join(lines) + "\n")
    out = tmp_path / "out.json"
    said = voltlap("explain", log, "--model", "vtm16e", "--json", out).stdout
    answer = json.loads(out.read_text())
    assert answer["verdict"] == "no_discrepancy" or answer["causes"][0]["name"] == "dropped_or_late_frames"
    assert "from 300.0 to 308.1 s, gap" in said and "1 rows: out of order, sorted, first in row 2101" in said
    assert re.search(r"cell 2: 19 of \d{4} rows without a value", said)


def test_a_log_that_is_too_short_says_what_drive_would_tell(tmp_path, drive):
    answer = explained(tmp_path, drive()[:400])
    assert answer["verdict"] == "bad_data" and "too short" in answer["sentence"] and "two laps" in answer["next_test"]
