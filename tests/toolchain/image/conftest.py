# SPDX-License-Identifier: Apache-2.0
"""Images for all tests of this folder, built once."""
import os
import pathlib
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "toolchain"))
import image_build  # noqa: E402

HOST = pathlib.Path(os.environ["VOLTLAP_BUILD_DIR"])
VOLTLAP = HOST / "bin" / "voltlap"


@pytest.fixture(scope="session")
def kind_of():
    """cells -> the Kind, built."""
    built = {}

    def kind(cells=None):
        if cells not in built:
            built[cells] = image_build.Kind(cells=cells)
            image_build.build(built[cells])
        return built[cells]

    return kind


@pytest.fixture(scope="session")
def image_of(kind_of):
    return lambda name, cells=None: kind_of(cells).image(name)


def tool(name, *arguments, **settings):
    return subprocess.run([sys.executable, ROOT / "toolchain" / name, *map(str, arguments)], capture_output=True,
                          text=True, **settings)
