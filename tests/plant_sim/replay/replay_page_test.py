# SPDX-License-Identifier: Apache-2.0
"""The report of a replay in a browser: the charts of firmware and log, and a row of the table shows its stretch."""
import os
import subprocess
from pathlib import Path

BUILD = Path(os.environ["VOLTLAP_BUILD_DIR"])
TIGHT = ("--set", "bms.discharge_current_max_a=120")


def voltlap(*arguments):
    return subprocess.run([BUILD / "bin/voltlap", *map(str, arguments)], capture_output=True, text=True, timeout=300)


def test_the_report_draws_and_shows_a_stretch(browser, tmp_path):
    """A lap of a car without the limit that the replayed firmware has: the current goes beyond it."""
    log, report = tmp_path / "race.log", tmp_path / "replay.html"
    assert voltlap("endurance", "--laps", 1, "--candump", log).returncode == 0
    assert voltlap("replay", log, *TIGHT, "--report", report).returncode == 1
    page = browser.page(report.as_uri(), 1280, 1230)
    page.wait_for("document.documentElement?.dataset.ready")
    assert page.run("document.querySelectorAll('#strips canvas').length") >= 5
    assert page.run("document.querySelector('h1').textContent").startswith("Not answered as recorded")
    whole = page.run("document.getElementById('view').textContent")
    page.run("document.querySelector('#disagreements button').click()")
    page.wait_for(f"document.getElementById('view').textContent !== {whole!r}")
    assert "120 A" in page.run("document.getElementById('disagreements').textContent")
    asked = page.run("performance.getEntriesByType('resource').map(entry => entry.name)")
    assert [url for url in asked if not url.startswith("data:")] == []
