# SPDX-License-Identifier: Apache-2.0
"""No text of the project holds what a merge left unfinished."""
import pathlib
import re

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
TEXTS = {".c", ".cmake", ".cpp", ".css", ".dbc", ".h", ".hpp", ".html", ".js", ".json", ".ld", ".md", ".py", ".sh",
         ".toml", ".txt", ".yaml", ".yml", ""}
MARK = re.compile(r"^(?:<{7} |\|{7} |>{7} |={7}$)", re.MULTILINE)


def marks(text):
    return [f"line {text.count(chr(10), 0, found.start()) + 1}" for found in MARK.finditer(text)]


def texts():
    for path in sorted(ROOT.rglob("*")):
        hidden = any(part in ("build", ".git", "__pycache__") for part in path.relative_to(ROOT).parts)
        if not hidden and path.is_file() and path.suffix in TEXTS:
            yield path


def test_no_file_holds_a_mark_of_a_merge():
    found = {str(path.relative_to(ROOT)): marks(path.read_text(errors="replace")) for path in texts()}
    assert len(found) > 500  # it looked
    assert not {path: where for path, where in found.items() if where}


@pytest.mark.parametrize("mark", ["<" * 7 + " HEAD", "=" * 7, ">" * 7 + " branch", "|" * 7 + " base"])
def test_a_planted_mark_is_found(mark):
    assert marks(f"one\n{mark}\ntwo\n") == ["line 2"]
