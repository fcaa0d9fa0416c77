#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Starts the mutants of the firmware where their package is not installed: `voltlap mutate`."""
import sys

from mutation.options import arguments

arguments()  # help and mistakes need no other package
try:
    from mutation.main import main
except ModuleNotFoundError as error:
    print(f"voltlap mutate: the Python package {error.name} is missing. `pip install -r "
          "toolchain/requirements/mutate.txt` installs it, and so does ./voltlap mutate.", file=sys.stderr)
    sys.exit(4)

sys.exit(main())
