# SPDX-License-Identifier: Apache-2.0
"""Blind trials of the diagnosing tool on the hidden truth: cases, packing, sealing, runs, scores."""
