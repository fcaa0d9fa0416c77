# SPDX-License-Identifier: Apache-2.0
"""`python hil`: the command line of the package beside this file, without installing it."""
import sys

try:
    from voltlap_hil.__main__ import main
except ModuleNotFoundError as error:
    sys.exit(f"voltlap hil: the Python package {error.name} is missing. `./voltlap hil run` installs what it needs, "
             "or: pip install -r toolchain/requirements/run.txt -r toolchain/requirements/hil.txt")

sys.exit(main())
