# SPDX-License-Identifier: Apache-2.0
"""The mutated copy of the project: its sources, its build folder, and what the compiler says of them."""
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

PARTS = Path(__file__).resolve().parent
COPIED = ("CMakeLists.txt", "can_dbc", "firmware", "tests")
LINKED = ("plant_sim", "toolchain", "hil")
BLOCK = 2000  # numbers that a file has for its mutants, so that an edit of one file leaves those of the others
MESSAGE = re.compile(r"(/[^\s:]+|[^\s:]+):(\d+):\d+: (?:error|  required from here|.*required from)")


class Broken(Exception):
    """The build or the tests are not sound to begin with."""


def write_if_other(path, data):
    if not path.exists() or path.read_bytes() != data:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)


def suites_of(build, with_ports):
    """Targets of tests/firmware."""
    text = (build / "compile_commands.json").read_text()
    found = re.findall(r" -o tests/firmware/(\w+)[^ ]*?CMakeFiles/(\w+)\.dir/", text)
    suites = sorted({target for folder, target in found
                     if target.endswith("_test") and (with_ports or folder != "port")})
    if not suites:
        raise Broken("there is no suite in tests/firmware")
    return suites


class Tree:
    def __init__(self, root, place):
        self.root, self.source, self.build = root, place / "src", place / "build"

    def copy(self, files_max):
        """Sources as they are; a file that has gone from the project goes from the copy."""
        self.source.mkdir(parents=True, exist_ok=True)
        wanted = set()
        for part in COPIED:
            start = self.root / part
            for path in [start] if start.is_file() else sorted(start.rglob("*")):
                if path.is_file() and "__pycache__" not in path.parts:
                    name = path.relative_to(self.root)
                    wanted.add(self.source / name)
                    if name.parts[0] != "firmware" or path.suffix not in (".cpp", ".hpp"):
                        write_if_other(self.source / name, path.read_bytes())
        for part in LINKED:
            if not (self.source / part).is_symlink() and (self.root / part).exists():
                (self.source / part).symlink_to(self.root / part)
        for part in ("firmware", "tests"):
            for path in (self.source / part).rglob("*"):
                if path.is_file() and path not in wanted:
                    path.unlink()
        runner = (PARTS / "runner.cpp").read_text()
        size = f"#define VOLTLAP_MUTANTS {BLOCK * max(files_max, 1)}\n"
        write_if_other(self.source / "tests/main.cpp", (size + runner).encode())
        write_if_other(self.source / "mutation.hpp", (PARTS / "mutation.hpp").read_bytes())

    def put(self, name, data):
        write_if_other(self.source / name, data)

    def configure(self):
        for path in (self.root / "firmware").rglob("*.?pp"):
            name = path.relative_to(self.root)
            if not (self.source / name).exists():
                self.put(name, path.read_bytes())
        if not (self.build / "build.ninja").exists():
            self.run(["cmake", "-G", "Ninja", "-S", self.source, "-B", self.build, "-DCMAKE_BUILD_TYPE=Mutation",
                      "-DCMAKE_CXX_FLAGS_MUTATION=-O1", f"-DCMAKE_CXX_FLAGS=-w -include {self.source}/mutation.hpp",
                      f"-DVOLTLAP_PYTHON={sys.executable}", "-DVOLTLAP_PCH=OFF"])
        self.run(["ninja", "-C", self.build, "voltlap_can_generate"])

    def run(self, command):
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
        if done.returncode:
            raise Broken(f"{Path(command[0]).name} failed:\n{done.stdout[-4000:]}")

    def commands(self):
        """What compiles the sources of firmware/ on the host: [(name, words without the output)]."""
        found = {}
        for entry in json.loads((self.build / "compile_commands.json").read_text()):
            path = Path(entry["file"])
            if path.is_relative_to(self.source / "firmware"):
                words = shlex.split(entry["command"])
                words = words[next(i for i, word in enumerate(words) if "ccache" not in word):]
                words = words[:words.index("-o")] + words[words.index("-c"):]
                found.setdefault(str(path.relative_to(self.source)), words)
        return found

    def refused_lines(self, command):
        """Lines of the copy that the compiler refuses: {(name, line)}."""
        done = subprocess.run([*command, "-fsyntax-only"], cwd=self.build, capture_output=True, text=True, check=False)
        if done.returncode == 0:
            return set()
        lines = set()
        for path, line in MESSAGE.findall(done.stderr):
            full = Path(os.path.normpath(self.build / path))
            if full.is_relative_to(self.source / "firmware"):
                lines.add((str(full.relative_to(self.source)), int(line)))
        if not lines:
            raise Broken(done.stderr[-4000:])
        return lines

    def suites(self, with_ports):
        return suites_of(self.build, with_ports)

    def make(self, targets, jobs):
        self.run(["nice", "-n", "5", "ninja", "-C", self.build, f"-j{jobs}", *targets])

    def forget(self):
        shutil.rmtree(self.source.parent, ignore_errors=True)
