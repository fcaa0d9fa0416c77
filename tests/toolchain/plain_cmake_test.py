# SPDX-License-Identifier: Apache-2.0
"""CMake without the start script: it finds the virtual environment, or does without Python."""
import os
import pathlib
import subprocess
import sys

import pytest
from copies import PROJECT, copy_project

GENERATE = [sys.executable, PROJECT / "can_dbc" / "generate.py"]
NO_PYTHON = ("-DCMAKE_DISABLE_FIND_PACKAGE_Python3=ON", "-DVOLTLAP_PYTHON=")


@pytest.fixture
def project(tmp_path):
    """A copy in a folder with blanks in its name."""
    return copy_project(tmp_path / "my project")


def cmake(project, *arguments, code=0):
    run = subprocess.run(["cmake", *map(str, arguments)], cwd=project, capture_output=True, text=True)
    assert run.returncode == code, run.stdout + run.stderr
    # CMake breaks the lines of a message.
    return " ".join((run.stdout + run.stderr).split())


def ninja_file(project):
    """What is built and how, without the marks around blanks."""
    return (project / "build/default/build.ninja").read_text().replace("$ ", " ").replace('"', "")


def test_preset_finds_the_virtual_environment_and_builds(project):
    (project / "build").mkdir()
    (project / "build" / "venv").symlink_to(sys.prefix)
    cmake(project, "--preset", "default", "-DVOLTLAP_TESTS=OFF")
    cmake(project, "--build", "--preset", "default", "--target", "voltlap_fw_codec")
    assert str(project / "build/venv/bin/python") in ninja_file(project)


def test_python_without_cantools_is_refused_with_the_remedies(project, tmp_path):
    bare = tmp_path / "bare_python"
    bare.write_text("#!/bin/sh\nexit 1\n")
    bare.chmod(0o755)
    text = cmake(project, "--preset", "default", "-DVOLTLAP_TESTS=OFF", f"-DVOLTLAP_PYTHON={bare}", code=1)
    assert "toolchain/requirements/run.txt" in text and "-DVOLTLAP_CODECS=DIR" in text


@pytest.mark.parametrize("preset", ["default", "cortex-m4"])
def test_codecs_generated_ahead_need_no_python(project, tmp_path, preset):
    codecs = tmp_path / "codecs made ahead"
    subprocess.run([*GENERATE, "--out", codecs], check=True)
    cmake(project, "--preset", preset, "-DVOLTLAP_TESTS=OFF", f"-DVOLTLAP_CODECS={codecs}", *NO_PYTHON)
    cmake(project, "--build", "--preset", preset, "--target", "voltlap_fw_codec")
    assert not (project / "build" / preset / "can_dbc" / "generated").exists()


def test_codecs_generated_ahead_are_those_of_the_build(tmp_path):
    subprocess.run([*GENERATE, "--out", tmp_path], check=True)
    built = pathlib.Path(os.environ["VOLTLAP_BUILD_DIR"]) / "can_dbc" / "generated" / "can_dbc"
    headers = {path.name: path.read_text() for path in built.glob("*.hpp")}
    assert headers == {path.name: path.read_text() for path in (tmp_path / "can_dbc").iterdir()}


def test_missing_codec_is_named_with_the_command_that_writes_it(project, tmp_path):
    text = cmake(project, "--preset", "default", "-DVOLTLAP_TESTS=OFF", f"-DVOLTLAP_CODECS={tmp_path}", *NO_PYTHON,
                 code=1)
    assert "car.hpp does not exist" in text and "can_dbc/generate.py --out DIR" in text


def test_toml_headers_of_the_project_serve_where_the_distribution_has_none(project, tmp_path):
    cmake(project, "--preset", "default", "-DVOLTLAP_TESTS=OFF", f"-DVOLTLAP_PYTHON={sys.executable}",
          "-DCMAKE_DISABLE_FIND_PACKAGE_tomlplusplus=ON")
    vendored = project / "plant_sim" / "core" / "vendor"
    assert f"-isystem {vendored}" in ninja_file(project)
    source = tmp_path / "reads_toml.cpp"
    source.write_text("#include <toml++/toml.h>\nint main() { return toml::parse(\"a = 0\")[\"a\"].value_or(1); }\n")
    run = subprocess.run(["g++", "-std=c++20", "-H", "-fsyntax-only", "-isystem", vendored, source],
                         capture_output=True, text=True)
    assert run.returncode == 0 and "/usr/include/toml++" not in run.stderr, run.stderr
