# SPDX-License-Identifier: Apache-2.0
"""Rules of the firmware's sources that a compiler for the host does not enforce."""
import pathlib
import re

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
COMMENT_OR_TEXT = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"', re.DOTALL)
REFUSED = {
    "floating point": re.compile(r"\b(?:float|double)\b|\b\d+\.\d*(?:e[+-]?\d+)?f?\b"),
    "heap": re.compile(r"\b(?:new|delete|malloc|calloc|realloc|free)\b"),
    "exceptions": re.compile(r"\b(?:throw|try|catch)\b"),
    "run-time type information": re.compile(r"\b(?:dynamic_cast|typeid)\b"),
    "a choice by the preprocessor": re.compile(r"^\s*#\s*if", re.MULTILINE),
    "the standard library": re.compile(r"\bstd::(?!u?int(?:8|16|32|64|ptr)_t\b|size_t\b|numeric_limits\b|is_)\w+"),
}
# Made by `voltlap firmware-tables` from a team's own numbers.
GENERATED = {"pack_config.hpp", "master_config.hpp"}
HOST = ROOT / "firmware" / "port" / "host"


def violations(text):
    # `= delete` forbids a function and frees nothing.
    code = re.sub(r"=\s*delete\b", "", COMMENT_OR_TEXT.sub(" ", text))
    return sorted(what for what, rule in REFUSED.items() if rule.search(code))


def all_sources():
    return sorted(path for pattern in ("*.hpp", "*.cpp") for path in (ROOT / "firmware").rglob(pattern))


def sources():
    """What goes on the microcontroller: all but the host's side of the ports."""
    return [path for path in all_sources() if HOST not in path.parents]


def test_firmware_sources_keep_the_rules():
    files = sources()
    assert files
    found = {str(path.relative_to(ROOT)): bad for path in files if (bad := violations(path.read_text()))}
    assert found == {}


def test_firmware_sources_carry_the_licence():
    assert HOST.is_dir()
    for path in all_sources():
        if path.name in GENERATED:
            continue
        assert path.read_text().startswith("// SPDX-License-Identifier: Apache-2.0\n"), path


PLANTED = {
    "floating point": ["float x;", "auto x = 0.5;", "double f();"],
    "heap": ["int* p = new int;", "delete p;", "malloc(3);"],
    "exceptions": ["throw 1;", "try {} catch (...) {}"],
    "run-time type information": ["dynamic_cast<A*>(b);"],
    "a choice by the preprocessor": ["#ifdef HOST", "#if HOST"],
    "the standard library": ["std::vector<int> v;", "std::string s;"],
}


@pytest.mark.parametrize("what", PLANTED)
def test_what_is_planted_is_refused(what):
    for text in PLANTED[what]:
        assert what in violations(text), text


def test_comments_texts_and_separators_are_no_violation():
    assert violations('// a new float of 0.5\nint x = 1\'000; f("try new"); A(const A&) = delete; std::size_t n;') == []
