# SPDX-License-Identifier: Apache-2.0
"""Runs a command in a user-mode Linux guest that has CAN interfaces, on the host's root file system.

The guest is one process tree of the caller's own user. It sees the same files, gets the same environment, folder,
arguments and user, and its standard streams are relayed as they come. Nothing is left when it has ended.
"""
import collections
import glob
import json
import os
import select
import selectors
import shutil
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import termios
import time
import tty
from pathlib import Path

import caller
import guard
import link

KERNEL = "linux.uml"
WIDE = "amx_tile"  # flag of a processor with more registers than the kernel keeps
PACKAGES = ("user-mode-linux", "iproute2")
BOOT_LIMIT_S = 120.0
END_LIMIT_S = 10.0
PREFIX = "voltlap-vcan-"
HERE = Path(__file__).resolve().parent
ST_NOEXEC = 8
PATIENCE = 3  # the third signal of the same kind ends the guest itself


class CannotRun(Exception):
    """No guest can be had; the text says why and what to do. `code` is the exit code."""

    def __init__(self, text, code):
        super().__init__(text)
        self.code = code


def installed():
    return shutil.which(KERNEL, path=os.environ.get("PATH", "") + ":/usr/bin:/usr/local/bin")


def find_kernel():
    path = installed()
    ip = shutil.which("ip", path="/usr/local/sbin:/usr/sbin:/sbin:/usr/bin:/bin")
    if path is None or ip is None:
        raise CannotRun(f"there is no CAN interface here, and {KERNEL if path is None else 'ip'} is not installed to "
                        f"make one. This line does it:\n  sudo apt-get install -y --no-install-recommends "
                        f"{' '.join(PACKAGES)}", 4)
    return path


def memory_folder(megabytes):
    """Where the guest's memory lives: it must be executable and have room; shared memory is the fastest."""
    tried = []
    for folder in ("/dev/shm", tempfile.gettempdir(), "/tmp", "/var/tmp"):
        try:
            state = os.statvfs(folder)
        except OSError:
            continue
        free = state.f_bavail * state.f_frsize >> 20
        if os.access(folder, os.W_OK | os.X_OK) and not state.f_flag & ST_NOEXEC and free >= megabytes:
            return folder
        tried.append(f"{folder} ({'no programs allowed' if state.f_flag & ST_NOEXEC else f'{free} MB free'})")
    raise CannotRun(f"no place for {megabytes} MB of guest memory: {', '.join(tried)}. Free some, or give a smaller "
                    f"--memory.", 3)


def scratch_folder():
    """A folder that the guest sees too. Folders of runners that were killed go first."""
    for stale in scratch_base().glob(f"{PREFIX}{os.getuid()}-*"):
        owner = stale.name.split("-")[3]
        if owner.isdigit() and not os.path.exists(f"/proc/{owner}"):
            shutil.rmtree(stale, ignore_errors=True)
    return Path(tempfile.mkdtemp(prefix=scratch_prefix(), dir=scratch_base()))


def scratch_base():
    """/dev and /proc of the guest are its own, and the kernel's command line knows no blanks in a name."""
    base = tempfile.gettempdir()
    return Path("/tmp" if " " in base or base.startswith(("/dev", "/proc", "/sys")) else base)


def scratch_prefix():
    return f"{PREFIX}{os.getuid()}-{os.getpid()}-"


def guest_python():
    return "/usr/bin/python3" if os.path.exists("/usr/bin/python3") else os.path.realpath(sys.executable)


def needs_wide_registers(cpuinfo):
    """Does the text of /proc/cpuinfo tell of registers beyond AVX-512?"""
    return any(line.startswith("flags") and WIDE in line.split() for line in cpuinfo.splitlines())


def wide_registers(folder):
    """The library that lets the kernel run on such a processor, built into the folder."""
    path = os.environ.get("PATH", "") + ":/usr/bin"
    compiler = shutil.which("cc", path=path) or shutil.which("gcc", path=path)
    if compiler is None:
        raise CannotRun("this processor has AMX, whose registers the user-mode kernel does not know; what teaches it "
                        "takes a C compiler. This line does it:\n  sudo apt-get install -y --no-install-recommends gcc "
                        "libc6-dev", 4)
    library = folder / "wide_registers.so"
    built = subprocess.run([compiler, "-O2", "-shared", "-fPIC", "-o", library, HERE / "wide_registers.c"],
                           capture_output=True, text=True, check=False)
    if built.returncode != 0:
        raise CannotRun(f"{HERE / 'wide_registers.c'}: {compiler} cannot build it:\n{built.stderr.strip()}", 3)
    return library


class Guest:
    """The machine: started, and surely ended."""

    def __init__(self, megabytes, order):
        kernel = find_kernel()
        memory = memory_folder(megabytes)
        self.guard = guard.Guard(f"{glob.escape(str(scratch_base()))}/{scratch_prefix()}*")
        try:
            self._start(kernel, megabytes, memory, order)
        except BaseException:
            guard.clear_up([], self.guard.pattern)
            self.guard.dismiss()
            raise

    def _start(self, kernel, megabytes, memory, order):
        self.folder = scratch_folder()
        for name in ("guest.py", "link.py"):
            shutil.copy(HERE / name, self.folder / name)
        (self.folder / "order.json").write_text(json.dumps(order), encoding="ascii")
        environment = {"TMPDIR": memory, "PATH": os.environ.get("PATH", os.defpath)}
        if needs_wide_registers(Path("/proc/cpuinfo").read_text(encoding="ascii", errors="replace")):
            environment["LD_PRELOAD"] = str(wide_registers(self.folder))
        self.line, far_end = socket.socketpair()
        self._console = tempfile.TemporaryFile()
        words = [kernel, "rootfstype=hostfs", "rootflags=/", "rw", f"mem={megabytes}M", f"uml_dir={self.folder}/",
                 "umid=guest", "con=null", "con0=null,fd:1", f"ssl0=fd:{far_end.fileno()}", "quiet", "noreboot",
                 "panic=-1", "VOLTLAP_GUEST=1", f"init={guest_python()}", "--", "-I", "-S", f"{self.folder}/guest.py"]
        with far_end:
            self.process = subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=self._console,
                                            stderr=subprocess.STDOUT, pass_fds=[far_end.fileno()],
                                            env=environment, cwd="/", start_new_session=True,
                                            preexec_fn=self.guard.watch_me)

    def last_words(self):
        self._console.seek(0)
        lines = self._console.read().decode(errors="replace").splitlines()
        return "\n".join(f"  {line}" for line in lines[-15:])

    def send(self, kind, payload=b""):
        try:
            self.line.sendall(link.frame(kind, payload))
        except OSError:
            pass  # it has ended: reading the line says so

    def end(self, patience_s):
        """Waits for it to switch itself off; then by force. The kernel's main process may leave others behind."""
        if not self._ends_within(patience_s):
            # Not terminate(): it waits for a process that has just ended, and its number is free.
            os.kill(self.process.pid, signal.SIGTERM)
            self._ends_within(END_LIMIT_S)
        guard.end_group(self.process.pid)
        self.process.wait()
        self.line.close()
        self._console.close()
        shutil.rmtree(self.folder, ignore_errors=True)
        self.guard.dismiss()

    def _ends_within(self, seconds):
        """Leaves it to be waited for, so that its number cannot be another's yet."""
        limit = time.monotonic() + seconds
        while os.waitid(os.P_PID, self.process.pid, os.WEXITED | os.WNOWAIT | os.WNOHANG) is None:
            if time.monotonic() > limit:
                return False
            time.sleep(0.01)
        return True


class Session:
    """One command in one guest, seen from outside."""

    def __init__(self, guest, terminal, signals):
        self.guest = guest
        self.signals = signals
        self.terminal = terminal
        self.reader = link.Reader()
        self.selector = selectors.PollSelector()  # files are always readable to it
        self.selector.register(guest.line, selectors.EVENT_READ)
        self.selector.register(signals.wake, selectors.EVENT_READ)
        self.credit = link.CREDIT
        self.input_open = True
        self.ready = False
        self.deaf = set()  # our own outputs that nobody reads any more
        self.code = None
        self.finished = False  # the guest said so, and switches itself off
        self.limit = None  # on the monotonic clock: when it must have started, or ended
        self.told = 0
        self.heard = collections.Counter()  # signals, by their number
        self.saved = None

    def run(self):
        try:
            return self._loop()
        finally:
            self._give_back_terminal()

    def _loop(self):
        self.limit = time.monotonic() + BOOT_LIMIT_S
        while self.code is None:
            self._watch_input()
            for key, _ in self.selector.select(None if self.limit is None else max(0.0, self.limit - time.monotonic())):
                if key.fileobj is self.guest.line:
                    self._listen()
                elif key.fileobj == self.signals.wake:
                    self._pass_signals_on()
                else:
                    self._read_input()
            if self.limit is None or self.code is not None or time.monotonic() < self.limit:
                continue
            if self.ready:  # it was told to end, and has not
                self.code = 128 + self.told
            else:
                raise CannotRun(f"the guest did not start within {BOOT_LIMIT_S:.0f} s. Its last words:\n"
                                f"{self.guest.last_words()}", 3)
        return self.code

    def _listen(self):
        try:
            data = self.guest.line.recv(1 << 16)
        except ConnectionError:
            data = b""
        if not data:
            raise CannotRun(f"the guest ended before the command did. Its last words:\n{self.guest.last_words()}", 3)
        for kind, payload in self.reader.feed(data):
            self._obey(kind, payload)

    def _obey(self, kind, payload):
        if kind in (link.STDOUT, link.STDERR):
            self._show(1 if kind == link.STDOUT else 2, payload)
        elif kind == link.TAKEN:
            self.credit += struct.unpack("<I", payload)[0]
        elif kind == link.READY:
            self.ready = True
            self.limit = None
            self._make_terminal_raw()
        elif kind == link.EXIT:
            number = struct.unpack("<i", payload)[0]
            self.finished = True
            self.code = number if number >= 0 else 128 - number
        elif kind == link.REFUSED:
            self.finished = True
            raise CannotRun(payload.decode(errors="surrogateescape"), 3)

    def _show(self, descriptor, data):
        if descriptor in self.deaf:
            return
        try:
            self._write(descriptor, data)
        except OSError:  # as a writer into a closed pipe would be told
            self.deaf.add(descriptor)
            self.guest.send(link.SIGNAL, bytes([signal.SIGPIPE]))

    def _write(self, descriptor, data):
        """As much at a time as a pipe surely takes: a reader that has stopped keeps no signal from the command."""
        view = memoryview(data)
        while view:
            readable, writable, _ = select.select([self.signals.wake], [descriptor], [])
            if readable:
                self._pass_signals_on()
            if writable:
                view = view[os.write(descriptor, view[:select.PIPE_BUF]):]

    def _watch_input(self):
        wanted = self.ready and self.input_open and self.credit > 0 and (self.terminal or not self._input_stops_us())
        watched = 0 in self.selector.get_map()
        if wanted and not watched:
            self.selector.register(0, selectors.EVENT_READ)
        elif watched and not wanted:
            self.selector.unregister(0)

    @staticmethod
    def _input_stops_us():
        return os.isatty(0) and not caller.in_foreground(0)

    def _read_input(self):
        try:
            data = os.read(0, min(self.credit, link.CHUNK))
        except BlockingIOError:
            return
        except OSError:
            data = b""
        if data:
            self.credit -= len(data)
            self.guest.send(link.STDIN, data)
        else:
            self.input_open = False
            self.guest.send(link.STDIN_END)

    def _pass_signals_on(self):
        number = self.signals.take()
        if number == signal.SIGWINCH:
            if self.ready and self.terminal:
                self.guest.send(link.RESIZE, struct.pack("<HH", *caller.window_size()))
            return
        self.heard[number] += 1
        if self.ready and self.heard[number] < PATIENCE:
            self.guest.send(link.SIGNAL, bytes([number]))
            if number in (signal.SIGTERM, signal.SIGHUP) and self.limit is None:
                self.limit, self.told = time.monotonic() + END_LIMIT_S, number
        else:
            self.code = 128 + number
            self.guest.process.terminate()

    def _make_terminal_raw(self):
        if self.terminal:
            self.saved = termios.tcgetattr(0)
            tty.setraw(0)

    def _give_back_terminal(self):
        if self.saved is not None:
            termios.tcsetattr(0, termios.TCSADRAIN, self.saved)


def current_umask():
    mask = os.umask(0o022)
    os.umask(mask)
    return mask


def order_to_run(argv, interfaces):
    terminal = os.isatty(0) and os.isatty(1) and caller.in_foreground(0)
    return {"argv": argv, "interfaces": interfaces, "environment": dict(os.environ), "folder": os.getcwd(),
            "uid": os.getuid(), "gid": os.getgid(), "groups": os.getgroups(), "umask": current_umask(),
            "host": socket.gethostname(), "terminal": terminal, "size": caller.window_size() if terminal else (0, 0),
            "separate_stderr": not caller.same_place(1, 2)}


def run(argv, interfaces, megabytes):
    """Exit code of the command, run inside."""
    order = order_to_run(argv, interfaces)
    signals = caller.Signals()
    try:
        guest = Guest(megabytes, order)
    except CannotRun:  # Ctrl-C goes to everybody at the terminal, the compiler too
        if (number := signals.first_to_end()) is not None:
            return 128 + number
        raise
    session = Session(guest, order["terminal"], signals)
    try:
        return session.run()
    finally:
        guest.end(END_LIMIT_S if session.finished else 0.0)
