# SPDX-License-Identifier: Apache-2.0
"""The step `gateway` of a scenario file: a fault of the bus, checked as the gateway will be given it."""
from __future__ import annotations

import re
from functools import partial
from typing import Any

from .car import Car
from .dbc import Dbc, Message, Signal, Value
from .errors import InputError
from .faults import Fault
from .frame import EXTENDED, LOCKSTEP_FIRST, LOCKSTEP_LAST, is_lockstep
from .nodes import ECUS
from .quantity import TICK_MS, number, ticks, whole
from .scenario_sensors import read_sensor
from .step import Step
from .yaml_node import YamlNode

# What each fault of the bus may say besides its messages and `for`, and what Fault calls it.
_WORDS = {"drop": {"every": "every", "share": "share"},
          "silence": {}, "delay": {"by": "delay_ticks"}, "duplicate": {"copies": "copies"},
          "corrupt": {"bit": "bit"}, "replay": {"frames": "copies"}, "stuck_counter": {},
          "babble": {"frames": "copies"},
          "second_sender": {"signals": "signals", "counter_ahead": "counter_ahead"}}
# What it is where the file does not say.
_USUAL: dict[str, dict[str, Any]] = {
    "drop": {"every": 1}, "duplicate": {"copies": 1}, "corrupt": {"bit": None}, "replay": {"copies": 1},
    "babble": {"copies": 1}, "second_sender": {"signals": {}, "counter_ahead": 1}}


def read_gateway(node: YamlNode, car: Car) -> Step:
    if node.has("sensor"):
        return read_sensor(node, car)
    kind, fields = _kind_and_fields(node)
    targets = [n.value(partial(_target, kind=kind, dbc=car.dbc)) for n in fields[kind].items()]
    messages = car.dbc.select(t for t in targets if isinstance(t, str))
    for_ms = fields["for"].value(partial(ticks, least=1)) * float(TICK_MS) if "for" in fields else None
    what = dict(_USUAL.get(kind, {}))
    ids = frozenset([*(m.id for m in messages), *(t for t in targets if isinstance(t, int))])
    for name, field in _WORDS[kind].items():
        if name in fields:
            what[field] = _read_word(name, fields[name], messages)
            _check(fields[name], kind, ids, {field: what[field]}, car.dbc)
    _check(fields[kind], kind, ids, what, car.dbc)
    named = tuple(m for m in messages if m.name in targets and kind != "babble")  # that is a node of its own
    return Step(f"gateway: {kind}", lambda rig: rig.gateway(kind, targets, for_ms, **what), needs_gateway=True,
                named=named)


def check_reached(step: Step, behind: tuple[str, ...], node: YamlNode) -> None:
    """What goes between two nodes on the same side of the gateway does not go through it."""
    for message in step.named:
        sender = message.sender.lower()
        others = [name.lower() for name in sorted(message.receivers - {message.sender})]
        ecus = [name for name in others if name in ECUS] or others
        if not ecus or any((name in behind) != (sender in behind) for name in ecus):
            continue
        apart = sender if sender in ECUS else ecus[0]
        raise node.error(f"found {message.name}, from {sender} to {' and '.join(ecus)}, on the same side of the "
                         f"gateway, so that nothing of it is missed; expected them on its two sides (`behind: "
                         f"{apart}`, in a scenario `behind_gateway: [{apart}]`)")


def _kind_and_fields(node: YamlNode) -> tuple[str, dict[str, YamlNode]]:
    words = sorted({word for of_kind in _WORDS.values() for word in of_kind})
    fields = node.fields([*_WORDS, *words, "for"])
    kinds = [name for name in fields if name in _WORDS]
    if len(kinds) != 1:
        raise node.error(f"found {len(kinds)} faults, expected one of {', '.join(_WORDS)}")
    kind = kinds[0]
    for name, value in fields.items():
        if name not in [kind, "for", *_WORDS[kind]]:
            raise value.error(f"{kind} has no {name!r}; it has {', '.join(['for', *_WORDS[kind]])}")
    if kind == "delay" and "by" not in fields:
        raise fields[kind].error("'by' is missing: by how much, for example 'by: 30 ms'")
    return kind, fields


def _check(node: YamlNode, kind: str, ids: frozenset[int], what: dict[str, Any], dbc: Dbc) -> None:
    """As the rig will make it, but told with its place, before anything runs."""
    try:
        Fault(kind, ids, **what).check_fits(dbc)
    except InputError as error:
        raise node.error(str(error)) from None


_IDENTIFIER = re.compile(r"0x([0-9A-Fa-f]+)")


def _target(text: str, kind: str, dbc: Dbc) -> str | int:
    """A message, a group of messages or a node; a babbling node may use any identifier."""
    if kind != "babble" or not text.startswith("0x"):
        dbc.select([text])
        return text
    match = _IDENTIFIER.fullmatch(text)
    can_id = int(match[1], 16) if match else -1
    if match is None or can_id > 0x1FFF_FFFF:
        raise InputError(f"found {text!r}, expected an identifier from 0x000 to 0x7FF, or of 29 bits to "
                         "0x1FFFFFFF")
    if can_id > 0x7FF or len(match[1]) == 8:  # eight digits say 29 bits, as candump writes them
        return can_id | EXTENDED
    if is_lockstep(can_id):
        raise InputError(f"found {text!r}, expected one outside of 0x{LOCKSTEP_FIRST:X} to 0x{LOCKSTEP_LAST:X}, which "
                         "keep the nodes in step")
    return can_id


def _read_word(name: str, node: YamlNode, messages: list[Message]) -> Any:
    if name == "by":
        return node.value(partial(ticks, least=1))
    if name == "share":
        return 0.01 * float(node.value(partial(number, unit="%", low=0.0, high=100.0)))
    if name == "signals":
        return read_signals(node, messages)
    if name == "counter_ahead" and not all(message.counter for message in messages):
        without = next(message.name for message in messages if not message.counter)
        raise node.error(f"{without} has no rolling counter, which could be ahead")
    return node.value(whole)


def read_signals(node: YamlNode, messages: list[Message]) -> dict[str, Value | None]:
    """Values of signals that every one of the messages has, each in its range."""
    common = [name for name in messages[0].signals if all(name in m.signals for m in messages)]
    return {name: [field.value(partial(_signal_value, m.signals[name])) for m in messages][0]
            for name, field in node.fields(common).items()}


def _signal_value(signal: Signal, text: str) -> Value | None:
    if signal.role in ("counter", "crc", "checksum"):
        raise InputError(f"{signal.name} is the {signal.role} that each frame gets when it is sent; leave it out")
    low, high = signal.range
    value = None if text == "invalid" else text if signal.states else number(text, signal.unit, low, high)
    signal.message.encode({signal.short_name: value})
    return value
