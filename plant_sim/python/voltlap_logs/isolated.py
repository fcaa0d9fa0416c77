# SPDX-License-Identifier: Apache-2.0
"""Reading that a library may not survive: damaged bytes end asammdf's C code by a signal. It runs in a process of its
own, and what that one gave before it ended counts."""
from __future__ import annotations

import os
import pickle
import signal
from collections.abc import Callable, Iterator

from .errors import BrokenOff, LogError
from .tally import Tally


def told(error: BaseException) -> BaseException:
    """As it is where the programs know it; else where the file breaks off."""
    if isinstance(error, (LogError, BrokenOff, MemoryError, KeyboardInterrupt)):
        return error
    words = " ".join(str(error).split()) or type(error).__name__
    return BrokenOff(f"its blocks of frames cannot be read ({words})")


def work(lines: Callable[[Tally], Iterator[str]], tally: Tally, into: int) -> None:
    """In the child: every text, then what was counted and how it ended. It never returns."""
    try:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)  # the last words of a library in C
        with os.fdopen(into, "wb") as out:
            ended: BaseException | None = None
            try:
                for text in lines(tally):
                    pickle.dump(text, out)
                    out.flush()
            except BaseException as error:
                ended = told(error)
            pickle.dump((tally.skipped, tally.first, tally.facts, ended), out)
    finally:
        os._exit(0)


def isolated(lines: Callable[[Tally], Iterator[str]], tally: Tally) -> Iterator[str]:
    """What `lines` yields and raises. Raises BrokenOff where its process was ended by a signal."""
    readable, writable = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(readable)
        work(lines, tally, writable)
    os.close(writable)
    ended: BaseException | None = None
    try:
        with os.fdopen(readable, "rb") as given:
            while True:
                try:
                    item = pickle.load(given)
                except (EOFError, pickle.UnpicklingError):
                    ended = BrokenOff("its blocks of frames cannot be read (a damaged one ends the library that reads)")
                    break
                if not isinstance(item, str):
                    tally.skipped, tally.first, tally.facts, ended = item
                    break
                yield item
    finally:
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
    if ended is not None:
        raise ended
