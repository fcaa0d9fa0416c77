# SPDX-License-Identifier: Apache-2.0
"""The hidden truth: a physics of cells and cars that owes nothing to the model that diagnoses it.

Single-particle cells with Butler-Volmer kinetics, core and surface heat, a car on slipping tyres, instruments with
their own noise. Written from text-books; no equation, table, unit convention or random stream is shared with
plant_sim or firmware. Everything is computed for many cases at once: the first axis of an array is the case.
"""
