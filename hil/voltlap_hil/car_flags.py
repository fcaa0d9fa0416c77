# SPDX-License-Identifier: Apache-2.0
"""The flags that choose the car of a harness's runs; they need no other package."""
from __future__ import annotations

import argparse


def add_car(parser: argparse.ArgumentParser, how: str) -> None:
    parser.add_argument("--vehicle", metavar="CAR", help=f"a car by name or file; {how} (vtm16e)")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE",
                        help="another number of the car; may be repeated")


def car_words(options: argparse.Namespace) -> tuple[str, ...]:
    """As plant and ECUs take them; none for the example car."""
    vehicle = ("--vehicle", options.vehicle) if options.vehicle else ()
    return (*vehicle, *(word for setting in options.set for word in ("--set", setting)))
