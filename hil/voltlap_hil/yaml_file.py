# SPDX-License-Identifier: Apache-2.0
"""The bytes of a scenario file as nodes of YAML. What is no plain page of YAML is told with its line, at once.

A file may come from anywhere: its size, its nesting and what its aliases stand for are bounded before they cost time.
"""
from __future__ import annotations

import codecs
import stat
from collections.abc import Callable
from pathlib import Path

import yaml

from .errors import InputError

_MOST_BYTES = 400_000  # four times the table of faults, two hundred times the longest scenario
_MOST_LEVELS = 20  # a scenario needs seven
_MOST_VALUES = 80_000  # with every alias followed
_OTHER_ENCODINGS = ((codecs.BOM_UTF32_LE, "UTF-32"), (codecs.BOM_UTF32_BE, "UTF-32"), (codecs.BOM_UTF16_LE, "UTF-16"),
                    (codecs.BOM_UTF16_BE, "UTF-16"))  # the longer marks first: UTF-32 begins as UTF-16 does
_NO_FILE = ((stat.S_ISDIR, "a folder"), (stat.S_ISCHR, "a device"), (stat.S_ISBLK, "a device"),
            (stat.S_ISFIFO, "a pipe"), (stat.S_ISSOCK, "a socket"))


class _Refusal(yaml.MarkedYAMLError):
    """It is YAML, and nothing that a scenario has a use for."""

    def __init__(self, problem: str, mark: yaml.Mark) -> None:
        super().__init__(problem=problem, problem_mark=mark)


class _Loader(yaml.SafeLoader):
    """Composes nodes and makes no objects of them."""

    def __init__(self, text: str) -> None:
        super().__init__(text)
        self._levels = 0
        self._values = 0
        self._values_of: dict[int, int] = {}  # by node, once it is whole

    def compose_node(self, parent: yaml.Node | None, index: object) -> yaml.Node | None:
        event = self.peek_event()
        self._levels += 1
        if self._levels > _MOST_LEVELS:
            raise _Refusal(f"found brackets or indents more than {_MOST_LEVELS} levels deep, expected a scenario; "
                           "close what is open", event.start_mark)
        if getattr(event, "tag", None) is not None:
            raise _Refusal(f"found the tag {str(event.tag)[:60]!r}, expected a plain value; leave the tag out",
                           event.start_mark)
        before = self._values
        node = super().compose_node(parent, index)  # type: ignore[arg-type]
        if isinstance(event, yaml.AliasEvent):
            if id(node) not in self._values_of:
                raise _Refusal(f"found the alias *{event.anchor} inside of what it stands for; write the value out",
                               event.start_mark)
            self._values += self._values_of[id(node)]
        else:
            self._values += 1
            self._values_of[id(node)] = self._values - before
        if self._values > _MOST_VALUES:
            raise _Refusal(f"found more than {_MOST_VALUES} values, aliases followed; expected a page; make it shorter",
                           event.start_mark)
        self._levels -= 1
        return node


def line_of(mark: yaml.Mark) -> int:
    """As an editor counts; what is missing at the end of a file is missed in its last line."""
    text = (mark.buffer or "").rstrip("\0\n")
    return text.count("\n", 0, min(mark.index, len(text))) + 1


def compose(path: Path, fill: Callable[[str], str] = str) -> yaml.Node:
    """The one document of a file."""
    text = fill(_decoded(path, _read(path)))
    if odd := yaml.SafeLoader.NON_PRINTABLE.search(text):
        line = text.count("\n", 0, odd.start()) + 1
        raise InputError(f"{path}:{line}: found the control character U+{ord(odd[0]):04X}, expected text; take it out")
    loader = _Loader(text)
    try:
        node = loader.get_single_node()
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or loader.get_mark()
        raise InputError(f"{path}:{line_of(mark)}: {_problem(error, mark)}") from None
    except (ValueError, OverflowError):  # an escape such as "\UFFFFFFFF"
        raise InputError(f"{path}:{line_of(loader.get_mark())}: found an escape that stands for no character; this is "
                         "no YAML") from None
    if node is None:
        raise InputError(f"{path}:1: the file is empty; expected a scenario")
    return node


def _problem(error: yaml.MarkedYAMLError, mark: yaml.Mark) -> str:
    if isinstance(error, _Refusal):
        return str(error.problem)
    if "another document" in str(error.problem):
        return "found a second document ('---'), expected one scenario a file"
    if (mark.buffer or "")[mark.index:mark.index + 1] == "\t":
        return "found a tab; indent with spaces. This is no YAML"
    problem = " ".join(str(part) for part in (error.context, error.problem) if part)
    return f"{problem[:200]}; this is no YAML"


def _read(path: Path) -> bytes:
    try:
        mode = path.stat().st_mode
        for is_such, what in _NO_FILE:
            if is_such(mode):
                raise InputError(f"{path}: found {what}, expected a file")
        with path.open("rb") as file:
            data = file.read(_MOST_BYTES + 1)
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from None
    except ValueError as error:  # a NUL in the name
        raise InputError(f"{str(path)!r}: {error}") from None
    if len(data) > _MOST_BYTES:
        raise InputError(f"{path}: found more than {_MOST_BYTES // 1000} kB, expected a scenario or a table of faults")
    return data


def _decoded(path: Path, data: bytes) -> str:
    """UTF-8, with or without a byte order mark; every line end as a line feed."""
    for mark, name in _OTHER_ENCODINGS:
        if data.startswith(mark):
            raise InputError(f"{path}:1: found {name}, expected UTF-8; save the file as UTF-8")
    if len(data) > 1 and (data[0] == 0) != (data[1] == 0):
        raise InputError(f"{path}:1: found what looks like UTF-16, expected UTF-8; save the file as UTF-8")
    data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"{path}:{data.count(10, 0, error.start) + 1}: found the byte 0x{data[error.start]:02X}, "
                         "which is no UTF-8 (Latin-1?); save the file as UTF-8") from None
