# SPDX-License-Identifier: Apache-2.0
"""Includes go one way. Firmware: base <- codec <- {bms, master} <- app; ports stand beside the logic, which never sees
one. Plant: core <- {car, io} <- race <- {charge, replay, learn, explain} <- apps. The two meet only in
frames, and in apps/."""
import pathlib
import re

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
QUOTED = re.compile(r'^\s*#\s*include\s+"([^"]+)"', re.MULTILINE)
ANGLED = re.compile(r"^\s*#\s*include\s+<([^>]+)>", re.MULTILINE)

# What each part of the firmware may include besides itself.
FIRMWARE = {
    "base": set(),
    "codec": {"base", "can_dbc"},
    "config": {"base", "can_dbc", "bms", "master"},
    "bms": {"base", "codec", "can_dbc"},
    "master": {"base", "codec", "can_dbc"},
    "app": {"base", "codec", "config", "bms", "master", "can_dbc"},
    "port": {"base", "can_dbc"},
    "examples": {"base", "codec", "bms", "master", "app", "port", "can_dbc"},
}
# Of the image's own folder or made for it at build time.
FIRMWARE_OF_THE_IMAGE = {"pack_config.hpp", "master_config.hpp"}
FIRMWARE_HOST = "firmware/port/host/"  # behind the seams on Linux: the system's headers are allowed here alone
FIRMWARE_SYSTEM = {"cstdint", "cstddef", "limits", "type_traits"}
# What each flow of the plant may include besides itself: a row a flow.
PLANT = {
    "core": set(),
    "car": {"core"},
    "io": {"core"},
    "race": {"core", "car", "io"},
    "charge": {"core", "car", "io", "race"},
    "replay": {"core", "car", "io", "race"},
    "learn": {"core", "car", "io", "race"},
    "explain": {"core", "car", "io", "race"},
    "apps": {"core", "car", "io", "race", "charge", "replay", "learn", "explain"},
}
# The plant talks to the firmware in frames: the wire, its seal; on Linux the port; the nodes only where processes are
# put together.
PLANT_FROM_FIRMWARE = {
    "io": {"base", "codec", "can_dbc", "port"},
    "race": {"base", "codec", "can_dbc"},
    "charge": {"base", "codec", "can_dbc"},
    "replay": {"base", "codec", "can_dbc"},
    "apps": {"base", "codec", "can_dbc", "port", "app", "bms", "master", "config"},
}


def wrong_includes(path, text):
    """Every include of the file `path` (relative to the root) that goes against the direction."""
    parts = pathlib.PurePosixPath(path).parts
    area, part = parts[0], parts[1]
    quoted = [(name, name.split("/")[0]) for name in QUOTED.findall(text)]
    if area == "firmware":
        allowed = FIRMWARE[part] | {part}
        wrong = [name for name, first in quoted if first not in allowed and name not in FIRMWARE_OF_THE_IMAGE]
        if path.startswith(FIRMWARE_HOST):
            return wrong
        wrong += [name for name, _ in quoted if name.startswith("port/host/")]
        return wrong + [name for name in ANGLED.findall(text) if name not in FIRMWARE_SYSTEM]
    allowed = {part} | PLANT[part] | PLANT_FROM_FIRMWARE.get(part, set())
    return [name for name, first in quoted if first not in allowed]


def sources(area):
    files = [path for pattern in ("*.hpp", "*.cpp") for path in (ROOT / area).rglob(pattern)]
    return sorted(str(path.relative_to(ROOT)) for path in files)


@pytest.mark.parametrize("area", ["firmware", "plant_sim"])
def test_includes_go_one_way(area):
    files = sources(area)
    assert files
    wrong = {name: found for name in files if (found := wrong_includes(name, (ROOT / name).read_text()))}
    assert wrong == {}


def test_every_flow_has_its_row():
    """A new folder is refused until somebody has said what it may include."""
    flows = {path.split("/")[1] for path in sources("plant_sim")}
    assert flows <= PLANT.keys()


def test_learn_and_explain_never_meet():
    assert "learn" not in PLANT["explain"] and "explain" not in PLANT["learn"]


PLANTED = {
    "master may not see the BMS": ("firmware/master/x.cpp", '#include "bms/config.hpp"'),
    "BMS may not see the master": ("firmware/bms/x.hpp", '#include "master/io.hpp"'),
    "base stands alone": ("firmware/base/x.hpp", '#include "codec/seal.hpp"'),
    "codec may not see a node": ("firmware/codec/x.hpp", '  #  include "app/bms_node.hpp"'),
    "logic may not see a port": ("firmware/bms/x.cpp", '#include "port/can.hpp"'),
    "a seam may not see what stands behind it": ("firmware/port/can.hpp", '#include "port/host/socket_can.hpp"'),
    "a seam may not see the system": ("firmware/port/can.hpp", "#include <linux/can.h>"),
    "a port may not see a node": ("firmware/port/host/x.cpp", '#include "app/bms_node.hpp"'),
    "the race may not see a port": ("plant_sim/race/x.cpp", '#include "port/host/socket_can.hpp"'),
    "the race may not see a node": ("plant_sim/race/x.cpp", '#include "app/bms_node.hpp"'),
    "app may not see the plant": ("firmware/app/x.cpp", '#include "car/battery/pack.hpp"'),
    "no heap through the library": ("firmware/app/x.cpp", "#include <vector>"),
    "the plant's battery may not see the BMS": ("plant_sim/car/battery/x.cpp", '#include "bms/config.hpp"'),
    "the car may not see frames": ("plant_sim/car/x.hpp", '#include "can_dbc/car.hpp"'),
}


@pytest.mark.parametrize("name", PLANTED)
def test_a_planted_include_is_refused(name):
    path, text = PLANTED[name]
    assert wrong_includes(path, text)


def plant_directions():
    """Every flow that a flow may not include."""
    return [(part, other) for part in PLANT for other in PLANT if other != part and other not in PLANT[part]]


@pytest.mark.parametrize("part, other", plant_directions())
def test_a_planted_include_of_another_flow_is_refused(part, other):
    assert wrong_includes(f"plant_sim/{part}/sub/x.hpp", f'#include "{other}/sub/y.hpp"')


@pytest.mark.parametrize("part, other", [(part, other) for part in PLANT for other in PLANT[part]])
def test_an_include_in_the_stated_order_is_accepted(part, other):
    assert wrong_includes(f"plant_sim/{part}/x.cpp", f'#include "{other}/y.hpp"') == []


def test_the_order_has_no_circle():
    """Whoever is included never includes back, over however many flows."""
    reached = {part: set(rows) for part, rows in PLANT.items()}
    for _ in PLANT:
        for part, rows in reached.items():
            rows |= set().union(*(reached[other] for other in rows))
    assert all(part not in rows for part, rows in reached.items())


def test_the_right_direction_is_accepted():
    assert wrong_includes("firmware/app/x.cpp", '#include "bms/config.hpp"\n#include <cstdint>') == []
    assert wrong_includes("firmware/port/host/x.cpp", '#include "port/can.hpp"\n#include <linux/can.h>') == []
    assert wrong_includes("plant_sim/apps/x.cpp", '#include "app/bms_node.hpp"\n#include <vector>') == []
    assert wrong_includes("plant_sim/io/bus/x.cpp", '#include "port/host/socket_can.hpp"') == []
