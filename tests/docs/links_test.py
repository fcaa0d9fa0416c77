# SPDX-License-Identifier: Apache-2.0
"""What the documents point to exists: links, headings, files, commands and flags."""
import glob
import os
import re
import subprocess

import pytest
from documents import PROJECT, documents, prose

LINK = re.compile(r"\]\(([^)\s]+)\)")
CODE = re.compile(r"`([^`\n]+)`")
FILE = re.compile(r"[\w.*{},+-]+(/[\w.*{},+-]*)+|[\w*{},-]+\.(cpp|hpp|toml|dbc|py|sh|cmake|csv|md|txt)")
# Named like a file of the project, but made by the reader; the build makes what lies in build/.
NOT_IN_THE_TREE = {"run.log", "run.json", "run.csv.gz", "ours.toml"}


def read(name):
    return (PROJECT / name).read_text()


def headings(text):
    titles = re.findall(r"^#+ (.+)$", text, re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


def broken_links(name, text):
    broken = []
    for link in LINK.findall(text):
        if re.match(r"[a-z]+:", link):
            continue
        path, _, heading = link.partition("#")
        target = (PROJECT / name).parent / path if path else PROJECT / name
        if not target.exists() or (heading and heading not in headings(target.read_text())):
            broken.append(link)
    return broken


def alternatives(pattern):
    """The names that a pattern like a.{hpp,cpp} stands for."""
    braces = re.search(r"\{([^{}]*)\}", pattern)
    if not braces:
        return [pattern]
    return [name for part in braces[1].split(",")
            for name in alternatives(pattern[:braces.start()] + part + pattern[braces.end():])]


def missing_files(name, text):
    """Names in code quotes that look like files and are none, seen from the document's folder or the root."""
    bases = [(PROJECT / name).parent, PROJECT]
    missing = []
    for code in CODE.findall(text):
        if not FILE.fullmatch(code) or code in NOT_IN_THE_TREE or code.startswith("build/"):
            continue
        for path in alternatives(code):
            if not any(glob.glob(str(base / path)) for base in bases):
                missing.append(path)
    return missing


def start_script_commands():
    return set(re.findall(r"^  row ([a-z-]+) ", read("voltlap"), re.MULTILINE))


def unknown_commands(text):
    named = [code.split() for code in CODE.findall(text) if re.match(r"(\./)?voltlap ", code)]
    known = start_script_commands()
    return [words[1] for words in named if re.fullmatch("[a-z-]+", words[1]) and words[1] not in known]


def help_of(words):
    return subprocess.run([PROJECT / "voltlap", *words], capture_output=True, text=True, check=True,
                          env={**os.environ, "CI": "true"}).stdout


@pytest.fixture(scope="module")
def all_help():
    texts = [help_of([])]
    for command in sorted(start_script_commands()):
        texts.append(help_of([command, "--help"]))
        inner = re.search(r"^Subcommands:\n((?:  .*\n)+)", texts[-1], re.MULTILINE)  # of a command that has its own
        names = re.findall(r"^  (\S+)", inner[1], re.MULTILINE) if inner else []
        texts += [help_of([command, name, "--help"]) for name in names]
    return "".join(texts)


@pytest.mark.parametrize("name", documents())
def test_links_lead_somewhere(name):
    assert broken_links(name, prose(read(name))) == []


@pytest.mark.parametrize("name", [name for name in documents() if name != "CHANGELOG.md"])
def test_named_files_exist(name):
    assert missing_files(name, prose(read(name))) == []


@pytest.mark.parametrize("name", documents())
def test_named_commands_exist(name):
    assert unknown_commands(prose(read(name))) == []


@pytest.mark.parametrize("name", documents())
def test_named_flags_are_flags_of_a_command(name, all_help):
    flags = {flag for code in CODE.findall(prose(read(name))) if re.match(r"--|(\./)?voltlap ", code)
             for flag in re.findall(r"(?<!\S)--[a-z][a-z-]*", code)}
    assert {flag for flag in flags if not re.search(flag + r"\b", all_help)} == set()


# ---- the checks themselves ----

@pytest.mark.parametrize("text", ["[a](no/such/file.md)", "[a](#no-such-heading)", "[a](docs/no.md#x)"])
def test_broken_link_is_seen(text):
    assert broken_links("README.md", text)


@pytest.mark.parametrize("text", ["`bms/no_such.cpp`", "`firmware/bms/{limits,no_such}.cpp`", "`plant_sim/none/`"])
def test_missing_file_is_seen(text):
    assert missing_files("firmware/README.md", text)


def test_unknown_command_is_seen():
    assert unknown_commands("`./voltlap race --fast`") == ["race"]
