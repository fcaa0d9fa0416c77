# SPDX-License-Identifier: Apache-2.0
"""voltlap log plot: the command, and its page in headless Chromium: every value that was sent, gaps, steps, zoom."""
import gzip
import json
import math
import os
import pathlib
import random
import struct
import subprocess

import pytest

BINARY = pathlib.Path(os.environ["VOLTLAP_BUILD_DIR"]) / "bin" / "voltlap-logs"
BEGIN_S = 1_700_000_000.0
DBC = """VERSION ""

BU_: Bms X

BO_ 256 Pack: 8 Bms
 SG_ Voltage : 0|16@1+ (0.1,0) [0|1000] "V" X
 SG_ Current : 16|16@1- (0.1,0) [-3000|3000] "A" X
 SG_ State : 32|8@1+ (1,0) [0|5] "" X
 SG_ Counter : 40|4@1+ (1,0) [0|15] "" X

BO_ 512 Inverter: 2 Bms
 SG_ MotorTemp : 0|8@1+ (1,-40) [-40|200] "degC" X
 SG_ Idle : 8|8@1+ (1,0) [0|255] "" X

VAL_ 256 State 0 "Off" 1 "Precharge" 2 "Drive" 3 "Fault" ;
"""


def payload(k):
    """Of the k-th frame: a slow wave, one spike, a state, a counter."""
    volts = 9000 if k == 1234 else 4000 + round(200 * math.sin(0.01 * k))
    return struct.pack("<HhBBxx", volts, round(1000 * math.sin(0.02 * k)), k // 1000 % 4, k % 16).hex().upper()


def lines():
    """40 s at 100 frames a second; nothing from 15 s to 25 s."""
    for k in range(4000):
        if not 1500 <= k < 2500:
            yield f"({BEGIN_S + 0.01 * k:.6f}) can0 100#{payload(k)}\n"
        if k % 100 == 0:
            yield f"({BEGIN_S + 0.01 * k + 0.001:.6f}) can0 200#{60 + k // 400:02X}07\n"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("plot")
    (path / "car.dbc").write_text(DBC)
    with gzip.open(path / "drive.log.gz", "wt") as out:
        out.writelines(lines())
    return path


def plot(folder, *arguments, code=0):
    run = subprocess.run([BINARY, "log", "plot", *map(str, arguments)], cwd=folder, capture_output=True, text=True,
                         timeout=300, env={**os.environ, "XDG_CACHE_HOME": str(folder / "cache")})
    assert run.returncode == code, run.stderr
    return run


@pytest.fixture(scope="module")
def page_file(folder):
    run = plot(folder, "drive.log.gz", "--dbc", "car.dbc", "--report", "page.html")
    assert "the 4 of 6 signals that move; 1 never change, 1 are counters" in run.stdout
    return folder / "page.html"


def opened(browser, path, **how):
    page = browser.page(path.as_uri(), **how)
    page.wait_for("document.documentElement?.dataset.ready", timeout_s=300)
    return page


def drawn(page, chart, series=0):
    """[[x, value or null], ...] as the chart has them."""
    flat = page.run(f"Array.from(echarts.getInstanceByDom(document.getElementById('chart-{chart}')).getOption()"
                    f".series[{series}].data, v => Number.isNaN(v) ? null : v)")
    return list(zip(flat[::2], flat[1::2], strict=True))


def box_of(page, chart):
    return page.run(f"(() => {{ const b = document.getElementById('chart-{chart}').getBoundingClientRect();"
                    f" scrollTo(0, b.y - 200 + scrollY); const c = document.getElementById('chart-{chart}')"
                    ".getBoundingClientRect(); return [c.x, c.y, c.width, c.height]; })()")


def test_page_is_one_file_that_asks_for_nothing_and_says_what_it_shows(browser, page_file):
    page = opened(browser, page_file)
    assert page.complaints() == []
    sent = {event["params"]["request"]["url"] for event in page.happened("Network.requestWillBeSent")} - {page.url}
    assert {url for url in sent if not url.startswith("data:")} == set()
    text = page.run("document.body.innerText")
    assert "drive.log.gz, 2023-11-14 22:13:20.000 UTC" in text
    titles = page.run("[...document.querySelectorAll('#charts h3')].map(h => h.textContent)")
    assert titles == ["Voltage", "Current", "Temperature", "Numbers without a unit"]
    assert "Pack.Voltage 380.0 … 900.0" in page.run("document.querySelector('#charts .legend').textContent")


def test_a_spike_is_drawn_and_a_gap_is_not(browser, page_file):
    points = drawn(opened(browser, page_file), 0)
    assert max(value for _, value in points if value is not None) == pytest.approx(900.0)
    holes = [x for x, value in points if value is None]
    assert len(holes) == 1 and holes[0] == pytest.approx(25.0, abs=0.001)
    before = max(x for x, value in points if value is not None and x < 20.0)
    assert before == pytest.approx(14.99, abs=0.001)


def test_a_state_is_drawn_in_steps_and_a_wave_is_not(browser, page_file):
    page = opened(browser, page_file)
    step = "echarts.getInstanceByDom(document.getElementById('chart-{}')).getOption().series[0].step ?? null"
    assert page.run(step.format(3)) == "end" and page.run(step.format(1)) is None


def test_all_charts_show_the_stretch_that_one_is_zoomed_to(browser, page_file):
    page = opened(browser, page_file)
    x, y, width, height = box_of(page, 1)
    left, wide = x + 66, width - 66 - 18
    page.drag((left + 0.25 * wide, y + height / 2), (left + 0.30 * wide, y + height / 2))
    begin, end = map(float, page.run("document.getElementById('view').textContent")[:-2].split(" to "))
    assert begin == pytest.approx(10.0, abs=0.1) and end == pytest.approx(12.0, abs=0.1)
    for chart in range(4):
        xs = [at for at, _ in drawn(page, chart)]
        assert min(xs) >= 9.9 and max(xs) <= 12.1
    # Now every sample is there: none is left out of a view that has room for it.
    assert len(drawn(page, 1)) >= 199
    page.run("document.getElementById('whole').click()")
    page.settle()
    assert max(at for at, _ in drawn(page, 2)) > 38.0


def test_cursor_tells_the_value_and_that_nothing_is_known_in_a_gap(browser, page_file):
    page = opened(browser, page_file)
    x, y, width, height = box_of(page, 0)
    left, wide = x + 66, width - 66 - 18
    page.mouse("mouseMoved", left + 0.5 * wide, y + height / 2)
    page.settle()
    assert page.run("document.querySelector('#charts .legend output').textContent") == "not known"
    page.mouse("mouseMoved", left + 0.1 * wide, y + height / 2)
    page.settle()
    assert page.run("document.querySelector('#charts .legend output').textContent").endswith(" V")


def test_a_state_is_told_by_its_name(browser, page_file):
    page = opened(browser, page_file)
    x, y, width, height = box_of(page, 3)
    page.mouse("mouseMoved", x + 66 + 0.3 * (width - 84), y + height / 2)
    page.settle()
    assert page.run("[...document.querySelectorAll('#charts .legend')][3].querySelector('output').textContent") == \
        "Precharge (1)"
    assert "Fault (3)" in page.run("document.getElementById('signals').textContent")


def test_thinning_keeps_extremes_gaps_and_edges_of_any_signal(browser, page_file):
    seed = random.randrange(2**32)
    page = opened(browser, page_file)
    page.run("""window.check = (seed) => {
      let state = seed;
      const random = () => (state = (state * 1664525 + 1013904223) % 4294967296) / 4294967296;
      const count = 2 + Math.floor(3000 * random());
      const times = new Float64Array(count), values = new Float64Array(count), begins = [0];
      for (let i = 1, t = 0; i < count; i += 1) {
        const gap = random() < 0.01;
        t += random() < 0.05 ? 0 : random() + (gap ? 50 : 0);
        if (gap) begins.push(i);
        times[i] = t;
        values[i] = Math.round(10 * random()) + (random() < 0.01 ? 1000 : 0);
      }
      const stepped = random() < 0.5;
      const signal = new voltlap.OwnTimes(times, values, begins, stepped);
      const end = times[count - 1], from = end * random() * 0.9, to = from + (end - from) * random() + 1e-3;
      const width = 100 + Math.floor(500 * random());
      const drawn = signal.points(from, to, width);
      if (drawn.length > 2 * (4 * width + 2 * begins.length + 8)) return "too many points";
      const inside = [...values.keys()].filter((i) => times[i] >= from && times[i] <= to);
      const shown = [];
      for (let k = 0; k < drawn.length; k += 2) {
        if (k > 0 && drawn[k] < drawn[k - 2]) return `time runs back at ${drawn[k]}`;
        if (drawn[k] < from || drawn[k] > to) return `a point outside of the view at ${drawn[k]}`;
        if (!Number.isNaN(drawn[k + 1])) shown.push(drawn[k + 1]);
      }
      for (const pick of [Math.max, Math.min]) {
        const whole = pick(...inside.map((i) => values[i]));
        const lost = inside.length && (pick === Math.max ? Math.max(...shown) < whole : Math.min(...shown) > whole);
        if (lost) return `an extreme of ${whole} is lost`;
      }
      const holes = [...drawn].filter((v) => Number.isNaN(v)).length;
      const inner = begins.filter((b) => b > 0 && times[b] >= from && times[b] <= to);
      const known = inner.filter((b) => times[b - 1] >= from || signal.valueAt(from) !== null);
      if (holes < known.length || holes > inner.length) return `${holes} holes for ${known.length} gaps`;
      return "";
    }""")
    for draw in range(300):
        found = page.run(f"check({(seed + draw) % 2**32})")
        assert not found, f"seed {seed}, draw {draw}: {found}"


@pytest.mark.parametrize("how", [{"width": 390, "height": 800, "mobile": True}, {"dark": True}])
def test_narrow_and_dark_pages_show_everything(browser, page_file, how):
    page = opened(browser, page_file, **how)
    assert page.complaints() == []
    assert page.run("document.documentElement.scrollWidth <= innerWidth")
    assert page.run("[...document.querySelectorAll('#charts canvas')].every(c => c.width > 100)")


def test_a_stretch_of_the_recording_keeps_the_recordings_own_times(browser, folder):
    plot(folder, "drive.log.gz", "--dbc", "car.dbc", "--signals", "voltage,*Temp*", "--from", "5", "--to", "12.5",
         "--report", "part.html")
    page = opened(browser, folder / "part.html")
    assert page.run("document.getElementById('view').textContent") == "5.000 to 12.500 s"
    xs = [x for x, _ in drawn(page, 0)]
    assert 5.0 <= min(xs) < 5.1 and 12.4 < max(xs) <= 12.5


def test_a_long_recording_makes_a_small_page(folder):
    with gzip.open(folder / "long.log.gz", "wt", compresslevel=1) as out:
        for k in range(500_000):
            out.write(f"({BEGIN_S + 0.002 * k:.6f}) can0 100#{payload(k * 37)}\n")
    plot(folder, "long.log.gz", "--dbc", "car.dbc", "--signals", "*", "--report", "long.html")
    assert (folder / "long.html").stat().st_size < 5_000_000


@pytest.mark.parametrize("arguments, complaint", [
    (["nowhere.log", "--dbc", "car.dbc"], "nowhere.log"),
    (["drive.log.gz", "--dbc", "nowhere.dbc"], "nowhere.dbc"),
    (["drive.log.gz", "--dbc", "car.dbc", "--signals", "Pack.Volts"], "Pack.Voltage"),
    (["drive.log.gz", "--dbc", "car.dbc", "--from", "500"], "no value in that stretch"),
    (["drive.log.gz", "--dbc", "car.dbc", "--from", "9", "--to", "3"], "not after --from"),
    (["car.dbc", "--dbc", "car.dbc"], "car.dbc"),
    (["drive.log.gz"], "drive.log.gz"),
])
def test_what_cannot_be_done_is_told_and_nothing_is_left_behind(folder, arguments, complaint):
    run = plot(folder, *arguments, "--report", "none.html", code=2)
    assert complaint in run.stderr and run.stdout == ""
    assert not (folder / "none.html").exists()


def test_the_recording_is_not_written_over(folder):
    before = (folder / "drive.log.gz").read_bytes()
    plot(folder, "drive.log.gz", "--dbc", "car.dbc", "--report", "drive.log.gz", code=2)
    assert (folder / "drive.log.gz").read_bytes() == before


def test_the_data_of_the_page_are_those_of_the_recording(page_file):
    text = page_file.read_text()
    data = json.loads(text.split('id="voltlap-data">')[1].split("</script>")[0])
    series = {one["name"]: one for chart in data["charts"] for one in chart["series"]}
    assert series["Pack.Current"]["range"] == "-100.0 … 100.0"
    assert series["Inverter.MotorTemp"]["range"] == "20 … 29"
    assert series["Pack.State"]["stepped"] and not series["Pack.Voltage"]["stepped"]
