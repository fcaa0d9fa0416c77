# SPDX-License-Identifier: Apache-2.0
"""A classic CAN frame with the time at which it counts: simulated time in lockstep, the bus's time otherwise."""
from __future__ import annotations

from typing import NamedTuple

EXTENDED = 0x8000_0000  # the kernel's flag for a 29-bit identifier
REMOTE = 0x4000_0000
ERROR = 0x2000_0000
LOCKSTEP_FIRST, LOCKSTEP_LAST = 0x7E0, 0x7FF


class Frame(NamedTuple):
    id: int  # bit 31 set: extended
    data: bytes
    time_ms: float = 0.0

    @property
    def lockstep(self) -> bool:
        return is_lockstep(self.id)


def is_lockstep(can_id: int) -> bool:
    return LOCKSTEP_FIRST <= can_id <= LOCKSTEP_LAST
