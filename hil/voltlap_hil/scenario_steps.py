# SPDX-License-Identifier: Apache-2.0
"""The steps of a scenario file: one reader a verb, in the table at the end."""
from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

from .condition import Condition
from .dbc import Dbc, Signal, Value
from .errors import InputError
from .faults import Fault
from .quantity import duration_ms, number, ticks
from .rig import STAGES, START_UP_NEEDS, SWITCHES, Rig
from .yaml_node import YamlNode


@dataclass(frozen=True)
class Step:
    """`needs`: signals it looks at."""

    text: str
    act: Callable[[Rig], None]
    needs: tuple[str, ...] = ()
    needs_gateway: bool = False


def read_step(node: YamlNode, dbc: Dbc) -> Step:
    verb, value = node.single(list(_READERS))
    return _READERS[verb](value, dbc)


def _start_up(node: YamlNode, _: Dbc) -> Step:
    stage = node.one_of(list(STAGES))
    return Step(f"start up to {stage}", lambda rig: rig.start_up(stage), START_UP_NEEDS)


_SWITCH_STATES = {"released": "Off", "pressed": "On", "open": "Off", "closed": "On", "automatic": "Automatic"}


def _driver(node: YamlNode, _: Dbc) -> Step:
    pedals: dict[str, float] = {}
    switches: dict[str, str] = {}
    for name, value in node.fields(["accelerator", "brake", *SWITCHES]).items():
        if name in SWITCHES:
            words = ["closed", "open"] if name == "shutdown" else ["pressed", "released"]
            switches[name] = _SWITCH_STATES[value.one_of([*words, "automatic"])]
        else:
            pedals[name] = value.value(_pedal)
    return Step("driver", lambda rig: rig.driver(**pedals, **switches))  # type: ignore[arg-type]


def _pedal(text: str) -> float:
    percent = number(text, "%")
    if not 0.0 <= percent <= 100.0:
        raise InputError(f"found {text!r}, expected 0 % to 100 %")
    return percent


# Unit of a fault's value, and how many of its codes one unit is.
_FAULT_VALUES = {"CellOffset": ("mV", 1), "Apps1Offset": ("mV", 1), "ThermistorOffset": ("degC", 10),
                 "CellResistanceScale": ("", 100)}


def _plant(node: YamlNode, dbc: Dbc) -> Step:
    found = node.fields(["fault", "index", "value"], needed=["fault"])
    fault = found["fault"].one_of(list(dbc.signal("PlantFault.Fault").states.values()))
    index = int(found["index"].value(lambda text: number(text, ""))) if "index" in found else 0
    value = 0
    if fault in _FAULT_VALUES:
        unit, codes = _FAULT_VALUES[fault]
        if "value" not in found:
            raise node.error(f"'value' is missing: {fault} needs one, with unit {unit or 'none'}")
        value = round(found["value"].value(lambda text: number(text, unit)) * codes)
    elif "value" in found:
        raise found["value"].error(f"{fault} has no value")
    return Step(f"plant: {fault}", lambda rig: rig.plant(fault, index, value))


def _signals(node: YamlNode, message: str, dbc: Dbc) -> dict[str, Value | None]:
    row = dbc.message(message)
    return {name: value.value(partial(_signal_value, row.signals[name]))
            for name, value in node.fields(list(row.signals)).items()}


def _signal_value(signal: Signal, text: str) -> Value | None:
    if text == "invalid":
        return None
    return text if signal.states else number(text, signal.unit)


def _send(node: YamlNode, dbc: Dbc) -> Step:
    found = node.fields(["message", "signals"], needed=["message", "signals"])
    message = found["message"].one_of(list(dbc.messages))
    values = _signals(found["signals"], message, dbc)
    return Step(f"send {message}", lambda rig: rig.send(message, **values), (f"{message}.",))


# What each fault of the bus may say besides its messages and `for`.
_GATEWAY_WORDS = {"drop": ["every"], "silence": [], "delay": ["by"], "duplicate": ["copies"], "corrupt": ["bit"],
                  "replay": ["frames"], "stuck_counter": [], "babble": ["frames"],
                  "second_sender": ["signals", "counter_ahead"]}


def _gateway(node: YamlNode, dbc: Dbc) -> Step:
    fields = node.fields([*_GATEWAY_WORDS, *sorted({w for words in _GATEWAY_WORDS.values() for w in words}), "for"])
    kinds = [name for name in fields if name in _GATEWAY_WORDS]
    if len(kinds) != 1:
        raise node.error(f"found {len(kinds)} faults, expected one of {', '.join(_GATEWAY_WORDS)}")
    kind = kinds[0]
    for name, value in fields.items():
        if name not in [kind, "for", *_GATEWAY_WORDS[kind]]:
            raise value.error(f"{kind} has no {name!r}; it has {', '.join(['for', *_GATEWAY_WORDS[kind]])}")
    messages = [n.value(lambda text: _target(text, kind, dbc)) for n in fields[kind].items()]
    for_ms = fields["for"].value(duration_ms) if "for" in fields else None
    what = _gateway_what(kind, fields, messages, dbc)
    _check_fault(fields[kind], kind, messages, what, dbc)
    return Step(f"gateway: {kind}", lambda rig: rig.gateway(kind, messages, for_ms, **what), needs_gateway=True)


def _check_fault(node: YamlNode, kind: str, messages: list[str | int], what: dict[str, Any], dbc: Dbc) -> None:
    """As the rig will make it, but told with its place, before anything runs."""
    ids = frozenset(m.id for m in dbc.select(m for m in messages if isinstance(m, str)))
    try:
        Fault(kind, ids, **what).check_fits(dbc)
    except InputError as error:
        raise node.error(str(error)) from None


def _target(text: str, kind: str, dbc: Dbc) -> str | int:
    """A message, a group of messages or a node; a babbling node may use any identifier."""
    if kind == "babble" and text.startswith("0x"):
        try:
            return int(text, 16)
        except ValueError:
            raise InputError(f"found {text!r}, expected an identifier such as 0x001") from None
    dbc.select([text])
    return text


def _gateway_what(kind: str, fields: dict[str, YamlNode], messages: list[str | int], dbc: Dbc) -> dict[str, Any]:
    def count(name: str, default: int) -> int:
        return int(fields[name].value(lambda text: number(text, ""))) if name in fields else default

    if kind == "drop":
        return {"every": count("every", 1)}
    if kind == "delay":
        if "by" not in fields:
            raise fields[kind].error("'by' is missing: by how much, for example 'by: 30 ms'")
        return {"delay_ticks": fields["by"].value(ticks)}
    if kind == "duplicate":
        return {"copies": count("copies", 1)}
    if kind in ("replay", "babble"):
        return {"copies": count("frames", 1)}
    if kind == "corrupt":
        return {"bit": count("bit", 0) if "bit" in fields else None}
    if kind == "second_sender":
        values = _signals(fields["signals"], str(messages[0]), dbc) if "signals" in fields else {}
        return {"signals": values, "counter_ahead": count("counter_ahead", 1)}
    return {}


def _clear(node: YamlNode, _: Dbc) -> Step:
    what = node.one_of(["gateway", "plant"])
    if what == "gateway":
        return Step("clear the gateway", lambda rig: rig.clear_gateway(), needs_gateway=True)
    return Step("clear the plant's faults", lambda rig: rig.plant("ClearAll"))


def _kill(node: YamlNode, _: Dbc) -> Step:
    name = node.one_of(["bms", "master"])
    return Step(f"kill {name}", lambda rig: rig.kill(name))


def _run(node: YamlNode, _: Dbc) -> Step:
    duration = node.text()
    node.value(ticks)
    return Step(f"run {duration}", lambda rig: rig.run(duration))


def _wait(node: YamlNode, dbc: Dbc) -> Step:
    found = node.fields(["for", "within"], needed=["for", "within"])
    condition = found["for"].value(lambda text: Condition.parse(text, dbc))
    within = found["within"].text()
    found["within"].value(duration_ms)
    return Step(f"wait for {condition.text}", lambda rig: _ignore(rig.wait(condition, within)),
                tuple(s.name for s in condition.signals))


def _ignore(_: object) -> None:
    return None


_READERS: dict[str, Callable[[YamlNode, Dbc], Step]] = {
    "start_up": _start_up, "driver": _driver, "plant": _plant, "gateway": _gateway, "send": _send, "clear": _clear,
    "kill": _kill, "run": _run, "wait": _wait}
