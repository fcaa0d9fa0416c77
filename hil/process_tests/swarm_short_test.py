# SPDX-License-Identifier: Apache-2.0
"""A short swarm, from another seed each time; VOLTLAP_TEST_SEED repeats it."""
import os
import random
import subprocess
import sys
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[2]
SEED = os.environ.get("VOLTLAP_TEST_SEED") or str(random.randrange(2**32))
RUNS = 40


def swarm(*arguments):
    return subprocess.run([sys.executable, PROJECT / "hil" / "swarm.py", *map(str, arguments)], capture_output=True,
                          text=True, timeout=600)


def test_a_short_swarm_breaks_nothing():
    print(f"VOLTLAP_TEST_SEED={SEED}")
    done = swarm("--runs", RUNS, "--seconds", 300, "--seed", int(SEED) % 2**32)
    assert done.returncode == 0, done.stdout
    assert f"{RUNS} scenarios" in done.stdout


def test_the_seed_is_said_before_anything_is_driven():
    assert swarm("--runs", 1, "--seed", 17).stdout.startswith("seed 17\n")
    assert swarm("--runs", 1).stdout.startswith("seed ")


def test_a_mistake_on_the_command_line_is_told():
    done = swarm("--seconds", "soon")
    assert done.returncode == 2
    assert "found 'soon', expected a whole number" in done.stderr
