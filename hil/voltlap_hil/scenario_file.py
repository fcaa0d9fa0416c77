# SPDX-License-Identifier: Apache-2.0
"""A scenario as a page of YAML: given, when, meanwhile, then, always. Every mistake is told with its place."""
from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from . import checks, requirements
from .car import Car
from .car_quantities import filled
from .dbc import Dbc
from .errors import InputError
from .nodes import ECUS
from .quantity import LONGEST_MS, duration_ms
from .scenario_checks import read_check
from .scenario_faults import check_reached
from .scenario_steps import read_step
from .step import Step
from .yaml_node import YamlNode, document


@dataclass
class Scenario:
    """`when` is what the scenario is about: without it every check of `then` must fail, those of `always` must hold."""

    path: Path
    title: str
    proves: list[str] = field(default_factory=list)
    behind: tuple[str, ...] = ("bms", "master")
    arguments: list[str] = field(default_factory=list)
    given: list[Step] = field(default_factory=list)
    when: list[Step] = field(default_factory=list)
    meanwhile: list[Step] = field(default_factory=list)
    then: list[checks.Check] = field(default_factory=list)
    always: list[checks.Check] = field(default_factory=list)
    observe_ms: float = 0.0

    @property
    def steps(self) -> list[Step]:
        return [*self.given, *self.when, *self.meanwhile]

    @property
    def needs_gateway(self) -> bool:
        return any(step.needs_gateway for step in self.steps)

    @property
    def needs_process(self) -> bool:
        return any(step.needs_process for step in self.steps)

    @property
    def automatic(self) -> bool:
        return any(step.automatic for step in self.steps)

    @property
    def watch(self) -> list[str]:
        """Signals that a step or a check looks at."""
        return sorted({name for part in (self.steps, self.then, self.always) for one in part for name in one.needs})


_AFTER_MS = 500.0
_MOST_MISTAKES = 20
TOP = ["scenario", "proves", "behind_gateway", "arguments", "given", "when", "meanwhile", "then", "always", "observe"]


class Mistakes:
    """All that is wrong with a file, so that it is mended in one go."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._texts: list[str] = []

    @contextmanager
    def noted(self) -> Iterator[None]:
        """What is wrong in here is kept, and the reading goes on behind it."""
        try:
            yield
        except InputError as error:
            self._texts.append(str(error))
        if len(self._texts) == _MOST_MISTAKES:
            self._texts.append(f"{self._path}: more may follow; reading ended here")
            self.tell()

    def tell(self) -> None:
        if self._texts:
            raise InputError("\n".join(self._texts))


def load(path: str | Path, dbc: Dbc, arguments: Sequence[str] = ()) -> Scenario:
    """Reads and checks a file whole, before anything runs. `arguments`: of the car, before those of the file."""
    path, car = Path(path), Car(dbc, tuple(arguments))
    top = document(path, lambda text: filled(text, car, path)).fields(TOP, needed=["scenario", "when", "then"])
    scenario, mistakes = Scenario(path, ""), Mistakes(path)
    with mistakes.noted():
        scenario.title = _title(top["scenario"])
    if "proves" in top:
        with mistakes.noted():
            scenario.proves = _each_once(top["proves"], lambda n: n.value(requirements.requirement).id)
    if "behind_gateway" in top:
        with mistakes.noted():
            scenario.behind = tuple(_each_once(top["behind_gateway"], lambda n: n.one_of(list(ECUS))))
    if "arguments" in top:
        with mistakes.noted():
            scenario.arguments = _arguments(top["arguments"], car)
    _read_steps(scenario, top, Car(dbc, (*arguments, *scenario.arguments)), mistakes)
    for part, node in _entries(top, ("then", "always"), mistakes):
        with mistakes.noted():
            getattr(scenario, part).append(read_check(node, Car(dbc, (*arguments, *scenario.arguments))))
    if "observe" in top:
        with mistakes.noted():
            scenario.observe_ms = top["observe"].value(duration_ms)
    mistakes.tell()
    _settle_observation(scenario, top)
    return scenario


def _title(node: YamlNode) -> str:
    title = " ".join(node.words().split())
    if not title:
        raise node.error("found nothing, expected a title")
    return title


def _each_once(node: YamlNode, read: Callable[[YamlNode], str]) -> list[str]:
    found: dict[str, None] = {}
    for one in node.items():
        name = read(one)
        if name in found:
            raise one.error(f"{name!r} stands here twice")
        found[name] = None
    return list(found)


def _arguments(node: YamlNode, car: Car) -> list[str]:
    arguments = [one.words() for one in node.items()]
    try:
        Car(car.dbc, (*car.arguments, *arguments)).check_arguments()
    except InputError as error:
        raise node.error(str(error)) from None
    return arguments


def _entries(top: dict[str, YamlNode], parts: Iterable[str], mistakes: Mistakes) -> Iterator[tuple[str, YamlNode]]:
    for part in parts:
        nodes: list[YamlNode] = []
        if part in top:
            with mistakes.noted():
                nodes = list(top[part].items())
        for node in nodes:
            yield part, node


def _read_steps(scenario: Scenario, top: dict[str, YamlNode], car: Car, mistakes: Mistakes) -> None:
    killed: set[str] = set()
    for part, node in _entries(top, ("given", "when", "meanwhile"), mistakes):
        with mistakes.noted():
            step = read_step(node, car)
            check_reached(step, scenario.behind, node)
            if step.kills in killed:
                raise node.error(f"found that {step.kills} is killed twice; it is dead since the first time")
            if step.kills:
                killed.add(step.kills)
            getattr(scenario, part).append(step)


def _settle_observation(scenario: Scenario, top: dict[str, YamlNode]) -> None:
    """Long enough for every check, by itself or because the file says so."""
    needed_ms = max(check.lasts_ms for check in [*scenario.then, *scenario.always])
    if "observe" not in top:
        scenario.observe_ms = _long_enough(scenario)
    elif scenario.observe_ms < needed_ms:
        raise top["observe"].error(f"found {scenario.observe_ms:g} ms, expected at least the {needed_ms:g} ms that the "
                                   "checks need")
    if scenario.observe_ms > LONGEST_MS:
        raise top["then"].error(f"found checks that need more than {LONGEST_MS / 3.6e6:g} h; make their times shorter")


def _long_enough(scenario: Scenario) -> float:
    """Every bound and what must last beyond it. What starts with `after` is given half a second to start."""
    return max(c.lasts_ms + (_AFTER_MS if c.after else 0.0) for c in [*scenario.then, *scenario.always])
