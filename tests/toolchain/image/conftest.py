# SPDX-License-Identifier: Apache-2.0
"""Images for all tests of this folder, built once."""
import image_tools  # noqa: F401  (the path to toolchain/)
import pytest

import image_build


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
