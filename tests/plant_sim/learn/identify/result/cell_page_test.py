# SPDX-License-Identifier: Apache-2.0
"""The report of voltlap identify in headless Chromium: curves, residuals, parameters, dark, narrow, offline."""
import json
import math
import os
import pathlib
import re
import subprocess
import sys

import pytest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))
import long_recording  # noqa: E402

BINARY = pathlib.Path(os.environ["VOLTLAP_BUILD_DIR"]) / "bin" / "voltlap"
CHARTS = ["chart-voltage", "chart-error", "chart-current"]


def voltlap(folder, *arguments, code=0):
    run = subprocess.run([BINARY, *map(str, arguments)], cwd=folder, capture_output=True, text=True, timeout=300)
    assert run.returncode == code, run.stderr
    return run


@pytest.fixture(scope="module")
def identified(tmp_path_factory):
    """Two cells at two currents: their mean, its report and its JSON."""
    folder = tmp_path_factory.mktemp("cell")
    voltlap(folder, "bench-test", "pulse_15", "--set", "test.temperature_c=30", "test.current_a=[200, 400]", "--out",
            "rig")
    tables = sorted(folder.glob("rig/*_cell[12].csv"))
    voltlap(folder, "identify", "--tables", "tests", *tables, "--report", "cell.html", "--json", "cell.json")
    return folder / "cell.html", json.loads((folder / "cell.json").read_text())


@pytest.fixture(scope="module")
def day(tmp_path_factory):
    """A test that lasts a day, with a pause and an open contactor at its end: its report, its JSON, its text, the time
    behind the pause."""
    folder = tmp_path_factory.mktemp("day")
    behind = long_recording.write(folder / "day.csv")
    text = voltlap(folder, "identify", "day.csv", "--report", "day.html", "--json", "day.json").stdout
    return folder / "day.html", json.loads((folder / "day.json").read_text()), text, behind


def opened(browser, path, **how):
    page = browser.page(path.as_uri(), **how)
    page.wait_for("document.documentElement?.dataset.ready", timeout_s=300)
    return page


def ask(page, expression):
    return page.run("(() => { const option = id => echarts.getInstanceByDom(document.getElementById(id)).getOption();"
                    f" return {expression}; }})()")


def choose(page, select, index):
    page.run(f"(() => {{ const s = document.getElementById('{select}'); s.value = {index};"
             " s.dispatchEvent(new Event('change')); })()")
    page.settle()


def test_page_is_one_small_file_that_asks_for_nothing(browser, identified):
    assert identified[0].stat().st_size < 2_000_000
    page = opened(browser, identified[0])
    assert page.complaints() == []
    sent = {event["params"]["request"]["url"] for event in page.happened("Network.requestWillBeSent")} - {page.url}
    assert {url for url in sent if not url.startswith("data:")} == set()
    assert "Mean of 2 cells" in page.run("document.body.innerText")


def test_every_recording_is_shown_with_its_error(browser, identified):
    page = opened(browser, identified[0])
    names = page.run("[...document.getElementById('recording').options].map(o => o.textContent)")
    files = [file for test in identified[1]["tests"] for file in test["files"]]
    assert names == [pathlib.Path(file["file"]).name for file in files] and len(names) == 4
    for at, file in enumerate(files):
        choose(page, "recording", at)
        measured, model, error = (ask(page, f"Array.from({data}).filter((_, i) => i % 2)") for data in
                                  ("option('chart-voltage').series[1].data", "option('chart-voltage').series[0].data",
                                   "option('chart-error').series[0].data"))
        assert len(measured) == len(model) == len(error) > 1000
        assert max(map(abs, error)) < 50 * 1e3 * file["rms_v"]
        # The histogram is of the rows that count, here all of them: its spread is the RMS of the file, but for what the
        # outer bins hold.
        bins = ask(page, "option('chart-histogram').series[0].data")
        square = sum(seconds * middle**2 for middle, seconds in bins) / sum(seconds for _, seconds in bins)
        assert math.sqrt(square) == pytest.approx(1e3 * file["rms_v"], rel=0.1)


def test_zoom_is_shared(browser, identified):
    page = opened(browser, identified[0])
    box = page.run("(() => { const b = document.getElementById('chart-error').getBoundingClientRect();"
                   " scrollTo(0, b.y - 200); const c = document.getElementById('chart-error').getBoundingClientRect();"
                   " return [c.x, c.y, c.width, c.height]; })()")
    y = box[1] + box[3] / 2
    page.drag((box[0] + 0.4 * box[2], y), (box[0] + 0.6 * box[2], y))
    zooms = ask(page, f"{CHARTS}.map(id => [option(id).dataZoom[0].startValue, option(id).dataZoom[0].endValue])")
    end = ask(page, "option('chart-error').xAxis[0].max")
    assert zooms[0] == zooms[1] == zooms[2]
    assert 0.1 * end < zooms[0][1] - zooms[0][0] < 0.4 * end


def test_parameters_have_the_intervals_of_the_json(browser, identified):
    page = opened(browser, identified[0])
    for at, test in enumerate(identified[1]["tests"]):
        choose(page, "place", at)
        for key, factor in (("em_v", 1), ("r0_ohm", 1e3), ("r2_ohm", 1e3), ("tau2_s", 1)):
            table = test["parameters"][key]
            curve = ask(page, f"option('chart-{key}').series.filter(s => s.type === 'line').at(-1).data")
            assert [p[1] for p in curve] == pytest.approx([factor * v for v in table["value"]])
            assert [p[2] for p in curve] == pytest.approx([factor * v for v in table["ci95_low"]])
        assert ask(page, "option('chart-r0_ohm').series.length") == 3  # the other place, this one, its bars


def axis_names(page):
    return {ask(page, f"option('{name}').xAxis[0].name") for name in CHARTS}


def labels(page, chart, axis):
    """The numbers at an axis as they are drawn."""
    return page.run(f"""(() => {{
        const chart = echarts.getInstanceByDom(document.getElementById('{chart}'));
        return chart.getModel().getComponent('{axis}').axis.getViewLabels().map(one => one.formattedLabel); }})()""")


def test_time_is_in_the_unit_of_the_stretch_and_says_it(browser, identified, day):
    page = opened(browser, day[0])
    assert axis_names(page) == {"time, h"}
    assert page.run("document.getElementById('view').textContent") == "0 to 24.07 h"
    assert labels(page, "chart-error", "xAxis")[:3] == ["0", "2", "4"]
    box = page.run("(() => { document.getElementById('chart-error').scrollIntoView(); const b ="
                   " document.getElementById('chart-error').getBoundingClientRect(); return [b.x, b.y, b.width]; })()")
    page.drag((box[0] + 0.5 * box[2], box[1] + 80), (box[0] + 0.55 * box[2], box[1] + 80))
    assert axis_names(page) == {"time, min"}
    assert page.run("document.getElementById('view').textContent").endswith(" min")
    assert axis_names(opened(browser, identified[0])) == {"time, h"}  # a pulse test of the bench


def test_no_line_is_drawn_over_a_pause_of_the_recording(browser, day):
    page = opened(browser, day[0])
    for name in CHARTS:
        points = ask(page, f"Array.from(option('{name}').series[0].data, v => Number.isNaN(v) ? 'none' : v)")
        times, values = points[::2], points[1::2]
        gaps = [at for at, value in enumerate(values) if value == "none"]
        assert len(gaps) == 1, name
        assert times[gaps[0]] == pytest.approx(day[3], abs=0.02) == pytest.approx(times[gaps[0] + 1], abs=0.02)
        assert times[gaps[0] - 1] < day[3] - 7000


def test_errors_are_on_the_scale_of_those_that_count_and_what_lies_beyond_is_told(browser, day):
    page = opened(browser, day[0])
    head = page.run("document.querySelector('h1').textContent")
    rms, of_all = map(float, re.search(r"within ([\d.]+) mV RMS \(([\d.]+) mV with", head).groups())
    assert rms == pytest.approx(1e3 * day[1]["tests"][0]["rms_v"], abs=0.006) and of_all > 20 * rms
    far = max(ask(page, "Array.from(option('chart-error').series[0].data).filter((v, i) => i % 2 && v === v)"))
    scale = "echarts.getInstanceByDom(document.getElementById('chart-error')).getModel().getComponent('yAxis').axis" \
            ".scale.getExtent()"
    assert far > 400 and 2 * rms < page.run(scale)[1] < 20 * rms
    assert ask(page, "option('chart-error').series.find(s => s.name === 'beyond').data.length") >= 1
    legend = "document.getElementById('chart-error').closest('.card').querySelector('.legend')"
    assert f"beyond the scale: ▲ to {far:.2f} mV" in page.run(f"{legend}.textContent")
    assert "does not count" in page.run(f"{legend}.textContent")
    assert page.run("document.getElementById('chart-voltage').closest('.card').textContent").count("beyond") == 1
    volts = "echarts.getInstanceByDom(document.getElementById('chart-voltage')).getModel().getComponent('yAxis').axis"
    assert page.run(f"{volts}.scale.getExtent()")[0] > 2.3  # the open contactor has 2.1 V
    page.run(f"{legend}.querySelector('button').click()")
    assert page.run(scale)[1] > far


def test_many_recordings_are_small_charts_on_one_scale_that_open(browser, identified):
    page = opened(browser, identified[0])
    names = page.run("[...document.querySelectorAll('#overview .small-name')].map(one => one.textContent)")
    assert names == page.run("[...document.getElementById('recording').options].map(o => o.textContent)")
    scales = [ask(page, f"(({{min, max}}) => [min, max])(option('small-{at}').yAxis[0])") for at in range(4)]
    assert all(scale == scales[0] for scale in scales) and scales[0][0] == -scales[0][1]
    page.run("document.querySelectorAll('#overview .small')[2].click()")
    page.settle()
    assert page.run("document.getElementById('recording').value") == "2"
    assert page.run("document.querySelectorAll('#overview [aria-current=true]').length") == 1
    assert page.run("document.querySelectorAll('#strips canvas').length") == len(CHARTS)


def test_one_recording_has_no_small_charts(browser, day):
    page = opened(browser, day[0])
    assert page.run("document.getElementById('overview').hidden")


def test_what_is_assumed_is_marked_wherever_it_stands(browser, day):
    page = opened(browser, day[0])
    facts = page.run("Object.fromEntries([...document.querySelectorAll('#facts tbody tr')].map(row =>"
                     " [row.cells[0].textContent, [...row.querySelectorAll('.assumed')].map(c => c.textContent)]))")
    for name in ("mass", "heat capacity", "surface", "convection", "temperature", "R0 with temperature",
                 "R1 with temperature", "tau1 with temperature"):
        assert facts[name] == ["assumed"], name
    assert facts["capacity"] == []
    assert page.run("document.getElementById('place').options[0].textContent") == "25.0 °C (assumed)"
    assert "25.0 °C (assumed)" in page.run("document.getElementById('coverage').textContent")


NO_NUMBER = re.compile(r"\b-?(?:nan|inf)\b|NaN|Infinity|\d(?:\.\d+)?e[-+]\d")


def test_every_number_can_be_read_by_a_person(browser, identified, day, tmp_path):
    table = identified[0].parent / "rig" / "30c_400a_cell1.csv"
    text = voltlap(tmp_path, "identify", table, "--method", "all", "--report", "all.html", "--json", "all.json").stdout
    ipo = voltlap(tmp_path, "identify", table, "--method", "ipo", "--report", "ipo.html", "--json", "ipo.json").stdout
    for words in (text, ipo, day[2]):
        assert NO_NUMBER.findall(words) == []
    for path in (tmp_path / "all.html", tmp_path / "ipo.html", day[0], identified[0]):
        assert NO_NUMBER.findall(opened(browser, path).run("document.body.innerText")) == []
    assert "not settled" in (tmp_path / "ipo.html").read_text()

    def refuse(constant):
        raise AssertionError(constant)

    for path in (tmp_path / "all.json", tmp_path / "ipo.json"):
        json.loads(path.read_text(), parse_constant=refuse)


def test_a_phone_shows_all_of_it(browser, day):
    page = opened(browser, day[0], width=390, height=844, mobile=True)
    assert page.run("document.documentElement.scrollWidth") == 390
    outside = page.run("[...document.querySelectorAll('main *')].filter(one => one.getBoundingClientRect().right > 391"
                       " && !one.closest('.scroll')).map(one => one.outerHTML.slice(0, 80))")
    assert outside == []
    assert labels(page, "chart-error", "xAxis") != []


@pytest.mark.parametrize("how", [{"dark": True}, {"width": 390, "height": 844, "mobile": True}])
def test_page_fits_dark_and_narrow_screens(browser, identified, how):
    page = opened(browser, identified[0], **how)
    assert page.complaints() == []
    assert page.run("document.documentElement.scrollWidth") <= how.get("width", 1400)
    background = page.run("getComputedStyle(document.body).backgroundColor")
    assert background == ("rgb(15, 19, 23)" if how.get("dark") else "rgb(245, 246, 248)")


def test_tables_stand_in_the_page_without_scripts(identified):
    text = identified[0].read_text()
    assert "<noscript>" in text and "Spread between 2 cells" in text
    for words in ("Em, V; SOC across", "tau2, s; SOC across", "held-out pulses", "Noise of the voltage"):
        assert words in text
    assert text.count("30c_200a_cell1.csv") >= 2


def test_places_without_a_test_are_marked_and_methods_compared(browser, identified, tmp_path):
    rig = identified[0].parent / "rig"
    cold = tmp_path / "cold.csv"
    rows = (rig / "30c_200a_cell1.csv").read_text().splitlines()
    head = rows.index("time_s,current_a,voltage_v,temperature_c,ambient_c")
    cold.write_text("\n".join([rows[head], *(f"{r.rsplit(',', 2)[0]},10,10" for r in rows[head + 1:])]) + "\n")
    voltlap(tmp_path, "identify", "--tables", "tests", rig / "30c_200a_cell1.csv", rig / "30c_400a_cell1.csv",
            "--cell", "cell1", cold,
            "--report", "x.html", code=2)  # two cells whose tests differ
    voltlap(tmp_path, "identify", "--tables", "tests", "--cell", "a", rig / "30c_200a_cell1.csv",
            rig / "30c_400a_cell1.csv", cold,
            "--report", "filled.html")
    assert "not tested, filled from" in (tmp_path / "filled.html").read_text()
    voltlap(tmp_path, "identify", rig / "30c_400a_cell1.csv", "--method", "all", "--report", "all.html")
    page = opened(browser, tmp_path / "all.html")
    assert page.complaints() == []
    assert page.run("[...document.querySelectorAll('#methods tbody th')].map(c => c.textContent)") == [
        "ipo", "fpo", "ilo", "flo", "ffo", "full"]


def test_method_without_intervals_has_a_report_without_bars(browser, identified, tmp_path):
    voltlap(tmp_path, "identify", identified[0].parent / "rig" / "30c_400a_cell1.csv", "--method", "ipo", "--report",
            "ipo.html")
    page = opened(browser, tmp_path / "ipo.html")
    assert page.complaints() == []
    assert ask(page, "option('chart-r0_ohm').series.length") == 1


def test_report_and_another_file_in_one_are_refused_and_leave_nothing(identified, tmp_path):
    table = identified[0].parent / "rig" / "30c_400a_cell1.csv"
    assert "--report" in voltlap(tmp_path, "identify", table, "--report", "x", "--json", "x", code=2).stderr
    assert "absent/x.html" in voltlap(tmp_path, "identify", table, "--report", "absent/x.html", code=2).stderr
    assert list(tmp_path.iterdir()) == []
