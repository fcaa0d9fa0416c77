# SPDX-License-Identifier: Apache-2.0
"""The chart of each cell's temperature: every cell's curve, which one the pointer is on, the switches of all charts."""
import random

import pytest
from report_reader import ask, one_view, opened, run

LAPS = 3


def varied(cells):
    seed = random.randrange(2**32)
    draw = random.Random(seed)
    return seed, [f"battery.cells.{i + 1}.resistance_scale={draw.gauss(1.0, 0.1):.3f}" for i in range(cells)]


@pytest.fixture(scope="module")
def unlike(tmp_path_factory):
    """A run with cells of drawn resistances: seed, result, address, rows of its time series."""
    folder = tmp_path_factory.mktemp("unlike")
    seed, settings = varied(24)
    result, url = run(folder, "--laps", str(LAPS), "--csv", "run.csv", "--set", *settings)
    lines = [line for line in (folder / "run.csv").read_text().splitlines() if not line.startswith("#")]
    names = lines[0].split(",")
    columns = [names.index(f"cell_{i + 1}_temperature_c") for i in range(24)]
    rows = [[float(line.split(",")[column]) for column in [0, *columns]] for line in lines[1:]]
    return seed, result, url, rows


@pytest.fixture
def page(browser, unlike):
    return opened(browser.page(unlike[2]))


def names(page):
    return ask(page, "chart('chart-cells').getOption().series.map(one => one.name)")


def test_each_cells_curve_is_that_of_the_time_series(page, unlike):
    seed, _, _, rows = unlike
    assert names(page) == [*(f"cell {i + 1}" for i in range(24)), "emphasis"]
    at = {round(row[0], 1): row for row in rows}
    for i in range(24):
        xs = ask(page, f"series('chart-cells', {i}).getRawData().mapArray('x', v => v)")
        values = ask(page, f"values('chart-cells', {i})")
        assert len(xs) == len(values) > 100
        for time, value in zip(xs, values):
            assert value == pytest.approx(at[round(time, 1)][i + 1], abs=0.011), f"seed {seed}, cell {i + 1}, {time} s"
    assert page.complaints() == []


def test_hottest_and_coldest_are_named_with_their_values(page, unlike):
    seed, result, _, rows = unlike
    marks = ask(page, "chart('chart-cells').getOption().series.flatMap(one => one.markPoint?.label?.formatter ?? [])")
    end = ask(page, "series('chart-cells', 0).getRawData().mapArray('x', v => v)")[-1]
    last = next(row for row in rows if round(row[0], 1) == round(end, 1))[1:]  # the chart ends at a coarser step

    def one_of(chosen):  # two may be equal as the page writes them
        return [f"cell {i + 1}, " for i, value in enumerate(last) if abs(value - chosen) < 0.011]

    hottest = [mark for mark in marks if mark.startswith(tuple(one_of(max(last))))]
    assert hottest, f"seed {seed}"
    assert float(hottest[0].split(", ")[1].split()[0]) == pytest.approx(result["max_battery_temp_c"], abs=0.0601)
    assert any(mark.startswith(tuple(one_of(min(last)))) for mark in marks), f"seed {seed}"
    title = page.run("document.getElementById('chart-cells').closest('.card').querySelector('h3').textContent")
    assert title == "Temperature of each of 24 cells"


def test_pointer_tells_the_cell_that_it_is_on(page, unlike):
    page.run("document.getElementById('chart-cells').scrollIntoView({block: 'center'})")
    left, top, width, _ = ask(page, "box('chart-cells')")
    x = 0.9 * width
    time = ask(page, f"timeAt('chart-cells', {x})")
    row = min(unlike[3], key=lambda one: abs(one[0] - time))[1:]
    for cell in (row.index(max(row)), row.index(min(row)), row.index(sorted(row)[12])):
        y = ask(page, f"chart('chart-cells').convertToPixel({{yAxisIndex: 0}}, {row[cell]})")
        page.mouse("mouseMoved", left + x, top + y)
        page.settle()
        tip = page.run("[...document.querySelectorAll('.tip')].filter(tip => tip.offsetWidth > 0)[0].innerText")
        named = int(tip.split("\n")[1].split()[1]) - 1
        pixel = abs(ask(page, f"chart('chart-cells').convertFromPixel({{yAxisIndex: 0}}, {y} + 1.5)") - row[cell])
        assert row[named] == pytest.approx(row[cell], abs=pixel + 0.02), f"seed {unlike[0]}: {tip}"
        emphasised = ask(page, "chart('chart-cells').getOption().series.at(-1)")
        assert emphasised["name"] == "emphasis" and emphasised["data"]
    page.mouse("mouseMoved", 2, 2)
    page.settle()
    assert not ask(page, "chart('chart-cells').getOption().series.at(-1).data.length")


def test_cells_follow_the_switches_of_all_charts(page, unlike):
    page.run("document.getElementById('over-distance').click()")
    page.settle()
    assert ask(page, "view('chart-cells')") == pytest.approx(one_view(page), abs=1e-6)
    far = ask(page, "series('chart-cells', 0).getRawData().mapArray('x', v => v).at(-1)")
    assert far == pytest.approx(unlike[1]["distance_m"], rel=0.02)
    page.run("document.getElementById('overlay').click()")
    page.settle()
    assert names(page)[:-1] == [f"cell {i + 1}, lap {lap + 1}" for lap in range(LAPS) for i in range(24)]
    first = [lap * 24 for lap in range(LAPS)]
    starts = ask(page, f"{first}.map(i => series('chart-cells', i).getRawData().get('x', 0))")
    assert all(0.0 <= start < 60.0 for start in starts)
    page.run("document.getElementById('over-time').click()")
    page.settle()
    assert ask(page, "view('chart-cells')") == pytest.approx(one_view(page), abs=1e-6)
    assert page.complaints() == []


def test_many_laps_of_many_cells_show_the_hottest_and_the_coldest_of_each_lap(browser, tmp_path):
    seed, settings = varied(96)
    _, url = run(tmp_path, "--laps", "5", "--set", "battery.cells_in_series=96", "battery.cells_in_parallel=6",
                 "battery.cell=sony_vtc6", "sensors.temperature_count=20", *settings)
    page = opened(browser.page(url))
    assert len(names(page)) == 97, f"seed {seed}"
    page.run("document.getElementById('overlay').click()")
    page.settle()
    assert names(page) == [f"{which}, lap {lap + 1}" for lap in range(5) for which in ("hottest", "coldest")]
    assert page.complaints() == []
    assert (tmp_path / "run.html").stat().st_size < 3_000_000


@pytest.mark.parametrize("flags", [(), ("--cells", "representative")])
def test_cells_that_are_all_alike_have_no_chart_of_each(browser, tmp_path, flags):
    _, url = run(tmp_path, "--laps", "1", *flags)
    page = opened(browser.page(url))
    assert not page.run("document.getElementById('chart-cells')")
    assert "all cells alike" in page.run("document.getElementById('chart-temperature').closest('.card').innerText")
    assert page.complaints() == []


@pytest.mark.parametrize("dark", [False, True])
def test_a_phone_shows_the_cells_too(browser, unlike, dark):
    page = opened(browser.page(unlike[2], width=390, height=844, mobile=True, dark=dark))
    page.settle()
    assert page.run("document.documentElement.scrollWidth") <= 390
    assert ask(page, "box('chart-cells')")[2] > 0.8 * 390
    assert page.complaints() == []
