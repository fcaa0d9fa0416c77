# SPDX-License-Identifier: Apache-2.0
"""Starts the swarm where the package is not installed: `voltlap swarm`."""
import sys

try:
    from voltlap_hil.swarm_main import main

    sys.exit(main())
except ModuleNotFoundError as error:
    sys.exit(f"voltlap swarm: the Python package {error.name} is missing. `pip install -r "
             "toolchain/requirements/run.txt -r toolchain/requirements/hil.txt` installs it, and so does "
             "./voltlap swarm.")
