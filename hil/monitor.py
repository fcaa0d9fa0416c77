# SPDX-License-Identifier: Apache-2.0
"""Starts the monitor where the package is not installed: `voltlap monitor`."""
import sys

try:
    from voltlap_hil.monitor import main

    sys.exit(main())
except ModuleNotFoundError as error:
    print(f"voltlap monitor: the Python package {error.name} is missing. `pip install -r "
          "toolchain/requirements/run.txt -r toolchain/requirements/hil.txt` installs it, and so does "
          "./voltlap monitor.", file=sys.stderr)
    sys.exit(4)
