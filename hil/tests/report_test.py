# SPDX-License-Identifier: Apache-2.0
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

from voltlap_hil import report
from voltlap_hil.checks import Result
from voltlap_hil.errors import InputError
from voltlap_hil.runner import Outcome
from voltlap_hil.scenario_file import Scenario

HELD = Result("torque zero", True, 60, "100 ms", "ms")
MISSED = Result("torque zero", False, None, "100 ms", "ms")


@pytest.fixture
def outcomes():
    scenario = Scenario(Path("s.yaml"), "Pedals <lost> | late", ["MST-001"])
    return [Outcome(scenario, True, [HELD]), Outcome(scenario, False, [MISSED]), Outcome(scenario, True, [MISSED]),
            Outcome(scenario, True, error="the plant died")]


def test_junit_counts_failures_and_errors(outcomes):
    suite = ElementTree.fromstring(report.junit(outcomes).split("\n", 1)[1])
    assert (suite.get("tests"), suite.get("failures"), suite.get("errors")) == ("4", "1", "1")
    assert suite[0].get("name") == "Pedals <lost> | late" and suite[0].find("failure") is None
    assert "bound 100 ms" in suite[2].find("failure").text and suite[3].find("error").get("message") == "the plant died"


def test_markdown_has_a_row_for_each_check_with_measured_time_and_bound(outcomes):
    lines = report.markdown(outcomes).splitlines()
    assert "4 runs: 2 as it must be, 1 not, 1 could not be run." in lines
    assert lines[6] == "| Pedals <lost> \\| late | MST-001 | with event | torque zero | 60 ms | 100 ms | held |"
    assert lines[7].endswith("| without event | torque zero | never | 100 ms | not held |")
    assert lines[8].endswith("| never | 100 ms | not held, WRONG |")
    assert lines[9].endswith("| the plant died |  |  | not run |")


def test_html_is_escaped_and_marks_what_is_wrong(outcomes):
    page = report.html_page(outcomes)
    assert "Pedals &lt;lost&gt;" in page and page.count('class="wrong"') == 2


def test_html_is_read_on_a_phone_and_one_run_is_one(outcomes):
    page = report.html_page(outcomes[:1])
    assert 'name="viewport" content="width=device-width' in page and 'data-name="measured"' in page
    assert "1 run: 1 as it must be, 0 not." in page and 'class="status good"' in page


@pytest.mark.parametrize("suffix", [".xml", ".md", ".html"])
def test_a_file_is_written_whole(tmp_path, outcomes, suffix):
    path = tmp_path / f"r{suffix}"
    report.write(path, outcomes)
    assert path.read_text() == report.WRITERS[suffix](outcomes)
    assert list(tmp_path.iterdir()) == [path]


def test_an_unknown_form_or_place_is_told(tmp_path, outcomes):
    with pytest.raises(InputError, match="found .pdf, expected one of .xml, .md, .html"):
        report.write(tmp_path / "r.pdf", outcomes)
    with pytest.raises(InputError, match="cannot write"):
        report.write(tmp_path / "none" / "r.md", outcomes)
