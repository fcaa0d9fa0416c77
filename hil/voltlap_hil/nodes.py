# SPDX-License-Identifier: Apache-2.0
"""Plant and ECUs as processes of a run: started, watched, killed by a scenario, and ended with it."""
from __future__ import annotations

import os
import subprocess
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from .errors import HilError, InputError

ECUS = ("bms", "master")
_END_S = 5.0


def program() -> Path:
    """$VOLTLAP_BUILD_DIR/bin/voltlap, else that of the project's default build."""
    named = os.environ.get("VOLTLAP_BUILD_DIR")
    build = Path(named) if named else Path(__file__).resolve().parents[2] / "build" / "default"
    path = build / "bin" / "voltlap"
    if not path.exists():
        raise InputError(f"{path} is missing. Build it with `./voltlap build`, or set VOLTLAP_BUILD_DIR.")
    return path


class Nodes:
    def __init__(self) -> None:
        self._running: dict[str, subprocess.Popen[bytes]] = {}
        self._output: dict[str, Path] = {}
        self._folder = tempfile.TemporaryDirectory(prefix="voltlap-hil-")

    def start(self, name: str, arguments: Sequence[str]) -> None:
        if name in self._running:
            raise HilError(f"{name} runs already")
        self._output[name] = Path(self._folder.name) / f"{name}.txt"
        with self._output[name].open("wb") as output:
            self._running[name] = subprocess.Popen([str(program()), *arguments], stdin=subprocess.DEVNULL,
                                                   stdout=output, stderr=subprocess.STDOUT)

    def kill(self, name: str) -> None:
        """At once, as a node dies that loses its supply."""
        if name not in self._running:
            raise InputError(f"no node {name!r} runs here; running: {', '.join(self._running) or 'none'}")
        process = self._running.pop(name)
        process.kill()
        process.wait()

    def check_alive(self) -> None:
        for name, process in self._running.items():
            if process.poll() is not None:
                raise HilError(f"{name} ended with exit code {process.returncode}: {self.output(name)}")

    def output(self, name: str) -> str:
        text = self._output[name].read_text(errors="replace").strip()
        return text[-2000:] or "it wrote nothing"

    def stop(self) -> None:
        """Asks every process to end now."""
        for process in self._running.values():
            process.terminate()
        self.close()

    def close(self) -> None:
        """Waits for the plant's own end and then for that of the others; what still runs is ended here."""
        plant = self._running.get("plant")
        alone = plant is None or plant.poll() is not None
        give_up = time.monotonic() + (0.0 if alone else _END_S)
        for process in sorted(self._running.values(), key=lambda p: p is not plant):
            try:
                process.wait(max(0.1, give_up - time.monotonic()))
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        self._running.clear()
        self._folder.cleanup()
