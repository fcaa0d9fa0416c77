# SPDX-License-Identifier: Apache-2.0
"""What the native programs hand to the field's own libraries: recordings that they do not read, files that they do not
write. Each module that has a `main` is started as `python -m voltlap_logs.NAME`."""
