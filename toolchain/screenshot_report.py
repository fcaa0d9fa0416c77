#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Pictures of reports in docs/: `python3 toolchain/screenshot_report.py`, with the program built and Chromium there."""
import argparse
import os
import pathlib
import subprocess
import sys
import tempfile

from chromium import Chromium
from outputs import output_folder

PROJECT = pathlib.Path(__file__).resolve().parent.parent
LAP = 5  # what the charts show is one lap: a curve says more than a band


def endurance(binary, folder, browser):
    report = folder / "report.html"
    subprocess.run([binary, "endurance", "--report", report], check=True, stdout=subprocess.DEVNULL)
    page = browser.page(report.as_uri(), 1280, 1230)
    page.wait_for("document.documentElement?.dataset.ready")
    page.run(f"document.querySelector('#laps tr[data-lap=\"{LAP}\"] button').click()")
    page.run("scrollTo(0, 0)")
    return page


def charge(binary, folder, browser):
    report = folder / "charge.html"
    subprocess.run([binary, "charge", "--from-soc", "10", "--report", report], check=True, stdout=subprocess.DEVNULL)
    page = browser.page(report.as_uri(), 1280, 1230)
    page.wait_for("document.documentElement?.dataset.ready")
    return page


def compare(binary, folder, browser):
    """A car, the same car lighter, and the same car on less current."""
    runs = {"base": [], "lighter": ["vehicle.mass_kg=225"], "120_ampere": ["bms.discharge_current_max_a=120"]}
    for name, settings in runs.items():
        flags = [word for setting in settings for word in ("--set", setting)]
        subprocess.run([binary, "endurance", "--json", folder / f"{name}.json", *flags], check=True,
                       stdout=subprocess.DEVNULL)
    report = folder / "compare.html"
    subprocess.run([binary, "compare", *(folder / f"{name}.json" for name in runs), "--report", report], check=True,
                   stdout=subprocess.DEVNULL)
    page = browser.page(report.as_uri(), 1280, 1230)
    page.wait_for("document.documentElement?.dataset.ready")
    page.run(f"document.getElementById('lap').value = '{LAP - 1}'")
    page.run("document.getElementById('lap').dispatchEvent(new Event('change'))")
    return page


def explain(binary, folder, browser):
    """The example of docs/explain.md, as it stands there."""
    text = (PROJECT / "docs" / "explain.md").read_text(encoding="utf-8")
    commands = text.split("```sh\n", 1)[1].split("```", 1)[0].replace("./voltlap", str(binary))
    subprocess.run(["bash", "-e", "-c", commands], check=True, cwd=folder, stdout=subprocess.DEVNULL,
                   stderr=subprocess.DEVNULL)
    page = browser.page((folder / "why.html").as_uri(), 1280, 1230)
    page.wait_for("document.documentElement?.dataset.ready")
    return page


def replay(log, words, role_map="uwfe_can_bms"):
    """A recording of docs/replay.md with its pack, at the row of the table that has these words."""
    def picture(binary, folder, browser):
        pack, report = folder / "pack.toml", folder / "replay.html"
        text = (PROJECT / "docs" / "replay.md").read_text(encoding="utf-8")
        pack.write_text(text.split("```toml\n", 1)[1].split("```", 1)[0], encoding="utf-8")
        recording = pathlib.Path(os.environ["VOLTLAP_DATA"]) / "uwfe_canlogs" / log
        subprocess.run([binary, "replay", recording, "--map", role_map, "--pack", pack, "--report", report],
                       check=True, stdout=subprocess.DEVNULL)
        page = browser.page(report.as_uri(), 1280, 1230)
        page.wait_for("document.documentElement?.dataset.ready")
        page.run(f"[...document.querySelectorAll('#disagreements tr')].find(row => row.textContent.includes('{words}'))"
                 ".querySelector('button').click()")
        page.run("scrollTo(0, 0)")
        return page
    return picture


def orion(binary, folder, browser):
    """The log of docs/orion.md with the pack that is made of its profile."""
    data, pack, report = pathlib.Path(os.environ["VOLTLAP_DATA"]), folder / "pack.toml", folder / "replay.html"
    data = data / "orion2_conversion_candump"
    subprocess.run([sys.executable, PROJECT / "plant_sim/python/orion.py", "import", data / "UpdatedProfile.o2bms",
                    "--output", pack], check=True, stdout=subprocess.DEVNULL)
    subprocess.run([binary, "replay", data / "candump-2025-11-22_161709.trc.gz", "--map", "orion2_conversion_can",
                    "--pack", pack, "--report", report], check=True, stdout=subprocess.DEVNULL)
    page = browser.page(report.as_uri(), 1280, 1230)
    page.wait_for("document.documentElement?.dataset.ready")
    return page


PICTURES = {"report": endurance, "charge": charge, "compare": compare, "explain": explain,
            "replay_weak_cell": replay("A_postregen_193.candump.log.gz", "falls to"),
            "orion": orion,
            "replay_soc_jump": replay("B_pitt_autox_24.candump.log.gz", "SOC jumps"),
            "replay_corrupt_frames": replay("F_april2025_glitchy_11.TXT.gz", "cell 4 falls", "uwfe_inverter_current")}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(PICTURES)}; without: all")
    parser.add_argument("--binary", type=pathlib.Path, default=PROJECT / "build/default/bin/voltlap",
                        help="program that writes the reports")
    parser.add_argument("--output", type=output_folder, default=PROJECT / "docs", help="folder of the PNG files")
    arguments = parser.parse_args()
    if unknown := set(arguments.names) - set(PICTURES):
        parser.error(f"no picture {', '.join(sorted(unknown))}; there are {', '.join(PICTURES)}")
    with tempfile.TemporaryDirectory() as folder, Chromium() as browser:
        for name in arguments.names or PICTURES:
            page = PICTURES[name](arguments.binary.resolve(), pathlib.Path(folder), browser)
            page.settle()
            page.picture(arguments.output / f"{name}.png")


if __name__ == "__main__":
    main()
