# SPDX-License-Identifier: Apache-2.0
"""The fuzzer on the readers, four seconds each, and what it does with a defect.

One reader of each kind of input, and a third of the others, drawn by VOLTLAP_TEST_SEED; all with VOLTLAP_TEST_WHOLE=1:
together they take minutes.
"""
import importlib.util
import json
import os
import pathlib
import random
import subprocess
import sys

import pytest

PROJECT = pathlib.Path(__file__).resolve().parents[2]
COMMAND = PROJECT / "toolchain" / "fuzz.py"
RUN_S = 900
SEED = os.environ.get("VOLTLAP_TEST_SEED") or str(random.randrange(2**32))

sys.path.insert(0, str(COMMAND.parent))  # as when it is run
spec = importlib.util.spec_from_file_location("fuzz", COMMAND)
fuzz = importlib.util.module_from_spec(spec)
sys.modules["fuzz"] = fuzz  # its data classes look for themselves there
spec.loader.exec_module(fuzz)


@pytest.fixture(scope="module")
def fuzzer():
    if not fuzz.has_libfuzzer():
        pytest.skip("no clang++ with libFuzzer: clang and libclang-rt-dev")
    fuzz.build()
    return fuzz.FUZZER


# Tables, CAN text, what a DBC file gives, maps, tracks, plans, drives, scenarios.
EACH_KIND = ("measured_table", "can", "dbc", "role_map", "track", "plan", "drive", fuzz.SCENARIOS)


def drawn(readers):
    if os.environ.get("VOLTLAP_TEST_WHOLE") == "1":
        return readers
    others = [reader for reader in readers if reader not in EACH_KIND]
    assert len(others) + len(EACH_KIND) == len(readers)
    return [*EACH_KIND, *random.Random(SEED).sample(others, (len(others) + 2) // 3)]


@pytest.mark.usefixtures("fuzzer")
def test_seconds_of_drawn_readers_find_nothing(tmp_path):
    readers = drawn([*fuzz.known_targets(), fuzz.SCENARIOS])
    print(f"VOLTLAP_TEST_SEED={SEED}")
    result = tmp_path / "campaigns.json"
    run = subprocess.run([sys.executable, COMMAND, "--each", "4s", "--fresh", "--json", result, *readers],
                         capture_output=True, text=True, timeout=RUN_S)
    assert run.returncode == 0, run.stdout + run.stderr
    campaigns = json.loads(result.read_text())
    assert [*sorted(c["target"] for c in campaigns)] == sorted(readers)
    for campaign in campaigns:
        assert campaign["executions"] > 0 and not campaign["words"], campaign
        assert campaign["coverage"] > 100 or campaign["target"] == fuzz.SCENARIOS, campaign


def test_a_planted_defect_is_found_and_its_input_shows_it_again(tmp_path, fuzzer):
    run = subprocess.run([fuzzer, "--target=planted", "-max_total_time=60", "-max_len=16",
                          f"-artifact_prefix={tmp_path}/"], capture_output=True, text=True)
    found = list(tmp_path.iterdir())
    assert run.returncode != 0 and len(found) == 1, run.stderr
    assert found[0].read_bytes().startswith(b"A") and fuzz.first_words(run.stderr) == "no InputError but: planted"
    again = subprocess.run([fuzzer, "--target=planted", found[0]], capture_output=True, text=True)
    assert again.returncode != 0 and "planted" in again.stderr


@pytest.mark.parametrize(("text", "seconds"), [("10s", 10), ("1.5min", 90), ("1h", 3600)])
def test_a_time_is_read_in_its_unit(text, seconds):
    assert fuzz.duration(text) == seconds


@pytest.mark.parametrize("text", ["", "10", "0s", "-1s", "1 h", "1d", "nan h"])
def test_what_is_no_time_is_refused(text):
    with pytest.raises(fuzz.argparse.ArgumentTypeError, match="expected a time"):
        fuzz.duration(text)
