# SPDX-License-Identifier: Apache-2.0
"""Shows a CAN bus of the car by the names of its signals: states, limits with their reasons, who is fresh or lost,
how full the bus is. It only listens. With --dbc it is any car's bus: values, ranges, rates and load by its own files.

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
                        help="a recording instead, in any format of `voltlap log`; shown as at its end")
    parser.add_argument("--dbc", type=Path, metavar="FILE", action="append", default=[],
                        help="DBC file (KCD, SYM, ARXML as well) of the car; may be given again")
    parser.add_argument("--signals", type=_names, metavar="A,B", default=[],
                        help="with --dbc: only signals of these names or patterns (PackVoltage, '*Temp*')")
    parser.add_argument("--once", action="store_true", help="listen, print once and end")
    parser.add_argument("--wait", type=_seconds, default=1.0, metavar="S", help="how long --once listens (1)")
    parser.add_argument("--at", type=_seconds, metavar="S", help="with --log: as after S seconds of it")
    parser.add_argument("--from", type=_seconds, metavar="S", dest="start",
                        help="with --log: nothing before S seconds of it counts")
    parser.add_argument("--speed", type=_seconds, metavar="X",
                        help="with --log: play it, X times as fast as it was recorded; then as at its end")
    parser.add_argument("--bit-rate", type=_seconds, metavar="KBIT", default=500.0,
                        help="with --dbc: kbit/s of the buses, for their load (500)")
    parser.add_argument("--json", action="store_true", help="print JSON; with --once or --log")
    return parser


def _seconds(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0.0 < value < 1e9:
        raise argparse.ArgumentTypeError(f"found {text!r}, expected a number above 0")
    return value


def _names(text: str) -> list[str]:
    names = [name.strip() for name in text.split(",") if name.strip()]
    if not names:
        raise argparse.ArgumentTypeError(f"found {text!r}, expected names of signals, separated by commas")
    return names


def _check(options: argparse.Namespace) -> None:
    if options.json and not (options.once or options.log):
        raise InputError("--json prints once: give --once too")
    for flag, value in (("--at", options.at), ("--from", options.start), ("--speed", options.speed)):
        if value and not options.log:
            raise InputError(f"{flag} is {'a place in' if flag != '--speed' else 'that of'} a log: give --log FILE too")
    if options.at and options.start and options.at <= options.start:
        raise InputError(f"--at {options.at:g} is not after --from {options.start:g}")
    if options.signals and not options.dbc:
        raise InputError("--signals are those of a car's DBC file: give --dbc FILE too")


if __name__ == "__main__":
    sys.exit(main())
