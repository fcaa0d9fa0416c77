# SPDX-License-Identifier: Apache-2.0
"""No class or name keeps a std::initializer_list: what it points to may be gone when it is read, as a fuzzer found."""
import pathlib
import re

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
KEPT = re.compile(r"^\s*(?:const )?std::initializer_list<[^;(]*> \w+(?:, \w+)*(?:;|\{|  +//)"
                  r"|^using \w+ = std::initializer_list", re.MULTILINE)


def test_no_list_of_initializers_is_kept():
    found = [f"{path.relative_to(ROOT)}: {match[0].strip()}" for folder in ("firmware", "plant_sim")
             for path in sorted((ROOT / folder).rglob("*.?pp")) for match in KEPT.finditer(path.read_text())]
    assert not found


@pytest.mark.parametrize("line", ["  std::initializer_list<int> words;", "  std::initializer_list<int> words, parts;",
                                  "using Names = std::initializer_list<int>;",
                                  "  const std::initializer_list<std::pair<int, int>> words;  ///< of it"])
def test_a_kept_list_is_seen(line):
    assert KEPT.search(line)


def test_an_argument_is_no_kept_list():
    assert not KEPT.search("  explicit Outputs(std::initializer_list<std::string> paths) {\n")
