# SPDX-License-Identifier: Apache-2.0
"""`voltlap compare` as a race engineer meets it: what it lists, what it computes, what it refuses, its report."""
import csv
import json
import os
import pathlib
import random
import shutil
import subprocess

import pytest
from report_reader import BINARY, opened, requests

SEED = int(os.environ.get("VOLTLAP_TEST_SEED", "11"))


def endurance(folder, name, *arguments, code=0):
    done = subprocess.run([BINARY, "endurance", "--json", name, *arguments], cwd=folder, capture_output=True, text=True,
                          timeout=300)
    assert done.returncode == code, done.stderr
    return json.loads((folder / name).read_text())


def compare(folder, *arguments, code=0):
    done = subprocess.run([BINARY, "compare", *map(str, arguments)], cwd=folder, capture_output=True, text=True,
                          timeout=120)
    assert done.returncode == code, done.stdout + done.stderr
    return done.stderr if code else done.stdout


def compared(folder, *runs):
    compare(folder, *runs, "--json", "compared.json")
    return json.loads((folder / "compared.json").read_text())


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Two cars of different mass, and the first once more with its time series."""
    folder = tmp_path_factory.mktemp("runs")
    base = endurance(folder, "base.json", "--laps", "3", "--csv", "base.csv")
    heavy = endurance(folder, "heavy.json", "--laps", "3", "--set", "vehicle.mass_kg=280")
    return folder, base, heavy


def test_exactly_the_changed_key_is_listed_with_unit_and_both_values(runs):
    folder, base, _ = runs
    [row] = compared(folder, "base.json", "heavy.json")["inputs"]
    assert (row["key"], row["unit"]) == ("vehicle.mass_kg", "kg")
    assert [float(value) for value in row["values"]] == [base["parameters"]["vehicle.mass_kg"], 280.0]


def test_any_drawn_key_that_differs_is_listed_and_no_other(runs):
    folder, base, _ = runs
    draw = random.Random(SEED)
    keys = draw.sample([key for key, value in base["parameters"].items() if isinstance(value, float)], 20)
    for key in keys:
        other = json.loads((folder / "base.json").read_text())
        other["parameters"][key] += 0.125
        (folder / "other.json").write_text(json.dumps(other))
        assert [row["key"] for row in compared(folder, "base.json", "other.json")["inputs"]] == [key], (SEED, key)


def test_one_cell_that_differs_is_listed_alone(runs):
    folder, _, _ = runs
    endurance(folder, "weak.json", "--laps", "3", "--set", "battery.cells.6.capacity_scale=0.9")
    [row] = compared(folder, "base.json", "weak.json")["inputs"]
    assert row["key"] == "battery.cells.6.capacity_scale" and [float(value) for value in row["values"]] == [1.0, 0.9]


def test_sums_over_another_number_of_laps_have_no_difference(runs):
    folder, _, _ = runs
    endurance(folder, "short.json", "--laps", "2")
    rows = {row["name"]: row["differences"] for row in compared(folder, "base.json", "short.json")["results"]}
    for name in ("total time", "distance driven", "charge left", "energy out"):
        assert rows[name][1] is None, name
    assert rows["laps completed"][1] == -1 and rows["top speed"][1] is not None
    same = {row["name"]: row["differences"] for row in compared(folder, "base.json", "heavy.json")["results"]}
    assert same["total time"][1] > 0.0


def test_time_behind_ends_at_the_difference_of_the_total_times(runs):
    folder, base, heavy = runs
    result = compared(folder, "base.json", "heavy.json")
    first, second = result["delta"]
    assert set(first["delta_s"]) == {0.0}
    assert second["delta_s"][-1] == pytest.approx(heavy["total_time_s"] - base["total_time_s"], abs=1e-3)
    assert second["distance_m"][-1] == pytest.approx(3 * base["course_length_m"], abs=1e-3)
    total = result["results"][0]
    assert total["name"] == "total time" and total["unit"] == "s"
    assert total["differences"][1] == pytest.approx(heavy["total_time_s"] - base["total_time_s"], abs=1e-9)
    laps = [row["differences"][1] for row in result["lap_times"]]
    assert sum(laps) == pytest.approx(total["differences"][1], abs=1e-9)


def test_time_behind_at_each_line_is_that_of_the_lap_table(runs):
    folder, base, _ = runs
    result = compared(folder, "base.json", "heavy.json")
    places, behind = result["delta"][1]["distance_m"], result["delta"][1]["delta_s"]
    sums = 0.0
    for lap, row in enumerate(result["lap_times"], 1):
        sums += row["differences"][1]
        nearest = min(range(len(places)), key=lambda i: abs(places[i] - lap * base["course_length_m"]))
        assert behind[nearest] == pytest.approx(sums, abs=0.05)  # a tick of each, and half a step of the trace


def series(folder, name="base.csv"):
    lines = [line for line in (folder / name).read_text().splitlines() if not line.startswith("#")]
    return [{key: value if key == "limit_reason" else float(value) for key, value in row.items()}
            for row in csv.DictReader(lines)]


def test_power_sums_to_the_energy_and_its_mean_stays_under_its_peak(runs):
    folder, base, _ = runs
    rows = series(folder)
    mean_kw = sum(row["power_kw"] for row in rows) / len(rows)
    assert mean_kw * base["total_time_s"] / 3600 == pytest.approx(base["energy_out_kwh"], rel=0.02)
    means = [row["power_mean_500ms_kw"] for row in rows]
    # 500 ms windows that follow each other without a gap hold all of the energy.
    energy_kwh = sum(means[4::5]) * 0.5 / 3600
    assert energy_kwh == pytest.approx(base["energy_out_kwh"], rel=2e-3)
    assert max(means) <= base["max_power_mean_500ms_kw"] + 1e-4 <= base["max_power_kw"] + 1e-4
    assert all(row["power_kw"] == pytest.approx(row["pack_current_a"] * row["pack_voltage_v"] / 1000, abs=1e-3)
               for row in rows)


def test_distance_speed_and_acceleration_belong_together(runs):
    folder, base, _ = runs
    rows = series(folder)
    assert sum(row["distance_m"] for row in base["lap_rows"]) == pytest.approx(base["distance_m"], abs=1e-6)
    for before, row in zip(rows, rows[1:]):
        assert row["speed_kmh"] == pytest.approx(3.6 * row["speed_mps"], abs=5e-4)
        assert 0.0 <= row["lap_distance_m"] <= base["course_length_m"] + 0.5
        assert (row["lap"] == before["lap"]) == (row["lap_distance_m"] >= before["lap_distance_m"])
        assert abs(row["lateral_mps2"]) < 25.0
    gained = sum(row["longitudinal_mps2"] for row in rows) * 0.1
    assert gained == pytest.approx(rows[-1]["speed_mps"] - rows[0]["speed_mps"], abs=0.03 * base["total_time_s"])


def test_lateral_acceleration_is_that_of_the_listed_corner_to_the_right_or_left(runs):
    track = pathlib.Path(__file__).resolve().parents[4] / "plant_sim/data/tracks/michigan_2015.csv"
    corners, end_m = [], 0.0  # first and last metre, curvature; negative turns left
    for row in csv.DictReader(line for line in track.read_text().splitlines() if not line.startswith("#")):
        start_m = end_m + float(row["straight_m"])
        radius_m, angle = float(row["corner_radius_m"]), float(row["corner_angle_rad"])
        corners.append((end_m, start_m, 0.0))
        end_m = start_m + radius_m * abs(angle)
        corners.append((start_m, end_m, (1 if angle > 0 else -1) / radius_m))
    seen = set()
    for row in series(runs[0]):
        for first, last, curvature in corners:
            if first + 0.1 < row["lap_distance_m"] < last - 0.1:
                assert row["lateral_mps2"] == pytest.approx(row["speed_mps"] ** 2 * curvature, abs=0.01)
                seen.add(curvature)
    assert min(seen) < 0.0 < max(seen) and 0.0 in seen


def test_new_columns_stand_behind_those_that_were_there(runs):
    names = next(line for line in (runs[0] / "base.csv").read_text().splitlines() if not line.startswith("#"))
    assert names.startswith("time_s,distance_m,lap,speed_mps,target_mps,accelerator,brake,pack_current_a")
    assert names.endswith("_temperature_c,lap_distance_m,speed_kmh,power_kw,power_mean_500ms_kw,longitudinal_mps2,"
                          "lateral_mps2,charge_drawn_ah")


def test_recorded_drive_has_no_lateral_acceleration_and_can_be_compared(tmp_path):
    (tmp_path / "drive.csv").write_text("time_s,speed_mps\n0,0\n5,5\n20,5\n25,1\n")
    endurance(tmp_path, "a.json", "--drive", "drive.csv", "--csv", "a.csv")
    endurance(tmp_path, "b.json", "--drive", "drive.csv", "--set", "vehicle.mass_kg=280")
    assert all(row["lateral_mps2"] != row["lateral_mps2"] for row in series(tmp_path, "a.csv"))
    assert "vehicle.mass_kg" in compare(tmp_path, "a.json", "b.json")


def test_unfinished_run_is_compared_as_far_as_it_came_and_said(runs):
    folder = runs[0]
    failed = endurance(folder, "failed.json", "--laps", "3", "--set", "assertions.battery_temperature_max_c=27.2",
                       code=3)
    said = compare(folder, "base.json", "failed.json", "--json", "c.json")
    assert "FAILED after" in said and failed["failure"]["cause"] in said
    behind = json.loads((folder / "c.json").read_text())["delta"][1]
    assert behind["distance_m"][-1] == pytest.approx(failed["trace"]["distance_m"][-1], abs=1e-3)


def without(folder, name, *keys):
    other = json.loads((folder / "base.json").read_text())
    for key in keys:
        del other[key]
    (folder / name).write_text(json.dumps(other))
    return name


def changed(folder, name, change):
    other = json.loads((folder / "base.json").read_text())
    change(other)
    (folder / name).write_text(json.dumps(other))
    return name


ERRORS = {
    "one alone": (lambda f: ["base.json"], ["1 of them", "2 to 5 runs"]),
    "six": (lambda f: [shutil.copy(f / "base.json", f / f"{i}.json").name for i in range(6)], ["6 of them"]),
    "twice": (lambda f: ["base.json", "./base.json"], ["the same file twice", "Leave one out"]),
    "absent": (lambda f: ["base.json", "gone.json"], ["gone.json: found No such file"]),
    "folder": (lambda f: ["base.json", "."], ["the JSON of a run"]),
    "no JSON": (lambda f: ["base.json", "base.csv"], ["base.csv:1: found what is no JSON"]),
    "no run": (lambda f: [(f / "l.json").write_text('{"lap_time_s": 1}') and "l.json", "base.json"],
               ["l.json, status: found no such field", "voltlap endurance --json"]),
    "old": (lambda f: ["base.json", without(f, "old.json", "trace", "course_length_m")],
            ["old.json, trace", "voltlap endurance --vehicle vtm16e --track michigan_2015 --lap-start flying --laps 3",
             "--seed 1 --json old.json"]),
    "other course": (lambda f: ["base.json", changed(f, "x.json", lambda run: run.update(course="oval"))],
                     ["x.json, course: found oval", "michigan_2015", "as in base.json"]),
    "torn trace": (lambda f: ["base.json", changed(f, "x.json", lambda run: run["trace"]["soc_pct"].pop())],
                   ["x.json, trace.soc_pct: found", "as distance_m has"]),
    "time runs back": (lambda f: ["base.json", changed(f, "x.json", lambda run: run["trace"]["time_s"].reverse())],
                       ["x.json, trace.time_s[1]"]),
    "words for a number": (lambda f: ["base.json", changed(f, "x.json", lambda run: run.update(end_soc_pct="full"))],
                           ['x.json, end_soc_pct: found "full"; expected a number']),
    "result over a run": (lambda f: ["base.json", "heavy.json", "--json", "heavy.json"], ["--json", "one of the runs"]),
}


@pytest.mark.parametrize("make, words", ERRORS.values(), ids=ERRORS.keys())
def test_what_cannot_be_compared_is_refused_with_reason(runs, tmp_path, make, words):
    folder = tmp_path / "copy"
    shutil.copytree(runs[0], folder)
    arguments = make(folder)
    before = (folder / "heavy.json").read_text()
    said = compare(folder, *arguments, "--report", "never.html", code=2)
    assert all(word in said for word in words), said
    assert not (folder / "never.html").exists() and (folder / "heavy.json").read_text() == before


ODD = [None, True, -1, 1e300, "", "words", [], {}, [None], {"a": 1}, 2**64]


def test_a_drawn_thing_that_is_wrong_is_refused_and_never_a_defect(runs):
    folder = runs[0]
    draw = random.Random(SEED)
    for _ in range(150):
        run = json.loads((folder / "base.json").read_text())
        at, key = run, draw.choice(list(run))
        while isinstance(at[key], (dict, list)) and at[key] and draw.random() < 0.6:
            at = at[key]
            key = draw.choice(list(at)) if isinstance(at, dict) else draw.randrange(len(at))
        odd = draw.choice(ODD)
        at[key] = odd
        (folder / "odd.json").write_text(json.dumps(run))
        done = subprocess.run([BINARY, "compare", "base.json", "odd.json", "--report", "odd.html"], cwd=folder,
                              capture_output=True, text=True, timeout=60)
        assert done.returncode in (0, 2), (SEED, key, odd, done.stderr)
        assert done.returncode == 0 or "odd.json" in done.stderr, (SEED, key, odd, done.stderr)


@pytest.mark.parametrize("width, dark", [(1280, False), (390, True)])
def test_report_draws_every_run_and_asks_for_nothing(runs, browser, width, dark):
    folder, base, heavy = runs
    compare(folder, "base.json", "heavy.json", "--report", "compare.html")
    url = (folder / "compare.html").as_uri()
    page = opened(browser.page(url, width=width, height=844, mobile=width < 500, dark=dark))
    page.settle()
    assert page.complaints() == [] and requests(page) == set()
    assert page.run("document.documentElement.scrollWidth") <= width
    chart = "echarts.getInstanceByDom(document.getElementById('chart-delta'))"
    last = page.run(f"[...{chart}.getModel().getSeriesByIndex(1).getRawData().mapArray('value', v => v)].at(-1)")
    assert last == pytest.approx(heavy["total_time_s"] - base["total_time_s"], abs=2e-3)
    page.run("document.getElementById('next').click()")
    page.settle()
    text = page.run("document.body.innerText")
    assert "vehicle.mass_kg" in text and "lap 2" in page.run("document.getElementById('view').textContent")
    # Of one lap the time behind counts from its start: at the end of it stands the difference of the lap times.
    points = f"{chart}.getModel().getSeriesByIndex(1).getRawData()"
    at, behind = page.run(f"['x', 'value'].map(name => {points}.mapArray(name, v => v))")
    near = [min(range(len(at)), key=lambda i: abs(at[i] - k * base["course_length_m"])) for k in (1, 2)]
    lap_s = heavy["lap_rows"][1]["time_s"] - base["lap_rows"][1]["time_s"]
    assert [behind[i] for i in near] == pytest.approx([0.0, lap_s], abs=0.05)
