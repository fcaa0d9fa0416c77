# SPDX-License-Identifier: Apache-2.0
"""The table of faults: each row is one line of YAML, read into a scenario of the engine that runs scenario files.

`situations` say how the car is driven; `rows` what breaks then, what must be seen, and what the car must do in time.
"""
from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import yaml

from . import checks, requirements
from .car import Car
from .car_quantities import filled
from .condition import Condition
from .dbc import Dbc
from .errors import InputError
from .nodes import ECUS
from .quantity import TICK_MS, duration_ms, ticks
from .scenario_checks import bound_of, read_check
from .scenario_file import Mistakes, Scenario
from .scenario_faults import check_reached
from .scenario_steps import read_step
from .yaml_node import YamlNode, document

TABLE = Path(__file__).resolve().parents[1] / "faults.yaml"
OF_INVERTER = {"pm100": TABLE.with_name("faults_pm100.yaml"), "amk": TABLE.with_name("faults_amk.yaml")}
_SITUATION = ["what", "sound", "ends", "given", "meanwhile"]
_ENDS = {"torque": "torque_zero_within", "contactors": "contactors_open_within"}
_ROW = ["id", "group", "what", "rule", "proves", "drive", "when", "meanwhile", "sees", "seen_within",
        "torque_zero_within", "contactors_open_within", "commanded_open_within", "goes_on", "then", "behind",
        "arguments", "observe", "only_with", "told_by", "vcan", "known"]
_NEEDED = ["id", "group", "what", "drive", "when"]
_REACTIONS = {"torque_zero_within": checks.torque_zero_within, "contactors_open_within": checks.contactors_open_within,
              "commanded_open_within": checks.contactors_commanded_open_within}
_ID = re.compile(r"[a-z][a-z0-9_]{2,59}")
_BEHIND_USUAL = ECUS
_RULE = re.compile(r"(?:EV|T)\.\d+(?:\.\d+){0,3}")


@dataclass(frozen=True)
class Situation:
    """How the car is driven when something breaks.

    sound  what a car without fault keeps to all the while
    ends   reactions that the drive itself brings, fault or not: the foot leaves the pedal, the circuit opens
    """

    name: str
    what: str
    sound: Condition
    given: tuple[YamlNode, ...]
    meanwhile: tuple[YamlNode, ...]
    ends: frozenset[str] = frozenset()


@dataclass
class Row:
    """One fault. `seen`: how it is told on the bus; `goes_on_ms`: a sound car drives on for so long."""

    line: int
    id: str
    group: str
    what: str
    situation: Situation
    scenario: Scenario
    rule: list[str] = field(default_factory=list)
    seen: checks.Check | None = None
    reactions: dict[str, checks.Check] = field(default_factory=dict)
    more: list[checks.Check] = field(default_factory=list)
    goes_on_ms: float = 0.0
    vcan: bool = False
    known: str = ""
    own_meanwhile: bool = False
    fault: str = ""  # the text of `when`
    otherwise: Row | None = None  # in the next of its drives, for a car that does not do this one
    told_by: Condition | None = None  # what the drive has to bring for a second, or the fault cannot be told
    only_with: str = ""           # why the row says nothing of this car; empty: it does

    @property
    def answers_to(self) -> str:
        """The rules and requirements that it is evidence for."""
        return ", ".join([*self.rule, *self.scenario.proves])


def load_table(path: Path, dbc: Dbc, arguments: Sequence[str] = ()) -> list[Row]:
    """Reads and checks the whole table for the car that `arguments` name; every mistake is told with its line and
    field."""
    car = Car(dbc, tuple(arguments))
    car.check_arguments()
    top = document(path, lambda text: filled(text, car, path)).fields(["situations", "rows"],
                                                                      needed=["situations", "rows"])
    mistakes = Mistakes(path)
    situations: dict[str, Situation] = {}
    for name, node in _named(top["situations"]):
        with mistakes.noted():
            situations[name] = _situation(name, node, car)
    rows: list[Row] = []
    for node in top["rows"].items():
        with mistakes.noted():
            row = _row(node, situations, car)
            if any(row.id == other.id for other in rows):
                raise node.error(f"the id {row.id!r} stands here twice")
            rows.append(row)
    mistakes.tell()
    return rows


def load_rows(dbc: Dbc, arguments: Sequence[str] = ()) -> list[Row]:
    """Of the project's tables all that there is about a car: the usual one, and that of its inverter."""
    own = OF_INVERTER.get(Car(dbc, tuple(arguments)).words.get("inverter.protocol", ""))
    return [row for path in (TABLE, own) if path for row in load_table(path, dbc, arguments)]


def _named(node: YamlNode) -> Iterator[tuple[str, YamlNode]]:
    """The entries of a mapping whose names are the writer's own."""
    if not isinstance(node.raw, yaml.MappingNode):
        raise node.error(f"found {node.kind}, expected a mapping of situations")
    yield from node.fields([str(key.value) for key, _ in node.raw.value]).items()


def _situation(name: str, node: YamlNode, car: Car) -> Situation:
    fields = node.fields(_SITUATION, needed=["what", "sound", "given"])
    situation = Situation(name, fields["what"].words(), fields["sound"].value(lambda t: Condition.parse(t, car.dbc)),
                          tuple(fields["given"].items()),
                          tuple(fields["meanwhile"].items()) if "meanwhile" in fields else (),
                          frozenset(_ENDS[n.one_of(list(_ENDS))] for n in fields["ends"].items())
                          if "ends" in fields else frozenset())
    for step in (*situation.given, *situation.meanwhile):
        read_step(step, car)
    return situation


def _row(node: YamlNode, situations: dict[str, Situation], of_all: Car, drive: int = 0) -> Row:
    fields, dbc = node.fields(_ROW, needed=_NEEDED), of_all.dbc
    identifier = fields["id"].words()
    if _ID.fullmatch(identifier) is None:
        raise fields["id"].error(f"found {identifier!r}, expected 3 to 60 small letters, digits and _, such as "
                                  "apps1_open")
    node.name = f"row {identifier}"
    fields = node.fields(_ROW, needed=_NEEDED)  # once more, so that a mistake names the row
    drives = [situations[n.one_of(list(situations))] for n in fields["drive"].items()]
    situation = drives[drive]
    scenario = Scenario(node.path, fields["what"].words(), arguments=_arguments(fields, of_all), behind=_behind(fields))
    if "proves" in fields:
        scenario.proves = [n.value(requirements.requirement).id for n in fields["proves"].items()]
    car = Car(dbc, (*of_all.arguments, *scenario.arguments))
    row = Row(node.raw.start_mark.line + 1, identifier, fields["group"].words(), scenario.title, situation, scenario)
    if "only_with" in fields:
        row.only_with = fields["only_with"].value(lambda text: _unlike(text, car))
    if row.only_with:
        return row  # what it says need not be a thing of this car
    scenario.given = [read_step(step, car) for step in situation.given]
    scenario.when = [read_step(step, car) for step in fields["when"].items()]
    for step, place in zip(scenario.when, fields["when"].items(), strict=True):
        check_reached(step, scenario.behind, place)
    own = fields["meanwhile"].items() if "meanwhile" in fields else situation.meanwhile
    scenario.meanwhile = [read_step(step, car) for step in own]
    row.rule = [n.value(_rule) for n in fields["rule"].items()] if "rule" in fields else []
    if not row.rule and not scenario.proves:
        raise node.error("found neither 'rule' nor 'proves', expected the rule or the requirement that it is about")
    row.fault = yaml.serialize(fields["when"].raw)
    row.own_meanwhile = "meanwhile" in fields
    row.vcan = "vcan" in fields and fields["vcan"].one_of(["true", "false"]) == "true"
    if row.vcan and scenario.needs_process:
        raise fields["vcan"].error("found true beside 'reset', which needs car and firmware in one process; leave it "
                                   "out")
    row.known = fields["known"].words() if "known" in fields else ""
    _read_expectations(row, node, fields, car)
    if "told_by" in fields:
        row.told_by = fields["told_by"].value(lambda text: Condition.parse(text, dbc))
    if drive + 1 < len(drives):
        row.otherwise = _row(node, situations, of_all, drive + 1)
    return row


def _unlike(text: str, car: Car) -> str:
    """Why a car is none that `KEY=WORD|WORD` says; nothing when it is one."""
    key, equals, words = text.partition("=")
    if not equals or not words:
        raise InputError(f"found {text!r}, expected KEY=WORD or KEY=WORD|WORD, such as bms.limit_method=equation")
    has = car.words.get(key)
    if has is None or has in words.split("|"):
        return ""
    return f"it is about a car with {key} {' or '.join(words.split('|'))}; this one has {has}"


def _read_expectations(row: Row, node: YamlNode, fields: dict[str, YamlNode], car: Car) -> None:
    dbc = car.dbc
    if ("sees" in fields) != ("seen_within" in fields):
        raise node.error("'sees' and 'seen_within' go together: what tells of the fault, and how soon")
    if "sees" in fields:
        condition = fields["sees"].value(lambda text: Condition.parse(text, dbc))
        row.seen = checks.reached(condition, fields["seen_within"].value(whole_bound))
    for name, make in _REACTIONS.items():
        if name in fields:
            row.reactions[name] = make(dbc, fields[name].value(whole_bound))
    row.more = [read_check(one, car) for one in fields["then"].items()] if "then" in fields else []
    if "goes_on" in fields:
        row.goes_on_ms = fields["goes_on"].value(lambda text: duration_ms(text, TICK_MS))
        if row.reactions:
            raise fields["goes_on"].error("found a car that goes on and one that is stopped, expected one of them")
    if not (row.seen or row.reactions or row.more or row.goes_on_ms):
        raise node.error("nothing is expected; give 'sees', a reaction, or 'goes_on' for a sound car that drives on")
    everything = [*([row.seen] if row.seen else []), *row.reactions.values(), *row.more]
    needed_ms = max([row.goes_on_ms, *(check.lasts_ms for check in everything)]) + checks.HOLD_MS
    row.scenario.observe_ms = fields["observe"].value(duration_ms) if "observe" in fields else needed_ms
    if row.scenario.observe_ms < needed_ms:
        raise fields["observe"].error(f"found {row.scenario.observe_ms:g} ms, expected at least the {needed_ms:g} ms "
                                      "that what is expected needs")


def whole_bound(text: str) -> float:
    """A bound that is a whole number of ticks, as all that is measured."""
    total = bound_of(text)
    ticks(f"{total:g} ms")
    return total


def _rule(text: str) -> str:
    if _RULE.fullmatch(text) is None:
        raise InputError(f"found {text!r}, expected the id of a rule such as T.4.2.4 or EV.7.3")
    return text


def _behind(fields: dict[str, YamlNode]) -> tuple[str, ...]:
    if "behind" not in fields:
        return _BEHIND_USUAL
    return tuple(n.one_of(list(ECUS)) for n in fields["behind"].items())


def _arguments(fields: dict[str, YamlNode], car: Car) -> list[str]:
    """What plant and ECUs are told: settings `KEY=VALUE`, one or a list."""
    if "arguments" not in fields:
        return []
    words = [word for n in fields["arguments"].items() for word in ("--set", n.words())]
    try:
        Car(car.dbc, (*car.arguments, *words)).check_arguments()
    except InputError as error:
        raise fields["arguments"].error(str(error)) from None
    return words
