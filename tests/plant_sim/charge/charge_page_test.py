# SPDX-License-Identifier: Apache-2.0
"""The report of a charge in a browser: every curve is drawn, and nothing is asked of the network."""
import os
import subprocess
from pathlib import Path

BUILD = Path(os.environ["VOLTLAP_BUILD_DIR"])


def test_the_report_draws_its_charts(browser, tmp_path):
    report = tmp_path / "charge.html"
    charged = subprocess.run([BUILD / "bin/voltlap", "charge", "--from-soc", "97", "--soc-spread", "0.1",
                              "--capacity-spread", "0", "--report", report], capture_output=True, text=True,
                             timeout=300)
    assert charged.returncode == 0, charged.stderr
    page = browser.page(report.as_uri(), 1280, 1230)
    page.wait_for("document.documentElement?.dataset.ready")
    assert page.run("document.querySelectorAll('#strips canvas').length") >= 6
    assert page.run("document.querySelector('h1').textContent").endswith("every cell is full, and all are even.")
    assert page.run("document.querySelectorAll('dl.tiles > div').length") == 6
    asked = page.run("performance.getEntriesByType('resource').map(entry => entry.name)")
    assert [url for url in asked if not url.startswith("data:")] == []
