# SPDX-License-Identifier: Apache-2.0
# These tests start car and firmware as one process; they need no CAN interface.
import pytest

from voltlap_hil.dbc import Dbc
from voltlap_hil.in_process import PROCESS
from voltlap_hil.nodes import ECUS
from voltlap_hil.rig import Bench, Rig


@pytest.fixture(scope="session")
def dbc():
    return Dbc.of_project()


@pytest.fixture
def open_rig(dbc):
    def opened(gateway=False, behind=ECUS, **what):
        return Rig(Bench(PROCESS, PROCESS if gateway else None, behind), dbc=dbc, **what)
    return opened
