# SPDX-License-Identifier: Apache-2.0
"""The HTML report as a reader meets it: a real browser, real mouse, touch and keys, numbers read from the charts."""
import json
import os

import pytest
from report_reader import TIME_CHARTS, ask, one_view, opened, requests, run, voltlap, wait_until

SIZE_MAX = 3_000_000
OPEN_MAX_MS = 2000
CTRL, SHIFT = 2, 8


def opening_ms(browser, url, tries=8):
    """From the start of the navigation to the frame after all charts are drawn: the best of up to `tries` openings,
    which end at the first that is fast enough. On a machine with more to do than it can, the clock tells of others'
    work; then the processor time of the page's process counts, which is more than an idle machine would need."""
    best = float("inf")
    for _ in range(tries):
        page = opened(browser.page(url))
        best = min(best, page.run("performance.getEntriesByName('voltlap-ready')[0].startTime"))
        if os.getloadavg()[0] > 1.5 * os.cpu_count():
            best = min(best, 1000 * page.processor_s())
        if best <= OPEN_MAX_MS:
            break
    return best


@pytest.fixture(scope="module")
def endurance(tmp_path_factory):
    folder = tmp_path_factory.mktemp("endurance")
    result, url = run(folder)
    return result, url, folder / "run.html"


@pytest.fixture
def page(browser, endurance):
    return opened(browser.page(endurance[1]))


def altered(endurance, tmp_path, old, new):
    """A copy of the report with one thing wrong."""
    text = endurance[2].read_text()
    assert old in text
    (tmp_path / "altered.html").write_text(text.replace(old, new, 1))
    return (tmp_path / "altered.html").as_uri()


def test_file_of_27_laps_is_at_most_3_mb(endurance):
    assert endurance[0]["laps"] == 27
    assert endurance[2].stat().st_size <= SIZE_MAX


def test_report_opens_within_two_seconds(browser, endurance, record_property):
    best = opening_ms(browser, endurance[1])
    record_property("opening_ms", best)
    print(f"opened in {best:.0f} ms")
    assert best <= OPEN_MAX_MS


def test_both_clocks_see_work_that_is_planted_into_the_page(browser, endurance, tmp_path):
    work = "<script>for (let i = 0, x = 1; i < 1e9; i++) x = (x * 31 + i) | 0;</script></head>"
    page = opened(browser.page(endurance[1]))
    usual_s = page.processor_s()
    slow = opened(browser.page(altered(endurance, tmp_path, "</head>", work)))
    planted_s = slow.processor_s() - usual_s
    assert planted_s > 0.4
    assert slow.run("performance.getEntriesByName('voltlap-ready')[0].startTime") > 1000 * planted_s


@pytest.mark.parametrize("dark", [False, True])
def test_page_is_quiet_and_asks_the_network_for_nothing(browser, endurance, dark):
    page = opened(browser.page(endurance[1], dark=dark))
    assert page.complaints() == []
    assert requests(page) == set()


def test_a_request_and_a_complaint_are_noticed(browser, endurance, tmp_path):
    wrong = "<img src='http://127.0.0.1:9/x.png'><script>console.error('planted')</script></head>"
    page = opened(browser.page(altered(endurance, tmp_path, "</head>", wrong)))
    assert requests(page) == {"http://127.0.0.1:9/x.png"}
    said = json.dumps(page.complaints())
    assert "planted" in said
    assert "Content Security Policy" in said  # and the page's own rule has stopped the request


def test_light_and_dark_follow_the_system(browser, endurance):
    def colours(dark):
        page = opened(browser.page(endurance[1], dark=dark))
        paint = "getComputedStyle(document.body).backgroundColor"
        line = "chart('chart-current').getOption().series[0].lineStyle.color"
        return page, [page.run(paint), ask(page, line)]

    _, dark = colours(True)
    page, light = colours(False)
    assert all(a != b for a, b in zip(dark, light))
    page.color_scheme("dark")  # while it is open
    page.settle()
    assert ask(page, "chart('chart-current').getOption().series[0].lineStyle.color") == dark[1]


def test_numbers_read_back_from_the_charts_are_those_of_the_json(page, endurance):
    result = endurance[0]
    assert max(ask(page, "values('chart-current', 0)")) == pytest.approx(result["max_battery_current_a"], abs=1e-9)
    speeds = ask(page, "values('chart-speed', 0)")  # samples are rounded to 0.01 m/s, the extreme among them is not
    assert max(speeds) == pytest.approx(result["max_speed_mps"], abs=0.005)
    assert min(abs(speed - result["max_speed_mps"]) for speed in speeds) < 1e-9
    assert min(ask(page, "values('chart-pack-voltage', 0)")) == pytest.approx(result["min_pack_voltage_v"], abs=1e-9)
    assert min(ask(page, "values('chart-cell-voltage', 0)")) == pytest.approx(result["min_cell_voltage_v"], abs=1e-9)
    assert max(ask(page, "values('chart-temperature', 0)")) == pytest.approx(result["max_battery_temp_c"], abs=0.02)
    assert ask(page, "values('chart-soc', 0)")[-1] == pytest.approx(result["end_soc_pct"], abs=1e-9)
    ends = ask(page, "lines().map(line => line.xAxis)")
    assert len(ends) == result["laps"] == 27
    assert ends[-1] == pytest.approx(result["total_time_s"], abs=1e-6)


def test_samples_beside_the_peaks_agree_with_the_time_series(browser, tmp_path):
    result, url = run(tmp_path, "--laps", "1", "--csv", tmp_path / "run.csv")
    lines = [line for line in (tmp_path / "run.csv").read_text().splitlines() if not line.startswith("#")]
    names, rows = lines[0].split(","), [line.split(",") for line in lines[1:]]
    page = opened(browser.page(url))
    for name, chart, step in (("speed_mps", "chart-speed", 0.01), ("pack_current_a", "chart-current", 0.1),
                              ("front_rotor_c", "chart-rotors", 0.1), ("brake", "chart-pedals", 0.1)):
        scale, series = (100.0, 1) if name == "brake" else (1.0, 0)
        data = f"series('{chart}', {series}).getRawData()"
        points = ask(page, f"['x', 'value'].map(axis => {data}.mapArray(axis, v => v))")
        charted = {round(time, 1): value for time, value in zip(*points) if abs(time - round(time, 1)) < 1e-6}
        assert len(charted) >= len(rows) - 1
        for row in rows[1:]:
            expected = scale * float(row[names.index(name)])
            assert charted[round(float(row[0]), 1)] == pytest.approx(expected, abs=0.51 * step)
    assert result["laps"] == 1


def test_dragging_across_one_chart_zooms_all(page, endurance):
    assert one_view(page) == pytest.approx([0.0, endurance[0]["total_time_s"]])
    page.run("document.getElementById('chart-current').scrollIntoView({block: 'center'})")
    x, y, width, height = ask(page, "box('chart-current')")
    left, right = ask(page, f"[0.25, 0.30].map(part => timeAt('chart-current', part * {width}))")
    page.drag((x + 0.25 * width, y + height / 2), (x + 0.30 * width, y + height / 2))
    second_per_pixel = (right - left) / (0.05 * width)
    assert one_view(page) == pytest.approx([left, right], abs=1.5 * second_per_pixel)


def test_wheel_with_ctrl_zooms_all_about_the_pointer_and_without_it_scrolls(page):
    page.run("document.getElementById('chart-soc').scrollIntoView({block: 'center'})")
    x, y, width, height = ask(page, "box('chart-soc')")
    at = (x + 0.6 * width, y + height / 2)
    before, under = one_view(page), ask(page, f"timeAt('chart-soc', {0.6 * width})")
    page.wheel(at, -300, CTRL)
    wait_until(page, f"view('chart-speed')[0] > {before[0]}")
    page.settle()
    after = one_view(page)
    assert after[1] - after[0] < 0.7 * (before[1] - before[0])
    assert ask(page, f"timeAt('chart-soc', {0.6 * width})") == pytest.approx(under, abs=1.0)
    scrolled = page.run("scrollY")
    page.wheel(at, 120)
    page.wait_for(f"scrollY !== {scrolled}")
    assert one_view(page) == after


def test_a_chart_that_does_not_follow_is_seen(page):
    ask(page, "chart('chart-rotors').dispatchAction({type: 'dataZoom', startValue: 5, endValue: 6})")
    with pytest.raises(AssertionError):
        one_view(page)


def test_double_click_shift_drag_and_keys_move_all(page, endurance):
    whole = [0.0, endurance[0]["total_time_s"]]
    page.run("document.getElementById('chart-speed').scrollIntoView({block: 'center'})")
    x, y, width, height = ask(page, "box('chart-speed')")
    middle = y + height / 2
    page.drag((x + 0.4 * width, middle), (x + 0.5 * width, middle))
    zoomed = one_view(page)
    page.mouse("mousePressed", x + 0.5 * width, middle, button="left", buttons=1, clickCount=1, modifiers=SHIFT)
    page.mouse("mouseMoved", x + 0.7 * width, middle, button="left", buttons=1, modifiers=SHIFT)
    page.mouse("mouseReleased", x + 0.7 * width, middle, button="left", clickCount=1, modifiers=SHIFT)
    page.settle()
    moved = one_view(page)
    assert moved[0] < zoomed[0] - 1 and moved[1] - moved[0] == pytest.approx(zoomed[1] - zoomed[0], abs=1e-6)
    for click in (1, 2):
        page.mouse("mousePressed", x + 0.5 * width, middle, button="left", buttons=1, clickCount=click)
        page.mouse("mouseReleased", x + 0.5 * width, middle, button="left", clickCount=click)
    page.settle()
    assert one_view(page) == pytest.approx(whole)
    page.run("document.querySelector('.surface').focus()")
    page.key("+", "+")
    page.settle()
    assert one_view(page)[1] - one_view(page)[0] < 0.8 * whole[1]
    page.key("ArrowRight")
    assert page.run("document.getElementById('cursor').textContent")
    page.key("Escape")
    page.settle()
    assert one_view(page) == pytest.approx(whole)


def test_a_lap_is_chosen_by_list_buttons_and_table(page, endurance):
    rows = endurance[0]["lap_rows"]
    starts = [sum(row["time_s"] for row in rows[:i]) for i in range(len(rows) + 1)]
    page.run("document.getElementById('lap').value = '4'")
    page.run("document.getElementById('lap').dispatchEvent(new Event('change'))")
    page.settle()
    assert one_view(page) == pytest.approx(starts[4:6], abs=1e-3)
    assert "lap 5" in page.run("document.getElementById('map-card').innerText")
    page.run("document.getElementById('next').click()")
    page.settle()
    assert one_view(page) == pytest.approx(starts[5:7], abs=1e-3)
    page.run("document.querySelector('#laps tr[data-lap=\"9\"] button').click()")
    page.settle()
    assert one_view(page) == pytest.approx(starts[8:10], abs=1e-3)


def test_cursor_shows_values_with_units_in_every_chart_and_the_car_on_the_course(page):
    page.run("document.getElementById('chart-speed').scrollIntoView({block: 'center'})")
    x, y, width, height = ask(page, "box('chart-speed')")
    page.mouse("mouseMoved", x + 0.5 * width, y + height / 2)
    page.settle()
    values = page.run("[...document.querySelectorAll('.legend output')].map(output => output.textContent)")
    units = (" m/s", " %", " A", " V", " °C", " kW")
    assert len(values) == 18 and all(any(unit in value for unit in units) for value in values), values
    assert page.run("getComputedStyle(document.querySelector('.car')).display") == "block"
    shown = "[...document.querySelectorAll('.tip')].filter(tip => tip.offsetWidth > 0)"
    tips = page.run(shown + ".map(tip => tip.textContent)")
    lap = 1 + ask(page, f"lines().filter(line => line.xAxis <= timeAt('chart-speed', {0.5 * width})).length")
    assert len(tips) == 1 and " m/s" in tips[0] and f"lap {lap}," in tips[0]


def test_energy_flow_starts_with_the_cells_chemical_energy_and_loses_none(page, endurance):
    ledger = endurance[0]["energy_ledger_kwh"]
    links = ask(page, "flows()")
    stages = ["cells", "pack", "inverter", "wheels"]
    for stage in stages:
        inward = sum(link["value"] for link in links if link["target"] == stage) or ledger["battery_chemical"]
        assert sum(link["value"] for link in links if link["source"] == stage) == pytest.approx(inward, rel=1e-9)
    leaves = sum(link["value"] * (1 if link["source"] in stages else -1)  # motion may give a little back
                 for link in links if link["target"] not in stages or link["source"] not in stages)
    assert leaves == pytest.approx(ledger["battery_chemical"], rel=1e-9)
    front = ask(page, "flows().find(link => link.target === 'front brakes').value")
    assert front == pytest.approx(ledger["brake_front"], rel=1e-12)


def test_every_parameter_is_there_and_can_be_searched(page, endurance):
    keys = page.run("[...document.querySelectorAll('#parameters code')].map(code => code.textContent)")
    assert sorted(keys) == sorted(endurance[0]["parameters"])
    page.run("document.getElementById('search').focus()")
    page.call("Input.insertText", text="Mass_KG table b.3")
    rows = "[...document.querySelectorAll('#parameters tbody tr')]"
    shown = page.run(rows + ".filter(row => !row.hidden).map(row => row.innerText)")
    assert len(shown) == 2 and all("mass_kg" in row and "Table B.3" in row and "vtm16e.toml" in row for row in shown)
    text = page.run("document.body.innerText")
    assert endurance[0]["trace_hash"] in text and f"seed {endurance[0]['seed']}" in text


@pytest.mark.parametrize("width", [390, 768])
def test_a_phone_shows_it_without_sideways_scroll(browser, endurance, width):
    page = opened(browser.page(endurance[1], width=width, height=844, mobile=True))
    page.settle()
    assert page.run("document.documentElement.scrollWidth") <= width
    widths = [ask(page, f"box('{name}')")[2] for name in [*TIME_CHARTS, "chart-energy", "chart-track"]]
    assert min(widths) > 0.8 * width
    parts = "[...document.querySelectorAll('.tiles, .tile, .card, .toolbar')]"
    too_wide = parts + ".filter(part => part.scrollWidth > part.clientWidth + 1).map(part => part.innerText)"
    assert page.run(too_wide) == []
    page.run("document.body.append(Object.assign(document.createElement('div'), {style: 'width: 900px; height: 1px'}))")
    assert page.run("document.documentElement.scrollWidth") > width  # a part that is too wide is seen


def test_two_fingers_zoom_and_one_moves_the_cursor(browser, endurance):
    page = opened(browser.page(endurance[1], width=390, height=844, mobile=True))
    page.call("Emulation.setTouchEmulationEnabled", enabled=True, maxTouchPoints=2)
    page.run("document.getElementById('chart-speed').scrollIntoView({block: 'center'})")
    x, y, width, height = ask(page, "box('chart-speed')")

    def touch(kind, *parts):
        points = [{"x": x + part * width, "y": y + height / 2, "id": i} for i, part in enumerate(parts)]
        page.call("Input.dispatchTouchEvent", type=kind, touchPoints=points)

    touch("touchStart", 0.5)
    touch("touchEnd")
    page.settle()
    assert page.run("document.getElementById('cursor').textContent")
    before = one_view(page)
    touch("touchStart", 0.5, 0.6)
    touch("touchMove", 0.45, 0.65)
    touch("touchMove", 0.35, 0.75)
    touch("touchEnd")
    page.settle()
    page.settle()
    after = one_view(page)
    assert after[1] - after[0] < 0.6 * (before[1] - before[0])


def test_limits_that_bind_are_coloured_by_reason(browser, tmp_path):
    result, url = run(tmp_path, "--laps", "2", "--set", "bms.discharge_current_max_a=120")
    page = opened(browser.page(url))
    bands = ask(page, "chart('chart-current').getOption().series.find(one => one.name === 'bands').data")
    assert {band[2] for band in bands} == {1}
    first = page.run("document.querySelector('#parameters tbody tr').innerText")
    assert "bms.discharge_current_max_a" in first and "--set" in first  # what was changed stands first
    held_s = result["limit_active_s"]["config_maximum"]
    assert sum(band[1] - band[0] for band in bands) == pytest.approx(held_s, rel=0.05)
    assert f"config maximum, {held_s:.1f} s" in page.run("document.body.innerText")
    assert max(ask(page, "values('chart-current', 1)")) == pytest.approx(120.0)


RUNS = {
    "failed": (["--laps", "2", "--set", "assertions.battery_temperature_max_c=27.2"], 3,
               "is beyond assertions.battery_temperature_max_c"),
    "standing start": (["--lap-start", "standing", "--laps", "2"], 0, "standing start"),
    "other car, other track": (["--vehicle", "vtm17e", "--track", "michigan_2014", "--laps", "1"], 0,
                               "vtm17e finished 1 lap of michigan_2014"),
}


@pytest.mark.parametrize("arguments, code, words", RUNS.values(), ids=RUNS.keys())
def test_other_runs_have_a_report_too(browser, tmp_path, arguments, code, words):
    result, url = run(tmp_path, *arguments, code=code)
    page = opened(browser.page(url))
    assert page.complaints() == []
    text = page.run("document.body.innerText")
    assert words in text and ("✓ Finished" if code == 0 else "✕ Failed") in text
    assert one_view(page) == pytest.approx([0.0, result["total_time_s"]], abs=1e-6)
    labels = ask(page, "lines().map(line => line.label?.formatter ?? '')")
    assert labels == [""] * result["laps"] + ["failed"] * (code == 3)


def test_recorded_drive_has_charts_but_no_course(browser, tmp_path):
    (tmp_path / "drive.csv").write_text("time_s,speed_mps\n0,0\n5,5\n20,5\n25,1\n")
    _, url = run(tmp_path, "--drive", tmp_path / "drive.csv")
    page = opened(browser.page(url))
    assert page.complaints() == []
    assert "has no course" in page.run("document.getElementById('map-card').innerText")
    assert one_view(page) == pytest.approx([0.0, 25.0], abs=0.1)


def test_car_that_never_gets_ready_has_a_report_without_charts(browser, tmp_path):
    result, url = run(tmp_path, "--set", "battery.initial_temperature_c=75", code=3)
    page = opened(browser.page(url))
    assert page.complaints() == []
    text = page.run("document.body.innerText")
    assert "it did not start" in text and "no charts over time" in text
    assert result["distance_m"] == 0.0


def test_without_scripts_the_numbers_stand_in_the_page(endurance):
    text = endurance[2].read_text()
    assert "<noscript>" in text and text.count("<tr data-lap=") == 27
    assert f"<b>{endurance[0]['max_battery_current_a']:.1f}</b>" in text


def test_unwritable_report_is_told_before_the_run_and_leaves_nothing(tmp_path):
    unwritable = voltlap(tmp_path, "--report", "absent/run.html")
    assert unwritable.returncode == 2 and "absent/run.html" in unwritable.stderr
    shared = voltlap(tmp_path, "--report", "x", "--json", "x")
    assert shared.returncode == 2 and "--report" in shared.stderr
    assert list(tmp_path.iterdir()) == []
