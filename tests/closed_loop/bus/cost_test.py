# SPDX-License-Identifier: Apache-2.0
"""The lockstep costs at most twice the bare exchange of the same frames, measured in the same run."""
import sys

from conftest import BUS, PROGRAM, ROOT

sys.path.insert(0, str(ROOT / "toolchain"))
import lockstep_cost  # noqa: E402


def test_lockstep_costs_at_most_twice_the_bare_exchange():
    lockstep_s, bare_s, simulated_s = lockstep_cost.measure(PROGRAM.parents[1], BUS, rounds=3)
    print(f"lockstep {lockstep_s:.3f} s, bare {bare_s:.3f} s, {simulated_s / lockstep_s:.1f} times real time")
    assert lockstep_s <= lockstep_cost.RATIO_MAX * bare_s
