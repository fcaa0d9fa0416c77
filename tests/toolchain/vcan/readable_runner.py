# SPDX-License-Identifier: Apache-2.0
"""The runner for tests that play another user, who may read neither a private home with the project in it nor its
virtual environment."""
import atexit
import os
import shutil
import sys
import tempfile
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[3] / "toolchain" / "vcan"


def readable_runner():
    """Command line of a copy that everybody may read, removed at the end."""
    folder = Path(tempfile.mkdtemp(prefix="voltlap-runner-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    folder.chmod(0o755)
    shutil.copytree(SOURCE, folder / "vcan", ignore=shutil.ignore_patterns("__pycache__"))
    python = "/usr/bin/python3" if os.path.exists("/usr/bin/python3") else sys.executable
    return [python, str(folder / "vcan" / "with_vcan.py")]
