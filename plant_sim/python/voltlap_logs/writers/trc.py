# SPDX-License-Identifier: Apache-2.0
"""PEAK TRC 2.1, written plainly: python-can's writer knows data frames only. Stamps to the microsecond. Of an error
frame it holds which error was on the line."""
from __future__ import annotations

from datetime import datetime, timezone
from decimal import Decimal
from pathlib import Path

from ..candump import BRS, ERROR, ESI, EXTENDED, LINE_ERRORS, NS, Frame, fd_code, microseconds
from ..spool import Spool

MILLISECOND = 1_000_000
DAY_NS, DAYS_TO_1970 = 86400 * NS, 25569
FD_TYPES = {0: "FD", BRS: "FB", BRS | ESI: "FE", ESI: "BI"}
OTHER_ERROR = 8
COLUMNS = """;   Message   Time    Type    ID     Rx/Tx
;   Number    Offset  |  Bus  [hex]  |  Reserved
;   |         [ms]    |  |    |      |  |  Data Length Code
;   |         |       |  |    |      |  |  |    Data [hex] ...
;---+-- ------+------ +- +- --+----- +- +- +--- +- -- -- -- -- -- -- --
"""


def header(start_ns: int, channels: dict[str, int]) -> str:
    days = (Decimal(start_ns) / DAY_NS + DAYS_TO_1970).quantize(Decimal("1.000000000000"))
    start = datetime.fromtimestamp(start_ns // NS, timezone.utc)
    rule = ";" + "-" * 79 + "\n"
    buses = "".join(f";   {number:<5} {bus}\n" for bus, number in channels.items())
    return (f";$FILEVERSION=2.1\n;$STARTTIME={days}\n;$COLUMNS=N,O,T,B,I,d,R,L,D\n;\n"
            f";   Start time: {start:%d.%m.%Y %H:%M:%S}.{start_ns % NS // MILLISECOND:03d} UTC\n{rule}"
            f";   Bus   Name\n{buses}{rule}{COLUMNS}")


def row(number: int, frame: Frame, since_us: int, channel: int) -> str:
    kind, id, data = "DT", f"{frame.id & ~EXTENDED:0{8 if frame.id & EXTENDED else 4}X}", frame.data
    code = frame.remote_length if frame.remote_length is not None else fd_code(len(data))
    if frame.id & ERROR:
        protocol = data[2] if len(data) > 2 else 0
        error = next((code for code, bit in LINE_ERRORS.items() if bit == protocol), OTHER_ERROR)
        kind, id, code, data = "ER", "-", 5, bytes((error, 0, 0, 0, 0))
    elif frame.remote_length is not None:
        kind = "RR"
    elif frame.fd_flags is not None:
        kind = FD_TYPES[frame.fd_flags]
    words = f"{number:>7} {since_us // 1000:>9}.{since_us % 1000:03d} {kind} {channel:>2} {id:>8} Rx -  {code:<4}"
    return f"{words} {data.hex(' ').upper()}".rstrip() + "\n"


def write(path: Path, spool: Spool) -> None:
    channels = spool.channels(1)
    start_ns = spool.first_ns // MILLISECOND * MILLISECOND
    with path.open("w", newline="\r\n") as out:
        out.write(header(start_ns, channels))
        for number, frame in enumerate(spool.frames(), 1):
            if frame.id & ERROR:
                spool.changed["error frames without their class"] += 1
            out.write(row(number, frame, microseconds(frame.time_ns - start_ns), channels[frame.bus]))
