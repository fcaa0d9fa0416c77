# SPDX-License-Identifier: Apache-2.0
import subprocess
import sys
from pathlib import Path

import pytest

import voltlap_hil


@pytest.mark.parametrize("name", voltlap_hil.__all__)
def test_every_public_name_is_there(name):
    assert getattr(voltlap_hil, name).__name__ == name


def test_a_name_that_is_not_there_is_an_error():
    with pytest.raises(AttributeError):
        voltlap_hil.Buss


def test_help_of_the_monitor_needs_no_other_package():
    program = Path(voltlap_hil.__file__).parents[1] / "monitor.py"
    run = subprocess.run([sys.executable, "-S", program, "--help"], capture_output=True, text=True)
    assert run.returncode == 0 and "--bus IF" in run.stdout, run.stderr
