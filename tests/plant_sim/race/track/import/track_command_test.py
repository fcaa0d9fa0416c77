# SPDX-License-Identifier: Apache-2.0
"""voltlap track as its users meet it: a course file that lap drives, a picture, JSON, messages for bad sources.

With VOLTLAP_DATA the courses that teams digitised come in as they are (fsae_tracks).
"""
import csv
import gzip
import json
import os
import pathlib
import subprocess
import xml.etree.ElementTree

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[5]
BUILD = pathlib.Path(os.environ["VOLTLAP_BUILD_DIR"])
EXAMPLES = ROOT / "docs" / "tracks"
DATA = os.environ.get("VOLTLAP_DATA")
TEAMS = pathlib.Path(DATA or "/nowhere") / "fsae_tracks"
needs_data = pytest.mark.skipif(not DATA, reason="VOLTLAP_DATA is not set: no courses of teams on this machine")


def voltlap(*arguments, ends_with=0):
    done = subprocess.run([BUILD / "bin" / "voltlap", *map(str, arguments)], capture_output=True, text=True,
                          timeout=300)
    assert done.returncode == ends_with, done.stdout + done.stderr
    return done


def imported(folder, source, *flags):
    """What the import says, and the lap of what it made."""
    course, said = folder / "course.csv", folder / "said.json"
    voltlap("track", "import", source, "--out", course, "--json", said, *flags)
    lap = json.loads(voltlap("lap", "--track", course, "--json", "-").stdout)
    return json.loads(said.read_text()) | {"lap_time_s": lap["lap_time_s"], "lap_length_m": lap["length_m"]}


@pytest.mark.parametrize("source, kind", [("paddock.csv", "points"), ("paddock_laps.csv", "gps"),
                                          ("paddock_gates_ft.csv", "gates")])
def test_three_sources_of_one_course_give_one_course(tmp_path, source, kind):
    said = imported(tmp_path, EXAMPLES / source)
    assert said["source_kind"] == kind and said["closed"]
    assert said["length_m"] == pytest.approx(500.0, rel=0.006)
    assert said["lap_length_m"] == pytest.approx(said["length_m"], rel=1e-9)
    assert said["closing_gap_m"] < 0.01
    assert said["lap_time_s"] == pytest.approx(35.7, rel=0.05)


def test_laps_of_a_recording_are_counted_and_one_may_be_chosen(tmp_path):
    mean, third = (imported(tmp_path, EXAMPLES / "paddock_laps.csv", *flags) for flags in ((), ("--lap", 3)))
    assert (mean["laps_found"], mean["laps_used"], third["laps_used"]) == (4, 4, 1)
    assert mean["noise_m"] == pytest.approx(0.5, abs=0.05)


def test_gpx_is_the_recording_that_a_table_is(tmp_path):
    with open(EXAMPLES / "paddock_laps.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if line[0] != "#"))
    points = "".join(f'<trkpt lat="{r["latitude"]}" lon="{r["longitude"]}"/>\n' for r in rows)
    (tmp_path / "laps.gpx").write_text(f"<gpx><trk><trkseg>\n{points}</trkseg></trk></gpx>\n")
    table, gpx = (imported(tmp_path, source) for source in (EXAMPLES / "paddock_laps.csv", tmp_path / "laps.gpx"))
    assert gpx["lap_time_s"] == table["lap_time_s"]


def test_a_compressed_source_is_read_and_the_endurance_drives_the_course(tmp_path):
    source = tmp_path / "yard.csv.gz"
    source.write_bytes(gzip.compress((EXAMPLES / "paddock.csv").read_bytes()))
    said = imported(tmp_path, source)
    assert said["name"] == "yard"
    voltlap("endurance", "--track", tmp_path / "course.csv", "--laps", 2)


def test_picture_is_svg_with_the_course_and_its_points(tmp_path):
    plot = tmp_path / "course.svg"
    voltlap("track", "import", EXAMPLES / "paddock.csv", "--out", tmp_path / "course.csv", "--plot", plot)
    tags = [element.tag.split("}")[1] for element in xml.etree.ElementTree.parse(plot).iter()]
    assert tags.count("circle") == 500 and "path" in tags
    voltlap("track", "show", "michigan_2015", "--plot", plot)
    assert "michigan_2015: 814 m" in plot.read_text()


def test_the_course_file_may_go_to_standard_output(tmp_path):
    course = tmp_path / "course.csv"
    course.write_text(voltlap("track", "import", EXAMPLES / "paddock.csv", "--out", "-").stdout)
    assert "length" in voltlap("track", "show", course).stdout


def test_show_says_length_corners_tightest_and_gap():
    said = json.loads(voltlap("track", "show", "michigan_2014", "--json", "-").stdout)
    assert said["length_m"] == pytest.approx(746.9, abs=0.1) and said["tightest_radius_m"] == pytest.approx(3.0)
    assert said["corners"] > 30 and said["closing_gap_m"] > 10.0


def test_show_says_what_climbs_and_where_it_ends(tmp_path):
    course = tmp_path / "hill.csv"
    course.write_text("straight_m,corner_radius_m,corner_angle_deg,grade_pct\n60,10,180,5\n60,10,180,-2\n")
    half = 60.0 + 10.0 * 3.14159265
    said = json.loads(voltlap("track", "show", course, "--json", "-").stdout)
    assert said["climb_m"] == pytest.approx(0.05 * half, abs=1e-3)
    assert said["rise_m"] == pytest.approx(0.03 * half, abs=1e-3)
    assert "2.7 m above its start" in voltlap("track", "show", course).stdout


@pytest.mark.parametrize("text, flags, message", [
    ("x,y\n0,0\n1,1\n", (), "Say --unit m or --unit ft"),
    ("time,speed\n0,0\n", (), "found the columns time, speed"),
    ("lat,lon\n142,8\n", (), "expected -90 to 90 degrees"),
    ("x_m,y_m\n0,0\n1,nan\n", (), 'found "nan"'),
    ("x_m,y_m\n0,0\n1,1\n", (), "found 2 points"),
    ("x_m,y_m\n0,0\n1,1\n", ("--as", "circle"), "expected one of points, gps, gates, curvature, segments"),
    ("x_m,y_m\n0,0\n1,1\n", ("--open", "--closed"), "expected one of the two"),
])
def test_a_bad_source_is_refused_and_nothing_is_written(tmp_path, text, flags, message):
    (tmp_path / "bad.csv").write_text(text)
    out = tmp_path / "course.csv"
    assert message in voltlap("track", "import", tmp_path / "bad.csv", "--out", out, *flags, ends_with=2).stderr
    assert not out.exists() and len(list(tmp_path.iterdir())) == 1


@pytest.mark.parametrize("arguments, message", [
    ((), "track: found no command; expected one of import, show"),
    (("imprt",), "Did you mean import? See `voltlap track --help`"),
    (("import", "--out", "c.csv"), "`voltlap track import --help` shows what it may be"),
    (("import", "x.csv", "--out", "c.csv", "--nois", "1"), "track import: found the unknown flag --nois"),
])
def test_a_command_line_that_is_wrong_is_told_with_the_command(arguments, message):
    assert message in voltlap("track", *arguments, ends_with=2).stderr


COURSES = [  # file, flags, length in m, closed
    ("autocross_michigan_2019_gates_ft.csv", ("--unit", "ft"), 890, False),
    ("endurance_michigan_2019_gates_ft.csv", ("--unit", "ft"), 2040, True),
    ("endurance_lincoln_2015_curvature_m.csv.gz", (), 1501, True),
    ("endurance_lincoln_2016_curvature_m.csv.gz", (), 1455, True),
    ("lincoln_2015_autocross_m.csv.gz", (), 919, False),
    ("lincoln_2015_endurance_m.csv.gz", (), 1501, True),
    ("lincoln_2016_autocross_m.csv.gz", (), 875, False),
    ("lincoln_2016_endurance_m.csv.gz", (), 1456, True),
    ("michigan_2014_segments.csv", (), 1072, False),
    ("michigan_2019_autocross_racing_line.csv.gz", (), 866, False),
    ("michigan_2019_endurance_racing_line.csv.gz", ("--noise", 0.4), 2050, True),  # its points have loops of 0.3 m
    ("michigan_2021_endurance_segments.csv", (), 1063, True),
    ("michigan_2022_autox_segments.csv", (), 726, False),
]


@needs_data
def test_the_list_of_courses_is_whole():
    assert {name for name, *_ in COURSES} == {path.name for path in TEAMS.iterdir()} - {"README.md"}


@needs_data
@pytest.mark.parametrize("name, flags, length, closed", COURSES)
def test_courses_that_teams_digitised_come_in(tmp_path, name, flags, length, closed):
    said = imported(tmp_path, TEAMS / name, *flags)
    assert said["length_m"] == pytest.approx(length, rel=0.025) and said["closed"] == closed
    assert 5.0 < said["length_m"] / said["lap_time_s"] < 25.0


@needs_data
@pytest.mark.parametrize("year", [2015, 2016])
def test_points_and_curvature_of_lincoln_give_one_lap_time(tmp_path, year):
    points = imported(tmp_path, TEAMS / f"lincoln_{year}_endurance_m.csv.gz")
    curvature = imported(tmp_path, TEAMS / f"endurance_lincoln_{year}_curvature_m.csv.gz")
    assert points["lap_time_s"] == pytest.approx(curvature["lap_time_s"], rel=0.005)
    assert points["tightest_radius_m"] == pytest.approx(curvature["tightest_radius_m"], rel=0.05)


@needs_data
def test_segments_of_teams_come_in_as_they_are(tmp_path):
    source = TEAMS / "michigan_2021_endurance_segments.csv"
    voltlap("track", "import", source, "--out", tmp_path / "course.csv")
    with open(source, encoding="utf-8-sig") as was, open(tmp_path / "course.csv", encoding="utf-8") as file:
        rows = [[row["type"], float(row["section_length_m"])] for row in csv.DictReader(was)]
        found = [[row["type"], float(row["section_length_m"])]
                 for row in csv.DictReader(line for line in file if line[0] != "#")]
    assert found == [row for row in rows if row[1] > 0.0]
