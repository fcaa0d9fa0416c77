# SPDX-License-Identifier: Apache-2.0
"""Includes go one way: base <- codec <- {bms, master} <- app; ports stand beside the logic, which never sees one; firmware
and plant meet only in frames."""
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
}
FIRMWARE_HOST = "firmware/port/host/"  # behind the seams on Linux: the system's headers are allowed there, and only there
FIRMWARE_SYSTEM = {"cstdint", "cstddef", "limits", "type_traits"}
# The plant talks to the firmware in frames: the wire, its seal, and, where the processes are put together, the nodes.
PLANT_FROM_FIRMWARE = {"base", "codec", "can_dbc"}
JOINED = {"apps": {"app", "bms", "master", "config", "port"}, "bus": {"port"}}


def wrong_includes(path, text):
    """Every include of the file `path` (relative to the root) that goes against the direction."""
    parts = pathlib.PurePosixPath(path).parts
    area, part = parts[0], parts[1]
    quoted = [(name, name.split("/")[0]) for name in QUOTED.findall(text)]
    if area == "firmware":
        allowed = FIRMWARE[part] | {part}
        wrong = [name for name, first in quoted if first not in allowed]
        if path.startswith(FIRMWARE_HOST):
            return wrong
        wrong += [name for name, _ in quoted if name.startswith("port/host/")]
        return wrong + [name for name in ANGLED.findall(text) if name not in FIRMWARE_SYSTEM]
    own = {entry.name for entry in (ROOT / "plant_sim").iterdir() if entry.is_dir()}
    allowed = own | PLANT_FROM_FIRMWARE | JOINED.get(part, set())
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


PLANTED = {
    "master may not see the BMS": ("firmware/master/x.cpp", '#include "bms/config.hpp"'),
    "BMS may not see the master": ("firmware/bms/x.hpp", '#include "master/io.hpp"'),
    "base stands alone": ("firmware/base/x.hpp", '#include "codec/seal.hpp"'),
    "codec may not see a node": ("firmware/codec/x.hpp", '  #  include "app/bms_node.hpp"'),
    "logic may not see a port": ("firmware/bms/x.cpp", '#include "port/can.hpp"'),
    "a seam may not see what stands behind it": ("firmware/port/can.hpp", '#include "port/host/socket_can.hpp"'),
    "a seam may not see the system": ("firmware/port/can.hpp", "#include <linux/can.h>"),
    "a port may not see a node": ("firmware/port/host/x.cpp", '#include "app/bms_node.hpp"'),
    "a study may not see a port": ("plant_sim/study/x.cpp", '#include "port/host/socket_can.hpp"'),
    "a study may not see a node": ("plant_sim/study/x.cpp", '#include "app/bms_node.hpp"'),
    "app may not see the plant": ("firmware/app/x.cpp", '#include "battery/cell.hpp"'),
    "no heap through the library": ("firmware/app/x.cpp", "#include <vector>"),
    "the plant's battery may not see the BMS": ("plant_sim/battery/x.cpp", '#include "bms/config.hpp"'),
}


@pytest.mark.parametrize("name", PLANTED)
def test_a_planted_include_is_refused(name):
    path, text = PLANTED[name]
    assert wrong_includes(path, text)


def test_the_right_direction_is_accepted():
    assert wrong_includes("firmware/app/x.cpp", '#include "bms/config.hpp"\n#include <cstdint>') == []
    assert wrong_includes("firmware/port/host/x.cpp", '#include "port/can.hpp"\n#include <linux/can.h>') == []
    assert wrong_includes("plant_sim/apps/x.cpp", '#include "app/bms_node.hpp"\n#include <vector>') == []
    assert wrong_includes("plant_sim/bus/x.cpp", '#include "port/host/socket_can.hpp"') == []
