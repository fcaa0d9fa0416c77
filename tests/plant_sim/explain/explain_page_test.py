# SPDX-License-Identifier: Apache-2.0
"""The report of voltlap explain in headless Chromium: verdicts, charts, choice of channel, dark, narrow, offline."""
import math

import pytest
from drives import Drives, comes_and_goes, contact, lagging, stuck, voltlap, write

def odd(rows):
    """A cell that is wrong in no known way."""
    return [{**row, "cell_voltage_3_v": row["cell_voltage_3_v"] + 0.02 * math.sin(row["time_s"] / 4.0)} for row in rows]


# By name: what the log is made of, the word of its verdict, whether anything is changed by what was found.
LOGS = {
    "contact": (lambda drive: contact(drive(), 0.006), "Named", True),
    "lag": (lambda drive: lagging(drive(), 150.0), "Named", True),
    "part": (lambda drive: comes_and_goes(drive()), "Ambiguous", True),
    "clean": (lambda drive: drive(), "No discrepancy", False),
    "stuck": (lambda drive: stuck(drive()), "Named", False),
    "short": (lambda drive: drive()[:300], "Too little data", False),
    "unknown": (lambda drive: odd(drive()), "Unknown cause", False),
}


@pytest.fixture(scope="module")
def reports(tmp_path_factory):
    folder = tmp_path_factory.mktemp("reports")
    drive = Drives(folder)
    for name, (rows, _, _) in LOGS.items():
        voltlap("explain", write(folder / f"{name}.csv", rows(drive)), "--model", "vtm16e", "--report",
                folder / f"{name}.html")
    return folder


def opened(browser, path, **how):
    page = browser.page(path.as_uri(), **how)
    page.wait_for("document.documentElement?.dataset.ready", timeout_s=60)
    return page


def text(page, selector):
    return page.run(f"document.querySelector('{selector}').textContent")


def extremes(page, chart, series):
    values = page.run(f"Array.from(echarts.getInstanceByDom(document.getElementById('{chart}')).getOption()"
                      f".series[{series}].data).filter((_, i) => i % 2)")
    return min(values), max(values)


@pytest.mark.parametrize("name", LOGS)
def test_every_verdict_has_a_page_that_is_whole_and_asks_for_nothing(browser, reports, name):
    path = reports / f"{name}.html"
    assert path.stat().st_size < 3_000_000
    page = opened(browser, path)
    assert page.complaints() == []
    assert LOGS[name][1] in text(page, ".status") and text(page, "h1").endswith(".")
    tables = page.run("document.querySelectorAll('table.map').length")
    assert tables == (0 if name == "short" else 2 if LOGS[name][2] else 1)
    sent = {event["params"]["request"]["url"] for event in page.happened("Network.requestWillBeSent")} - {page.url}
    assert {url for url in sent if not url.startswith("data:")} == set()


def test_the_first_chart_shows_what_the_answer_takes_away(browser, reports):
    page = opened(browser, reports / "contact.html")
    assert "contact" in text(page, "h1") and "mOhm" in text(page, "h1")
    assert text(page, "#strips h3") == "Pack voltage given the cells"
    after, before = extremes(page, "chart-error-0", 0), extremes(page, "chart-error-0", 1)
    assert before[0] < -1.0 and -0.2 < after[0] and after[1] < 0.2  # V; 0.006 ohm at 230 A


def test_the_race_stands_in_the_page(browser, reports):
    page = opened(browser, reports / "contact.html")
    rows = page.run("[...document.querySelectorAll('[aria-labelledby=\"race-title\"] tbody tr')]"
                    ".map(r => r.innerText.split('\\t'))")
    by_name = {row[0].strip(): row[1:] for row in rows}
    assert float(by_name["charge left, % SOC"][1]) < float(by_name["charge left, % SOC"][0])
    assert by_name["outcome"][0].strip() == "finished"


def test_another_channel_can_be_chosen(browser, reports):
    page = opened(browser, reports / "contact.html")
    titles = page.run("[...document.getElementById('channel').options].map(o => o.textContent)")
    assert titles[0] == "pack voltage given the cells" and "temperature given the current" in titles
    chart = "echarts.getInstanceByDom(document.getElementById('chart-against-0'))"
    unit = lambda: page.run(f"{chart}.getOption().yAxis[0].name")
    assert unit() == "error, V"
    chosen = titles.index("temperature given the current")
    page.run(f"(() => {{ const s = document.getElementById('channel'); s.value = {chosen};"
             " s.dispatchEvent(new Event('change')); })()")
    assert unit() == "error, K"


def test_stretches_that_were_not_used_are_listed_and_marked(browser, reports):
    page = opened(browser, reports / "stuck.html")
    assert "frozen at" in text(page, "[aria-labelledby=\"masked-title\"]")
    assert page.run("document.getElementById('strips').textContent").count("not used") >= 1


def test_page_is_readable_in_the_dark_on_a_narrow_screen_and_without_scripts(browser, reports):
    page = opened(browser, reports / "part.html", width=390, height=800, dark=True, mobile=True)
    assert page.complaints() == []
    assert page.run("document.documentElement.scrollWidth") <= 390
    source = (reports / "part.html").read_text()
    assert "<noscript>" in source and "The test that would tell" in source
