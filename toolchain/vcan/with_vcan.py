#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs a command where the CAN interfaces vcan0 and vcan1 exist.

  1. They exist and are up: the command runs as it is.
  2. This kernel can have them, and you are root or `sudo -n` works: they are made, and removed afterwards.
  3. Else a user-mode Linux kernel (package user-mode-linux) starts on this machine's file system in about two seconds,
     makes them, runs the command inside as your user, with the same folder, environment and arguments, relays its
     input, output, signals and exit code, and switches itself off. It has the loopback network only. What the command
     leaves running ends with it.

A listener with a large buffer needs net.core.rmem_max of that size: the user-mode kernel allows 128 MB, a host 208 kB
until `sysctl net.core.rmem_max=BYTES` says otherwise (candump -r, as root, needs no leave).
"""
import argparse
import re
import sys

import host
import uml

EXIT_USAGE = 2


def interface_names(text):
    names = text.split(",")
    for name in names:
        if not re.fullmatch(r"[A-Za-z0-9_.-]{1,15}", name):
            raise argparse.ArgumentTypeError(f'"{name}" is no interface name; for instance: vcan0,vcan1')
    return names


def megabytes(text):
    match = re.fullmatch(r"(\d+)([MG]?)", text)
    size = int(match[1]) * (1024 if match[2] == "G" else 1) if match else 0
    if not 64 <= size <= 65536:
        raise argparse.ArgumentTypeError(f'"{text}" is no size from 64M to 64G; for instance: 512M')
    return size


def arguments(words):
    parser = argparse.ArgumentParser(prog="voltlap with-vcan", description=__doc__, allow_abbrev=False,
                                     formatter_class=argparse.RawTextHelpFormatter,
                                     usage="voltlap with-vcan [options] COMMAND [ARGUMENT ...]",
                                     epilog="Exit codes: those of the command (128 + n when a signal ended it, 127 not "
                                            "found, 126 not executable);\n2 usage, 3 the guest failed, 4 a package is "
                                            "missing.")
    parser.add_argument("--interfaces", type=interface_names, default=["vcan0", "vcan1"], metavar="NAME,NAME",
                        help="which ones (vcan0,vcan1)")
    parser.add_argument("--private", action="store_true",
                        help="interfaces that nobody else sees, for tests: those of a user-mode kernel, or of a\n"
                             "network namespace where there is none")
    parser.add_argument("--force", choices=("uml", "host"), help="only the user-mode kernel, or never")
    parser.add_argument("--memory", type=megabytes, default=512, metavar="SIZE",
                        help="most memory of the user-mode kernel (512M)")
    parser.add_argument("command", nargs=argparse.REMAINDER, metavar="COMMAND", help="what to run, with its arguments")
    parsed = parser.parse_args(words)
    if parsed.command[:1] == ["--"]:
        del parsed.command[0]
    if not parsed.command:
        parser.error("which command? For instance: voltlap with-vcan candump vcan0")
    return parsed


def complain(text):
    print(f"voltlap with-vcan: {text}", file=sys.stderr)


def places(asked):
    """Where to look for the interfaces, in this order."""
    if asked.force:
        return [asked.force]
    return ["uml", "host"] if asked.private and uml.installed() else ["host", "uml"]


def main(words):
    asked = arguments(words)
    for place in places(asked):
        code = on_host(asked) if place == "host" else in_guest(asked)
        if code is not None:
            return code
    complain(f"this machine has no {' and '.join(asked.interfaces)}, and they cannot be made here: that takes a kernel "
             "with the module vcan and root (or sudo without a password). Without --force host a user-mode kernel is "
             "used.")
    return 3


def on_host(asked):
    links = host.Namespace(asked.interfaces) if asked.private else host.Interfaces(asked.interfaces)
    return host.run(asked.command, links)


def in_guest(asked):
    try:
        return uml.run(asked.command, asked.interfaces, asked.memory)
    except uml.CannotRun as error:
        complain(error)
        return error.code


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
