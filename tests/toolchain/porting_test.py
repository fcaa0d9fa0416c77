# SPDX-License-Identifier: Apache-2.0
"""docs/porting.md, followed to the letter for a Cortex-M7: every command of it, in a copy of the project."""
import os
import pathlib
import re
import shutil
import subprocess

import pytest
from copies import PROJECT, copy_project

GUIDE = PROJECT / "docs" / "porting.md"
CODECS = pathlib.Path(os.environ["VOLTLAP_BUILD_DIR"]) / "can_dbc" / "generated"


def commands():
    return [line for block in re.findall(r"```bash\n(.*?)```", GUIDE.read_text(), re.S) for line in block.splitlines()]


@pytest.fixture(scope="module")
def project(tmp_path_factory):
    if not shutil.which("arm-none-eabi-g++"):
        pytest.skip("arm-none-eabi-g++ is not installed")
    return copy_project(tmp_path_factory.mktemp("porting") / "voltlap", without=("tests", "plant_sim", "hil", "docs"))


def run(command, project, code=0):
    done = subprocess.run(["bash", "-c", command], cwd=project, capture_output=True, text=True)
    assert done.returncode == code, command + "\n" + done.stdout + done.stderr
    return done.stdout + done.stderr


def test_the_guide_ends_in_an_image_that_links(project):
    steps = commands()
    assert len(steps) == 6 and steps[0].startswith("cp -r firmware/port/template")
    for command in steps:
        if command.startswith("cmake --preset"):  # the guide's own way for where there is no Python
            command += f" -DVOLTLAP_CODECS={CODECS}"
        if command.startswith("cmake --build"):
            command += " -- -j2 both_nodes_my_board bms_node_my_board master_node_my_board"
        printed = run(command, project)
        assert "warning" not in printed
    assert {int(n) for n in re.findall(r"FILL (\d)", printed)} == {1, 2, 3, 4, 5, 6}
    for image in ("both_nodes", "bms_node", "master_node"):
        elf = project / "build" / "cortex-m7" / "images" / f"{image}_my_board.elf"
        attributes = run(f"arm-none-eabi-readelf -A {elf}", project)
        assert 'Tag_CPU_name: "7E-M"' in attributes or "Cortex-M7" in attributes or "v7E-M" in attributes
    objects = " ".join(str(path) for path in (project / "build" / "cortex-m7").rglob("*.a"))
    assert "0 findings" in run(f"toolchain/check_firmware_objects.py {objects}", project)


def test_every_fill_of_the_template_has_its_chapter():
    chapters = GUIDE.read_text()
    marks = {n for path in (PROJECT / "firmware" / "port" / "template").iterdir()
             for n in re.findall(r"FILL (\d)", path.read_text())}
    assert marks == {"1", "2", "3", "4", "5", "6"}
    for mark in marks:
        assert re.search(rf"^## .*\(FILL {mark}\)", chapters, re.M)


def test_a_board_that_is_not_there_is_told(project):
    printed = run(f"cmake --preset cortex-m7 -DVOLTLAP_BOARD=no_board -DVOLTLAP_CODECS={CODECS}", project, code=1)
    assert "firmware/port/no_board/board.cpp is not there" in " ".join(printed.split())
    assert "docs/porting.md" in printed
