# SPDX-License-Identifier: Apache-2.0
"""Every change that voltlap mutate knows is made in a small source, the text with its switches compiles, and survivors
are explained by their lines."""
import pathlib
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "toolchain"))

from mutation import explained  # noqa: E402
from mutation.rewrite import number_mutants, rewrite  # noqa: E402
from mutation.sites import Reader, parser_flags  # noqa: E402

SOURCE = """\
constexpr int kMost = 2000;
void act(int& x);
bool f(int a, int b, bool c) {
  static_assert(kMost > 1, "no site");
  if (a < b && !c) return true;
  int x = -a + 1;
  x += b * 3;
  act(x);
  for (int i = 0; i <= kMost; ++i) {
    if (x == i) break;
  }
  return x % 5 > 0;
}
"""
CHANGES = ["a < b -> a <= b", "a < b -> a >= b", "a < b && !c -> a < b || !c", "a < b -> true", "!c -> true",
           "a < b && !c -> false", "!c -> c", "return true -> return !(true)", "-a + 1 -> -a - 1", "-a -> a",
           "1 -> 0", "1 -> 2", "x += b * 3 -> x -= b * 3", "b * 3 -> b / 3", "3 -> 4", "act(x); -> (nothing)",
           "x += b * 3; -> (nothing)", "i <= kMost -> i < kMost", "i <= kMost -> false",
           "constexpr int kMost = 2000 -> doubled", "x == i -> x != i", "break; -> (nothing)", "x % 5 -> x * 5",
           "x % 5 > 0 -> x % 5 >= 0"]


@pytest.fixture
def reader(tmp_path):
    source = tmp_path / "small.cpp"
    source.write_text(SOURCE)
    return Reader(source, parser_flags(["c++", "-std=c++17"])).read()


@pytest.mark.parametrize("change", CHANGES)
def test_every_change_is_made(reader, change):
    assert change in [mutant.change for site in reader.sites for mutant in site.mutants]


def test_nothing_is_changed_where_the_compiler_computes(reader):
    assert [site.line for site in reader.sites if site.line == 4] == []


def test_all_changes_compile_together_on_the_lines_of_the_source(reader, tmp_path):
    assert number_mutants(reader.sites, 0) >= len(CHANGES)
    mutated = tmp_path / "mutated.cpp"
    mutated.write_bytes(rewrite(reader.data, reader.sites))
    assert len(mutated.read_text().splitlines()) == len(SOURCE.splitlines())
    subprocess.run(["c++", "-std=c++17", "-w", "-fsyntax-only", "-include", ROOT / "toolchain/mutation/mutation.hpp",
                    mutated], check=True)


def row(verdict):
    return {"file": "a.cpp", "function": "f", "text": "x < y", "change": "x < y -> x <= y", "verdict": verdict}


def test_a_survivor_is_explained_by_its_line_and_a_stale_explanation_is_told():
    known = {("a.cpp", "f", "x < y", "x < y -> x <= y"): "x is never y"}
    rows = [row("survived")]
    assert explained.judge(rows, known, {"a.cpp"}) == [] and rows[0]["verdict"] == "explained"
    assert explained.judge([row("killed")], known, {"a.cpp"}) == ["a.cpp: a test sees it now: f: x < y -> x <= y"]
    assert explained.judge([], known, {"a.cpp"}) == ["a.cpp: there is no such mutant any more: f: x < y -> x <= y"]
    assert explained.judge([], known, {"b.cpp"}) == []


def test_an_explanation_without_a_reason_is_refused(tmp_path):
    path = tmp_path / "mutants.toml"
    path.write_text('[[equivalent]]\nfile = "a"\nfunction = "f"\nline = "x"\nchange = "y"\nwhy = ""\n')
    with pytest.raises(explained.Malformed):
        explained.read(path)
