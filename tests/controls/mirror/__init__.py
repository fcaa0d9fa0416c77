# SPDX-License-Identifier: Apache-2.0
"""The mirror: our own simulator drives with a hidden effect; explain is given the exact model of the sound car."""
