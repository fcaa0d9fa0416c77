#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Stands in for an engine in the tests of the mirror: it always says the one verdict that its file name holds."""

import json
import sys
from pathlib import Path

verdict = "named" if "named" in Path(sys.argv[0]).name else "no_discrepancy"
options = sys.argv[1:]
cause = {"name": "series_resistance", "equivalent_to": [], "share_of_residual": 1.0, "probability": 1.0, "d_prime": 9.0,
         "parameters": {"resistance_ohm": {"value": 1e-4, "ci95_low": 0.0, "ci95_high": 1.0, "unit": "ohm"}}}
answer = {"verdict": verdict, "sentence": "", "causes": [cause] if verdict == "named" else [], "unknown_in": None,
          "gain": {}, "masked": [], "next_test": None, "extended_model": None, "mode": "absolute", "seed": 1,
          "version": "stand-in"}
Path(options[options.index("--json") + 1]).write_text(json.dumps(answer))
