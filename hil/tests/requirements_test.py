# SPDX-License-Identifier: Apache-2.0
import re

import pytest

from voltlap_hil import requirements
from voltlap_hil.errors import InputError


def test_a_bound_is_the_number_of_the_requirement():
    assert requirements.bound_ms("BMS-013") == 510
    assert requirements.bound_ms("MST-001") == 50


def test_every_number_stands_in_the_text_of_its_bound():
    """within_ms repeats the text's time, with the step of 10 ms that 'one step more' or 'same step' means."""
    for row in requirements.requirements().values():
        if row.within_ms is None:
            continue
        times = {int(ms) for ms in re.findall(r"(\d+) ms", row.bound)}
        step = 10 if re.search(r"one step more|same step|first step|one step", row.bound, re.I) else 0
        assert row.within_ms in {t + step for t in times} | ({10} if step else set()), row


def test_an_unknown_id_and_one_without_time_are_told():
    with pytest.raises(InputError, match="Did you mean"):
        requirements.bound_ms("BMS-01")
    with pytest.raises(InputError, match="BMS-003 states no time"):
        requirements.bound_ms("BMS-003")


def test_a_file_that_is_not_there_is_told(tmp_path, monkeypatch):
    monkeypatch.setenv("VOLTLAP_REQUIREMENTS", str(tmp_path / "x.toml"))
    requirements.requirements.cache_clear()
    with pytest.raises(InputError, match="VOLTLAP_REQUIREMENTS"):
        requirements.requirement("BMS-013")
    requirements.requirements.cache_clear()


@pytest.mark.parametrize("data", [b"\xff", b"[[requirement]", b"a = 1", b"[[requirement]]\nid = 1", b"requirement = 3",
                                  b"requirement = [1]"])
def test_a_file_that_cannot_be_used_is_told(tmp_path, monkeypatch, data):
    (tmp_path / "x.toml").write_bytes(data)
    monkeypatch.setenv("VOLTLAP_REQUIREMENTS", str(tmp_path / "x.toml"))
    requirements.requirements.cache_clear()
    with pytest.raises(InputError, match=r"x.toml: .*Set VOLTLAP_REQUIREMENTS"):
        requirements.requirement("BMS-013")
    requirements.requirements.cache_clear()
