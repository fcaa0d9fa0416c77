# SPDX-License-Identifier: Apache-2.0
"""One module a format of CAN recordings. Its `read(source, tally)` gives candump lines in the order of the file, one or
many in each string; it raises `BrokenOff` after the last one where the file breaks off."""
