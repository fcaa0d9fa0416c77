# SPDX-License-Identifier: Apache-2.0
"""Where the runner was called from: its terminal, its streams, and the signals that are meant for the command."""
import fcntl
import os
import signal
import struct
import termios

FORWARDED = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)


def in_foreground(descriptor):
    try:
        return os.tcgetpgrp(descriptor) == os.getpgrp()
    except OSError:
        return False


def same_place(one, other):
    try:
        first, second = os.fstat(one), os.fstat(other)
    except OSError:
        return False
    return (first.st_dev, first.st_ino) == (second.st_dev, second.st_ino)


def window_size():
    rows, columns, _, _ = struct.unpack("HHHH", fcntl.ioctl(0, termios.TIOCGWINSZ, bytes(8)))
    return rows, columns


class Signals:
    """Those that are for the command, from now on kept until they are passed on."""

    def __init__(self):
        self.wake, self._wake_end = os.pipe()
        self._waiting = []
        for number in (*FORWARDED, signal.SIGWINCH):
            if signal.getsignal(number) != signal.SIG_IGN:
                signal.signal(number, self._keep)

    def _keep(self, number, _):
        self._waiting.append(number)
        os.write(self._wake_end, b"!")

    def take(self):
        os.read(self.wake, 1)
        return self._waiting.pop(0)

    def first_to_end(self):
        """The first that asks for an end, or None."""
        return next((number for number in self._waiting if number in FORWARDED), None)
