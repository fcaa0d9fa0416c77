# SPDX-License-Identifier: Apache-2.0
"""Sees to it that nothing of a guest is left: its processes, and its folder when the runner itself is killed."""
import contextlib
import os
import shutil
import signal
import time

GRACE_S = 3.0


def members(group):
    """Processes of a group that are not dead yet."""
    found = []
    for name in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open(f"/proc/{name}/stat", encoding="ascii", errors="replace") as file:
                state, _, its_group = file.read().rpartition(")")[2].split()[:3]
        except OSError:
            continue
        if int(its_group) == group and state not in "ZX":
            found.append(int(name))
    return found


def end_group(group):
    limit = time.monotonic() + GRACE_S
    while members(group) and time.monotonic() < limit:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(group, signal.SIGKILL)
        time.sleep(0.005)


class Guard:
    """A process that clears up when the runner itself is killed; asleep until then."""

    def __init__(self, group, folder):
        watched, self._held = os.pipe()
        self._process = os.fork()
        if self._process == 0:
            try:
                os.setsid()
                os.closerange(0, watched)
                os.closerange(watched + 1, os.sysconf("SC_OPEN_MAX"))
                if not os.read(watched, 1):
                    self._clear_up(group, folder)
            finally:
                os._exit(0)
        os.close(watched)

    @staticmethod
    def _clear_up(group, folder):
        limit = time.monotonic() + GRACE_S  # most guests notice and switch themselves off
        while time.monotonic() < limit and members(group):
            time.sleep(0.05)
        end_group(group)
        shutil.rmtree(folder, ignore_errors=True)

    def dismiss(self):
        os.write(self._held, b"!")
        os.waitpid(self._process, 0)
        os.close(self._held)
