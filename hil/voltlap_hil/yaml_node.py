# SPDX-License-Identifier: Apache-2.0
"""A YAML file as a tree that knows where each value stands, so that a mistake is told with file, line and field."""
from __future__ import annotations

import unicodedata
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import yaml

from .errors import InputError, did_you_mean
from .yaml_file import compose, line_of

_MOST_CHARACTERS = 1000
_NULL, _BOOL = "tag:yaml.org,2002:null", "tag:yaml.org,2002:bool"


class YamlNode:
    """A place in the file: says where it is when something is wrong with it."""

    def __init__(self, raw: yaml.Node, path: Path, name: str) -> None:
        self.raw, self.path, self.name = raw, path, name

    def error(self, text: str) -> InputError:
        return InputError(f"{self.path}:{line_of(self.raw.start_mark)}: {self.name or 'file'}: {text}")

    def text(self) -> str:
        if not isinstance(self.raw, yaml.ScalarNode) or self.raw.tag == _NULL:
            raise self.error(f"found {self.kind}, expected text or a number")
        text = str(self.raw.value)
        if len(text) > _MOST_CHARACTERS:
            raise self.error(f"found {len(text)} characters, expected at most {_MOST_CHARACTERS}")
        odd = next((c for c in text if unicodedata.category(c) in ("Cc", "Cs") and c not in "\n\t"), None)
        if odd is not None:
            raise self.error(f"found the control character U+{ord(odd):04X}, expected text; take it out")
        return text

    def words(self) -> str:
        """Text for people or programs, where YAML's truth values are a mistake."""
        text = self.text()
        if self.raw.tag == _BOOL:
            raise self.error(f"found {text}, which YAML takes for a truth value; expected text: put it in quotes")
        return text

    @property
    def kind(self) -> str:
        if isinstance(self.raw, yaml.ScalarNode):
            return "nothing" if self.raw.tag == _NULL else "a single value"
        return "a mapping" if isinstance(self.raw, yaml.MappingNode) else "a list"

    def value(self, read: Callable[[str], Any]) -> Any:
        """What `read` makes of the text; its complaint gets the place."""
        text = self.text()
        try:
            return read(text)
        except InputError as error:
            raise self.error(str(error)) from None

    def one_of(self, known: list[str]) -> str:
        text = self.text()
        if text not in known:
            raise self.error(f"found {text!r}, expected one of {', '.join(known)}.{did_you_mean(text, known)}")
        return text

    def items(self) -> Iterator[YamlNode]:
        """A list of at least one; a single value counts as a list of one."""
        if not isinstance(self.raw, yaml.SequenceNode):
            yield self
            return
        if not self.raw.value:
            raise self.error("found an empty list, and lists need at least one entry")
        for i, row in enumerate(self.raw.value):
            yield YamlNode(row, self.path, f"{self.name}[{i}]")

    def fields(self, known: list[str], needed: list[str] | None = None) -> dict[str, YamlNode]:
        if not isinstance(self.raw, yaml.MappingNode):
            raise self.error(f"found {self.kind}, expected a mapping with {', '.join(known)}")
        found: dict[str, YamlNode] = {}
        for key, value in self.raw.value:
            name = self._key(key, known)
            inner = YamlNode(value, self.path, f"{self.name}.{name}" if self.name else name)
            if name in found:
                raise YamlNode(key, self.path, inner.name).error(f"{name!r} stands here twice")
            found[name] = inner
        for name in needed or []:
            if name not in found:
                raise self.error(f"{name!r} is missing")
        return found

    def has(self, name: str) -> bool:
        """Whether a mapping has the field; for a reader that looks which of two forms it has before it."""
        return isinstance(self.raw, yaml.MappingNode) and any(str(key.value) == name for key, _ in self.raw.value)

    def _key(self, raw: yaml.Node, known: list[str]) -> str:
        here = YamlNode(raw, self.path, self.name)
        if not isinstance(raw, yaml.ScalarNode):
            raise here.error(f"found {here.kind} as a name, expected one of {', '.join(known)}")
        name = str(raw.value)
        if name == "<<":
            raise here.error("found the merge key '<<', which is not read; write its fields out")
        if name not in known:
            short = name if len(name) <= 60 else f"{name[:60]}..."
            if short.isprintable():
                here.name = f"{self.name}.{short}" if self.name else short
            raise here.error(f"found {short!r}, expected one of {', '.join(known)}.{did_you_mean(short, known)}")
        return name

    def single(self, known: list[str]) -> tuple[str, YamlNode]:
        """The one `name: value` of a step or check."""
        found = self.fields(known)
        if len(found) != 1:
            raise self.error(f"found {len(found)} of them, expected one of {', '.join(known)}")
        return next(iter(found.items()))


def document(path: Path, fill: Callable[[str], str] = str) -> YamlNode:
    """`fill` is given the file's text and returns what is read in its place, line for line."""
    return YamlNode(compose(path, fill), path, "")
