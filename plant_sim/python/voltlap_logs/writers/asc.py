# SPDX-License-Identifier: Apache-2.0
"""Vector ASC by python-can; stamps to the microsecond."""
from __future__ import annotations

from pathlib import Path

from ..candump import microseconds
from ..errors import need
from ..spool import Spool
from .blf import message


def write(path: Path, spool: Spool) -> None:
    channels = spool.channels(1)
    writer = need("can").ASCWriter(str(path))
    try:
        for frame in spool.frames():
            writer.on_message_received(message(frame, microseconds(frame.time_ns) * 1e-6, channels[frame.bus] - 1))
    finally:
        writer.stop()
