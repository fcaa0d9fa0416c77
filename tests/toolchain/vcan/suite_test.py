# SPDX-License-Identifier: Apache-2.0
"""A suite that CMake has put behind the runner finds what it was promised."""
import os
import socket
import subprocess


def test_vcan0_and_vcan1_carry_frames():
    for name in ("vcan0", "vcan1"):
        sender = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
        listener = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
        with sender, listener:
            listener.settimeout(5)
            for end in (sender, listener):
                end.bind((name,))
            subprocess.run(["cansend", name, "123#0102"], check=True)
            assert listener.recv(16)[8:10] == b"\x01\x02"


def test_build_folder_is_known_inside():
    assert os.path.isfile(os.path.join(os.environ["VOLTLAP_BUILD_DIR"], "CMakeCache.txt"))
