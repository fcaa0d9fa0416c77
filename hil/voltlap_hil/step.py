# SPDX-License-Identifier: Apache-2.0
"""What a scenario does at one point of a run."""
from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from .rig import Rig


@dataclass(frozen=True)
class Step:
    """`needs`: signals it looks at; `kills`: the node that is dead after it."""

    text: str
    act: Callable[[Rig], None]
    needs: tuple[str, ...] = ()
    needs_gateway: bool = False
    kills: str = ""
