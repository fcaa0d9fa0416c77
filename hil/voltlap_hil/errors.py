# SPDX-License-Identifier: Apache-2.0
"""What goes wrong outside of a check: each message says where, what was found, what was expected, what to do."""
from __future__ import annotations

import difflib
import os
from collections.abc import Iterable
from pathlib import Path


class HilError(Exception):
    """The scenario could not be run: a node died, an interface is missing, a condition never came."""


class InputError(HilError):
    """Something that a person wrote is wrong: a name, a number, a file."""


def check_place(path: Path) -> None:
    """That a file can stand there, before the work whose result it takes is done."""
    if os.path.isdir(path):
        raise InputError(f"{path}: cannot write: it is a folder")
    if not os.path.isdir(path.parent):
        raise InputError(f"{path}: cannot write: no folder {path.parent}")


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """' Did you mean A or B?', or nothing when no known word is near."""
    near = difflib.get_close_matches(word, list(known), n=2, cutoff=0.6)
    return f" Did you mean {' or '.join(near)}?" if near else ""
