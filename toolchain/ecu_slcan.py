#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Starts BMS and master controller on an emulated Cortex-M4 whose serial line speaks SLCAN, as a USB adapter does.

Without --bus it says where the line is, for slcand or python-can. With --bus it carries the frames between that line
and a CAN interface, where `voltlap plant` drives the car: both nodes step with its Sync, as `voltlap ecu` does. A board
whose plant has ended begins anew, with the records of its memory, and waits for the next one.
"""
import argparse
import re
import select
import subprocess
import sys
from pathlib import Path

import image_build
from image_build import Refused

EPILOG = """\
Examples:
  ./voltlap ecu-slcan --bus vcan0
  ./voltlap plant --bus vcan0 --members bms,master --laps 1      # in another terminal
  ./voltlap ecu-slcan
  sudo slcand -o -s6 /dev/pts/3 slcan0 && sudo ip link set slcan0 up    # the name that it says
  ./voltlap plant --bus slcan0 --members bms,master --laps 1
Exit codes: 0 ended with Ctrl-C or --once, 2 usage or input, 3 the emulator or the interface failed, 4 a program is
missing"""
EXTENDED = 0x8000_0000
SYNC, STOP_BYTE = 0x7E0, 6
START_S = 10.0


def start(image):
    """The emulator, and the name of its serial line."""
    image_build.require("qemu-system-arm", "qemu-system-arm")
    if not Path(image).is_file():
        raise Refused(2, f"--image {image}: found no such file; expected an image with SLCAN. Build it: ./voltlap "
                         "image")
    command = ["qemu-system-arm", "-M", "mps2-an386", "-display", "none", "-monitor", "none", "-parallel", "none",
               "-semihosting-config", "enable=on,target=native", "-serial", "pty", "-kernel", str(image)]
    process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    said, _, _ = select.select([process.stdout], [], [], START_S)
    line = process.stdout.readline().decode() if said else ""
    found = re.search(r"redirected to (\S+)", line)
    if not found:
        process.kill()
        raise Refused(3, f"the emulator does not start: {line.strip() or 'it says nothing'}")
    return process, found[1]


def line_of(can_id, data):
    head = f"T{can_id & ~EXTENDED:08X}" if can_id & EXTENDED else f"t{can_id:03X}"
    return f"{head}{len(data)}{data.hex().upper()}\r".encode()


def frame_of(line):
    """(identifier, data) of a line, None for what is no frame."""
    digits = {b"t": 3, b"T": 8}.get(line[:1])
    if digits is None:
        return None
    can_id = int(line[1:1 + digits], 16) | (EXTENDED if digits == 8 else 0)
    return can_id, bytes.fromhex(line[digits + 2:].decode())


class Bridge:
    """Between a serial line and a CAN interface."""

    def __init__(self, path, interface):
        import can
        import serial
        self._message = can.Message
        self._serial = serial.Serial(path, timeout=0)
        try:
            self._bus = can.Bus(channel=interface, interface="socketcan")
        except OSError as error:
            raise Refused(3, f"--bus {interface}: {error.strerror or error}; expected a CAN interface that is up. "
                             "./voltlap with-vcan makes vcan0") from None
        self._rest = b""
        self._serial.write(b"\rC\rS6\rO\r")

    def carry(self, wait_s):
        """What has come on either side; True when a plant has ended its run."""
        ready, _, _ = select.select([self._serial, self._bus], [], [], wait_s)
        stopped = self._from_bus() if self._bus in ready else False
        if self._serial in ready:
            self._from_line()
        return stopped

    def _from_bus(self):
        lines, stopped = [], False
        while (frame := self._bus.recv(0)) is not None:
            if frame.is_error_frame or frame.is_remote_frame:
                continue
            can_id = frame.arbitration_id | (EXTENDED if frame.is_extended_id else 0)
            lines.append(line_of(can_id, bytes(frame.data)))
            stopped |= can_id == SYNC and bool(frame.data[STOP_BYTE] & 1)
        self._serial.write(b"".join(lines))
        return stopped

    def _from_line(self):
        *lines, self._rest = (self._rest + self._serial.read(65536).replace(b"\a", b"\r")).split(b"\r")
        for line in lines:
            if (frame := frame_of(line)) is not None:
                can_id, data = frame
                self._bus.send(self._message(arbitration_id=can_id & ~EXTENDED, data=data,
                                             is_extended_id=bool(can_id & EXTENDED)))

    def close(self):
        self._bus.shutdown()
        self._serial.close()


def arguments():
    parser = argparse.ArgumentParser(prog="voltlap ecu-slcan", description=__doc__, epilog=EPILOG,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bus", metavar="IF", help="carry the frames to and from this CAN interface, such as vcan0")
    parser.add_argument("--once", action="store_true", help="with --bus: end with the plant's run")
    parser.add_argument("--image", metavar="FILE", default=image_build.Kind().image("both_nodes_slcan"),
                        help="an image with SLCAN; default: the one that ./voltlap image builds")
    given = parser.parse_args()
    if given.once and not given.bus:
        parser.error("--once goes with --bus, expected both or none")
    return given


def run(given):
    process, path = start(given.image)
    try:
        print(f"BMS and master controller speak SLCAN on {path}", flush=True)
        if not given.bus:
            process.wait()
        else:
            bridge = Bridge(path, given.bus)
            print(f"bridged to {given.bus}; next: ./voltlap plant --bus {given.bus} --members bms,master", flush=True)
            while process.poll() is None:
                if bridge.carry(0.1) and given.once:
                    bridge.carry(0.1)
                    bridge.close()
                    return
        said = process.stdout.read().decode(errors="replace").strip()
        raise Refused(3, f"the emulator has ended with exit code {process.returncode}: {said or 'it says nothing'}")
    finally:
        process.kill()
        process.wait()


def main():
    given = arguments()
    try:
        run(given)
    except Refused as error:
        print(f"voltlap ecu-slcan: {error}", file=sys.stderr)
        return error.code
    except KeyboardInterrupt:
        pass
    except OSError as error:
        print(f"voltlap ecu-slcan: {error}", file=sys.stderr)
        return 3
    return 0


if __name__ == "__main__":
    sys.exit(main())
