# SPDX-License-Identifier: Apache-2.0
"""A Java bean written by XMLEncoder as plain values by property, such as `populationTable[3].populated`.

Nothing of it is ever called or built: it is text. A document type or an entity, a method call and an object inside the
profile are refused with their line, and so is a file that is larger or nested deeper than any profile."""
from __future__ import annotations

import dataclasses
import pathlib
import re
import xml.parsers.expat

from voltlap_logs.errors import LogError

MOST_BYTES = 4_000_000  # profiles have 40 kB
MOST_DEPTH = 16         # profiles have 7
VALUES = ("boolean", "byte", "char", "double", "float", "int", "long", "null", "short", "string")
WORDS = 40  # of what was found, in a message


class ProfileRefused(LogError):
    """Where, what was found, what was expected, what to do."""

    def __init__(self, where: str, found: str, expected: str, action: str):
        super().__init__(f"{where}: found {found}; expected {expected}. {action}.")


@dataclasses.dataclass(frozen=True)
class Value:
    kind: str  # of VALUES
    text: str
    line: int


@dataclasses.dataclass
class Bean:
    path: str
    values: dict[str, Value]

    def where(self, name: str) -> str:
        """Place of a property: with its line where the file has it."""
        value = self.values.get(name)
        return f"{self.path}:{value.line}: {name}" if value else f"{self.path}: {name}"


def quoted(text: str) -> str:
    """Foreign text in a message: short, on one line, printable."""
    shown = text if len(text) <= WORDS else text[:WORDS] + ".."
    return '"' + "".join(sign if sign.isprintable() else "?" for sign in shown) + '"'


class BeanReader:
    """Takes what expat finds; `path` is for messages."""

    def __init__(self, path: str):
        self.path = path
        self.values: dict[str, Value] = {}
        self.names: list[str] = []     # of the open <void>s
        self.elements: list[str] = []  # all that are open
        self.line_of_value = 0
        self.text: list[str] | None = None  # of the open value
        self.parser = xml.parsers.expat.ParserCreate()
        self.parser.buffer_text = True
        self.parser.StartDoctypeDeclHandler = self.document_type
        self.parser.EntityDeclHandler = self.document_type
        self.parser.StartElementHandler = self.start
        self.parser.EndElementHandler = self.end
        self.parser.CharacterDataHandler = self.characters

    def read(self, data: bytes) -> None:
        try:
            self.parser.Parse(data, True)
        except xml.parsers.expat.ExpatError as error:
            reason = xml.parsers.expat.ErrorString(error.code)
            raise self.refused(f"XML that cannot be read ({reason})", "a whole profile", "Save the profile again",
                               error.lineno) from error
        except (LookupError, ValueError) as error:  # an encoding that nobody knows
            raise self.refused("an encoding that cannot be read", "UTF-8", "Save the profile again") from error

    def refused(self, found: str, expected: str, action: str, line: int = 0) -> ProfileRefused:
        return ProfileRefused(f"{self.path}:{line or self.parser.CurrentLineNumber}", found, expected, action)

    def document_type(self, *_: object) -> None:
        raise self.refused("a document type", "a profile, which has no DTD and no entities",
                           "Save the profile again in the Orion utility")

    def start(self, element: str, attributes: dict[str, str]) -> None:
        self.elements.append(element)
        if len(self.elements) > MOST_DEPTH:
            raise self.refused(f"elements nested {len(self.elements)} deep", f"at most {MOST_DEPTH} of a profile",
                               "Check that this is the file you meant")
        if self.text is not None:
            raise self.refused(f"<{element}> inside a value", "its text alone", "Save the profile again")
        if len(self.elements) <= 2:
            self.start_outside(element, attributes)
        elif element == "void":
            self.start_property(attributes)
        elif element in VALUES:
            self.text, self.line_of_value = [], self.parser.CurrentLineNumber
        else:
            raise self.refused(f"<{element}> {quoted(attributes.get('class', ''))}", "properties and values alone",
                               "Nothing in a profile is built or called: check where the file comes from")

    def start_outside(self, element: str, attributes: dict[str, str]) -> None:
        expected = (("java", "java.beans.XMLDecoder"), ("object", "Profile"))[len(self.elements) - 1]
        name = attributes.get("class", "")
        if element != expected[0] or not name.endswith(expected[1]):
            raise self.refused(f"<{element}> {quoted(name)}", f"<{expected[0]}> of class {expected[1]}",
                               "Check that this is a profile of an Orion BMS 2 (.o2bms)")

    def start_property(self, attributes: dict[str, str]) -> None:
        if set(attributes) - {"id", "property", "index"}:
            odd = min(set(attributes) - {"id", "property", "index"})
            raise self.refused(f"{odd} {quoted(attributes[odd])}", "properties and values alone",
                               "Nothing in a profile is built or called: check where the file comes from")
        name, index = attributes.get("property"), attributes.get("index")
        if (name is None) == (index is None):
            raise self.refused("<void> with neither property nor index, or with both", "one of the two",
                               "Save the profile again")
        if name is not None and not re.fullmatch(r"\w{1,80}", name, re.ASCII):
            raise self.refused(f"property {quoted(name)}", "a name of letters and digits", "Save the profile again")
        if index is not None and not re.fullmatch(r"\d{1,6}", index, re.ASCII):
            raise self.refused(f"index {quoted(index)}", "a number from 0 on", "Save the profile again")
        self.names.append(f".{name}" if name is not None else f"[{int(index or 0)}]")

    def end(self, element: str) -> None:
        self.elements.pop()
        if self.text is not None:
            self.take("".join(self.text), element)
            self.text = None
        elif element == "void":
            self.names.pop()

    def take(self, text: str, kind: str) -> None:
        name = "".join(self.names).removeprefix(".")
        if not name:
            raise self.refused(f"a value {quoted(text)} outside a property", "<void property=..> around it",
                               "Save the profile again", self.line_of_value)
        if name in self.values:
            raise self.refused(f"property {name} for the second time", f"each once (line {self.values[name].line} "
                               "has it)", "Remove the one that does not hold", self.line_of_value)
        self.values[name] = Value(kind, text, self.line_of_value)

    def characters(self, text: str) -> None:
        if self.text is not None:
            self.text.append(text)


def read_bean(path: str) -> Bean:
    file = pathlib.Path(path)
    with file.open("rb") as stream:
        data = stream.read(MOST_BYTES + 1)
    if len(data) > MOST_BYTES:
        raise ProfileRefused(path, f"more than {MOST_BYTES // 1_000_000} MB", "a profile, which has 40 kB",
                             "Check that this is the file you meant")
    reader = BeanReader(path)
    reader.read(data)
    if not reader.values:
        raise ProfileRefused(path, "no property", "a profile of an Orion BMS 2 (.o2bms)",
                             "Check that this is the file you meant")
    return Bean(path, reader.values)
