# SPDX-License-Identifier: Apache-2.0
"""Nothing is so long that a reader loses the thread: functions, files, lines and parameter lists have limits.

C++ is read by lizard, Python by its own parser. JavaScript is formatted by indentation, so a function ends where its
first line's indentation comes back.
"""
import ast
import pathlib
import re
from typing import NamedTuple

import lizard
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
FOLDERS = ("can_dbc", "firmware", "hil", "plant_sim", "tests", "toolchain")
FUNCTION_LINES_MAX = {".cpp": 70, ".hpp": 70, ".py": 70, ".js": 120}
FILE_LINES_MAX = 400
COLUMNS_MAX = 120
PARAMETERS_MAX = 6

# Both lists only shrink: an entry that nothing needs any more fails the test.
EXEMPT_FOLDERS = {
    "tests/controls": "is replaced by plant_sim/explain",
}
STAYS: dict[tuple[str, str, str], str] = {}  # (what, path, name) -> why it must be as long as it is


class Finding(NamedTuple):
    what: str  # "function", "parameters", "file" or "line"
    path: str
    name: str  # of the function; empty for a file or a line
    size: int
    limit: int
    line: int

    @property
    def key(self):
        return self.what, self.path, self.name

    def __str__(self):
        name = f" of {self.name}" if self.what == "parameters" else f" {self.name}" if self.name else ""
        return f"{self.path}:{self.line}: {self.what}{name}: {self.size}, at most {self.limit}"


class Function(NamedTuple):
    name: str
    line: int
    lines: int
    parameters: int


def top_level_parts(text):
    """Entries of a parameter list; commas inside brackets belong to a type or a default."""
    depth, parts = 0, [""]
    for character in text:
        depth += (character in "([{") - (character in ")]}")
        if character == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += character
    return [part for part in parts if part.strip()]


def cpp_functions(path, text):
    for found in lizard.analyze_file.analyze_source_code(path, text).function_list:
        if not found.name.endswith("TEST_GROUP"):  # a class
            parameters = len(top_level_parts(",".join(found.full_parameters)))
            yield Function(found.name, found.start_line, found.length, parameters)


def python_functions(_, text):
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            given = node.args
            everyone = (*given.posonlyargs, *given.args, *given.kwonlyargs, given.vararg, given.kwarg)
            names = [parameter.arg for parameter in everyone if parameter]
            parameters = len(names) - (names[:1] in (["self"], ["cls"]))
            yield Function(node.name, node.lineno, node.end_lineno - node.lineno + 1, parameters)


# A line that opens a function and leaves its body to the lines below: `=> {`, `=> [`, `function f() {`, `draw(x) {`.
JS_OPENS = re.compile(r"(?:=> ?[({\[]+|\bfunction\b.*\{|^\s*(?:static |async |get |set )*#?\w+\([^;]*\) \{)$")
JS_STATEMENT = re.compile(r"\s*(?:if|for|while|switch|catch|with)\b")
JS_AROUND_FILE = re.compile(r"^\((?:async )?(?:\(\) => \{|function \w*\(\) \{)$")


def javascript_functions(_, text):
    lines = text.splitlines()
    indents = [len(line) - len(line.lstrip()) if line.strip() else None for line in lines]
    for i, line in enumerate(lines):
        if not JS_OPENS.search(line) or JS_STATEMENT.match(line) or JS_AROUND_FILE.match(line):
            continue
        end = next((k for k in range(i + 1, len(lines)) if indents[k] is not None and indents[k] <= indents[i]), i)
        name = re.search(r"[#\w.]+(?=\s*[=:(])", line)
        yield Function(name[0] if name else "(anonymous)", i + 1, end - i + 1, 0)


FUNCTIONS = {".cpp": cpp_functions, ".hpp": cpp_functions, ".py": python_functions, ".js": javascript_functions}


def findings(path, text):
    """Everything in the file `path` (relative to the root) that is beyond a limit."""
    suffix, lines = pathlib.PurePosixPath(path).suffix, text.splitlines()
    found = [Finding("line", path, "", len(line), COLUMNS_MAX, i + 1)
             for i, line in enumerate(lines) if len(line) > COLUMNS_MAX]
    if len(lines) > FILE_LINES_MAX:
        found.append(Finding("file", path, "", len(lines), FILE_LINES_MAX, 1))
    for function in FUNCTIONS[suffix](path, text):
        for what, size, limit in (("function", function.lines, FUNCTION_LINES_MAX[suffix]),
                                  ("parameters", function.parameters, PARAMETERS_MAX)):
            if size > limit:
                found.append(Finding(what, path, function.name, size, limit, function.line))
    return found


def sources():
    """Every source that was written here, relative to the root."""
    found = [path for folder in FOLDERS for path in (ROOT / folder).rglob("*") if path.suffix in FUNCTIONS]
    names = [str(path.relative_to(ROOT)) for path in found if "vendor" not in path.parts]
    return sorted(name for name in names if not name.startswith(tuple(f"{folder}/" for folder in EXEMPT_FOLDERS)))


def verdict(found, stays):
    """What is wrong, as sentences: what is too long and not listed, and what is listed and not too long."""
    needed = {finding.key for finding in found}
    return ([str(finding) for finding in found if finding.key not in stays]
            + [f"{' '.join(key)} is within the limits: take it off the list" for key in stays if key not in needed])


def test_sources_keep_the_limits():
    names = sources()
    assert {pathlib.PurePosixPath(name).suffix for name in names} == set(FUNCTIONS)
    found = [finding for name in names for finding in findings(name, (ROOT / name).read_text())]
    wrong = verdict(found, STAYS)
    assert not wrong, "\n".join(wrong)


def test_what_is_listed_has_a_reason_and_exempt_folders_exist():
    assert all(STAYS.values()) and all(EXEMPT_FOLDERS.values())
    assert [folder for folder in EXEMPT_FOLDERS if not (ROOT / folder).is_dir()] == [], "take them off the list"


# ---- what must be found, and what must not ----

def body(count, line, head, tail):
    return "\n".join([head, *[line] * (count - 2), tail])


CPP = "namespace a {{\nclass B {{\n B(int c) : c_{{c}} {{}}\n int c_;\n}};\n{}\n}}\n"
JS = "// A page.\n\"use strict\";\n\n(() => {{\n{}\n}})();\n"
PLANTED = {
    "C++ function": ("function", "x.cpp", lambda n: CPP.format(body(n, "  work();", "int B::f() const {", "}")), 70),
    "C++ test": ("function", "x.cpp", lambda n: CPP.format(body(n, "  CHECK(1);", "TEST(Group, name) {", "}")), 70),
    "C++ template in a header": ("function", "x.hpp", lambda n: CPP.format(
        "template <class T>\n" + body(n, "  work();", "auto f(std::map<int, T> x = {{1, 2}}) {", "}")), 70),
    "Python function": ("function", "x.py", lambda n: body(n, "    work()", "def f(a):", "    return 1"), 70),
    "Python method": ("function", "x.py", lambda n: "class A:\n" + body(
        n, "        work()", "    async def f(self):", "        return 1"), 70),
    "JavaScript function": ("function", "x.js", lambda n: JS.format(
        body(n, "    work();", "  const f = (a) => {", "  };")), 120),
    "JavaScript list": ("function", "x.js", lambda n: JS.format(body(n, "    1,", "  const f = () => [", "  ];")), 120),
    "JavaScript method": ("function", "x.js", lambda n: "voltlap.A = class {\n" + body(
        n, "    work();", "  #f(a, { b }) {", "  }") + "\n};\n", 120),
    "C++ file": ("file", "x.hpp", lambda n: body(n, "int a;", "// x", "// x"), 400),
    "Python file": ("file", "x.py", lambda n: body(n, "a = 1", "# x", "# x"), 400),
    "JavaScript file": ("file", "x.js", lambda n: body(n, "  work();", "(() => {", "})();"), 400),
    "C++ line": ("line", "x.cpp", lambda n: "//" + "x" * (n - 2), 120),
    "Python line": ("line", "x.py", lambda n: "#" + "\u00b0" * (n - 1), 120),
    "JavaScript line": ("line", "x.js", lambda n: "//" + "x" * (n - 2), 120),
    "C++ parameters": ("parameters", "x.cpp", lambda n: CPP.format(
        "void f(std::function<void(int, int)> g, " + "".join(f"int a{i}[3], " for i in range(n - 2))
        + "B b = {1, 2}) { }"), 6),
    "Python parameters": ("parameters", "x.py", lambda n: "class A:\n  def f(self, a: dict[str, int], " + "".join(
        f"a{i}, " for i in range(n - 3)) + "*, b=(1, 2), **c): pass", 6),
}


@pytest.mark.parametrize("case", PLANTED)
def test_what_is_planted_is_found_and_what_is_just_short_enough_is_not(case):
    what, path, planted, limit = PLANTED[case]
    assert findings(path, planted(limit)) == []
    found = findings(path, planted(limit + 1))
    assert [(finding.what, finding.size, finding.limit) for finding in found] == [(what, limit + 1, limit)]


def test_the_list_holds_only_what_is_needed():
    found = findings("x.py", "# " + "x" * 200)
    assert verdict(found, {}) == ["x.py:1: line: 202, at most 120"]
    assert verdict(found, {("line", "x.py", ""): "a table"}) == []
    assert verdict([], {("line", "x.py", ""): "a table"}) == ["line x.py  is within the limits: take it off the list"]
