# SPDX-License-Identifier: Apache-2.0
"""Every command in the documents works, and prints what the documents show.

A block of `sh` is run command by command. A block of `text` that follows a comment `<!-- output of: COMMAND -->` is
compared with what COMMAND prints; a line `...` in it stands for any lines.
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys

import pytest
from documents import PROJECT, blocks, commands, documents

# Commands that are not run here, each with its reason. One that no document has any more is refused.
NOT_RUN = {
    "./voltlap test": "it is what runs this test",
    "toolchain/bare_root_test.sh": "it downloads a system and takes minutes; its short form has a suite of its own",
}
# What differs from run to run, in what is shown and in what is printed.
VARIES = [(re.compile(r"computed in [\d.]+ s"), "computed in N s")]
WITH_COMMANDS = [name for name in documents()
                 if any(block.language == "sh" for block in blocks((PROJECT / name).read_text()))]
WITH_OUTPUT = [(name, block) for name in documents() for block in blocks((PROJECT / name).read_text()) if block.output_of]


def reason_not_to_run(command):
    return next((NOT_RUN[start] for start in NOT_RUN if command == start or command.startswith(start + " ")), None)


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
                          stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=300)


@pytest.mark.parametrize("name", WITH_COMMANDS)
def test_commands_of_a_document_work(folder, name):
    for block in blocks((PROJECT / name).read_text()):
        if block.language != "sh":
            continue
        for command in commands(block.body):
            if reason_not_to_run(command):
                continue
            done = run(command, folder)
            assert done.returncode == 0, f"{name}, block at line {block.line}: {command}\n{done.stdout}{done.stderr}"


@pytest.mark.parametrize("name, block", WITH_OUTPUT, ids=[f"{name}: {block.output_of}" for name, block in WITH_OUTPUT])
def test_shown_output_is_what_the_command_prints(folder, name, block):
    scripts = [commands(other.body) for other in blocks((PROJECT / name).read_text()) if other.language == "sh"]
    script = next((script for script in scripts if block.output_of in script), None)
    assert script, f"{name}: no block has the command {block.output_of!r}"
    for command in script[:script.index(block.output_of)]:
        run(command, folder)
    assert difference(block.body, run(block.output_of, folder).stdout) == ""


def difference(shown, printed):
    for varying, name in VARIES:
        shown, printed = varying.sub(name, shown), varying.sub(name, printed)
    pattern = "".join(".*" if line == "..." else re.escape(line) + "\n" for line in shown.splitlines())
    return "" if re.fullmatch(pattern, printed, re.DOTALL) else f"shown:\n{shown}\nprinted:\n{printed}"


def test_list_of_what_is_not_run_holds_no_left_over():
    everywhere = [command for name in WITH_COMMANDS for block in blocks((PROJECT / name).read_text())
                  if block.language == "sh" for command in commands(block.body)]
    left = [start for start in NOT_RUN if not any(c == start or c.startswith(start + " ") for c in everywhere)]
    assert left == []


def test_every_block_of_text_says_what_prints_it():
    silent = [f"{name}, line {block.line}" for name in documents() for block in blocks((PROJECT / name).read_text())
              if block.language == "text" and not block.output_of]
    assert silent == []


# ---- the checks themselves ----

def test_blocks_are_taken_apart_into_commands():
    script = "a --x   # why\n\n# only a comment\ncat >f <<'EOF'\nb # kept\nEOF\nc \\\n  d\n"
    assert commands(script) == ["a --x", "cat >f <<'EOF'\nb # kept\nEOF", "c d"]


@pytest.mark.parametrize("shown, printed, same", [
    ("a\nb\n", "a\nb\n", True), ("a\n...\nd\n", "a\nb\nc\nd\n", True), ("computed in 1.4 s\n", "computed in 2.0 s\n", True),
    ("a\n", "a\nb\n", False), ("end 26.0 %\n", "end 26.1 %\n", False),
])
def test_difference_is_seen(shown, printed, same):
    assert (difference(shown, printed) == "") is same


def test_failing_command_and_failing_pipe_are_seen(tmp_path):
    assert run("no-such-command", tmp_path).returncode != 0
    assert run("false | cat", tmp_path).returncode != 0
