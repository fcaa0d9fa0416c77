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
from itertools import count

from .car import Car
from .car_flags import car_words
from .dbc import Dbc
from .errors import HilError, InputError
from .fault_options import SEEDS
from .fault_table import TABLE, Row, load_table
from .in_process import PROCESS
from .inverter_names import names_of_car
from .nodes import program
from .rig import Bench, Rig
from .swarm import Drawn, check, draw, smallest, usable
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


_work: tuple[dict[str, Row], list[Row], Dbc, Car] | None = None  # of a worker, which was forked with it


def _open_rig(gateway: bool, behind: tuple[str, ...], **what: object) -> Rig:
    assert _work is not None
    return Rig(Bench(PROCESS, PROCESS if gateway else None, behind), dbc=_work[2], **what)  # type: ignore[arg-type]


def _check(drawn: Drawn) -> list[str]:
    assert _work is not None
    try:
        return check(drawn, _work[0], _open_rig, _work[3])
    except HilError as error:
        return [f"the run ends: {error}"]


def _one(seed: int) -> tuple[Drawn, list[str]]:
    assert _work is not None
    drawn = draw(seed, _work[1], _work[3].arguments)
    return drawn, _check(drawn)


def _run(options: argparse.Namespace) -> int:
    global _work
    program()
    dbc = names_of_car(Dbc.of_project(), car_words(options))
    rows = load_table(TABLE, dbc, car_words(options))
    _work = ({row.id: row for row in rows}, usable(rows), dbc, Car(dbc, car_words(options)))
    first = options.seed if options.seed is not None else random.randrange(SEEDS)
    print(f"seed {first}", flush=True)
    begin, runs, faults = time.monotonic(), 0, 0
    for drawn, found in _outcomes(options, first, begin):
        runs, faults = runs + 1, faults + len(drawn.faults)
        _show(options, begin, runs)
        if found:
            return _tell(drawn, found)
    print(f"{runs} scenarios with {faults} faults in {time.monotonic() - begin:.0f} s: nothing was broken")
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
