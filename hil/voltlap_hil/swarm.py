# SPDX-License-Identifier: Apache-2.0
"""Drawn scenarios: a car, a drive and up to two faults of the table, all from one seed; and a smaller one that fails
in the same way."""
from __future__ import annotations

import random
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

from .car import Car
from .car_quantities import full_phase_current_a
from .errors import HilError
from .fault_table import Row
from .invariants import Drive, broken
from .rig import Rig

# What is drawn from: two packs, and every inverter that the firmware speaks to.
CARS = {"vtm16e": ("--vehicle", "vtm16e"), "vtm17e": ("--vehicle", "vtm17e"), "amk_4wd": ("--vehicle", "amk_4wd"),
        "vtm16e with a PM100": ("--vehicle", "vtm16e", "--set", "inverter.protocol=pm100")}
TRACKS = ("michigan_2014", "michigan_2015")
_DRIVING = ("full", "rolling", "stand", "lifts", "lifts_rolling", "lap", "amk_full", "amk_stand",
            "pm100_full", "pm100_stand")
_LONGEST_MS, _PIECE_MS, _AFTER_MS = 9000, (100, 1500), 1500
DRIVEN_MS = _LONGEST_MS + _AFTER_MS  # at least, of a scenario, from ready to drive on
_USUAL: dict[str, Any] = {"vehicle": "vtm16e", "soc": 1.0, "celsius": 27, "weak": 1.0, "noise": False, "loss": 0}


@dataclass(frozen=True)
class Piece:
    """So long with these pedals [%]."""

    ms: int
    accelerator: int
    brake: int


@dataclass(frozen=True)
class Drawn:
    """A scenario. `foot` empty: the plant's own driver. Faults: (row, ms after the car is ready)."""

    seed: int
    vehicle: str
    track: str
    soc: float
    celsius: int
    weak: float       # factor on the resistance of one cell
    noise: bool
    loss: int         # [%] of all frames
    foot: tuple[Piece, ...]
    faults: tuple[tuple[str, int], ...] = field(default=())
    own: tuple[str, ...] = ()  # arguments of a car that was named, instead of `vehicle`

    def __str__(self) -> str:
        pieces = [f"{p.ms} ms {p.accelerator} %/{p.brake} %" for p in self.foot]
        foot = ", ".join(pieces) or f"laps of {self.track}"
        faults = ", ".join(f"{row} at {ms} ms" for row, ms in self.faults) or "none"
        car = (f"{' '.join(self.own) or self.vehicle}, charge {100 * self.soc:.0f} %, {self.celsius} degC, "
               f"a cell with {self.weak:g} times "
               "the resistance")
        return (f"{car}, {'noise' if self.noise else 'no noise'}, {self.loss} % of the frames lost; foot: {foot}; "
                f"faults: {faults}")

    @property
    def arguments(self) -> list[str]:
        settings = [f"battery.initial_soc={self.soc:g}", f"battery.initial_temperature_c={self.celsius}",
                    f"environment.ambient_c={self.celsius}", f"battery.cells.3.resistance_scale={self.weak:g}",
                    f"sensors.noise={'true' if self.noise else 'false'}"]
        return [*(self.own or CARS[self.vehicle]),
                *(word for setting in settings for word in ("--set", setting))]


def usable(rows: Sequence[Row]) -> list[Row]:
    """Rows whose fault may come at any moment of a drive of this car: no car or drive of their own."""
    return [row for row in rows if row.situation.name in _DRIVING and not row.scenario.arguments
            and not row.own_meanwhile and not row.known and not row.only_with]


def draw(seed: int, usable_of: Mapping[str, Sequence[Row]], own: tuple[str, ...] = ()) -> Drawn:
    """`usable_of`: the rows of each car; of one alone where it is named by `own`."""
    source = random.Random(seed)
    vehicle = source.choice(list(usable_of))
    rows = usable_of[vehicle]
    laps = source.random() < 0.25
    foot: list[Piece] = []
    while not laps and sum(p.ms for p in foot) < _LONGEST_MS:
        kind = source.choice(("accelerator", "accelerator", "accelerator", "brake", "none"))
        ms = 10 * source.randint(_PIECE_MS[0] // 10, _PIECE_MS[1] // 10)
        foot.append(Piece(ms, source.randint(10, 100) if kind == "accelerator" else 0,
                          source.randint(5, 80) if kind == "brake" else 0))
    faults: list[tuple[str, int]] = []
    first: Row | None = None
    for _ in range(source.choice((0, 1, 1, 2, 2))):
        row = source.choice([r for r in rows if first is None or r.scenario.behind == first.scenario.behind])
        first = first or row
        faults.append((row.id, 10 * source.randint(0, _LONGEST_MS // 10)))
    return Drawn(seed, vehicle, source.choice(TRACKS), round(source.uniform(0.3, 1.0), 2),
                 source.randint(5, 40), round(source.uniform(1.0, 1.4), 2), source.random() < 0.5,
                 source.choice((0, 0, 1, 2)), tuple(foot), tuple(sorted(faults, key=lambda f: f[1])), own)


def check(drawn: Drawn, rows: dict[str, Row], open_rig: Callable[..., Rig], car: Car) -> list[str]:
    """What the run broke, as sentences that begin with the name of the invariant."""
    faults = [rows[name] for name, _ in drawn.faults]
    behind = faults[0].scenario.behind if faults else ("bms", "master")
    automatic = {} if drawn.foot else {"automatic": True}
    arguments = [*drawn.arguments, *(["--track", drawn.track] if not drawn.foot else [])]
    with open_rig(gateway=True, behind=behind, arguments=arguments, seed=drawn.seed, **automatic) as rig:
        try:
            rig.start_up("ready_to_drive" if drawn.foot else "automatic")
        except HilError as error:
            return [f"ready: {error}"]
        ready_ms = rig.now_ms
        if drawn.loss:
            rig.gateway("drop", ["PLANT", "BMS", "MASTER"], share=0.01 * drawn.loss)
        _act(drawn, rows, rig)
        rig.run(f"{_AFTER_MS} ms")
        return broken(Drive(rig.dbc, rig.trace, ready_ms, bool(drawn.foot), drawn.loss, tuple(faults),
                            full_phase_current_a(car)))


def _act(drawn: Drawn, rows: dict[str, Row], rig: Rig) -> None:
    """Feet and faults in the order of their times; a fault that takes time of its own delays the foot."""
    events: list[tuple[int, Callable[[], None]]] = []
    at_ms = 0
    for piece in drawn.foot:
        events.append((at_ms, partial(rig.driver, piece.accelerator, piece.brake)))
        at_ms += piece.ms
    for name, ms in drawn.faults:
        events.append((ms, partial(_break, rows[name], rig)))
    begin_ms = rig.now_ms
    for ms, act in sorted(events, key=lambda event: event[0]):
        rig.run(f"{max(0.0, begin_ms + ms - rig.now_ms):g} ms")
        act()
    rig.run(f"{max(0.0, begin_ms + _LONGEST_MS - rig.now_ms):g} ms")


def _break(row: Row, rig: Rig) -> None:
    for step in row.scenario.when:
        step.act(rig)


def smallest(drawn: Drawn, fails: Callable[[Drawn], bool]) -> Drawn:
    """Nothing can be left out of it without it passing."""
    while True:
        for smaller in _smaller(drawn):
            if fails(smaller):
                drawn = smaller
                break
        else:
            return drawn


def _smaller(drawn: Drawn) -> Iterator[Drawn]:
    for i in range(len(drawn.faults)):
        yield replace(drawn, faults=drawn.faults[:i] + drawn.faults[i + 1:])
    for name, usual in _USUAL.items():
        if getattr(drawn, name) != usual:
            yield replace(drawn, **{name: usual})
    if len(drawn.foot) > 1:
        half = len(drawn.foot) // 2
        yield replace(drawn, foot=drawn.foot[:half])
        yield from (replace(drawn, foot=drawn.foot[:i] + drawn.foot[i + 1:]) for i in range(len(drawn.foot)))
