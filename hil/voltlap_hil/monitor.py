# SPDX-License-Identifier: Apache-2.0
"""Shows a CAN bus of the car by the names of its signals: states, limits with their reasons, who is fresh or lost,
how full the bus is. It only listens.

Exit codes: 0 done, 2 usage or input, 3 the bus is not there or silent, 130 interrupted (with --once).
"""
from __future__ import annotations

import argparse
import sys
from pathlib import Path

from .errors import HilError, InputError


def main(arguments: list[str] | None = None) -> int:
    options = _parser().parse_args(arguments)
    try:
        _check(options)
        from .monitor_feed import show  # only now: help needs none of its packages
        show(options)
    except InputError as error:
        print(f"voltlap monitor: {error}", file=sys.stderr)
        return 2
    except HilError as error:
        print(f"voltlap monitor: {error}", file=sys.stderr)
        return 3
    except KeyboardInterrupt:
        return 130 if options.once else 0
    except BrokenPipeError:
        sys.stderr.close()  # nothing more to say to nobody
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="voltlap monitor", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument("--bus", metavar="IF", help="CAN interface, for instance vcan0 or can0")
    source.add_argument("--log", type=Path, metavar="FILE",
                        help="a log instead (candump -l, .asc, .blf); shown as at its end")
    parser.add_argument("--once", action="store_true", help="listen, print once and end")
    parser.add_argument("--wait", type=_seconds, default=1.0, metavar="S", help="how long --once listens (1)")
    parser.add_argument("--at", type=_seconds, metavar="S", help="with --log: as after S seconds of it")
    parser.add_argument("--json", action="store_true", help="print JSON; with --once or --log")
    return parser


def _seconds(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0.0 < value < 1e9:
        raise argparse.ArgumentTypeError(f"found {text!r}, expected seconds above 0")
    return value


def _check(options: argparse.Namespace) -> None:
    if options.json and not (options.once or options.log):
        raise InputError("--json prints once: give --once too")
    if options.at and not options.log:
        raise InputError("--at is a place in a log: give --log FILE too")


if __name__ == "__main__":
    sys.exit(main())
