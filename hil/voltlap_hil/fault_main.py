# SPDX-License-Identifier: Apache-2.0
"""The fault matrix: every row of hil/faults.yaml is driven with plant and firmware in the loop, and measured.

With --ecu qemu BMS and master controller run as images of a Cortex-M4, an emulated board each, with --ecu process as
processes on pipes. Each row is then driven in one process, too, and fails where one frame differs.

Exit codes: 0 every row passed, 1 a row failed or is a known failure, 2 usage or input, 3 a row could not be run,
130 interrupted.
"""
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
from .dbc import Dbc
from .errors import HilError, InputError, check_place, did_you_mean
from .fault_run import PASSED, RowResult, Twins, run_row
from .fault_table import TABLE, Row, load_table
from .in_process import PROCESS, EcuPlace
from .nodes import program
from .quantity import whole
from .rig import Bench, Rig

_SEEDS, _MOST_JOBS = 2**32 - 1, 64


def main(arguments: list[str] | None = None) -> int:
    options = _parser().parse_args(arguments)
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


def number(low: int, high: int, text: str) -> int:
    try:
        return whole(text, low, high)
    except InputError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="voltlap faults", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--row", action="append", default=[], metavar="ID", help="only this row; may be repeated")
    parser.add_argument("--group", action="append", default=[], metavar="NAME",
                        help="only the rows of this group; may be repeated")
    parser.add_argument("--draw", type=partial(number, 1, 10_000), metavar="N",
                        help="only so many of them, drawn by --seed")
    parser.add_argument("--list", action="store_true", help="say which rows there are, and run nothing")
    parser.add_argument("--table", type=Path, default=TABLE, metavar="FILE", help="another table (hil/faults.yaml)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="everything that was measured")
    parser.add_argument("--report", type=Path, metavar="FILE",
                        help="one page with the curves of each row (.html), or the table (.md), which takes the place "
                        "of the one between its marks in a file such as docs/fault_matrix.md")
    parser.add_argument("--jobs", type=partial(number, 1, _MOST_JOBS), default=os.cpu_count() or 1, metavar="N",
                        help="rows at a time; one on a CAN interface (all processors)")
    parser.add_argument("--ecu", choices=("inside", "qemu", "process"), default="inside",
                        help="where the firmware runs; qemu: ./voltlap image builds the image (inside)")
    parser.add_argument("--image", metavar="FILE", help="with --ecu: an ELF or a program instead of the built one")
    parser.add_argument("--count-instructions", action="store_true",
                        help="with --ecu qemu: the worst step of each row, in --json and at the end")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE",
                        help="a number of the car, in every row that does not set it itself; may be repeated")
    parser.add_argument("--bus", metavar="IF", help="on this CAN interface, with processes for plant and ECUs, the "
                        "rows that say vcan: true; without it in one process")
    parser.add_argument("--far", metavar="IF", help="the interface behind the gateway (vcan1 with --bus vcan0)")
    parser.add_argument("--seed", type=partial(number, 0, _SEEDS), default=1, metavar="N",
                        help="of losses, noise and --draw; the same seed gives the same run (1)")
    return parser


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
    dbc = Dbc.of_project()
    rows = _chosen(load_table(options.table, dbc), options)
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
    if any(result.error for result in results):
        return 3
    return 0 if all(result.verdict == PASSED for result in results) else 1


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
    what["arguments"] = [*(word for setting in options.set for word in ("--set", setting)), *given]
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
