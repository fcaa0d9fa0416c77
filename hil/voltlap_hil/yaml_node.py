# SPDX-License-Identifier: Apache-2.0
"""A YAML file as a tree that knows where each value stands, so that a mistake is told with file, line and field."""
from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import yaml

from .errors import InputError, did_you_mean


class YamlNode:
    """A place in the file: says where it is when something is wrong with it."""

    def __init__(self, raw: yaml.Node, path: Path, name: str) -> None:
        self.raw, self.path, self.name = raw, path, name

    def error(self, text: str) -> InputError:
        return InputError(f"{self.path}:{self.raw.start_mark.line + 1}: {self.name or 'file'}: {text}")

    def text(self) -> str:
        if not isinstance(self.raw, yaml.ScalarNode):
            raise self.error(f"found a {self.kind}, expected text or a number")
        return str(self.raw.value)

    @property
    def kind(self) -> str:
        return {yaml.MappingNode: "mapping", yaml.SequenceNode: "list"}.get(type(self.raw), "single value")

    def value(self, read: Callable[[str], Any]) -> Any:
        """What `read` makes of the text; its complaint gets the place."""
        try:
            return read(self.text())
        except InputError as error:
            if str(error).startswith(str(self.path)):
                raise
            raise self.error(str(error)) from None

    def one_of(self, known: list[str]) -> str:
        text = self.text()
        if text not in known:
            raise self.error(f"found {text!r}, expected one of {', '.join(known)}.{did_you_mean(text, known)}")
        return text

    def items(self) -> Iterator[YamlNode]:
        """A list; a single value counts as a list of one."""
        if not isinstance(self.raw, yaml.SequenceNode):
            yield self
            return
        for i, row in enumerate(self.raw.value):
            yield YamlNode(row, self.path, f"{self.name}[{i}]")

    def fields(self, known: list[str] | None = None, needed: list[str] | None = None) -> dict[str, YamlNode]:
        if not isinstance(self.raw, yaml.MappingNode):
            raise self.error(f"found a {self.kind}, expected a mapping with {', '.join(known or ['fields'])}")
        found: dict[str, YamlNode] = {}
        for key, value in self.raw.value:
            name = str(key.value)
            inner = YamlNode(value, self.path, f"{self.name}.{name}" if self.name else name)
            at_key = YamlNode(key, self.path, inner.name)
            if known is not None and name not in known:
                raise at_key.error(f"found {name!r}, expected one of {', '.join(known)}.{did_you_mean(name, known)}")
            if name in found:
                raise at_key.error(f"{name!r} stands here twice")
            found[name] = inner
        for name in needed or []:
            if name not in found:
                raise self.error(f"{name!r} is missing")
        return found

    def single(self, known: list[str]) -> tuple[str, YamlNode]:
        """The one `name: value` of a step or check."""
        found = self.fields(known)
        if len(found) != 1:
            raise self.error(f"found {len(found)} of them, expected one of {', '.join(known)}")
        return next(iter(found.items()))


def document(path: Path) -> YamlNode:
    try:
        raw = yaml.compose(path.read_text(), Loader=yaml.SafeLoader)
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from None
    except yaml.MarkedYAMLError as error:
        line = error.problem_mark.line + 1 if error.problem_mark else 1
        raise InputError(f"{path}:{line}: {error.problem}; this is no YAML") from None
    if raw is None:
        raise InputError(f"{path}: the file is empty")
    return YamlNode(raw, path, "")
