#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The picture of the report in docs/: `python3 toolchain/screenshot_report.py`, with the program built and Chromium there."""
import argparse
import pathlib
import subprocess
import tempfile

from chromium import Chromium

PROJECT = pathlib.Path(__file__).resolve().parent.parent
WIDTH, HEIGHT = 1280, 1230
LAP = 5  # what the charts show is one lap: a curve says more than a band


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--binary", default=PROJECT / "build/default/bin/voltlap", help="program that writes the report")
    parser.add_argument("--output", default=PROJECT / "docs/report.png", help="PNG to write")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder, Chromium() as browser:
        report = pathlib.Path(folder) / "report.html"
        subprocess.run([arguments.binary, "endurance", "--report", report], check=True, stdout=subprocess.DEVNULL)
        page = browser.page(report.as_uri(), WIDTH, HEIGHT)
        page.wait_for("document.documentElement?.dataset.ready")
        page.run(f"document.querySelector('#laps tr[data-lap=\"{LAP}\"] button').click()")
        page.run("scrollTo(0, 0)")
        page.settle()
        page.picture(arguments.output)


if __name__ == "__main__":
    main()
