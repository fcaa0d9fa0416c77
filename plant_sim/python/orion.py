# SPDX-License-Identifier: Apache-2.0
"""Starts the package beside this file: `voltlap orion`."""
import sys

from voltlap_orion.__main__ import main

sys.exit(main())
