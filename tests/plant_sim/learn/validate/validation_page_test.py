# SPDX-License-Identifier: Apache-2.0
"""The report of a validation in a real browser: what stands in its charts, and that it asks for nothing."""
import csv
import json
import pathlib
import re
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[4]
sys.path.insert(0, str(ROOT / "tests" / "plant_sim" / "race" / "report"))
sys.path.insert(0, str(ROOT / "tests" / "plant_sim" / "learn"))
import long_recording  # noqa: E402
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


@pytest.fixture(scope="module")
def days(tmp_path_factory):
    """Two tests of a day with an open contactor at the end, against the cell of one: page, text, JSON, the time behind
    the pause."""
    folder = tmp_path_factory.mktemp("days")
    behind = long_recording.write(folder / "first_day_of_a_test_with_a_long_name.csv")
    long_recording.write(folder / "second.csv", hours=20)
    identify = [BINARY, "identify", "second.csv", "--temperature", "25", "--out", "cell.toml"]
    subprocess.run(identify, cwd=folder, check=True, capture_output=True, timeout=300)
    validate = [BINARY, "validate", "cell.toml", "first_day_of_a_test_with_a_long_name.csv", "second.csv", "--full",
                "--json", "v.json", "--report", "v.html"]
    run = subprocess.run(validate, cwd=folder, capture_output=True, text=True, timeout=300)
    assert run.returncode == 0, run.stderr
    return (folder / "v.html").as_uri(), run.stdout, (folder / "v.json").read_text(), behind


def choose(page, index):
    page.run(f"(() => {{ const s = document.getElementById('recording'); s.value = {index};"
             " s.dispatchEvent(new Event('change')); })()")
    page.settle()


@pytest.mark.parametrize("dark", [False, True])
def test_page_opens_quietly_and_asks_the_network_for_nothing(browser, report, dark):
    page = opened(browser.page(report[0], dark=dark))
    assert page.complaints() == []
    assert requests(page) == set()


def test_charts_hold_the_error_over_time(browser, report):
    page = opened(browser.page(report[0]))
    for file in (0, 1):
        own = [1e3 * float(row["error_v"]) for row in report[1] if row["file"] == str(file + 1)]
        choose(page, file)
        shown = ask(page, "values('chart-error', 0)")
        assert len(shown) == len(own)
        assert max(shown, key=abs) == pytest.approx(max(own, key=abs), abs=0.06)
        for name in ("voltage", "current", "temperature"):
            assert ask(page, f"values('chart-{name}', 0).length") == len(own)


def test_voltage_fills_its_chart(browser, report):
    page = opened(browser.page(report[0]))
    low, high = ask(page, "chart('chart-voltage').getModel().getComponent('yAxis').axis.scale.getExtent()")
    volts = [float(row["voltage_v"]) for row in report[1] if row["file"] == "1"]
    assert low > min(volts) - 0.25 and high < max(volts) + 0.25


def test_tables_of_the_study_stand_on_the_page(browser, report):
    page = opened(browser.page(report[0]))
    text = page.run("document.body.innerText")
    for words in ("RMS, capacities adjusted", "(192.8)", "60.1 mV", "convection_w_per_m2_k", "Appendix C"):
        assert words in text
    assert page.run("document.querySelectorAll('#files tbody tr').length") == 2


def test_time_is_in_hours_and_no_line_is_drawn_over_a_pause(browser, days):
    page = opened(browser.page(days[0]))
    for name in ("voltage", "error", "current"):
        assert ask(page, f"chart('chart-{name}').getOption().xAxis[0].name") == "time, h"
        points = ask(page, f"Array.from(chart('chart-{name}').getOption().series[0].data,"
                           " v => Number.isNaN(v) ? 'none' : v)")
        gaps = [at for at, value in enumerate(points[1::2]) if value == "none"]
        assert len(gaps) == 1, name
        assert points[::2][gaps[0]] == pytest.approx(days[3], abs=30)
        assert points[::2][gaps[0] - 1] < days[3] - 7000


def test_recordings_are_small_charts_on_one_scale_and_one_is_open(browser, days):
    page = opened(browser.page(days[0]))
    assert page.run("[...document.querySelectorAll('#overview .small-name')].map(one => one.textContent)") == [
        "first_day_of_a_test_with_a_long_name.csv", "second.csv"]
    scales = [ask(page, f"chart('small-{at}').getOption().yAxis[0].max") for at in (0, 1)]
    assert scales[0] == scales[1]
    page.run("document.querySelectorAll('#overview .small')[1].click()")
    page.settle()
    assert page.run("document.getElementById('recording').value") == "1"
    assert page.run("document.querySelectorAll('#strips canvas').length") == 3  # no temperature was recorded


def test_errors_are_on_the_scale_of_those_that_count(browser, days):
    page = opened(browser.page(days[0]))
    found = json.loads(days[2])["files"][0]
    high = ask(page, "chart('chart-error').getModel().getComponent('yAxis').axis.scale.getExtent()")[1]
    assert 1e3 * found["rms_v"] < high <= 2e3 * found["max_error_v"] < 400
    shown = ask(page, "values('chart-error', 0).filter(value => value === value)")
    assert max(shown) > 400  # the open contactor at its end does not count
    assert "beyond the scale: ▲ to" in page.run(
        "document.getElementById('chart-error').closest('.card').textContent")


def test_every_number_can_be_read_by_a_person(browser, days):
    no_number = re.compile(r"\b-?(?:nan|inf)\b|NaN|Infinity|\d(?:\.\d+)?e[-+]\d")
    page = opened(browser.page(days[0]))
    assert no_number.findall(page.run("document.body.innerText")) == []
    assert no_number.findall(days[1]) == []

    def refuse(constant):
        raise AssertionError(constant)

    json.loads(days[2], parse_constant=refuse)


def test_a_phone_shows_all_of_it(browser, days):
    page = opened(browser.page(days[0], width=390, height=844, mobile=True))
    assert page.run("document.documentElement.scrollWidth") == 390
