# SPDX-License-Identifier: Apache-2.0
"""First process of the guest: mounts, can modules, interfaces, then the one command, relayed over the serial line.

Started by the user-mode kernel as process 1 with the folder of this file on the command line. The file systems of the
guest are its own, but / is the host's: only what the user may write is written, and nothing here removes anything but
that folder.
"""
import ctypes
import errno
import fcntl
import json
import os
import pty
import select
import shutil
import signal
import struct
import subprocess
import sys
import termios
import time
import tty

FOLDER = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, FOLDER)
import link  # noqa: E402  (beside this file, which -I keeps off the path)

LINE = "/dev/ttyS0"
SYSTEM_PATH = "/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin"
MODULES = ("net/can/can", "net/can/can-raw", "net/can/can-gw", "net/can/can-bcm", "drivers/net/can/dev/can-dev",
           "drivers/net/can/vcan", "drivers/net/can/slcan/slcan")
# Room for listeners with large buffers, and for bursts that reach them faster than they are scheduled.
SETTINGS = {"net/core/rmem_max": "134217728", "net/core/wmem_max": "134217728", "net/core/netdev_max_backlog": "100000"}
FINIT_MODULE = {"x86_64": 313, "i686": 350}
POWER_OFF = 0x4321FEDC
GRACE_S = 5.0  # for what the command left running, on a busy machine

libc = ctypes.CDLL(None, use_errno=True)


class Refused(Exception):
    """The command cannot be run here; the text says why."""


def mount(source, target, kind, options=None):
    os.makedirs(target, exist_ok=True)
    if libc.mount(source.encode(), target.encode(), kind.encode(), 0, options.encode() if options else None) != 0:
        code = ctypes.get_errno()
        if code != errno.EBUSY:  # there already: devtmpfs, mounted by the kernel
            raise Refused(f"cannot mount {kind} on {target}: {os.strerror(code)}")


def check_place():
    """What follows ends every process and switches the machine off: it must be the guest, and nothing else."""
    if os.getpid() != 1 or os.environ.get("VOLTLAP_GUEST") != "1":
        sys.exit("guest.py is the first process of with_vcan.py's guest; it does not run anywhere else")


def check_kernel():
    with open("/proc/cpuinfo", encoding="ascii", errors="replace") as file:
        if "User Mode Linux" not in file.read():
            raise Refused("this is not a user-mode kernel")


def mount_file_systems():
    mount("sysfs", "/sys", "sysfs")
    mount("devtmpfs", "/dev", "devtmpfs")
    mount("devpts", "/dev/pts", "devpts", "ptmxmode=0666,mode=0620")
    try:
        mount("none", "/dev/shm", "hostfs", "/dev/shm")
    except Refused:  # the host has none
        mount("tmpfs", "/dev/shm", "tmpfs", "mode=1777")
    for name, target in (("fd", "/proc/self/fd"), ("stdin", "/proc/self/fd/0"), ("stdout", "/proc/self/fd/1"),
                         ("stderr", "/proc/self/fd/2")):
        if not os.path.lexists(f"/dev/{name}"):
            os.symlink(target, f"/dev/{name}")
    os.chmod("/dev/null", 0o666)


def load_modules():
    machine, release = os.uname().machine, os.uname().release
    for module in MODULES:
        path = f"/usr/lib/uml/modules/{release}/kernel/{module}.ko"
        try:
            descriptor = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
        except OSError as error:
            raise Refused(f"{path}: {error.strerror}; reinstall the package user-mode-linux") from None
        if libc.syscall(FINIT_MODULE[machine], descriptor, b"", 0) != 0 and ctypes.get_errno() != errno.EEXIST:
            raise Refused(f"{path}: {os.strerror(ctypes.get_errno())}")
        os.close(descriptor)


def create_interfaces(names):
    lines = ["link set lo up"]
    for name in names:
        lines += [f"link add dev {name} type vcan", f"link set {name} up"]
    done = subprocess.run(["ip", "-batch", "-"], input="\n".join(lines) + "\n", text=True, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, env={"PATH": SYSTEM_PATH}, check=False)
    if done.returncode != 0:
        raise Refused(f"cannot create {' '.join(names)}: {done.stdout.strip()}")


def apply_settings():
    for name, value in SETTINGS.items():
        with open(f"/proc/sys/{name}", "w", encoding="ascii") as file:
            file.write(value)


def open_line():
    descriptor = os.open(LINE, os.O_RDWR | os.O_NOCTTY | os.O_CLOEXEC)
    tty.setraw(descriptor)
    return descriptor


def send(line, kind, payload=b""):
    data = memoryview(link.frame(kind, payload))
    while data:
        data = data[os.write(line, data):]


def take_order():
    """What to run. The file holds the caller's environment and goes as soon as it is read."""
    path = f"{FOLDER}/order.json"
    with open(path, encoding="ascii") as file:
        order = json.load(file)
    os.unlink(path)
    return order


class Command:
    """The command with its pipes or its terminal."""

    def __init__(self, order):
        self.order = order
        self.terminal = order["terminal"]
        self.outputs = {}  # descriptor -> kind of frame
        self.pending = bytearray()  # for its standard input
        self.ending = False  # no more input will come
        if self.terminal:
            self._open_terminal()
        else:
            self._open_pipes()
        self.process = os.fork()
        if self.process == 0:
            self._become_command()
        for descriptor in set(self.ends):
            os.close(descriptor)
        if self.input is not None:
            os.set_blocking(self.input, False)

    def _open_terminal(self):
        master, slave = pty.openpty()
        os.fchown(slave, self.order["uid"], self.order["gid"])
        self.input, self.ends = master, (slave, slave, slave)
        self.outputs[master] = link.STDOUT
        self.resize(*self.order["size"])
        if self.order["separate_stderr"]:
            self._open_stderr()

    def _open_pipes(self):
        input_end, self.input = os.pipe()
        output, output_end = os.pipe()
        self.outputs[output] = link.STDOUT
        self.ends = (input_end, output_end, output_end)
        if self.order["separate_stderr"]:
            self._open_stderr()

    def _open_stderr(self):
        errors, errors_end = os.pipe()
        self.outputs[errors] = link.STDERR
        self.ends = (*self.ends[:2], errors_end)

    def _become_command(self):
        order = self.order
        code = 126
        try:
            os.setsid()
            if self.terminal:
                fcntl.ioctl(self.ends[0], termios.TIOCSCTTY, 0)
            for target, source in enumerate(self.ends):
                os.dup2(source, target)
            for name in (signal.SIGPIPE, signal.SIGXFSZ):
                signal.signal(name, signal.SIG_DFL)
            os.umask(order["umask"])
            os.setgroups(order["groups"])
            os.setgid(order["gid"])
            os.setuid(order["uid"])
            argv = [os.fsencode(word) for word in order["argv"]]
            os.execvpe(argv[0], argv, {os.fsencode(k): os.fsencode(v) for k, v in order["environment"].items()})
        except FileNotFoundError:
            code = 127
            os.write(2, os.fsencode(f"voltlap with-vcan: {order['argv'][0]}: command not found\n"))
        except OSError as error:
            os.write(2, os.fsencode(f"voltlap with-vcan: {order['argv'][0]}: {error.strerror}\n"))
        finally:
            os._exit(code)

    def resize(self, rows, columns):
        if self.terminal:
            fcntl.ioctl(self.input, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))

    def signal(self, number):
        try:
            os.killpg(self.process, number)
        except ProcessLookupError:
            pass

    def feed(self):
        """Writes what its input takes now; returns how much that was."""
        taken = 0
        if self.input is None:
            taken = len(self.pending)
            self.pending.clear()
            return taken
        try:
            taken = os.write(self.input, self.pending) if self.pending else 0
            del self.pending[:taken]
        except BlockingIOError:
            return 0
        except OSError:  # it reads no more
            taken = len(self.pending)
            self.pending.clear()
            self.ending = True
        if self.ending and not self.pending and not self.terminal:
            os.close(self.input)
            self.input = None
        return taken


def reap(wanted):
    """Takes every child that has ended; the status of `wanted` when it was among them."""
    status = None
    while True:
        try:
            process, found = os.waitpid(-1, os.WNOHANG)
        except ChildProcessError:
            return status
        if process == 0:
            return status
        if process == wanted:
            status = found


def others_left():
    return any(name.isdigit() and name != "1" and is_program(name) for name in os.listdir("/proc"))


def is_program(process):
    """Kernel threads have no command line, and neither have the dead that wait for their parent."""
    try:
        with open(f"/proc/{process}/cmdline", "rb") as file:
            return bool(file.read(1))
    except OSError:
        return False


def end_what_is_left():
    for number, grace in ((signal.SIGTERM, GRACE_S), (signal.SIGKILL, GRACE_S)):
        reap(None)
        if not others_left():
            return
        try:
            os.kill(-1, number)
        except ProcessLookupError:
            return
        limit = time.monotonic() + grace
        while others_left() and time.monotonic() < limit:
            time.sleep(0.01)
            reap(None)


class Relay:
    """Carries bytes between the line and the command until the command has ended."""

    def __init__(self, line, command):
        self.line, self.command = line, command
        self.reader = link.Reader()
        self.wake, wake_end = os.pipe()
        os.set_blocking(wake_end, False)
        signal.signal(signal.SIGCHLD, lambda *_: None)
        signal.set_wakeup_fd(wake_end, warn_on_full_buffer=False)
        os.set_blocking(self.wake, False)

    def run(self):
        status = reap(self.command.process)
        while status is None:
            inputs = [self.line, self.wake, *self.command.outputs]
            full = self.command.input is not None and self.command.pending
            readable, writable, _ = select.select(inputs, [self.command.input] if full else [], [])
            if self.line in readable:
                self._listen()
            if writable:
                self._feed()
            self._pass_on(readable)
            if self.wake in readable:
                os.read(self.wake, link.CHUNK)
            status = reap(self.command.process)
        end_what_is_left()
        self._drain()
        return os.waitstatus_to_exitcode(status)

    def _listen(self):
        data = os.read(self.line, link.CHUNK)
        if not data:
            raise EOFError
        for kind, payload in self.reader.feed(data):
            self._obey(kind, payload)

    def _obey(self, kind, payload):
        if kind == link.STDIN:
            self.command.pending += payload
            self._feed()
        elif kind == link.STDIN_END:
            self.command.ending = True
            self._feed()
        elif kind == link.SIGNAL:
            self.command.signal(payload[0])
        elif kind == link.RESIZE:
            self.command.resize(*struct.unpack("<HH", payload))

    def _feed(self):
        taken = self.command.feed()
        if taken:
            send(self.line, link.TAKEN, struct.pack("<I", taken))

    def _pass_on(self, readable):
        for descriptor, kind in list(self.command.outputs.items()):
            if descriptor in readable:
                try:
                    data = os.read(descriptor, link.CHUNK)
                except BlockingIOError:
                    continue
                except OSError:  # a terminal whose last user has gone
                    data = b""
                if data:
                    send(self.line, kind, data)
                else:
                    del self.command.outputs[descriptor]

    def _drain(self):
        for descriptor in self.command.outputs:
            os.set_blocking(descriptor, False)
        while self.command.outputs:
            readable, _, _ = select.select(list(self.command.outputs), [], [], 0)
            if not readable:
                return
            self._pass_on(readable)


def enter_folder(order):
    try:
        os.chdir(os.fsencode(order["folder"]))
    except OSError as error:
        raise Refused(f"the folder {order['folder']} cannot be entered inside: {error.strerror}") from None


def serve(line):
    order = take_order()
    load_modules()
    create_interfaces(order["interfaces"])
    apply_settings()
    libc.sethostname(order["host"].encode(), len(order["host"].encode()))
    enter_folder(order)
    send(line, link.READY)
    code = Relay(line, Command(order)).run()
    send(line, link.EXIT, struct.pack("<i", code))


def main():
    check_place()
    mount("proc", "/proc", "proc")
    check_kernel()
    try:
        mount_file_systems()
        line = open_line()
        try:
            serve(line)
        except Refused as refused:
            send(line, link.REFUSED, str(refused).encode(errors="surrogateescape"))
        termios.tcdrain(line)
    except EOFError:  # the runner was killed and cannot clear up
        shutil.rmtree(FOLDER, ignore_errors=True)
    except BaseException as error:  # process 1 must not end: the kernel would panic, and the runner is gone or waits
        print(f"guest: {type(error).__name__}: {error}", flush=True)
    finally:
        os.sync()  # the runner waits for the end: what the command wrote is on the host then
        libc.reboot(POWER_OFF)


if __name__ == "__main__":
    main()
