# SPDX-License-Identifier: Apache-2.0
"""Every flag of every command that takes a number: one that is none, or cannot be, is refused by the flag's name."""
import os
import pathlib
import re
import subprocess

import pytest

BINARY = pathlib.Path(os.environ["VOLTLAP_BUILD_DIR"]) / "bin" / "voltlap"
NUMBERS = {"[N]", "FLOAT", "INT", "UINT", "KG", "M", "N", "RATIO", "S", "X"}
WORDS = {"TEXT", "FILE", "DIR", "IF", "KEY=VALUE", "COMMIT", "PLAN", "previous|next|linear", "laws|tests"}
BELOW_ZERO = {"--temperature"}
WITHOUT_TOO = {"--loop"}  # its number may be left out


def voltlap(*arguments, code=0):
    done = subprocess.run([BINARY, *arguments], capture_output=True, text=True, timeout=60)
    assert done.returncode == code, f"{arguments}: {done.returncode}, {done.stderr}"
    return done


def commands(words=()):
    """Each command that has none inside."""
    said = voltlap(*words, "--help").stdout
    inner = said.split("Subcommands:\n")[1].split("\n\n")[0] if "Subcommands:" in said else ""
    names = re.findall(r"^  ([a-z][a-z-]*)", inner, re.M)
    if not names:
        yield words, said
    for name in names:
        yield from commands((*words, name))


def number_flags():
    """(words of the command, flag) of each flag that takes a number. A type that is neither must be said above."""
    for words, said in commands():
        for flag, kind in re.findall(r"^ +(?:-\w,)?(--[a-z][a-z-]*) (KEY=VALUE|[^\s=:]+)", said, re.M):
            if kind in NUMBERS:
                yield words, flag
            else:  # another flag's name after Needs or Excludes: this one takes no value
                assert kind in {*WORDS, "Needs", "Excludes"}, f"{words} {flag}: of type {kind}, number or not?"


FLAGS = list(number_flags())


def test_the_flags_are_found():
    found = {(words[-1], flag) for words, flag in FLAGS}
    assert {("identify", "--mass"), ("identify", "--temperature"), ("validate", "--temperature"),
            ("endurance", "--rate"), ("plant", "--duration"), ("endurance", "--laps"), ("import", "--noise"),
            ("endurance", "--pace")} <= found
    assert len(found) > 25


@pytest.mark.parametrize("words, flag", FLAGS, ids=[f"{' '.join(words)} {flag}" for words, flag in FLAGS])
def test_what_is_no_number_or_cannot_be_is_refused(words, flag):
    below = () if flag in BELOW_ZERO else ("-1",)
    nothing = () if flag in WITHOUT_TOO else ("",)
    for value in ("nan", "-nan", "inf", "-inf", "1e999", *nothing, "5,5", "0x", "seven", *below):
        said = voltlap(*words, f"{flag}={value}", code=2).stderr
        assert said.count("\n") == 1 and said.startswith(f"voltlap: {flag}: found"), f"{flag}={value}: {said}"
        assert "; expected" in said, said


@pytest.mark.parametrize("text", ["nan:10", "0:nan", "5:1", "a:b", "7"])
def test_windows_and_blocks_of_identify_are_numbers_too(text, tmp_path):
    table = tmp_path / "table.csv"
    table.write_text("time_s,current_a,voltage_v\n0,0,4.1\n1,2,4.0\n")
    assert "--window: found" in voltlap("identify", "--window", text, table, code=2).stderr
    for blocks in ("nan:even", "inf:odd", "0:even", "-5:even"):
        assert "--blocks: found" in voltlap("identify", table, "--blocks", blocks, code=2).stderr
