# SPDX-License-Identifier: Apache-2.0
import pytest

from voltlap_hil.frame import Frame
from voltlap_hil.trace import Trace

pytest_plugins = ["voltlap_hil.pytest_plugin"]


@pytest.fixture
def frame(dbc):
    """frame("Pedals", 30, Apps1=0.5): a sealed frame at 30 ms."""
    def made(message, time_ms=0.0, counter=0, **values):
        row = dbc.message(message)
        return Frame(row.id, row.seal(row.encode(values), counter), time_ms)
    return made


@pytest.fixture
def trace(dbc, frame):
    """trace(("VehicleIo", 10, {"AirPlusAux": 1}), ...)."""
    def made(*rows):
        return Trace(dbc, [frame(message, time_ms, **values) for message, time_ms, values in rows])
    return made
