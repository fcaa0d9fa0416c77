# SPDX-License-Identifier: Apache-2.0
"""Frames into a file: candump -l (.log), Vector ASC (.asc) or BLF (.blf). Lockstep frames are left out."""
from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TextIO

import can

from .errors import InputError, check_place
from .frame import EXTENDED, Frame

SUFFIXES = (".log", ".asc", ".blf")


def check_name(path: Path) -> None:
    """What can be said before a run: the suffix names a form, and there is a folder to write to."""
    if path.suffix not in SUFFIXES:
        raise InputError(f"{path}: found {path.suffix or 'no suffix'}, expected one of {', '.join(SUFFIXES)}")
    check_place(path)


class _CandumpWriter:
    """Lines as `candump -l` writes them; python-can's writer adds a direction, which canplayer does not know."""

    def __init__(self, path: Path) -> None:
        self._file: TextIO = path.open("w")

    def __call__(self, message: can.Message) -> None:
        width = 8 if message.is_extended_id else 3
        self._file.write(f"({message.timestamp:.6f}) {message.channel} {message.arbitration_id:0{width}X}#"
                         f"{bytes(message.data).hex().upper()}\n")

    def stop(self) -> None:
        self._file.close()


class Recorder:
    """
    >>> with Recorder("run.blf", channel="vcan0") as record:
    ...     record.write(bus.read())
    """

    def __init__(self, path: str | Path, channel: str) -> None:
        self._path, self._channel = Path(path), channel
        check_name(self._path)
        try:
            self._writer = _CandumpWriter(self._path) if self._path.suffix == ".log" else can.Logger(self._path)
        except OSError as error:
            raise InputError(f"{path}: cannot write: {error.strerror}") from None

    def __enter__(self) -> Recorder:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def write(self, frames: Iterable[Frame]) -> None:
        for frame in frames:
            if not frame.lockstep:
                self._writer(can.Message(timestamp=frame.time_ms * 1e-3, arbitration_id=frame.id & ~EXTENDED,
                                         is_extended_id=bool(frame.id & EXTENDED), data=frame.data,
                                         channel=self._channel))

    def close(self) -> None:
        self._writer.stop()
