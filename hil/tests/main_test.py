# SPDX-License-Identifier: Apache-2.0
import pathlib
import subprocess
import sys

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


def test_every_file_with_a_mistake_is_told_and_nothing_runs(file, capsys):
    for name, (old, new) in {"a": ("run:", "rnu:"), "b": ("10 ms", "0 ms"), "c": ("x", "y")}.items():
        (file.parent / f"{name}.yaml").write_text(SCENARIO.replace(old, new, 1))
    for more in (["--check-only"], []):
        assert main(["run", str(file.parent), *more]) == 2
        out = capsys.readouterr()
        assert f"{file.parent}/a.yaml:3: when[0].rnu" in out.err and f"{file.parent}/b.yaml:3: when[0].run" in out.err
        assert "2 of 4 scenario files have mistakes, and nothing was run" in out.err
        assert "[1/" not in out.err and not out.out


@pytest.mark.parametrize("arguments", [[""], ["s.yaml", "--record", ""], ["s.yaml", "--report", ""]])
def test_an_empty_name_is_no_file(arguments, capsys):
    with pytest.raises(SystemExit) as ended:
        main(["run", *arguments])
    assert ended.value.code == 2 and "found an empty name, expected a file" in capsys.readouterr().err


@pytest.mark.parametrize("more, complaint", [
    (["--record", "none/x.log"], "--record none/x.log: cannot write: no folder none"),
    (["--record", "x.txt"], "--record x.txt: found .txt, expected one of .log, .asc, .blf"),
    (["--report", "none/x.md"], "--report none/x.md: cannot write: no folder none")])
def test_where_nothing_can_be_written_is_told_before_anything_runs(file, capsys, more, complaint):
    assert main(["run", str(file), "--check-only", *more]) == 2
    assert complaint in capsys.readouterr().err


def test_dbc_files_that_cannot_be_read_are_told(file, capsys, monkeypatch, tmp_path):
    monkeypatch.setenv("VOLTLAP_CAN_DBC", str(tmp_path / "dbc"))
    assert main(["run", str(file), "--check-only"]) == 2
    assert "no car.dbc in" in capsys.readouterr().err
    (tmp_path / "dbc").mkdir()
    (tmp_path / "dbc" / "car.dbc").write_text("VERSION 1")
    assert main(["run", str(file), "--check-only"]) == 2
    assert "found what is no DBC file that can be read" in capsys.readouterr().err


def test_all_mistakes_of_a_file_are_told_in_one_go_until_they_are_too_many(file, capsys):
    file.write_text(SCENARIO.replace("run: 10 ms", "run: 0 ms\n  - kill: hil").replace("1 s", "1 h"))
    assert main(["run", str(file), "--check-only"]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert [line.split(": ")[1] for line in lines] == [f"{file}:{n}" for n in (3, 4, 6)]
    file.write_text(SCENARIO.replace("  - run: 10 ms\n", "  - rnu: 10 ms\n" * 3000))
    assert main(["run", str(file), "--check-only"]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 21 and "more may follow" in lines[-1]


def test_a_name_too_long_for_a_file_is_told(capsys):
    assert main(["run", "x" * 300, "--check-only"]) == 2
    assert "File name too long" in capsys.readouterr().err


@pytest.mark.parametrize("program", ["", "faults.py", "swarm.py", "monitor.py"])
def test_help_needs_no_package_and_what_does_says_so_with_code_4(program):
    """-S: no package but Python's own."""
    path = pathlib.Path(__file__).resolve().parents[1] / program
    bare = [sys.executable, "-S", str(path)]
    done = subprocess.run([*bare, "--help"], capture_output=True, text=True)
    assert done.returncode == 0 and "Exit code" in done.stdout and not done.stderr
    use = {"": ["run", "x.yaml"], "monitor.py": ["--bus", "vcan0"]}.get(program, [])
    done = subprocess.run([*bare, *use], capture_output=True, text=True)
    assert done.returncode == 4 and "is missing" in done.stderr and "pip install" in done.stderr


def test_an_interface_that_is_missing_is_no_wrong_reaction(file, capsys):
    assert main(["run", str(file), "--channel", "vcan9"]) == 3
    out = capsys.readouterr()
    assert "could not run" in out.out and "vcan9" in out.out and "with-vcan" in out.out and "WRONG" not in out.out


def test_a_car_that_is_not_there_is_told(file, capsys):
    assert main(["run", str(file), "--vehicle", "no_such_car", "--channel", "process"]) == 2
    assert "no_such_car" in capsys.readouterr().err
