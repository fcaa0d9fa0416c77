#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Starts `voltlap coverage`."""
import sys

from unreached.main import main

sys.exit(main())
