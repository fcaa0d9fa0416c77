# SPDX-License-Identifier: Apache-2.0
"""`python hil`: the command line of the package beside this file, without installing it."""
import sys

from voltlap_hil.run_options import parser

parser().parse_args()  # help and mistakes need no other package
try:
    from voltlap_hil.__main__ import main
except ModuleNotFoundError as error:
    print(f"voltlap hil: the Python package {error.name} is missing. `./voltlap hil run` installs what it needs, "
          "or: pip install -r toolchain/requirements/run.txt -r toolchain/requirements/hil.txt", file=sys.stderr)
    sys.exit(4)

sys.exit(main())
