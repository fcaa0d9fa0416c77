# SPDX-License-Identifier: Apache-2.0
"""A real browser for the suites that look at reports."""
import pathlib
import sys

import pytest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "toolchain"))
from chromium import Chromium, find_chromium  # noqa: E402


@pytest.fixture(scope="module")
def browser():
    if not find_chromium():
        pytest.skip("no Chromium on this machine; `./voltlap test` installs the package chromium where there is one")
    with Chromium() as started:
        yield started
