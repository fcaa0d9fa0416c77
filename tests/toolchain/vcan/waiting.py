# SPDX-License-Identifier: Apache-2.0
"""Waiting for what has happened, not for a time in which it should have: the machine may be busy."""
import time

HANG_S = 300.0  # only a hang takes as long


def wait_until(condition):
    """The first value of the condition that is true."""
    limit = time.monotonic() + HANG_S
    while time.monotonic() < limit:
        if value := condition():
            return value
        time.sleep(0.02)
    raise AssertionError("waited in vain")


def until_heard(interface):
    """Words of a shell: until somebody listens to every frame of the interface."""
    return f"until grep -q ' {interface} ' /proc/net/can/rcvlist_all; do sleep 0.05; done"
