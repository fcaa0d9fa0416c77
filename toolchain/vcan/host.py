# SPDX-License-Identifier: Apache-2.0
"""CAN interfaces of this machine: those that exist, and virtual ones made where its kernel has them."""
import ctypes
import os
import shutil
import signal
import subprocess

SYSTEM_PATH = "/usr/local/sbin:/usr/sbin:/sbin:/usr/local/bin:/usr/bin:/bin"
UP = 1  # IFF_UP
CLONE_NEWNS, CLONE_NEWUSER, CLONE_NEWNET = 0x20000, 0x10000000, 0x40000000
MS_REC, MS_SLAVE = 0x4000, 0x80000
WATCHED = {signal.SIGINT, signal.SIGQUIT, signal.SIGTERM, signal.SIGHUP, signal.SIGCHLD}
SI_KERNEL = 0x80  # si_code of a signal that the kernel sent, as for a key of the terminal
libc = ctypes.CDLL(None, use_errno=True)


def exists(name):
    return os.path.exists(f"/sys/class/net/{name}")


def is_up(name):
    try:
        with open(f"/sys/class/net/{name}/flags", encoding="ascii") as file:
            return bool(int(file.read(), 16) & UP)
    except (OSError, ValueError):
        return False


def may_be_root():
    """The words before a command that needs root; None when there is no way."""
    if os.geteuid() == 0:
        return []
    sudo = shutil.which("sudo")
    if sudo and quiet([sudo, "-n", "true"]):
        return [sudo, "-n"]
    return None


def quiet(words):
    try:
        return subprocess.run(words, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                              env={**os.environ, "PATH": f"{os.environ.get('PATH', '')}:{SYSTEM_PATH}"},
                              check=False).returncode == 0
    except OSError:
        return False


class Interfaces:
    """Makes what is missing and takes it away again; what was there stays as it was."""

    def __init__(self, names):
        self.names = names
        self.made = []
        self.raised = []
        self.root = []

    def ready(self):
        """True when every interface is there and up."""
        if all(is_up(name) for name in self.names):
            return True
        self.root = may_be_root()
        if self.root is None:
            return False
        quiet([*self.root, "modprobe", "vcan"])
        for name in self.names:
            if not exists(name):
                if not quiet([*self.root, "ip", "link", "add", "dev", name, "type", "vcan"]):
                    self.remove()
                    return False
                self.made.append(name)
            if not is_up(name):
                if name not in self.made:
                    self.raised.append(name)
                if not quiet([*self.root, "ip", "link", "set", name, "up"]):
                    self.remove()
                    return False
        return True

    def enter(self):
        """The command is where the interfaces are."""

    def remove(self):
        for name in self.made:
            quiet([*self.root, "ip", "link", "del", name])
        for name in self.raised:
            quiet([*self.root, "ip", "link", "set", name, "down"])
        self.made, self.raised = [], []


class Namespace:
    """Interfaces that nobody else sees, in namespaces of the command's own; the kernel removes them with the command.

    An ordinary user is root in a first user namespace, to make the interfaces, and himself again in a second.
    """

    def __init__(self, names):
        self.names = names

    def ready(self):
        """Tried out: an empty command in such a namespace."""
        quiet(["modprobe", "vcan"])
        try:
            return subprocess.run(["true"], preexec_fn=self.enter, check=False).returncode == 0
        except (subprocess.SubprocessError, OSError):
            return False

    def enter(self):
        user, group = os.getuid(), os.getgid()
        if user != 0:
            unshare(CLONE_NEWUSER)
            write_maps(f"0 {user} 1", f"0 {group} 1")
        unshare(CLONE_NEWNET | CLONE_NEWNS)
        mount("none", "/", None, MS_SLAVE | MS_REC)  # nothing that is mounted here reaches the host
        mount("sysfs", "/sys", "sysfs", 0)  # that of this namespace: /sys/class/net
        commands = [["link", "set", "lo", "up"]]
        for name in self.names:
            commands += [["link", "add", "dev", name, "type", "vcan"], ["link", "set", name, "up"]]
        if not all(quiet(["ip", *words]) for words in commands):
            raise OSError("the kernel makes no such interface")
        if user != 0:
            unshare(CLONE_NEWUSER)
            write_maps(f"{user} 0 1", f"{group} 0 1")

    def remove(self):
        """The kernel does."""


def unshare(flags):
    if libc.unshare(flags) != 0:
        raise OSError(ctypes.get_errno(), "unshare")


def mount(source, target, kind, flags):
    if libc.mount(source.encode(), target.encode(), kind.encode() if kind else None, flags, None) != 0:
        raise OSError(ctypes.get_errno(), f"mount {target}")


def write_maps(users, groups):
    for name, text in (("setgroups", "deny"), ("uid_map", users), ("gid_map", groups)):
        with open(f"/proc/self/{name}", "w", encoding="ascii") as file:
            file.write(text)


def run(argv, links):
    """Exit code of the command beside `links`, or None when this machine cannot have them."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, WATCHED)
    try:
        if not links.ready():
            return None
        try:
            child = subprocess.Popen(argv, preexec_fn=lambda: prepare(links, before))
        except OSError as error:
            print_error(argv[0], error)
            return 127 if isinstance(error, FileNotFoundError) else 126
        code = watch(child)
        return code if code >= 0 else 128 - code
    finally:
        links.remove()
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def prepare(links, mask):
    links.enter()
    signal.pthread_sigmask(signal.SIG_SETMASK, mask)


def watch(child):
    """Passes signals on until the command has ended. What the terminal sends, the command has from the terminal."""
    while child.poll() is None:
        found = signal.sigwaitinfo(WATCHED)
        if found.si_signo != signal.SIGCHLD and found.si_code != SI_KERNEL:
            child.send_signal(found.si_signo)
    return child.returncode


def print_error(name, error):
    reason = "command not found" if isinstance(error, FileNotFoundError) else error.strerror
    os.write(2, os.fsencode(f"voltlap with-vcan: {name}: {reason}\n"))
