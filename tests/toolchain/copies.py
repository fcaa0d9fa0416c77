# SPDX-License-Identifier: Apache-2.0
"""Copies of the project for tests that build or leave files behind."""
import pathlib
import shutil

PROJECT = pathlib.Path(__file__).resolve().parents[2]


def copy_project(target):
    """The sources without build folder and history."""
    shutil.copytree(PROJECT, target, ignore=shutil.ignore_patterns("build", ".git", "__pycache__", ".pytest_cache"))
    return target
