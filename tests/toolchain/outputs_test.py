# SPDX-License-Identifier: Apache-2.0
"""A file that cannot be written is told before the work, by every program of toolchain/ that takes one."""
import pathlib
import re
import subprocess
import sys
import time

import pytest

TOOLCHAIN = pathlib.Path(__file__).resolve().parents[2] / "toolchain"
FLAG = re.compile(r"""add(?:_argument)?\("(--(?:json|csv|write|output))\"""")
EVERY = [(path.name, flag) for path in sorted(TOOLCHAIN.glob("*.py")) for flag in FLAG.findall(path.read_text())]


def test_there_are_such_programs():
    assert len(EVERY) >= 10 and ("image_budgets.py", "--write") in EVERY


@pytest.mark.parametrize("program, flag", EVERY)
def test_it_is_told_at_once_and_in_words(program, flag, tmp_path):
    begin = time.monotonic()
    done = subprocess.run([sys.executable, TOOLCHAIN / program, flag, "nowhere/file"], cwd=tmp_path,
                          capture_output=True, text=True, timeout=60)
    assert done.returncode == 2 and "nowhere" in done.stderr and flag in done.stderr
    assert "Traceback" not in done.stderr and time.monotonic() - begin < 20.0
