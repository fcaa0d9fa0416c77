# SPDX-License-Identifier: Apache-2.0
"""CAN interfaces of this machine: those that exist, and virtual ones made where its kernel has them."""
import os
import shutil
import signal
import subprocess

SYSTEM_PATH = "/usr/local/sbin:/usr/sbin:/sbin:/usr/local/bin:/usr/bin:/bin"
UP = 1  # IFF_UP


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

    def remove(self):
        for name in self.made:
            quiet([*self.root, "ip", "link", "del", name])
        for name in self.raised:
            quiet([*self.root, "ip", "link", "set", name, "down"])
        self.made, self.raised = [], []


def run(argv, interfaces):
    """Exit code of the command, or None when this machine cannot have the interfaces."""
    links = Interfaces(interfaces)
    stopping = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGQUIT, signal.SIGTERM,
                                                                signal.SIGHUP)}
    child = None

    def pass_on(number, _):
        if child is not None:
            child.send_signal(number)

    try:
        # A terminal sends the first two to the command itself.
        for number in stopping:
            signal.signal(number, signal.SIG_IGN if number in (signal.SIGINT, signal.SIGQUIT) else pass_on)
        if not links.ready():
            return None
        try:
            child = subprocess.Popen(argv, preexec_fn=lambda: restore(stopping))
        except OSError as error:
            print_error(argv[0], error)
            return 127 if isinstance(error, FileNotFoundError) else 126
        code = child.wait()
        return code if code >= 0 else 128 - code
    finally:
        links.remove()
        restore(stopping)


def restore(handlers):
    for number, handler in handlers.items():
        signal.signal(number, handler)


def print_error(name, error):
    reason = "command not found" if isinstance(error, FileNotFoundError) else error.strerror
    os.write(2, os.fsencode(f"voltlap with-vcan: {name}: {reason}\n"))
