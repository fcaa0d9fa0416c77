# SPDX-License-Identifier: Apache-2.0
"""The report of a validation in a real browser: what stands in its charts, and that it asks for nothing."""
import csv
import pathlib
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[4]
sys.path.insert(0, str(ROOT / "tests" / "plant_sim" / "race" / "report"))
from report_reader import BINARY, ask, opened, requests  # noqa: E402


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    """Address of the page, and the error over time as a table."""
    folder = tmp_path_factory.mktemp("validation")
    bench = [BINARY, "bench-test", "random_resistors_free", "--out", "drive", "--set", "load.resistors=[4, 2, 6]"]
    subprocess.run(bench, cwd=folder, check=True, capture_output=True, timeout=300)
    files = sorted(str(path) for path in folder.glob("drive/*.csv"))[:2]
    validate = [BINARY, "validate", "aesc_e5_2p", *files, "--full", "--csv", "e.csv", "--report", "v.html"]
    subprocess.run(validate, cwd=folder, check=True, capture_output=True, timeout=300)
    with open(folder / "e.csv") as lines:
        rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    return (folder / "v.html").as_uri(), rows


@pytest.mark.parametrize("dark", [False, True])
def test_page_opens_quietly_and_asks_the_network_for_nothing(browser, report, dark):
    page = opened(browser.page(report[0], dark=dark))
    assert page.complaints() == []
    assert requests(page) == set()


def test_charts_hold_the_error_over_time(browser, report):
    page = opened(browser.page(report[0]))
    for file in (0, 1):
        own = [1e3 * float(row["error_v"]) for row in report[1] if row["file"] == str(file + 1)]
        shown = ask(page, f"values('chart-error-{file}', 0)")
        assert len(shown) == len(own)
        assert max(shown, key=abs) == pytest.approx(max(own, key=abs), abs=0.06)
        for name in ("voltage", "current", "temperature"):
            assert ask(page, f"values('chart-{name}-{file}', 0).length") == len(own)


def test_voltage_fills_its_chart(browser, report):
    page = opened(browser.page(report[0]))
    low, high = ask(page, "chart('chart-voltage-0').getModel().getComponent('yAxis').axis.scale.getExtent()")
    volts = [float(row["voltage_v"]) for row in report[1] if row["file"] == "1"]
    assert low > min(volts) - 0.25 and high < max(volts) + 0.25


def test_tables_of_the_study_stand_on_the_page(browser, report):
    page = opened(browser.page(report[0]))
    text = page.run("document.body.innerText")
    for words in ("RMS, capacities adjusted", "(192.8)", "60.1 mV", "convection_w_per_m2_k", "Appendix C"):
        assert words in text
    assert page.run("document.querySelectorAll('#files tbody tr').length") == 2
