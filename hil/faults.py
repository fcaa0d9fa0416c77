# SPDX-License-Identifier: Apache-2.0
"""Starts the fault matrix where the package is not installed: `voltlap faults`."""
import sys

try:
    from voltlap_hil.fault_main import main

    sys.exit(main())
except ModuleNotFoundError as error:
    sys.exit(f"voltlap faults: the Python package {error.name} is missing. `pip install -r "
             "toolchain/requirements/run.txt -r toolchain/requirements/hil.txt` installs it, and so does "
             "./voltlap faults.")
