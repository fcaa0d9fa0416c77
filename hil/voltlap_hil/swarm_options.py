# SPDX-License-Identifier: Apache-2.0
"""Drawn cars, drives and pairs of faults against what must hold in every drive; a failure is shrunk.

Exit codes: 0 nothing was broken, 1 something was, with the seed that repeats it, 2 usage or input, 130 interrupted.
"""
from __future__ import annotations

import argparse
import os
from functools import partial

from .car_flags import add_car
from .fault_options import MOST_JOBS, SEEDS, number

LONGEST_S = 10_000_000


def parser() -> argparse.ArgumentParser:
    out = argparse.ArgumentParser(prog="voltlap swarm", description=__doc__,
                                  formatter_class=argparse.RawDescriptionHelpFormatter)
    out.add_argument("--seconds", type=partial(number, 1, LONGEST_S), default=60, metavar="N",
                        help="how long it draws (60); what has begun is ended")
    out.add_argument("--runs", type=partial(number, 1, LONGEST_S), metavar="N", help="at most so many scenarios")
    out.add_argument("--jobs", type=partial(number, 1, MOST_JOBS), default=os.cpu_count() or 1, metavar="N",
                        help="scenarios at a time (all processors)")
    out.add_argument("--seed", type=partial(number, 0, SEEDS), metavar="N",
                        help="of the first scenario, the next has the next number; without it one is drawn and said")
    add_car(out, "drawn are its charge, its temperature and a weak cell of it, instead of a car")
    return out
