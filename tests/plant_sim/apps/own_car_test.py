# SPDX-License-Identifier: Apache-2.0
"""A team's car on a team's course, from nothing to a report, by the commands that docs/own_car.md lists."""
import json
import os
import pathlib
import re
import shlex
import subprocess

import pytest

PROJECT = pathlib.Path(__file__).resolve().parents[3]
BUILD = pathlib.Path(os.environ["VOLTLAP_BUILD_DIR"])
PAGE = (PROJECT / "docs" / "own_car.md").read_text()
COMMANDS = re.search(r"```sh\n(.*?)```", PAGE, re.S).group(1).splitlines()


@pytest.fixture(scope="module")
def lincoln():
    data = os.environ.get("VOLTLAP_DATA")
    if not data:
        pytest.skip("VOLTLAP_DATA names no folder with recordings")
    return pathlib.Path(data) / "fsae_tracks" / "lincoln_2015_endurance_m.csv.gz"


def test_ten_commands_lead_from_points_to_a_report(lincoln, tmp_path):
    assert len(COMMANDS) <= 10
    for line in COMMANDS:
        words = [str(lincoln) if word.startswith("docs/tracks/") else word for word in shlex.split(line)]
        assert words[0] == "./voltlap"
        done = subprocess.run([BUILD / "bin" / "voltlap", *words[1:]], cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == 0, f"{line}\n{done.stdout}{done.stderr}"
    full, saving = (json.loads((tmp_path / f"{name}.json").read_text()) for name in ("ours", "saving"))
    assert full["laps"] == saving["laps"] == 14
    for run, kw in ((full, 79), (saving, 40)):
        row = next(line for line in PAGE.splitlines() if line.startswith(f"| {kw} kW "))
        shown = [float(number) for number in re.findall(r"\| ([\d.]+)", row)[1:]]
        assert shown == pytest.approx([run["total_time_s"], run["end_soc_pct"], run["max_battery_temp_c"]], abs=0.06)
    for report in ("ours.html", "compare.html"):
        assert "</html>" in (tmp_path / report).read_text()
