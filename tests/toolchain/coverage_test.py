# SPDX-License-Identifier: Apache-2.0
"""What voltlap coverage says of a small source that Clang counted, and of explanations."""
import collections
import pathlib
import shutil
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "toolchain"))

from unreached.main import judge  # noqa: E402
from unreached.measure import Build, Counted, totals, unreached  # noqa: E402

SOURCE = """\
#define VOLTLAP_REQUIRE(c) ((c) ? void() : __builtin_abort())
constexpr bool kOn = true;
int f(int a, int b) {
  VOLTLAP_REQUIRE(a <
                  100);
  if (a > 0 && b > 0) return 1;
  if (a == 7) {
    b = 2;
    a = 3;
  }
  switch (b) {
    case 5: return 2;
    default: break;
  }
  if (kOn) return a < b ? 3 : 4;
  return 5;
}
int main() { return f(1, 0) + f(-1, 2) == 7 ? 0 : 1; }
"""


@pytest.fixture(scope="module")
def counted(tmp_path_factory):
    if shutil.which("clang++") is None or shutil.which("llvm-cov") is None:
        pytest.skip("Clang and LLVM's tools are not installed")
    root = tmp_path_factory.mktemp("project")
    (root / "firmware").mkdir()
    (root / "firmware/f.cpp").write_text(SOURCE)
    build = Build(root, root / "build")
    (build.folder / "tests/bin").mkdir(parents=True)
    subprocess.run(["clang++", "-O1", "-fprofile-instr-generate", "-fcoverage-mapping", "-w", root / "firmware/f.cpp",
                    "-o", build.folder / "tests/bin/small_test"], check=True)
    found = collections.defaultdict(Counted)
    build.count("small_test", found)
    build.count("small_test", found)  # counts add up
    return found["firmware/f.cpp"]


def test_what_never_ran_and_what_had_one_answer_is_told_by_its_line(counted):
    assert [(row["row"], row["rows"], row["what"]) for row in unreached("firmware/f.cpp", SOURCE, counted)] == [
        (6, 1, "b > 0 is never true"), (7, 1, "a == 7 is never true"), (8, 3, "never runs"), (12, 1, "never runs"),
        (16, 1, "never runs"), (18, 1, "f(1, 0) + f(-1, 2) == 7 is never false")]


def test_every_run_counts_and_each_line_and_answer_once(counted):
    assert counted.lines[6] == 4
    assert totals(SOURCE, counted) == (17, 12, 12, 8)


def test_an_explanation_is_of_a_line_and_what_it_explains_no_more_is_told():
    row = {"file": "a.cpp", "row": 3, "rows": 1, "line": "if (x)", "what": "x is never true"}
    known = {("a.cpp", "if (x)", "x is never true"): "who sends it is not built"}
    assert judge([row], known, {"a.cpp"}) == [] and row["why"] == "who sends it is not built"
    assert judge([], known, {"a.cpp"}) == ["a.cpp: nothing is unreached there any more: if (x): x is never true"]
    assert judge([], known, {"b.cpp"}) == []


@pytest.mark.parametrize("arguments, says", [(["firmwar"], "firmwar: no source of firmware/"),
                                             (["--jobs", "0"], "--jobs 0: 1 or more is expected"),
                                             (["--json", "nowhere/x.json"], "found no folder nowhere")])
def test_what_cannot_be_done_is_told_before_the_build(arguments, says):
    done = subprocess.run([sys.executable, ROOT / "toolchain/coverage.py", *arguments], capture_output=True, text=True,
                          cwd=ROOT, timeout=60)
    assert done.returncode == 2 and says in done.stderr and "building" not in done.stderr


def test_a_missing_compiler_is_named_with_what_installs_it(tmp_path):
    done = subprocess.run([sys.executable, ROOT / "toolchain/coverage.py"], capture_output=True, text=True,
                          env={"PATH": str(tmp_path)}, timeout=60)
    assert done.returncode == 4 and "clang++" in done.stderr and "apt-get install clang llvm" in done.stderr
