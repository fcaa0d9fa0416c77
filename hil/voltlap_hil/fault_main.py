# SPDX-License-Identifier: Apache-2.0
"""`voltlap faults`: reads the table, drives its rows, several at a time, and writes what came of it."""
from __future__ import annotations

import argparse
import multiprocessing
import os
import random
import sys
import time
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

from . import fault_report
from .car_flags import car_words
from .dbc import Dbc
from .errors import HilError, InputError, check_place, did_you_mean
from .fault_options import parser
from .fault_run import PASSED, RowResult, Twins, run_row
from .fault_table import Row, load_rows, load_table
from .in_process import PROCESS, EcuPlace
from .inverter_names import names_of_car
from .nodes import program
from .rig import Bench, Rig


def main(arguments: list[str] | None = None) -> int:
    options = parser().parse_args(arguments)
    try:
        return _run(options)
    except InputError as error:
        print(f"voltlap faults: {str(error).replace(chr(10), chr(10) + 'voltlap faults: ')}", file=sys.stderr)
        return 2
    except HilError as error:
        print(f"voltlap faults: {error}", file=sys.stderr)
        return 3
    except KeyboardInterrupt:
        return 130


def _run(options: argparse.Namespace) -> int:
    for flag, path, suffixes in (("--json", options.json, (".json",)), ("--report", options.report, (".html", ".md"))):
        if path is not None:
            if path.suffix not in suffixes:
                raise InputError(f"{flag} {path}: found {path.suffix or 'no suffix'}, expected {' or '.join(suffixes)}")
            check_place(path)
    if options.far and not options.bus:
        raise InputError("--far goes with --bus, expected both or none")
    ecu = _ecu_place(options)
    if not options.list:
        program()  # its absence is told once, before anything starts
        ecu.check()
    dbc = names_of_car(Dbc.of_project(), car_words(options))
    words = car_words(options)
    rows = _chosen(load_table(options.table, dbc, words) if options.table else load_rows(dbc, words), options)
    if options.list:
        print(fault_report.listing(rows))
        return 0
    begin = time.monotonic()
    results = [result for result in _progress(rows, _results(rows, options, dbc))]
    done = fault_report.Matrix(rows, results, options.seed, options.bus or PROCESS, time.monotonic() - begin,
                               options.ecu)
    print(fault_report.text(done))
    if options.json:
        fault_report.write(options.json, fault_report.json_text(done))
    if options.report:
        markdown = options.report.suffix == ".md"
        fault_report.write(options.report, fault_report.renewed(options.report, fault_report.markdown(done))
                           if markdown else fault_report.page(done))
    # What is about another car says nothing of this one, but where it was asked for or nothing else was driven.
    about = [result for row, result in zip(rows, results, strict=True) if not row.only_with or row.id in options.row]
    if not about or any(result.error for result in about):
        return 3
    return 0 if all(result.verdict == PASSED for result in about) else 1


def _ecu_place(options: argparse.Namespace) -> EcuPlace:
    ecu = EcuPlace(options.ecu, options.image, options.count_instructions)
    if ecu.outside and options.bus:
        raise InputError("--ecu goes without --bus: there the firmware runs as processes on the interface")
    for flag, given in (("--image", options.image), ("--count-instructions", options.count_instructions)):
        if given and not ecu.outside:
            raise InputError(f"{flag} goes with --ecu, expected both or none")
    return ecu


def _chosen(rows: list[Row], options: argparse.Namespace) -> list[Row]:
    for flag, wanted, known in (("--row", options.row, [row.id for row in rows]),
                                ("--group", options.group, list(dict.fromkeys(row.group for row in rows)))):
        for name in wanted:
            if name not in known:
                raise InputError(f"{flag} {name}: found no such {flag[2:]}.{did_you_mean(name, known)} "
                                 "`./voltlap faults --list` says which there are")
    if options.row or options.group:
        rows = [row for row in rows if row.id in options.row or row.group in options.group]
    if options.bus:
        rows = [row for row in rows if row.vcan]
        if not rows:
            raise InputError("--bus: none of these rows says vcan: true, which is needed on an interface")
    if options.draw and options.draw < len(rows):
        drawn = random.Random(options.seed).sample(range(len(rows)), options.draw)
        rows = [rows[i] for i in sorted(drawn)]
    return rows


def _open_rig(options: argparse.Namespace, dbc: Dbc, ecu: EcuPlace, gateway: bool, behind: Sequence[str],
              **what: object) -> Rig:
    given: Sequence[str] = what.get("arguments", ())  # type: ignore[assignment]
    what["arguments"] = [*car_words(options), *given]
    if options.bus is None:
        bench = Bench(PROCESS, PROCESS if gateway else None, behind, ecu=ecu)
    else:
        far = options.far or ("vcan1" if options.bus == "vcan0" else None)
        if gateway and far is None:
            raise InputError(f"--bus {options.bus}: name the interface behind the fault gateway with --far")
        bench = Bench(options.bus, far if gateway else None, behind)
    return Rig(bench, dbc=dbc, seed=options.seed, **what)  # type: ignore[arg-type]


# Of a worker, which was forked with it.
_work: tuple[list[Row], Dbc, partial[Rig], Twins, partial[Rig] | None] | None = None


def _one(index: int) -> RowResult:
    assert _work is not None
    rows, dbc, open_rig, twins, open_inside = _work
    return run_row(rows[index], dbc, open_rig, twins, open_inside)


def _results(rows: list[Row], options: argparse.Namespace, dbc: Dbc) -> Iterator[RowResult]:
    global _work
    ecu = _ecu_place(options)
    open_rig = partial(_open_rig, options, dbc, ecu)
    open_inside = partial(_open_rig, options, dbc, EcuPlace(taped=True)) if ecu.outside else None
    _work = (rows, dbc, open_rig, Twins(dbc, open_rig, open_inside), open_inside)
    jobs = 1 if options.bus else min(options.jobs, len(rows))
    if jobs == 1:
        yield from map(_one, range(len(rows)))
        return
    with multiprocessing.get_context("fork").Pool(jobs) as pool:
        yield from pool.imap(_one, range(len(rows)))


def _progress(rows: list[Row], results: Iterator[RowResult]) -> Iterator[RowResult]:
    """On a terminal one line that is written over, elsewhere one line a failure."""
    live, failed = sys.stderr.isatty(), 0
    for i, result in enumerate(results):
        bad = result.verdict != PASSED
        failed += bad
        if live:
            print(f"\r\033[K[{i + 1}/{len(rows)}] {failed} not passed, {rows[i].id}", end="", file=sys.stderr,
                  flush=True)
        elif bad or (i + 1) % 25 == 0:
            print(f"[{i + 1}/{len(rows)}] {result.verdict:7} {rows[i].id}", file=sys.stderr, flush=True)
        yield result
    if live:
        print("\r\033[K", end="", file=sys.stderr, flush=True)
