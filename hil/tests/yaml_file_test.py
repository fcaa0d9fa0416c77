# SPDX-License-Identifier: Apache-2.0
"""Bytes that are no plain page of YAML are told with their line, and cost neither time nor memory."""
import os
import time

import pytest

from voltlap_hil.errors import InputError
from voltlap_hil.scenario_file import load

GOOD = "scenario: x\nwhen:\n  - run: 10 ms\nthen:\n  - torque_zero_within: 1 s\n"


@pytest.fixture
def complaint_of(tmp_path, dbc):
    """What is said of a file's bytes, without the name of the file. What runs away takes minutes, or never ends; the
    longest of these a second or three, by the machine."""
    def reading(data):
        path = tmp_path / "s.yaml"
        path.write_bytes(data if isinstance(data, bytes) else data.encode())
        begin = time.process_time()
        with pytest.raises(InputError) as error:
            load(path, dbc)
        assert time.process_time() - begin < 30.0
        assert str(error.value).startswith(f"{path}:")
        return str(error.value).removeprefix(f"{path}:").strip()
    return reading


@pytest.mark.parametrize("data", [b"\xef\xbb\xbf" + GOOD.encode(), GOOD.replace("\n", "\r\n").encode(),
                                  GOOD.replace("\n", "\r").encode(), GOOD.rstrip().encode(),
                                  b"---\n" + GOOD.encode() + b"...\n",
                                  GOOD.replace(": x", ": Überholen, 100\u00a0 km/h \U0001f3ce").encode(),
                                  b"# \xe2\x82\xac\n" + GOOD.encode()])
def test_marks_line_ends_and_letters_of_any_editor_are_read(tmp_path, dbc, data):
    path = tmp_path / "s.yaml"
    path.write_bytes(data)
    assert len(load(path, dbc).when) == 1


@pytest.mark.parametrize("data, complaint", [
    (GOOD.replace("x", "Kl\xe4nge").encode("latin-1"), "1: found the byte 0xE4, which is no UTF-8"),
    (GOOD.encode() + b"# \xff", "6: found the byte 0xFF"),
    (GOOD.encode("utf-16"), "1: found UTF-16, expected UTF-8"),
    (GOOD.encode("utf-16-be"), "1: found what looks like UTF-16"),
    (GOOD.encode("utf-16-le"), "1: found what looks like UTF-16"),
    (b"\xff\xfe\x00\x00" + GOOD.encode("utf-32-le"), "1: found UTF-32"),
    (GOOD + "# \x07\n", "6: found the control character U+0007"),
    (GOOD.replace("10 ms", "10\x00ms"), "3: found the control character U+0000"),
    (GOOD.replace("x", r'"\0"'), "1: scenario: found the control character U+0000"),
    (GOOD.replace("x", r'"\ud800"'), "1: scenario: found the control character U+D800"),
    (GOOD.replace("x", r'"\U00110000"'), "1: found an escape that stands for no character"),
    (GOOD.replace("x", r'"\UFFFFFFFF"'), "1: found an escape that stands for no character"),
    ("", "1: the file is empty"), ("# nothing\n\n", "1: the file is empty"), ("~\n", "1: file: found nothing"),
    (GOOD.replace("  - run", "\t- run"), "3: found a tab; indent with spaces"),
    (GOOD + "---\n" + GOOD, "6: found a second document"),
    (GOOD + "observe: [", "6: while parsing a flow node expected the node content"),
    (GOOD + "observe: [\n\n\n", "6: while parsing a flow node expected the node content")])
def test_what_is_no_text_of_yaml_is_told_with_its_line(complaint_of, data, complaint):
    assert complaint_of(data).startswith(complaint)


def laughs(levels):
    rows = [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}' if i else 'ha'] * 9)}]" for i in range(levels)]
    return "\n".join(rows) + "\n"


@pytest.mark.parametrize("data, complaint", [
    ("[" * 50_000, "1: found brackets or indents more than 20 levels deep"),
    (GOOD + "observe: " + "{a: " * 5_000, "6: found brackets or indents more than 20 levels deep"),
    ("- " * 5_000 + "x", "1: found brackets or indents more than 20 levels deep"),
    (laughs(9), "6: found more than 80000 values, aliases followed"),
    (GOOD + "observe: &a [*a]\n", "6: found the alias *a inside of what it stands for"),
    (GOOD + "observe: *b\n", "6: found undefined alias"),
    (GOOD + "proves: [" + "MST-001, " * 9_000 + "]", "6: proves[1]: 'MST-001' stands here twice"),
    (GOOD + "arguments: [" + "a, " * 81_000 + "]", "6: found more than 80000 values"),
    (GOOD.replace("run: 10 ms", "run: " + "9" * 90_000),
     "3: when[0].run: found 90000 characters, expected at most 1000"),
    (GOOD + "y" * 90_000 + ": 1\n", "6: while scanning a simple key"),
    (GOOD + "#" * 400_000, "found more than 400 kB"), ("x" * 10_000_000, "found more than 400 kB"),
    (GOOD.replace("x", "!!python/object/apply:os.getcwd []"), "1: found the tag 'tag:yaml.org,2002:python/object"),
    (GOOD.replace("x", "!own y"), "1: found the tag '!own'"),
    (GOOD.replace("- run: 10 ms", "- {<<: {run: 10 ms}}"), "3: when[0]: found the merge key '<<'"),
    (GOOD.replace("run: 10 ms", "[run]: 10 ms"), "3: when[0]: found a list as a name"),
    (GOOD + "scenario: y\n", "6: scenario: 'scenario' stands here twice")])
def test_what_a_scenario_has_no_use_for_is_told_at_once(complaint_of, data, complaint):
    assert complaint_of(data).startswith(complaint)


def test_an_alias_stands_for_its_value(tmp_path, dbc):
    path = tmp_path / "s.yaml"
    path.write_text(GOOD.replace("run: 10 ms", "run: &t 10 ms\n  - run: *t"))
    assert [step.text for step in load(path, dbc).when] == ["run 10 ms"] * 2


def test_what_is_no_file_is_told(tmp_path, dbc):
    os.mkfifo(tmp_path / "pipe")
    for path, complaint in ((tmp_path, "found a folder"), ("/dev/zero", "found a device"),
                            (tmp_path / "pipe", "found a pipe"),
                            (tmp_path / "none.yaml", "No such file"), (tmp_path / ("x" * 300), "File name too long")):
        with pytest.raises(InputError, match=complaint):
            load(path, dbc)


@pytest.mark.skipif(os.geteuid() == 0, reason="root reads every file")
def test_a_file_that_may_not_be_read_is_told(tmp_path, dbc):
    path = tmp_path / "s.yaml"
    path.write_text(GOOD)
    path.chmod(0)
    with pytest.raises(InputError, match="Permission denied"):
        load(path, dbc)


def test_a_name_that_is_as_a_complaint_begins_hides_no_place(tmp_path, dbc, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "found").write_text(GOOD.replace("10 ms", "11 ms"))
    with pytest.raises(InputError, match="^found:3: when.0..run: found '11 ms', expected a multiple of 10 ms"):
        load("found", dbc)
