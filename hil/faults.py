# SPDX-License-Identifier: Apache-2.0
"""Starts the fault matrix where the package is not installed: `voltlap faults`."""
import sys

from voltlap_hil.fault_options import parser

parser().parse_args()  # help and mistakes need no other package
try:
    from voltlap_hil.fault_main import main
except ModuleNotFoundError as error:
    print(f"voltlap faults: the Python package {error.name} is missing. `pip install -r "
          "toolchain/requirements/run.txt -r toolchain/requirements/hil.txt` installs it, and so does "
          "./voltlap faults.",
          file=sys.stderr)
    sys.exit(4)

sys.exit(main())
