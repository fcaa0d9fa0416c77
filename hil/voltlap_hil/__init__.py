# SPDX-License-Identifier: Apache-2.0
"""Hardware-in-the-loop harness of Voltlap: see README.md beside this package."""
from .bus import Bus
from .checks import Check, Result
from .dbc import Dbc
from .errors import HilError, InputError
from .scenario import Rig
from .scenario_file import Scenario, load

__all__ = ["Bus", "Check", "Dbc", "HilError", "InputError", "Result", "Rig", "Scenario", "load"]
