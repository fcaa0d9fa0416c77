# SPDX-License-Identifier: Apache-2.0
"""Cells drawn at random, with tests, drives and instruments, for the campaign of toolchain/learn_bench.py.

A simulator in numpy that shares no code, table or random stream with plant_sim: circuits over SOC of 1 to 3 branches
with Arrhenius laws, charge transfer of two unlike electrodes, hysteresis, entropy and one mass of heat.
"""
