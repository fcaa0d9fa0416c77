# SPDX-License-Identifier: Apache-2.0
"""firmware/requirements.toml: every requirement stands in a source and in a test, and none is invented there."""
import pathlib
import re

try:
    import tomllib
except ModuleNotFoundError:  # Python before 3.11
    import tomli as tomllib

ROOT = pathlib.Path(__file__).resolve().parents[2]
ID = re.compile(r"\b(?:BMS|MST|DIA)-\d{3}\b")
SOURCES = (".hpp", ".cpp")


def requirements():
    with (ROOT / "firmware" / "requirements.toml").open("rb") as file:
        return tomllib.load(file)["requirement"]


def ids_in(texts):
    return {found for text in texts for found in ID.findall(text)}


def ids_under(folder):
    files = [path for path in (ROOT / folder).rglob("*") if path.suffix in SOURCES]
    assert files
    return ids_in(path.read_text() for path in files)


def unmatched(known, in_sources, in_tests):
    """What is wrong with the three sets, as sentences."""
    return ([f"{i} stands in no source" for i in sorted(known - in_sources)]
            + [f"{i} stands in no test" for i in sorted(known - in_tests)]
            + [f"{i} is not in requirements.toml" for i in sorted((in_sources | in_tests) - known)])


def test_every_requirement_is_complete_and_unique():
    rows = requirements()
    ids = [row["id"] for row in rows]
    assert len(set(ids)) == len(ids)
    for row in rows:
        assert ID.fullmatch(row["id"]), row
        assert row["text"].strip() and row["bound"].strip(), row
        assert set(row) <= {"id", "text", "bound", "within_ms", "rule"}, row


def test_every_requirement_has_a_source_and_a_test():
    known = {row["id"] for row in requirements()}
    assert unmatched(known, ids_under("firmware"), ids_under("tests")) == []


def test_a_requirement_without_its_parts_is_found():
    assert unmatched({"BMS-001"}, set(), {"BMS-001"}) == ["BMS-001 stands in no source"]
    assert unmatched({"BMS-001"}, {"BMS-001"}, set()) == ["BMS-001 stands in no test"]
    assert unmatched(set(), {"MST-009"}, set()) == ["MST-009 is not in requirements.toml"]
    assert ids_in(["// MST-031 (Eq. 4.13): text", "XMST-0312"]) == {"MST-031"}
