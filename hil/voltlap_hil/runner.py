# SPDX-License-Identifier: Apache-2.0
"""Runs a scenario of a file, with what it is about or without it, and says what each check measured."""
from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from .checks import Result
from .rig import Rig
from .scenario_file import Scenario
from .step import Step


@dataclass
class Outcome:
    """Results of one run. `event_ms`: simulated time of the event; `wall_s`: what the run cost."""

    scenario: Scenario
    with_event: bool
    then: list[Result] = field(default_factory=list)
    always: list[Result] = field(default_factory=list)
    event_ms: float = 0.0
    wall_s: float = 0.0
    error: str = ""

    @property
    def held(self) -> bool:
        return not self.error and all(result.held for result in [*self.then, *self.always])

    @property
    def contrary(self) -> bool:
        """True for a run without event as it must be: no reaction of `then` is seen, `always` holds."""
        return not self.error and not any(r.held for r in self.then) and all(r.held for r in self.always)

    @property
    def good(self) -> bool:
        return self.held if self.with_event else self.contrary


def run(scenario: Scenario, open_rig: Callable[..., Rig], with_event: bool = True,
        record: str | Path | None = None, progress: Callable[[str], None] = lambda text: None) -> Outcome:
    """`open_rig` gets watch, behind, arguments and record, and gives the rig to run on."""
    outcome = Outcome(scenario, with_event)
    begin = time.monotonic()

    def take(steps: list[Step]) -> None:
        for step in steps:
            progress(f"{rig.now_ms / 1000.0:7.2f} s  {step.text}")
            step.act(rig)

    driver = {"automatic": True} if scenario.automatic else {}
    with open_rig(watch=scenario.watch, behind=scenario.behind, arguments=scenario.arguments, record=record,
                  gateway=scenario.needs_gateway, **driver) as rig:
        take(scenario.given)
        outcome.event_ms = rig.now_ms
        if with_event:
            take(scenario.when)
        take(scenario.meanwhile)
        rest = outcome.event_ms + scenario.observe_ms - rig.now_ms
        rig.run(f"{max(0.0, rest):.3f} ms")
        outcome.then = [check.measure(rig.trace, outcome.event_ms) for check in scenario.then]
        outcome.always = [check.measure(rig.trace, outcome.event_ms) for check in scenario.always]
    outcome.wall_s = time.monotonic() - begin
    return outcome
