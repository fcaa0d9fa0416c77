# SPDX-License-Identifier: Apache-2.0
"""The test runner counts what it is told, and takes silence, crashes and empty suites for failures."""
import concurrent.futures
import json
import os
import pathlib
import signal
import subprocess
import sys
import threading
import time

import pytest
from copies import HANG_S, hear_interruptions

PROJECT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(PROJECT / "toolchain"))
import run_tests  # noqa: E402  (the folder of the runner is no package)


def cpputest(prints, code=0):
    script = f"import sys; print({prints!r}); sys.exit({code})"
    outcome = run_tests.run_cpputest("suite", [sys.executable, "-c", script], PROJECT)
    return outcome.passed, outcome.failed, outcome.skipped


CPPUTEST = {
    "all well": ("OK (5 tests, 5 ran, 9 checks, 0 ignored, 0 filtered out, 1 ms)", 0, (5, 0, 0)),
    "one ignored": ("OK (5 tests, 4 ran, 9 checks, 1 ignored, 0 filtered out, 1 ms)", 0, (4, 0, 1)),
    "two failed": ("Errors (2 failures, 5 tests, 5 ran, 9 checks, 0 ignored, 0 filtered out, 1 ms)", 2, (3, 2, 0)),
    "bad exit code, good summary": ("OK (5 tests, 5 ran, 9 checks, 0 ignored, 0 filtered out, 1 ms)", 3, (4, 1, 0)),
    "nothing ran": ("OK (0 tests, 0 ran, 0 checks, 0 ignored, 0 filtered out, 1 ms)", 0, (0, 1, 0)),
    "crash before the summary": ("..", -11, (0, 1, 0)),
}


@pytest.mark.parametrize("prints, code, counts", CPPUTEST.values(), ids=CPPUTEST.keys())
def test_cpputest_suite_is_counted_by_its_single_tests(prints, code, counts):
    assert cpputest(prints, abs(code)) == counts


def test_command_that_cannot_be_started_has_failed():
    outcome = run_tests.run_cpputest("suite", ["./no-such-suite"], PROJECT)
    assert (outcome.passed, outcome.failed) == (0, 1)


def test_pytest_suite_is_counted_by_its_single_tests(tmp_path):
    (tmp_path / "some_test.py").write_text(
        "import pytest\n"
        "def test_good(): pass\n"
        "def test_bad(): assert False\n"
        "def test_absent(): pytest.skip('no data here')\n")
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(tmp_path)]
    outcome = run_tests.run_pytest("suite", command, tmp_path, None)
    assert (outcome.passed, outcome.failed, outcome.skipped) == (1, 1, 1)
    assert outcome.skips == ("no data here",)


def test_suites_that_take_long_start_first_the_others_in_their_order():
    suites = [{"name": name, "properties": [{"name": "LABELS", "value": ["pytest"]},
                                            *([{"name": "COST", "value": cost}] if cost else [])]}
              for name, cost in (("a", 0), ("b", 60.0), ("c", 0), ("d", 200.0))] + [{"name": "e"}]
    assert [suite["name"] for suite in run_tests.longest_first(suites)] == ["d", "b", "a", "c", "e"]


def test_pytest_folder_without_tests_has_failed(tmp_path):
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(tmp_path)]
    assert run_tests.run_pytest("suite", command, tmp_path, None).failed == 1


def test_hanging_suite_has_failed(monkeypatch):
    monkeypatch.setattr(run_tests, "SUITE_TIMEOUT_S", 0.2)
    outcome = run_tests.run_cpputest("suite", [sys.executable, "-c", "import time; time.sleep(10000)"], PROJECT)
    assert (outcome.passed, outcome.failed) == (0, 1)


def test_suites_of_a_run_in_the_background_hear_an_interruption(tmp_path):
    ctest = tmp_path / "ctest"
    suite = {"name": "interrupts itself", "command": ["sh", "-c", "kill -INT $$; exit 0"]}
    ctest.write_text(f"#!/bin/sh\necho '{json.dumps({'tests': [suite]})}'\n")
    ctest.chmod(0o755)
    run = subprocess.run([sys.executable, run_tests.__file__], capture_output=True, text=True,
                         env={**os.environ, "PATH": f"{tmp_path}:{os.environ['PATH']}"}, timeout=HANG_S,
                         preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_IGN))
    assert "0 passed, 1 failed" in run.stdout, "the suite should have died of its own interruption"


def test_a_suite_that_began_just_before_an_interruption_hears_it_and_none_begins_after(monkeypatch):
    """The terminal's signal comes once: a worker that is free by it may start the next suite before it is told."""
    monkeypatch.setattr(run_tests, "_interrupted", threading.Event())
    hears = "signal.signal(signal.SIGINT, signal.default_int_handler)"
    endless = [sys.executable, "-c", f"import signal, time; {hears}\nwhile True: time.sleep(0.1)"]
    with concurrent.futures.ThreadPoolExecutor(1) as pool:
        running = pool.submit(run_tests.call, endless, ".")
        while not run_tests._running:
            time.sleep(0.01)
        time.sleep(0.5)
        run_tests.interrupt_the_young()
        code, _ = running.result(timeout=HANG_S)
    assert code != 0 and not run_tests._running
    assert run_tests.call(endless, ".") == (130, "interrupted")


def test_interruption_ends_the_run_without_starting_more(tmp_path):
    started = [tmp_path / f"started_{n}" for n in range(2 * os.cpu_count())]
    # Not a shell, which may lose an interruption while it starts its second command; and short sleeps: a signal that
    # comes between Python's last look at signals and the sleep itself is heard at the end of the sleep.
    suites = [{"name": path.name, "command": [
        sys.executable, "-c", f"import time; open('{path}', 'w')\nfor _ in range(100_000): time.sleep(0.1)"]}
              for path in started]
    ctest = tmp_path / "ctest"
    (tmp_path / "suites.json").write_text(json.dumps({"tests": suites}))
    ctest.write_text(f"#!/bin/sh\ncat {tmp_path}/suites.json\n")
    ctest.chmod(0o755)
    environment = {**os.environ, "PATH": f"{tmp_path}:{os.environ['PATH']}"}
    run = subprocess.Popen([sys.executable, run_tests.__file__], env=environment,
                           stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True,
                           preexec_fn=hear_interruptions)
    while sum(path.exists() for path in started) < os.cpu_count():
        assert run.poll() is None
        time.sleep(0.02)
    os.killpg(run.pid, signal.SIGINT)  # as a terminal does
    output, error = run.communicate(timeout=HANG_S)  # the suites would go on for hours
    assert run.returncode == 130 and "Traceback" not in error and "passed," not in output
    assert not all(path.exists() for path in started)
