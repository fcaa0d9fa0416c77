# SPDX-License-Identifier: Apache-2.0
"""The report of voltlap bench-test in headless Chromium: charts, choice of test, rests, dark, narrow, offline."""
import json
import os
import pathlib
import subprocess

import pytest

BINARY = pathlib.Path(os.environ["VOLTLAP_BUILD_DIR"]) / "bin" / "voltlap"
CHARTS = ["chart-voltage", "chart-current", "chart-temperature"]


def bench(folder, *arguments, code=0):
    run = subprocess.run([BINARY, "bench-test", *map(str, arguments)], cwd=folder, capture_output=True, text=True,
                         timeout=300)
    assert run.returncode == code, run.stderr
    return run


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    folder = tmp_path_factory.mktemp("bench")
    bench(folder, "pulse_15", "--report", "bench.html", "--json", "bench.json")
    return folder / "bench.html", json.loads((folder / "bench.json").read_text())


def opened(browser, path, **how):
    page = browser.page(path.as_uri(), **how)
    page.wait_for("document.documentElement?.dataset.ready", timeout_s=300)
    return page


def ask(page, expression):
    return page.run("(() => { const option = id => echarts.getInstanceByDom(document.getElementById(id)).getOption();"
                    f" return {expression}; }})()")


def extremes(page, chart, series):
    values = ask(page, f"Array.from(option('{chart}').series[{series}].data).filter((_, i) => i % 2)")
    return min(values), max(values)


def test_page_is_one_small_file_that_asks_for_nothing(browser, campaign):
    assert campaign[0].stat().st_size < 2_000_000
    page = opened(browser, campaign[0])
    assert page.complaints() == []
    sent = {event["params"]["request"]["url"] for event in page.happened("Network.requestWillBeSent")} - {page.url}
    assert {url for url in sent if not url.startswith("data:")} == set()


def test_charts_keep_the_extremes_of_the_test_that_is_chosen(browser, campaign):
    page = opened(browser, campaign[0])
    names = page.run("[...document.getElementById('test').options].map(o => o.textContent)")
    assert names == [test["name"] for test in campaign[1]["tests"]] and len(names) == 15
    for at in (0, 9):
        page.run(f"(() => {{ const s = document.getElementById('test'); s.value = {at};"
                 " s.dispatchEvent(new Event('change')); })()")
        page.settle()
        test = campaign[1]["tests"][at]
        lowest = min(extremes(page, "chart-voltage", cell)[0] for cell in range(4))
        assert lowest == pytest.approx(test["lowest_v"], abs=2e-4)
        # Read by a sensor that errs by up to 2 %, against the truth's mean over the strongest pulse.
        assert extremes(page, "chart-current", 0)[1] == pytest.approx(test["current_max_a"], rel=0.05)
        assert ask(page, "option('chart-current').xAxis[0].max") == pytest.approx(test["duration_s"])


def test_rest_is_shown_in_all_charts(browser, campaign):
    page = opened(browser, campaign[0])
    rests = page.run("document.querySelectorAll('#rests tbody tr').length")
    assert rests == campaign[1]["tests"][0]["rests"]
    # The rule stops a rest at 1 mV/min; it is read here from fewer, slower rows.
    rises = page.run("[...document.querySelectorAll('#rests tbody td:last-child')].map(c => Number(c.textContent))")
    assert max(rises[1:-1]) < 1.5 and min(rises[1:-1]) > 0
    page.run("document.querySelectorAll('#rests button')[3].click()")
    page.settle()
    zooms = ask(page, f"{CHARTS}.map(id => [option(id).dataZoom[0].startValue, option(id).dataZoom[0].endValue])")
    assert zooms[0] == zooms[1] == zooms[2] and zooms[0][1] - zooms[0][0] < 1800
    page.run("document.getElementById('whole').click()")
    page.settle()
    assert ask(page, "option('chart-voltage').dataZoom[0].startValue") == 0


@pytest.mark.parametrize("how", [{"dark": True}, {"width": 390, "height": 844, "mobile": True}])
def test_page_fits_dark_and_narrow_screens(browser, campaign, how):
    page = opened(browser, campaign[0], **how)
    assert page.complaints() == []
    assert page.run("document.documentElement.scrollWidth") <= how.get("width", 1400)
    background = page.run("getComputedStyle(document.body).backgroundColor")
    assert background == ("rgb(15, 19, 23)" if how.get("dark") else "rgb(245, 246, 248)")


def test_tables_stand_in_the_page_without_scripts(campaign):
    text = campaign[0].read_text()
    assert "<noscript>" in text and text.count("<th scope=\"row\">22c_") == 5
    assert "Seconds under load" in text and "test.temperature_c" in text


def test_dry_run_reports_the_rehearsal(browser, tmp_path):
    bench(tmp_path, "hppc", "--dry-run", "--report", "plan.html")
    page = opened(browser, tmp_path / "plan.html")
    assert page.complaints() == []
    text = page.run("document.body.innerText")
    assert "would take" in text and "nominal cell" in text and "Rehearsed" in text


def test_report_and_another_file_in_one_are_refused_and_leave_nothing(tmp_path):
    assert "--report" in bench(tmp_path, "hppc", "--report", "x", "--json", "x", code=2).stderr
    assert "absent/x.html" in bench(tmp_path, "hppc", "--report", "absent/x.html", code=2).stderr
    assert list(tmp_path.iterdir()) == []
