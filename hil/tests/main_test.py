# SPDX-License-Identifier: Apache-2.0
import pytest

from voltlap_hil.__main__ import main

SCENARIO = "scenario: x\nwhen:\n  - run: 10 ms\nthen:\n  - torque_zero_within: 1 s\n"


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "s.yaml"
    path.write_text(SCENARIO)
    return path


@pytest.mark.parametrize("more, complaint", [
    (["--report", "x.pdf"], "expected a name that ends in .xml, .md, .html"),
    (["--channel", "vcan9", "--nodes", "running"], "cannot open CAN interface 'vcan9'")])
def test_what_cannot_be_done_ends_with_a_reason(file, capsys, more, complaint):
    code = main(["run", str(file), *more])
    out = capsys.readouterr()
    assert code == (3 if "channel" in more[0] else 2) and complaint in out.err + out.out


def test_a_bad_file_ends_with_code_2_and_its_place(file, capsys):
    file.write_text(SCENARIO.replace("run:", "rnu:"))
    assert main(["run", str(file)]) == 2
    assert f"{file}:3: when[0].rnu: found 'rnu', expected one of start_up" in capsys.readouterr().err


def test_files_can_be_checked_without_a_bus(file, capsys):
    assert main(["run", str(file.parent), "--check-only"]) == 0
    assert "1 scenario files are right" in capsys.readouterr().out


def test_an_empty_folder_is_told(tmp_path, capsys):
    assert main(["run", str(tmp_path)]) == 2
    assert "no .yaml file in" in capsys.readouterr().err


def test_a_recording_is_of_one_scenario(file, capsys):
    assert main(["run", str(file), str(file), "--record", "x.log"]) == 2
    assert "--record takes one scenario, found 2" in capsys.readouterr().err


def test_a_fault_of_the_bus_needs_a_second_channel(file, capsys):
    file.write_text(SCENARIO.replace("run: 10 ms", "gateway: {drop: Pedals}"))
    assert main(["run", str(file), "--channel", "can0"]) == 2
    assert "name the channel behind the gateway with --far" in capsys.readouterr().err
