# SPDX-License-Identifier: Apache-2.0
"""What goes wrong with a file: each message says where, what was found, what was expected, what to do."""
from __future__ import annotations

import importlib
import sys
from collections.abc import Callable
from types import ModuleType

CANNOT = 2  # exit code: nothing useful could be read or written
BROKE_OFF = 3  # exit code: everything before the place was read


class LogError(Exception):
    """The file cannot be read or written as asked."""


class BrokenOff(Exception):
    """The file ends in the middle of something, or is damaged there; what stood before it has been read."""


def need(module: str) -> ModuleType:
    """A package of toolchain/requirements/logs.txt, imported when it is first needed."""
    try:
        return importlib.import_module(module)
    except ImportError as missing:
        raise LogError(f"the Python package {missing.name or module} is missing: `./voltlap log` installs it, or "
                       "`pip install -r toolchain/requirements/logs.txt`") from missing


def run(main: Callable[[], int]) -> int:
    """The exit code of a program, each failure as one line on stderr."""
    try:
        return main()
    except LogError as error:
        print(error, file=sys.stderr)
    except OSError as error:
        if isinstance(error, BrokenPipeError):  # who read the frames has seen enough
            sys.stdout = None
            return 141
        print(f"{error.filename or 'a file'}: {error.strerror or error}", file=sys.stderr)
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return 130
    except MemoryError:
        print("not enough memory for this file", file=sys.stderr)
    return CANNOT
