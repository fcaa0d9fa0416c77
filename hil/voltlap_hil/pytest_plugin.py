# SPDX-License-Identifier: Apache-2.0
"""For plain pytest: fixture `rig`, a started run on --channel; fixture `open_rig` for one with faults or arguments.

A conftest.py takes it in with `pytest_plugins = ["voltlap_hil.pytest_plugin"]`.
"""
from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import pytest

from .dbc import Dbc
from .nodes import ECUS
from .rig import Bench, Rig


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("voltlap_hil")
    group.addoption("--channel", default="vcan0", help="CAN channel of the plant (vcan0); can0: a real bus")
    group.addoption("--far", default="vcan1", help="CAN channel behind the fault gateway (vcan1)")


@pytest.fixture(scope="session")
def dbc() -> Dbc:
    return Dbc.of_project()


@pytest.fixture
def open_rig(request: pytest.FixtureRequest, dbc: Dbc) -> Iterator[Callable[..., Rig]]:
    """open_rig(gateway=True, behind=["bms"], arguments=[...], ...): as Rig, on the channels of the command line."""
    rigs: list[Rig] = []
    channel = request.config.getoption("--channel")

    def opened(gateway: bool = False, behind: Sequence[str] = ECUS, **what: object) -> Rig:
        far = request.config.getoption("--far") if gateway else None
        bench = Bench(channel, far, behind, start=channel.startswith("vcan"))
        rigs.append(Rig(bench, dbc=dbc, **what))  # type: ignore[arg-type]
        return rigs[-1]

    yield opened
    for rig in rigs:
        rig.close()


@pytest.fixture
def rig(open_rig: Callable[..., Rig]) -> Rig:
    return open_rig()
