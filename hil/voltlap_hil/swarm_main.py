# SPDX-License-Identifier: Apache-2.0
"""`voltlap swarm`: draws scenarios until its time is over, and shrinks the first that breaks something."""
from __future__ import annotations

import argparse
import multiprocessing
import os
import random
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count

from .car import Car
from .car_flags import car_words
from .dbc import Dbc
from .errors import HilError, InputError
from .fault_options import SEEDS
from .fault_table import Row, load_rows
from .in_process import PROCESS
from .inverter_names import names_of_car
from .nodes import program
from .rig import Bench, Rig
from .swarm import CARS, DRIVEN_MS, Drawn, check, draw, smallest, usable
from .swarm_options import parser


def main(arguments: list[str] | None = None) -> int:
    options = parser().parse_args(arguments)
    try:
        return _run(options)
    except InputError as error:
        print(f"voltlap swarm: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130


@dataclass(frozen=True)
class _Car:
    """A car with the names of its frames and its rows of the tables."""

    car: Car
    dbc: Dbc
    rows: dict[str, Row]

    def open_rig(self, gateway: bool, behind: tuple[str, ...], **what: object) -> Rig:
        return Rig(Bench(PROCESS, PROCESS if gateway else None, behind), dbc=self.dbc, **what)  # type: ignore[arg-type]


_cars: dict[str, _Car] = {}  # of a worker, which was forked with it
_own: tuple[str, ...] = ()   # the words of the car that was named


def _load(words: tuple[str, ...]) -> _Car:
    dbc = names_of_car(Dbc.of_project(), words)
    car = Car(dbc, words)
    return _Car(car, dbc, {row.id: row for row in usable(load_rows(dbc, words))})


def _check(drawn: Drawn) -> list[str]:
    of_car = _cars[drawn.vehicle]
    if not {name for name, _ in drawn.faults} <= of_car.rows.keys():
        return []  # made smaller to a car that has not this fault
    try:
        return check(drawn, of_car.rows, of_car.open_rig, of_car.car)
    except HilError as error:
        return [f"the run ends: {error}"]


def _one(seed: int) -> tuple[Drawn, list[str]]:
    drawn = draw(seed, {name: list(of_car.rows.values()) for name, of_car in _cars.items()}, _own)
    return drawn, _check(drawn)


def _run(options: argparse.Namespace) -> int:
    global _cars, _own
    program()
    _own = car_words(options)
    _cars = {name: _load(words) for name, words in ({"vtm16e": _own} if _own else CARS).items()}
    first = options.seed if options.seed is not None else random.randrange(SEEDS)
    print(f"seed {first}", flush=True)
    begin, runs, faults = time.monotonic(), 0, 0
    for drawn, found in _outcomes(options, first, begin):
        runs, faults = runs + 1, faults + len(drawn.faults)
        _show(options, begin, runs)
        if found:
            return _tell(drawn, found)
    minutes = runs * DRIVEN_MS / 60_000
    driven = f"{minutes / 60:.1f} h" if minutes >= 60 else f"{minutes:.0f} min"
    print(f"{runs} scenarios, {driven} driven, with {faults} faults in {time.monotonic() - begin:.0f} s: nothing "
          "was broken")
    return 0


def _outcomes(options: argparse.Namespace, first: int, begin: float) -> Iterator[tuple[Drawn, list[str]]]:
    def seeds() -> Iterator[int]:
        for i in count():
            if time.monotonic() - begin > options.seconds and i or i == options.runs:
                return
            yield (first + i) % (SEEDS + 1)

    if options.jobs == 1 or options.runs == 1:
        yield from map(_one, seeds())
        return
    with multiprocessing.get_context("fork").Pool(options.jobs) as pool:
        source = seeds()
        while batch := [seed for _, seed in zip(range(2 * options.jobs), source)]:
            yield from pool.map(_one, batch, chunksize=1)


def _show(options: argparse.Namespace, begin: float, runs: int) -> None:
    if sys.stderr.isatty():
        print(f"\r\033[K{runs} scenarios, {time.monotonic() - begin:.0f} of {options.seconds} s", end="",
              file=sys.stderr, flush=True)
    elif runs % 100 == 0:
        print(f"{runs} scenarios", file=sys.stderr, flush=True)


def _tell(drawn: Drawn, found: list[str]) -> int:
    name = found[0].partition(":")[0]
    print(f"BROKEN with seed {drawn.seed}: ./voltlap swarm --seed {drawn.seed} --runs 1")
    for text in found:
        print(f"  {text}")
    print(f"  drawn: {drawn}", flush=True)
    least = smallest(drawn, lambda one: any(text.partition(":")[0] == name for text in _check(one)))
    print(f"  smallest that breaks '{name}': {least}")
    for text in _check(least):
        print(f"    {text}")
    return 1
