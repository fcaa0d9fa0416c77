# SPDX-License-Identifier: Apache-2.0
"""The project's Markdown files, taken apart: commands, shown outputs, links, names of files."""
import dataclasses
import pathlib
import re

PROJECT = pathlib.Path(__file__).resolve().parents[2]
LEFT_OUT = {"build", "vendor", ".git", ".pytest_cache"}
FENCE = re.compile(r"^(?:<!-- output of: (?P<of>.+?) -->\n)?```(?P<language>\w*)\n(?P<body>.*?)^```$",
                   re.MULTILINE | re.DOTALL)


@dataclasses.dataclass
class Block:
    language: str
    body: str
    output_of: str  # the command in the comment before a block of output, else empty
    line: int


def documents():
    found = [path.relative_to(PROJECT) for path in PROJECT.rglob("*.md")]
    return sorted(str(path) for path in found if not LEFT_OUT & set(path.parts))


def blocks(text):
    return [Block(m["language"], m["body"], m["of"] or "", text.count("\n", 0, m.start()) + 1)
            for m in FENCE.finditer(text)]


def prose(text):
    """The text without its fenced blocks."""
    return FENCE.sub("", text)


def commands(script):
    """The commands of a shell block, each with its here-document and continued lines, without comments."""
    found, end = [], ""
    for line in script.splitlines():
        if end:
            found[-1] += "\n" + line
            end = "" if line == end else end
            continue
        line = re.sub(r"(^|\s+)#\s.*$", "", line).rstrip()
        if not line:
            continue
        if found and found[-1].endswith("\\"):
            found[-1] = found[-1][:-1].rstrip() + " " + line.lstrip()
        else:
            found.append(line)
        here = re.search(r"<<'?(\w+)'?", line)
        end = here[1] if here else ""
    return found
