# SPDX-License-Identifier: Apache-2.0
"""Numbers with units as a person writes them: 100 ms, 2.5 s, 40 %, -3.2 A."""
from __future__ import annotations

import math
import re

from .errors import InputError

TICK_MS = 10
LONGEST_MS = 24 * 3_600_000.0
_NUMBER = re.compile(r"\s*([-+]?[0-9]+(?:\.[0-9]+)?)\s*(\S*)\s*")
_WHOLE = re.compile(r"[-+]?[0-9]{1,15}")
_MILLISECONDS = {"ms": 1.0, "s": 1000.0, "min": 60_000.0}


def number(text: object, unit: str, low: float = -math.inf, high: float = math.inf) -> float:
    """The number of `text`, which must carry `unit`; a bare number will do where there is no unit."""
    match = _NUMBER.fullmatch(str(text))
    if match is None or match[2] != unit or not math.isfinite(float(match[1])):
        example = f"a number with unit, such as '10 {unit}'" if unit else "a number without unit"
        raise InputError(f"found {str(text)!r}, expected {example}")
    value = float(match[1])
    if not low <= value <= high:
        raise InputError(f"found {str(text)!r}, expected {with_unit(low, unit)} to {with_unit(high, unit)}")
    return value


def whole(text: object, low: int | None = None, high: int | None = None) -> int:
    """A whole number without unit, as of frames or bits."""
    if _WHOLE.fullmatch(str(text)) is None:
        raise InputError(f"found {str(text)!r}, expected a whole number without unit")
    value = int(str(text))
    if low is not None and value < low or high is not None and value > high:
        raise InputError(f"found {value}, expected a whole number from {low} to {high}")
    return value


def duration_ms(text: object, least_ms: float = 0.0) -> float:
    match = _NUMBER.fullmatch(str(text))
    if match is None or match[2] not in _MILLISECONDS or match[1].startswith("-"):
        raise InputError(f"found {str(text)!r}, expected a time with unit, such as '100 ms' or '2 s'")
    ms = round(float(match[1]) * _MILLISECONDS[match[2]], 6) if len(match[1]) < 20 else math.inf
    if not least_ms <= ms <= LONGEST_MS:
        raise InputError(f"found {str(text)!r}, expected a time from {least_ms:g} ms to {LONGEST_MS / 3.6e6:g} h")
    return ms


def ticks(text: object, least: int = 0) -> int:
    """A time that is a whole number of ticks of 10 ms."""
    ms = duration_ms(text, least * TICK_MS)
    if ms % TICK_MS:
        raise InputError(f"found {str(text)!r}, expected a multiple of {TICK_MS} ms")
    return round(ms / TICK_MS)


def with_unit(value: float, unit: str) -> str:
    return f"{value:.10g} {unit}".strip()
