# SPDX-License-Identifier: Apache-2.0
"""Hardware-in-the-loop harness of Voltlap: see README.md beside this package.

Names are imported when they are asked for, so that a command line can print its help without any other package.
"""
from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .bus import Bus
    from .checks import Check, Result
    from .dbc import Dbc
    from .errors import HilError, InputError
    from .rig import Bench, Rig
    from .scenario_file import Scenario, load

__all__ = ["Bench", "Bus", "Check", "Dbc", "HilError", "InputError", "Result", "Rig", "Scenario", "load"]
_HOME = {"Bench": "rig", "Bus": "bus", "Check": "checks", "Result": "checks", "Dbc": "dbc", "HilError": "errors",
         "InputError": "errors", "Rig": "rig", "Scenario": "scenario_file", "load": "scenario_file"}


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_HOME[name]}", __name__), name)
