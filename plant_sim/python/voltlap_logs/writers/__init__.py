# SPDX-License-Identifier: Apache-2.0
"""One module a format of recordings. Its `write(path, frames)` writes a `spool.Spool`; it counts there what the format
cannot hold."""
