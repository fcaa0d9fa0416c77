# SPDX-License-Identifier: Apache-2.0
"""The car whose configuration an image has: its headers, and where its images lie."""
import hashlib
import json
import os
import re
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import image_build
from image_build import Kind, Refused

HOST = Path(os.environ.get("VOLTLAP_BUILD_DIR", image_build.ROOT / "build" / "default"))
EXAMPLE, EXAMPLE_FOLDER = "vtm16e", image_build.ROOT / "firmware" / "examples"
HEADERS = ("pack_config.hpp", "master_config.hpp")
NAME_MOST = 60  # of a folder's name that a person reads; a number behind it tells alike ones apart


@dataclass
class Car:
    """As its headers say it."""
    asked: str            # what was named: a file, or a name
    folder: Path | None   # of the headers; None: the example car's
    label: str            # part of the name of the images' folder
    name: str
    cells: int
    bms_number: int
    master_number: int

    def __str__(self):
        return (f"{owner(self.name, self.asked)}, {self.cells} cells in series, configuration "
                f"{number_text(self.bms_number, self.master_number)}")


def owner(name, asked):
    return name if name == asked else f"{name} ({asked})"


def number_text(bms, master):
    return f"{bms:08x}-{master:08x}"


def add_flags(parser):
    parser.add_argument("--cells", type=int, metavar="N",
                        help=f"most cells that the BMS has memory for, 1 to {image_build.CELLS_MOST} (default: all)")
    parser.add_argument("--vehicle", metavar="CAR", help="a car by name or file")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", dest="settings",
                        help="another value of the car; may be repeated")


def check_flags(parser, given):
    if given.cells is not None and not 1 <= given.cells <= image_build.CELLS_MOST:
        parser.error(f"--cells {given.cells}: 1 to {image_build.CELLS_MOST} are expected")


def label_of(vehicle, settings):
    """Of one car and no other: two files of one name in two folders are two cars."""
    path = Path(vehicle)
    whole = json.dumps([str(path.resolve()) if path.exists() else vehicle, *settings])
    words = re.sub(r"\W+", "_", "_".join([path.stem, *settings]))[:NAME_MOST]
    return f"{words}-{hashlib.sha256(whole.encode()).hexdigest()[:8]}"


def write_headers(vehicle, settings, folder):
    command = [HOST / "bin" / "voltlap", "firmware-tables", "--vehicle", vehicle, "--out", folder / HEADERS[0],
               "--master-out", folder / HEADERS[1]]
    for setting in settings:
        command += ["--set", setting]
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if done.returncode != 0:
        raise Refused(2, done.stderr.strip().removeprefix("voltlap: "))


def keep(made, folder):
    """Only what has changed is written: what was built from it stays built."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in HEADERS:
        text = (made / name).read_text()
        kept = folder / name
        if not kept.exists() or kept.read_text() != text:
            kept.write_text(text)


def read_headers(asked, folder, label):
    text = {name: ((folder or EXAMPLE_FOLDER) / name).read_text() for name in HEADERS}

    def field(header, pattern):
        found = re.search(pattern, text[header])
        if not found:
            raise Refused(2, f"{folder or EXAMPLE_FOLDER}/{header}: found no {pattern.split('[')[0]}; expected a "
                             "header of ./voltlap firmware-tables. Make it again.")
        return found[1]

    pack, master = HEADERS
    return Car(asked, folder, label, field(pack, r'kPackCar\[\] = "([^"]*)"'),
               int(field(pack, r"c\.cells_in_series = (\d+);")),
               int(field(pack, r"kPackNumber = (\w+?)U?;"), 0), int(field(master, r"kMasterNumber = (\w+?)U?;"), 0))


def car_of(vehicle, settings):
    """The car that was asked for, its headers written; the example car as it is without any."""
    if vehicle is None and not settings:
        return read_headers(EXAMPLE, None, "")
    vehicle = vehicle or EXAMPLE
    label = label_of(vehicle, settings)
    with tempfile.TemporaryDirectory() as made:
        write_headers(vehicle, settings, Path(made))
        folder = image_build.ROOT / "build" / "images_of" / label
        keep(Path(made), folder)
    return read_headers(" ".join([vehicle, *(f"--set {setting}" for setting in settings)]), folder, label)


def kind_of(car, cpu="cortex-m4", cells=None):
    """What is built for it. Told before the compiler does: memory for fewer cells than it has."""
    if cells is not None and cells < car.cells:
        raise Refused(2, f"--cells {cells}: found memory for {cells} cells; expected at least the {car.cells} in "
                         f"series of {owner(car.name, car.asked)}. Give --cells {car.cells}, or leave it out.")
    return Kind(cpu, cells, car.folder, car.label)
