# SPDX-License-Identifier: Apache-2.0
"""The wire between the runner and the guest: frames on one serial line, binary-safe in both directions.

frame = kind u8, length u32 little-endian, payload
Standard input has credit: the runner sends at most CREDIT bytes that the command has not taken yet. So a command that
never reads keeps no signal from getting through, and the guest's line buffer (4096 bytes) is never full: the line
driver of the user-mode kernel then throttles, and may never wake up again (seen with 6.1.176).
"""
import struct

HEADER = struct.Struct("<BI")
CREDIT = 2048
CHUNK = 1 << 14

# runner -> guest
STDIN, STDIN_END, SIGNAL, RESIZE = range(1, 5)
# guest -> runner
READY, STDOUT, STDERR, TAKEN, EXIT, REFUSED = range(11, 17)


def frame(kind, payload=b""):
    return HEADER.pack(kind, len(payload)) + payload


class Reader:
    """Collects bytes and yields whole frames."""

    def __init__(self):
        self._pending = bytearray()

    def feed(self, data):
        self._pending += data
        while len(self._pending) >= HEADER.size:
            kind, length = HEADER.unpack_from(self._pending)
            end = HEADER.size + length
            if len(self._pending) < end:
                return
            payload = bytes(self._pending[HEADER.size:end])
            del self._pending[:end]
            yield kind, payload
