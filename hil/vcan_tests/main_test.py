# SPDX-License-Identifier: Apache-2.0
"""The command line on a real bus."""
import os
import subprocess
from pathlib import Path

import pytest

from voltlap_hil.__main__ import main

SCENARIOS = Path(__file__).resolve().parents[1] / "scenarios"


def test_a_scenario_runs_with_report_and_recording(tmp_path, capsys):
    files = {name: tmp_path / name for name in ("r.xml", "r.md", "r.html", "run.log")}
    code = main(["run", str(SCENARIOS / "pedals_lost.yaml"), "--record", str(files["run.log"]),
                 *(word for name in ("r.xml", "r.md", "r.html") for word in ("--report", str(files[name])))])
    out = capsys.readouterr()
    assert code == 0 and "as it must be  Lost pedals stop the torque" in out.out
    assert "held: torque zero: 60 ms, bound 100 ms" in out.out
    assert "gateway: drop" in out.err
    assert all(path.stat().st_size > 100 for path in files.values())


def test_a_recorded_scenario_is_replayed_by_the_firmware_byte_for_byte(tmp_path):
    """What the plant's fault did is in its frames. `voltlap` is that of the build that runs the tests."""
    voltlap, log = Path(os.environ["VOLTLAP_BUILD_DIR"]) / "bin/voltlap", tmp_path / "run.log"
    assert main(["run", str(SCENARIOS / "cell_voltage_low.yaml"), "--record", str(log)]) == 0
    replay = subprocess.run([voltlap, "replay", log], capture_output=True, text=True, timeout=60)
    assert replay.returncode == 0, replay.stdout + replay.stderr
    assert "answered as recorded, byte for byte" in replay.stdout and "CellVoltageLow (bms)" in replay.stdout


def test_without_its_event_the_same_checks_must_fail(capsys):
    assert main(["run", str(SCENARIOS / "pedals_lost.yaml"), "--without-event"]) == 0
    assert "not held: torque zero: never, bound 100 ms" in capsys.readouterr().out


def test_a_check_that_fails_ends_with_code_1(tmp_path, capsys):
    text = (SCENARIOS / "pedals_lost.yaml").read_text().replace("zero_within: 100 ms", "zero_within: 50 ms")
    (tmp_path / "s.yaml").write_text(text)
    assert main(["run", str(tmp_path / "s.yaml")]) == 1
    out = capsys.readouterr().out
    assert "WRONG" in out and "not held: torque zero: 60 ms, bound 50 ms" in out


def test_a_condition_that_never_comes_ends_with_code_3(tmp_path, capsys):
    text = (SCENARIOS / "pedals_lost.yaml").read_text().replace("> {full_current} A", "> 600 A")
    (tmp_path / "s.yaml").write_text(text)
    assert main(["run", str(tmp_path / "s.yaml")]) == 3
    assert "'InverterStatus.PhaseCurrent > 600 A' did not come within 1000 ms" in capsys.readouterr().out


@pytest.mark.parametrize("channel", ["vcan0"])
def test_nobody_on_the_bus_is_told(tmp_path, capsys, channel):
    assert main(["run", str(SCENARIOS / "pedals_lost.yaml"), "--channel", channel, "--nodes", "running"]) == 3
    assert "never heard" in capsys.readouterr().out
