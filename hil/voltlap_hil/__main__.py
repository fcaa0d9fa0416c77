# SPDX-License-Identifier: Apache-2.0
"""`voltlap hil run`: reads scenario files, runs them, says what each check measured."""
from __future__ import annotations

import argparse
import io
import os
import sys
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from . import record, report
from .car import Car
from .car_flags import car_words
from .dbc import Dbc
from .errors import HilError, InputError
from .in_process import PROCESS
from .inverter_names import names_of_car
from .rig import Bench, Rig
from .run_options import parser
from .runner import Outcome, run
from .scenario_file import Scenario, load

_SIMULATED = "vcan"


def main(arguments: list[str] | None = None) -> int:
    options = parser().parse_args(arguments)
    if isinstance(sys.stdout, io.TextIOWrapper):  # a terminal that cannot show a title shows its escapes
        sys.stdout.reconfigure(errors="backslashreplace")
    try:
        return _run(options)
    except InputError as error:
        print(f"voltlap hil: {error}", file=sys.stderr)
        return 2
    except HilError as error:
        print(f"voltlap hil: {error}", file=sys.stderr)
        return 3
    except KeyboardInterrupt:
        return 130


def _files(paths: list[Path]) -> list[Path]:
    files = [f for path in paths for f in (sorted(path.glob("*.yaml")) if os.path.isdir(path) else [path])]
    if not files:
        raise InputError(f"no .yaml file in {', '.join(map(str, paths))}")
    return files


def _load_all(files: list[Path], dbc: Dbc, arguments: Sequence[str]) -> list[Scenario]:
    """Every file is read before any runs, and every file with a mistake is told."""
    scenarios, mistakes = [], []
    for path in files:
        try:
            scenarios.append(load(path, dbc, arguments))
        except InputError as error:
            mistakes.append(str(error))
    if len(files) > 1 and mistakes:
        mistakes.append(f"{len(mistakes)} of {len(files)} scenario files have mistakes, and nothing was run")
    if mistakes:
        raise InputError("\n".join(mistakes).replace("\n", "\nvoltlap hil: "))
    return scenarios


def _check_flag(flag: str, check: Callable[[Path], None], path: Path) -> None:
    try:
        check(path)
    except InputError as error:
        raise InputError(f"{flag} {error}") from None


def _run(options: argparse.Namespace) -> int:
    dbc = Dbc.of_project()
    Car(dbc, car_words(options)).check_arguments()
    dbc = names_of_car(dbc, car_words(options))
    scenarios = _load_all(_files(options.scenario), dbc, car_words(options))
    for path in options.report:
        if path.suffix not in report.WRITERS:
            raise InputError(f"--report {path}: expected a name that ends in {', '.join(report.WRITERS)}")
        _check_flag("--report", report.check_name, path)
    if options.record and len(scenarios) != 1:
        raise InputError(f"--record takes one scenario, found {len(scenarios)}")
    if options.record:
        _check_flag("--record", record.check_name, options.record)
    for scenario in scenarios:
        if scenario.needs_process and options.channel != PROCESS:
            raise InputError(f"{scenario.path}: 'reset' takes the supply of a node, which --channel {options.channel} "
                             f"cannot; expected --channel {PROCESS}")
    if options.check_only:
        print(f"{len(scenarios)} scenario files are right")
        return 0
    outcomes = []
    for i, scenario in enumerate(scenarios):
        print(f"[{i + 1}/{len(scenarios)}] {scenario.title}", file=sys.stderr, flush=True)
        outcomes.append(_run_one(scenario, options, dbc))
    for path in options.report:
        report.write(path, outcomes)
    if any(outcome.error for outcome in outcomes):
        return 3
    return 0 if all(outcome.good for outcome in outcomes) else 1


def _run_one(scenario: Scenario, options: argparse.Namespace, dbc: Dbc) -> Outcome:
    try:
        outcome = run(scenario, partial(open_rig, options, dbc), not options.without_event, options.record,
                      progress=lambda text: print(f"      {text}", file=sys.stderr, flush=True))
    except InputError:
        raise
    except HilError as error:
        outcome = Outcome(scenario, not options.without_event, error=str(error))
    word = "could not run" if outcome.error else "as it must be" if outcome.good else "WRONG"
    print(f"{word:13}  {scenario.title}")
    for line in [outcome.error] if outcome.error else [*map(str, outcome.then), *map(str, outcome.always)]:
        print(f"               {line}")
    return outcome


def open_rig(options: argparse.Namespace, dbc: Dbc, gateway: bool, behind: Sequence[str], **what: object) -> Rig:
    start = options.nodes == "started" if options.nodes else options.channel.startswith((_SIMULATED, PROCESS))
    far = options.far
    if options.channel == PROCESS:
        if not start or far:
            raise InputError("--channel process starts all there is: leave out --far and --nodes running")
        far = PROCESS
    if gateway and far is None:
        if options.channel != "vcan0":
            raise InputError(f"this scenario plants faults of the bus: name the channel behind the gateway with --far, "
                             f"beside --channel {options.channel}")
        far = "vcan1"
    bench = Bench(options.channel, far if gateway else None, behind, start)
    what["arguments"] = [*car_words(options), *what.get("arguments", ())]  # type: ignore[misc]
    return Rig(bench, dbc=dbc, **what)  # type: ignore[arg-type]


if __name__ == "__main__":
    sys.exit(main())
