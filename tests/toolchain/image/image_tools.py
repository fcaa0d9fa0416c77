# SPDX-License-Identifier: Apache-2.0
"""Where things are, and how the programs of toolchain/ are called, for all tests of this folder."""
import os
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "toolchain"))

HOST = pathlib.Path(os.environ["VOLTLAP_BUILD_DIR"])
VOLTLAP = HOST / "bin" / "voltlap"


def tool(name, *arguments, **settings):
    return subprocess.run([sys.executable, ROOT / "toolchain" / name, *map(str, arguments)], capture_output=True,
                          text=True, **settings)
