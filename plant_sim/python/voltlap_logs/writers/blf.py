# SPDX-License-Identifier: Apache-2.0
"""Vector BLF by python-can, with whole nanoseconds: python-can takes differences of times since 1970 as doubles, which
are 240 ns apart, so it is given times since the start."""
from __future__ import annotations

from pathlib import Path

from ..candump import BRS, ERROR, ESI, EXTENDED, ID_MASK, Frame
from ..errors import need
from ..spool import Spool

MILLISECOND = 1_000_000
EPOCH_NS = 631_152_000 * 1_000_000_000  # 1990: python-can writes no date for a start before


def message(frame: Frame, seconds: float, channel: int) -> object:
    extended = bool(frame.id & EXTENDED)
    return need("can").Message(
        timestamp=seconds, arbitration_id=frame.id & ID_MASK, is_extended_id=extended, channel=channel,
        is_remote_frame=frame.remote_length is not None, is_error_frame=bool(frame.id & ERROR),
        is_fd=frame.fd_flags is not None, bitrate_switch=bool((frame.fd_flags or 0) & BRS),
        error_state_indicator=bool((frame.fd_flags or 0) & ESI), data=frame.data,
        dlc=len(frame.data) if frame.remote_length is None else frame.remote_length)


def write(path: Path, spool: Spool) -> None:
    channels = spool.channels(1)
    dated = spool.first_ns >= EPOCH_NS
    start_ns = spool.first_ns // MILLISECOND * MILLISECOND if dated or spool.first_ns < 0 else 0
    if spool.first_ns < 0:
        spool.tally.facts["moved_s"] = -start_ns * 1e-9  # a BLF file has no time before 0
    writer = need("can").BLFWriter(str(path))
    try:
        writer.start_timestamp = 0.0
        last_ns = start_ns
        for frame in spool.frames():
            last_ns = max(last_ns, frame.time_ns)
            # python-can counts from 0 and writes one more
            writer.on_message_received(message(frame, (frame.time_ns - start_ns) * 1e-9, channels[frame.bus] - 1))
        writer.start_timestamp, writer.stop_timestamp = start_ns * 1e-9, last_ns * 1e-9
    finally:
        writer.stop()
