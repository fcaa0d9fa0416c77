# SPDX-License-Identifier: Apache-2.0
"""Shares with intervals, nothing more."""

import math
from dataclasses import dataclass

Z95 = 1.959963984540054


@dataclass(frozen=True)
class Share:
    """`hits` of `of`, with the 95 % interval of E. B. Wilson (1927)."""

    hits: int
    of: int

    @property
    def value(self):
        return self.hits / self.of if self.of else float("nan")

    @property
    def interval(self):
        if self.of == 0:
            return 0.0, 1.0
        square = Z95 * Z95
        middle = (self.value + square / (2 * self.of)) / (1 + square / self.of)
        half = (
            Z95
            / (1 + square / self.of)
            * math.sqrt(self.value * (1 - self.value) / self.of + square / (4 * self.of * self.of))
        )
        return max(0.0, middle - half), min(1.0, middle + half)

    def __str__(self):
        if self.of == 0:
            return "no case"
        low, high = self.interval
        return f"{100 * self.value:5.1f} % [{100 * low:.1f}, {100 * high:.1f}] {self.hits}/{self.of}"


def share(flags):
    flags = list(flags)
    return Share(sum(map(bool, flags)), len(flags))


def median(values):
    values = sorted(values)
    if not values:
        return float("nan")
    middle = len(values) // 2
    return values[middle] if len(values) % 2 else 0.5 * (values[middle - 1] + values[middle])
