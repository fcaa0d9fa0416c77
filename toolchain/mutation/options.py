# SPDX-License-Identifier: Apache-2.0
"""Whether the firmware's tests notice a wrong line. A copy of the firmware is built once in which every change stands
behind a switch: a relation moved or turned, a condition forced, a sign or an operator exchanged, a number changed, a
statement left out. Each is switched on alone, and the tests that reach it are run. A change that no test sees is
printed; where none can see it, firmware/mutants.toml says why.
"""
import argparse
import os

from outputs import output_file

DEFAULT = ("firmware/master", "firmware/app", "firmware/codec")


def arguments():
    parser = argparse.ArgumentParser(
        prog="voltlap mutate", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="Example: ./voltlap mutate firmware/master/pedals.cpp\n"
               "Exit code: 0 every survivor is explained, 1 one is not, or one is stale, 2 usage, 4 a package "
               "is missing, 5 the copy does not build or its tests fail, 130 interrupted.")
    parser.add_argument("paths", nargs="*", metavar="PATH", help=f"sources or folders ({' '.join(DEFAULT)})")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), metavar="N", help="at a time (as many as CPUs)")
    parser.add_argument("--only", type=int, metavar="N", help="this mutant alone; --list says the numbers")
    parser.add_argument("--draw", type=int, metavar="N", help="N mutants, drawn")
    parser.add_argument("--seed", type=int, metavar="S", help="of what is drawn (another one each time, printed)")
    parser.add_argument("--json", type=output_file, metavar="FILE", help="every mutant with its verdict")
    parser.add_argument("--whole", action="store_true",
                        help="tests that take longer than 0.2 s, too, the state space among them; hours")
    parser.add_argument("--list", action="store_true", help="the mutants, and nothing else")
    given = parser.parse_args()
    for name in ("jobs", "draw"):
        if getattr(given, name) is not None and getattr(given, name) < 1:
            parser.error(f"--{name} {getattr(given, name)}: 1 or more is expected")
    return given, parser
