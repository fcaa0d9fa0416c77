# SPDX-License-Identifier: Apache-2.0
"""Writes reports and reads them in a browser: what stands in the charts, what the page asked for."""
import json
import os
import pathlib
import subprocess

import pytest

BINARY = pathlib.Path(os.environ["VOLTLAP_BUILD_DIR"]) / "bin" / "voltlap"
TIME_CHARTS = ["chart-speed", "chart-pedals", "chart-power", "chart-current", "chart-acceleration",
               "chart-pack-voltage", "chart-cell-voltage", "chart-soc", "chart-temperature", "chart-rotors"]
# What a test asks the charts, and not the page's own data.
CHART = """
const chart = id => echarts.getInstanceByDom(document.getElementById(id));
const series = (id, i) => chart(id).getModel().getSeriesByIndex(i);
const values = (id, i) => series(id, i).getRawData().mapArray("value", v => v);
const view = id => chart(id).getModel().getComponent("xAxis").axis.scale.getExtent();
const timeAt = (id, x) => chart(id).convertFromPixel({xAxisIndex: 0}, x);
const flows = () => chart("chart-energy").getOption().series[0].links;
const lines = () => chart("chart-speed").getOption().series[0].markLine.data;
const box = id => {
  const place = document.getElementById(id).getBoundingClientRect();
  return [place.x, place.y, place.width, place.height];
};
"""


def ask(page, expression):
    return page.run(f"(() => {{ {CHART} return {expression}; }})()")


def wait_until(page, expression):
    page.wait_for(f"(() => {{ {CHART} return {expression}; }})()")


def views(page):
    return [ask(page, f"view('{name}')") for name in TIME_CHARTS]


def one_view(page):
    """The stretch that all charts show; fails when one of them shows another."""
    all_views = views(page)
    assert all(view == pytest.approx(all_views[0], abs=1e-6) for view in all_views), all_views
    return all_views[0]


def opened(page):
    page.wait_for("document.documentElement?.dataset.ready", timeout_s=300)
    return page


def requests(page):
    """Everything that the page asked for besides itself."""
    sent = {event["params"]["request"]["url"] for event in page.happened("Network.requestWillBeSent")} - {page.url}
    listed = set(page.run("performance.getEntriesByType('resource').map(entry => entry.name)"))
    return {url for url in sent | listed if not url.startswith("data:")}


def voltlap(folder, *arguments):
    return subprocess.run([BINARY, "endurance", *arguments], cwd=folder, capture_output=True, text=True, timeout=300)


def run(folder, *arguments, code=0):
    """Result as JSON and the report's address."""
    done = voltlap(folder, "--json", "run.json", "--report", "run.html", *arguments)
    assert done.returncode == code, done.stderr
    return json.loads((folder / "run.json").read_text()), (folder / "run.html").as_uri()
