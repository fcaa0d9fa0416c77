# SPDX-License-Identifier: Apache-2.0
"""Sees to it that nothing of a guest is left: its processes, and its folder when the runner itself is killed."""
import contextlib
import glob
import os
import shutil
import signal
import time

NOTICE_S = 3.0  # a guest that sees its line end switches itself off
END_LIMIT_S = 60.0  # a killed process is gone at once, on a busy machine in seconds


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
    limit = time.monotonic() + END_LIMIT_S
    while members(group) and time.monotonic() < limit:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(group, signal.SIGKILL)
        time.sleep(0.005)


class Guard:
    """A process that clears up when the runner itself is killed; asleep until then.

    It is there before anything that it clears up: folders whose names match `pattern`, and the group of processes that
    it is told to watch.
    """

    def __init__(self, pattern):
        self.pattern = pattern
        watched, self._held = os.pipe()
        self._process = os.fork()
        if self._process == 0:
            try:
                os.setsid()
                os.closerange(0, watched)
                os.closerange(watched + 1, os.sysconf("SC_OPEN_MAX"))
                self._sleep(watched, pattern)
            finally:
                os._exit(0)
        os.close(watched)

    @staticmethod
    def _sleep(watched, pattern):
        """What the runner says: numbers of groups, a line each, and at its own end a full stop."""
        said = b""
        while heard := os.read(watched, 64):
            said += heard
        if not said.endswith(b"."):
            clear_up([int(group) for group in said.split()], pattern)

    def watch_me(self):
        """For preexec_fn of the leader of a group: before it is a program that the guard could not know of."""
        os.write(self._held, b"%d\n" % os.getpid())

    def dismiss(self):
        os.write(self._held, b".")
        os.close(self._held)
        os.waitpid(self._process, 0)


def clear_up(groups, pattern):
    limit = time.monotonic() + NOTICE_S
    while time.monotonic() < limit and any(map(members, groups)):
        time.sleep(0.05)
    for group in groups:
        end_group(group)
    limit = time.monotonic() + END_LIMIT_S
    while (folders := glob.glob(pattern)) and time.monotonic() < limit:  # a compiler may still write there
        for folder in folders:
            shutil.rmtree(folder, ignore_errors=True)
        time.sleep(0.005)
