# SPDX-License-Identifier: Apache-2.0
"""GVRET CSV for SavvyCAN; stamps to the microsecond. It knows no remote and no error frames, and no flags of FD."""
from __future__ import annotations

from pathlib import Path

from ..candump import ERROR, EXTENDED, ID_MASK, microseconds
from ..spool import Spool


def write(path: Path, spool: Spool) -> None:
    channels = spool.channels(0)
    with path.open("w", newline="\n") as out:
        out.write("Time Stamp,ID,Extended,Dir,Bus,LEN,D1,D2,D3,D4,D5,D6,D7,D8\n")
        for frame in spool.frames():
            if frame.remote_length is not None or frame.id & ERROR:
                spool.tally.skip("error frames" if frame.id & ERROR else "remote frames")
                continue
            if frame.fd_flags is not None and (frame.fd_flags or len(frame.data) <= 8):
                spool.changed["FD frames without their flags, short ones as classic frames"] += 1
            extended = "true" if frame.id & EXTENDED else "false"
            cells = "".join(f"{byte:02X}," for byte in frame.data)
            out.write(f"{microseconds(frame.time_ns)},{frame.id & ID_MASK:08X},{extended},Rx,{channels[frame.bus]},"
                      f"{len(frame.data)},{cells}\n")
