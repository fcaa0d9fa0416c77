# SPDX-License-Identifier: Apache-2.0
"""The rows of several groups in the order of their times."""
from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .errors import need
from .signal_folder import Signals

if TYPE_CHECKING:
    import numpy as np

    Array = np.ndarray[Any, Any]


def by_time(signals: Signals) -> tuple[Array, Array, Array]:
    """(time_s, number of the group, row in the group) of every row; equal times stay in the order of the groups."""
    np = need("numpy")
    times = np.concatenate([group.times() for group in signals.groups])
    owner = np.concatenate([np.full(group.rows, k, np.int32) for k, group in enumerate(signals.groups)])
    row = np.concatenate([np.arange(group.rows, dtype=np.int32) for group in signals.groups])
    order = np.argsort(times, kind="stable")
    return times[order], owner[order], row[order]
