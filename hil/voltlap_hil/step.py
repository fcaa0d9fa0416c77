# SPDX-License-Identifier: Apache-2.0
"""What a scenario does at one point of a run."""
from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from .dbc import Message
from .rig import Rig


@dataclass(frozen=True)
class Step:
    """`needs`: signals it looks at; `kills`: the node that is dead after it; `named`: messages that the gateway is told
    of by their own name.

    needs_process  only where car and firmware are one process
    automatic      the plant's own driver is asked for
    """

    text: str
    act: Callable[[Rig], None]
    needs: tuple[str, ...] = ()
    needs_gateway: bool = False
    kills: str = ""
    needs_process: bool = False
    automatic: bool = False
    named: tuple[Message, ...] = ()
