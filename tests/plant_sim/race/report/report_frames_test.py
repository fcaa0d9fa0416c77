# SPDX-License-Identifier: Apache-2.0
"""The endurance report's charts along time and distance, whole, by lap, and laps over each other."""
import pytest
from report_reader import ask, one_view, opened, run


@pytest.fixture(scope="module")
def endurance(tmp_path_factory):
    return run(tmp_path_factory.mktemp("endurance"))


@pytest.fixture
def page(browser, endurance):
    return opened(browser.page(endurance[1]))


def test_charts_switch_to_distance_and_show_the_same_stretch(page, endurance):
    page.run("document.getElementById('over-distance').click()")
    page.settle()
    length_m = endurance[0]["course_length_m"]
    assert one_view(page) == pytest.approx([0.0, 27 * length_m], abs=1.0)
    assert ask(page, "lines().map(line => line.xAxis)") == pytest.approx([k * length_m for k in range(1, 28)], abs=0.01)
    assert max(ask(page, "values('chart-speed', 0)")) == pytest.approx(endurance[0]["max_speed_mps"], abs=0.005)
    page.run("document.querySelector('#laps tr[data-lap=\"9\"] button').click()")
    page.settle()
    assert one_view(page) == pytest.approx([8 * length_m, 9 * length_m], abs=0.01)
    assert "lap 9," in page.run("document.getElementById('view').textContent")
    page.run("document.getElementById('over-time').click()")
    page.settle()
    assert one_view(page) == pytest.approx([0.0, endurance[0]["total_time_s"]], abs=1e-6)


@pytest.mark.parametrize("axis", ["time", "distance"])
def test_laps_lie_over_each_other_from_their_own_start(page, endurance, axis):
    page.run(f"document.getElementById('over-{axis}').click(); document.getElementById('overlay').click()")
    page.settle()
    laps = endurance[0]["lap_rows"]
    longest = max(lap["time_s"] for lap in laps) if axis == "time" else endurance[0]["course_length_m"]
    assert one_view(page) == pytest.approx([0.0, longest], abs=0.02)
    names = ask(page, "chart('chart-soc').getOption().series.map(one => one.name)")
    assert names == [f"plant, lap {lap['lap']}" for lap in laps]
    starts = ask(page, f"{list(range(27))}.map(i => series('chart-soc', i).getRawData().get('x', 0))")
    assert all(0.0 <= start < 3.0 for start in starts)
    ends = ask(page, f"{list(range(27))}.map(i => values('chart-soc', i).at(-1))")
    assert ends == pytest.approx([lap["end_soc_pct"] for lap in laps], abs=0.1)
    colours = ask(page, "chart('chart-soc').getOption().series.map(one => one.lineStyle.color)")
    assert len(set(colours)) == 27
    assert page.complaints() == []


def test_laps_to_lie_over_each_other_are_picked_with_keys_and_one_always_stays(page):
    page.run("document.getElementById('overlay').click()")
    buttons = "[...document.querySelectorAll('#laps-over button')]"
    page.run(f"{buttons}.find(button => button.textContent === 'first and last').click()")
    page.settle()
    shown = "chart('chart-soc').getOption().series.map(one => one.name)"
    assert ask(page, shown) == ["plant, lap 1", "plant, lap 27"]
    for lap in (1, 27):
        page.run(f"document.querySelector('#laps-over input[aria-label=\"lap {lap}\"]').focus()")
        page.key(" ", " ")
        page.settle()
    assert ask(page, shown) == ["plant, lap 27"]
    page.run("document.querySelector('.surface').focus()")
    page.key("ArrowRight")
    assert "into the lap" in page.run("document.getElementById('cursor').textContent")
    page.run("document.getElementById('overlay').click()")
    page.settle()
    assert ask(page, shown)[0] == "plant"
