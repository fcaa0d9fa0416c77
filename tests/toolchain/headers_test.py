# SPDX-License-Identifier: Apache-2.0
"""Every file includes what it uses: it compiles without the headers that a build reads ahead (VOLTLAP_PCH).

Four files, drawn by VOLTLAP_TEST_SEED; all with VOLTLAP_TEST_WHOLE=1: together they take minutes.
"""
import json
import os
import pathlib
import random
import shlex
import subprocess

SEED = os.environ.get("VOLTLAP_TEST_SEED") or str(random.randrange(2**32))
DRAWN = 4
READ_AHEAD = ("cmake_pch", "-Winvalid-pch")


def without_headers_read_ahead(command):
    """The words of a compiler's command, to check the syntax alone."""
    words = shlex.split(command)
    kept = [word for k, word in enumerate(words)
            if not any(mark in word for mark in READ_AHEAD)
            and not (word in ("-include", "-Xclang") and any(mark in words[k + 1] for mark in READ_AHEAD))]
    place = kept.index("-o")
    return [*kept[:place], *kept[place + 2:], "-fsyntax-only"]


def messages(command, folder):
    done = subprocess.run(without_headers_read_ahead(command), cwd=folder, capture_output=True, text=True,
                          env={**os.environ, "CCACHE_DISABLE": "1"})
    return "" if done.returncode == 0 else done.stderr


def test_drawn_files_compile_without_the_headers_that_are_read_ahead():
    build = pathlib.Path(os.environ["VOLTLAP_BUILD_DIR"])
    entries = [entry for entry in json.loads((build / "compile_commands.json").read_text())
               if build not in pathlib.Path(entry["file"]).parents]
    print(f"VOLTLAP_TEST_SEED={SEED}")
    whole = os.environ.get("VOLTLAP_TEST_WHOLE") == "1"
    for entry in entries if whole else random.Random(SEED).sample(entries, DRAWN):
        assert messages(entry["command"], entry["directory"]) == "", entry["file"]


def test_a_file_that_leans_on_them_is_found(tmp_path):
    (tmp_path / "cmake_pch.hxx").write_text("#include <vector>\n")
    (tmp_path / "file.cpp").write_text("std::vector<int> numbers;\n")
    command = "c++ -Winvalid-pch -include cmake_pch.hxx -o file.o -c file.cpp"
    assert subprocess.run(shlex.split(command), cwd=tmp_path).returncode == 0
    assert "vector" in messages(command, tmp_path)
