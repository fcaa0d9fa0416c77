# SPDX-License-Identifier: Apache-2.0
"""Every command in the documents works, and prints what the documents show.

A block of `sh` is run command by command. A block of `text` that follows a comment `<!-- output of: COMMAND -->` is
compared with what COMMAND prints; a line `...` in it stands for any lines.

README.md and CONTRIBUTING.md are run each time, of the other documents a third, drawn by VOLTLAP_TEST_SEED; all with
VOLTLAP_TEST_WHOLE=1: together they take minutes.
"""
import os
import pathlib
import random
import re
import shutil
import subprocess
import sys

import pytest
from documents import PROJECT, blocks, commands, documents

# Commands that are not run here, each with its reason. One that no document has any more is refused.
NOT_RUN = {
    "./voltlap test": "it is what runs this test",
    "./voltlap fuzz": "it builds everything with clang; its short form has a suite of its own",
    "./voltlap fuzz --for 1h": "as above, and it takes an hour",
    "./voltlap fuzz can dbc --each 10min": "as above",
    "VOLTLAP_DATA=data python3 toolchain/leave_one_out.py --rungs chosen,constant2,rival":
        "it takes an hour; two of its rows have a test of their own",
    "python3 toolchain/learn_bench.py --seed 1 --json build/marks.json --csv build/cells.csv":
        "it takes hours; its short form has a suite of its own",
    "python3 toolchain/learn_bench.py --seed 1 --cell 6 --keep build/cells": "as above",
    "toolchain/bare_root_test.sh": "it downloads a system and takes minutes; its short form has a suite of its own",
}
# What differs from run to run, in what is shown and in what is printed.
VARIES = [(re.compile(r"computed in [\d.]+ s"), "computed in N s"),
          (re.compile(r"in one process, \d+ s"), "in one process, N s")]
TEXTS = {name: (PROJECT / name).read_text() for name in documents()}
WITH_COMMANDS = [name for name, text in TEXTS.items() if any(block.language == "sh" for block in blocks(text))]
SEED = os.environ.get("VOLTLAP_TEST_SEED") or str(random.randrange(2**32))
ALWAYS = ("README.md", "CONTRIBUTING.md")


def run_now(names):
    """The documents of this run."""
    others = [name for name in names if name not in ALWAYS]
    drawn = random.Random(SEED).sample(others, (len(others) + 2) // 3)
    return [name for name in names if name in (*ALWAYS, *drawn) or os.environ.get("VOLTLAP_TEST_WHOLE") == "1"]


@pytest.fixture
def folder(tmp_path):
    """A copy of the sources, so that a command may write and edit. Its start script is the project's own, built one."""
    if pathlib.Path(os.environ["VOLTLAP_BUILD_DIR"]) != PROJECT / "build" / "default":
        pytest.skip("the documents' commands use build/default, and this build is elsewhere")
    copy = tmp_path / "voltlap"
    shutil.copytree(PROJECT, copy, ignore=shutil.ignore_patterns("build", ".git", "__pycache__", ".pytest_cache"))
    (copy / "voltlap").unlink()
    (copy / "voltlap").symlink_to(PROJECT / "voltlap")
    (copy / "build").mkdir()
    (copy / "build" / "venv").symlink_to(sys.prefix)
    return copy


def run(command, folder):
    return subprocess.run(["bash", "-euo", "pipefail", "-c", command], cwd=folder, env={**os.environ, "CI": "true"},
                          stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=300)


def problems(text, folder):
    """Runs the commands of a document in their order, and compares what it shows. Commands that fail end the run."""
    printed = {}
    for block in blocks(text):
        if block.language == "sh":
            for command in commands(block.body):
                if command in NOT_RUN:
                    continue
                done = run(command, folder)
                if done.returncode != 0:
                    return [f"line {block.line}: {command}\nends with {done.returncode}\n{done.stdout}{done.stderr}"]
                printed[command] = done.stdout
    shown = [block for block in blocks(text) if block.language == "text"]
    return [f"line {block.line}: {found}" for block in shown
            if (found := difference(block.body, printed[block.output_of]) if block.output_of in printed else
                f"no command of the document is {block.output_of!r}, so nothing prints this")]


@pytest.mark.parametrize("name", run_now(WITH_COMMANDS))
def test_commands_of_a_document_work_and_print_what_it_shows(folder, name):
    print(f"VOLTLAP_TEST_SEED={SEED}")
    assert problems(TEXTS[name], folder) == []


def difference(shown, printed):
    for varying, name in VARIES:
        shown, printed = varying.sub(name, shown), varying.sub(name, printed)
    pattern = "".join(".*" if line == "..." else re.escape(line) + "\n" for line in shown.splitlines())
    return "" if re.fullmatch(pattern, printed, re.DOTALL) else f"shown:\n{shown}\nprinted:\n{printed}"


def test_each_run_has_the_first_documents_and_a_third_of_the_others(monkeypatch):
    monkeypatch.delenv("VOLTLAP_TEST_WHOLE", raising=False)
    others = [f"docs/{k}.md" for k in range(10)]
    assert len(run_now([*ALWAYS, *others])) == len(ALWAYS) + 4 and {*ALWAYS} <= {*run_now([*ALWAYS, *others])}
    monkeypatch.setenv("VOLTLAP_TEST_WHOLE", "1")
    assert run_now(others) == others


def test_list_of_what_is_not_run_holds_no_left_over():
    everywhere = {command for text in TEXTS.values() for block in blocks(text) if block.language == "sh"
                  for command in commands(block.body)}
    assert set(NOT_RUN) <= everywhere


# ---- the checks themselves ----

def test_blocks_are_taken_apart_into_commands():
    script = "a --x   # why\n\n# only a comment\ncat >f <<'EOF'\nb # kept\nEOF\nc \\\n  d\n"
    assert commands(script) == ["a --x", "cat >f <<'EOF'\nb # kept\nEOF", "c d"]


@pytest.mark.parametrize("shown, printed, same", [
    ("a\nb\n", "a\nb\n", True), ("a\n...\nd\n", "a\nb\nc\nd\n", True),
    ("computed in 1.4 s\n", "computed in 2.0 s\n", True),
    ("a\n", "a\nb\n", False), ("end 26.0 %\n", "end 26.1 %\n", False),
])
def test_difference_is_seen(shown, printed, same):
    assert (difference(shown, printed) == "") is same


@pytest.mark.parametrize("text, problem", [
    ("```sh\nno-such-command\n```\n", "ends with 127"),
    ("```sh\nfalse | cat\n```\n", "ends with 1"),
    ("```sh\necho a\n```\n<!-- output of: echo a -->\n```text\nb\n```\n", "printed:\na"),
    ("```sh\necho a\n```\n<!-- output of: echo b -->\n```text\nb\n```\n", "no command of the document is 'echo b'"),
    ("```sh\necho a\n```\n```text\na\n```\n", "nothing prints this"),
])
def test_planted_error_is_seen(tmp_path, text, problem):
    assert [found for found in problems(text, tmp_path) if problem in found]


def test_examples_share_a_folder(tmp_path):
    document = "```sh\ncat >f <<'EOF'\nx\nEOF\n```\n```sh\ncat f\n```\n<!-- output of: cat f -->\n```text\nx\n```\n"
    assert problems(document, tmp_path) == []
