# SPDX-License-Identifier: Apache-2.0
"""Copies of the project for tests that build or leave files behind, and what else the suites here share."""
import pathlib
import shutil
import signal

HANG_S = 300.0  # only a hang takes as long, however busy the machine
PROJECT = pathlib.Path(__file__).resolve().parents[2]


LEFT_OUT = ("build", ".git", "__pycache__", ".pytest_cache")
# What the start script itself never looks at.
BUILT_FROM = ("tests", "plant_sim", "firmware", "docs")


def copy_project(target, without=()):
    """The sources without build folder and history."""
    shutil.copytree(PROJECT, target, ignore=shutil.ignore_patterns(*LEFT_OUT, *without))
    return target


def hear_interruptions():
    """For preexec_fn: a job in the background of a shell ignores Ctrl-C, and all that it starts does."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
