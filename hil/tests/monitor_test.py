# SPDX-License-Identifier: Apache-2.0
import json
import random
import subprocess
import sys
from pathlib import Path

import pytest

from voltlap_hil.monitor import main
from voltlap_hil.record import Recorder


@pytest.fixture(params=[".log", ".asc", ".blf"])
def log(request, tmp_path, frame):
    path = tmp_path / f"run{request.param}"
    with Recorder(path, "vcan0") as record:
        record.write(frame("BmsLimits", 1000.0 + 10.0 * i, counter=i, DischargeLimit=float(i),
                           DischargeReason="Temperature") for i in range(200))
    return path


def test_log_is_shown_as_at_its_end(log, capsys):
    assert main(["--log", str(log), "--json"]) == 0
    snapshot = json.loads(capsys.readouterr().out)
    assert snapshot["limits"][0] == {"what": "discharge", "value": 199.0, "unit": "A", "reason": "Temperature",
                                     "cell": 0}
    assert snapshot["channel"] == str(log) and snapshot["time_s"] == pytest.approx(1.99, abs=0.01)
    assert snapshot["messages"]["BmsLimits"]["counter_gaps"] == 0


def test_log_is_shown_as_it_was_at_a_time(log, capsys):
    assert main(["--log", str(log), "--at", "0.505", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["limits"][0]["value"] == 50.0


def test_text_has_limit_reason_state_and_lost_nodes(log, capsys):
    assert main(["--log", str(log)]) == 0
    text = capsys.readouterr().out
    assert "199 A" in text and "Temperature" in text and "never" in text and "BmsLimits" in text
    assert "\x1b" not in text


@pytest.mark.parametrize("arguments, complaint", [
    (["--log", "nowhere.log"], "No such file"), (["--bus", "vcan9", "--once"], "cannot open CAN interface 'vcan9'"),
    (["--bus", "vcan0", "--json"], "give --once too"), (["--bus", "vcan0", "--at", "1"], "give --log FILE too")])
def test_what_cannot_be_done_ends_with_a_reason(arguments, complaint, capsys):
    assert main(arguments) in (2, 3)
    assert complaint in capsys.readouterr().err


def test_text_that_is_no_log_is_refused(tmp_path, capsys):
    path = tmp_path / "x.log"
    path.write_text("this is no log\n")
    assert main(["--log", str(path)]) == 2
    assert str(path) in capsys.readouterr().err


def test_any_damage_to_a_log_is_told_or_passed_over(log, capsys):
    seed = random.randrange(2**32)
    draw, good = random.Random(seed), log.read_bytes()
    for number in range(8):
        data = bytearray(good[:draw.randrange(len(good))] if draw.random() < 0.3 else good)
        for _ in range(draw.choice((1, 3, 10)) if data else 0):
            at = draw.randrange(len(data))
            data[at:at + 1] = draw.choice((b"", b"9" * 20, b"#", b"nan", b"\xff", b"\0", b"\n", bytes([data[at] ^ 1])))
        log.write_bytes(data)
        try:
            assert main(["--log", str(log), "--json"]) in (0, 2)
        except Exception as error:
            raise AssertionError(f"seed {seed}, file {number}: {error!r}") from error
        capsys.readouterr()


def test_empty_log_is_told(tmp_path, capsys):
    path = tmp_path / "x.log"
    path.touch()
    assert main(["--log", str(path)]) == 2
    assert "found no frame" in capsys.readouterr().err


@pytest.mark.parametrize("arguments", [[], ["--bus", "vcan0", "--log", "x.log"], ["--bus", "vcan0", "--wait", "-1"]])
def test_usage_errors_end_with_code_2(arguments):
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    assert ended.value.code == 2


def test_missing_python_package_is_named_with_what_installs_it():
    program = Path(__file__).parents[1] / "monitor.py"
    run = subprocess.run([sys.executable, "-c", f"import sys, runpy; sys.modules['can'] = None;"
                          f"sys.path.insert(0, {str(program.parent)!r}); sys.argv = ['monitor.py', '--log', 'x.log'];"
                          f"runpy.run_path({str(program)!r}, run_name='__main__')"], capture_output=True, text=True)
    assert run.returncode != 0
    assert "package can is missing" in run.stderr and "pip install" in run.stderr
