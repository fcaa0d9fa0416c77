# SPDX-License-Identifier: Apache-2.0
"""Numbers with units as a person writes them: 100 ms, 2.5 s, 40 %, -3.2 A."""
from __future__ import annotations

import re

from .errors import InputError

TICK_MS = 10
_NUMBER = re.compile(r"\s*([-+]?\d+(?:\.\d+)?)\s*(\S*)\s*")
_MILLISECONDS = {"ms": 1.0, "s": 1000.0, "min": 60_000.0}


def number(text: object, unit: str) -> float:
    """The number of `text`, which must carry `unit`; a bare number will do where there is no unit."""
    match = _NUMBER.fullmatch(str(text))
    if match is None or match[2] != unit:
        example = f"a number with unit, such as '10 {unit}'" if unit else "a number without unit"
        raise InputError(f"found {str(text)!r}, expected {example}")
    return float(match[1])


def duration_ms(text: object) -> float:
    match = _NUMBER.fullmatch(str(text))
    if match is None or match[2] not in _MILLISECONDS or float(match[1]) < 0.0:
        raise InputError(f"found {str(text)!r}, expected a time with unit, such as '100 ms' or '2 s'")
    return float(match[1]) * _MILLISECONDS[match[2]]


def ticks(text: object) -> int:
    """A time that is a whole number of ticks of 10 ms."""
    ms = duration_ms(text)
    if ms % TICK_MS:
        raise InputError(f"found {str(text)!r}, expected a multiple of {TICK_MS} ms")
    return round(ms / TICK_MS)
