# SPDX-License-Identifier: Apache-2.0
"""The profile of an Orion BMS (`.o2bms`) read, and made into a pack file of ours: `voltlap orion`."""
