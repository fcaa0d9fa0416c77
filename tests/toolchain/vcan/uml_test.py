# SPDX-License-Identifier: Apache-2.0
"""The runner with a real user-mode kernel."""
import os
import pwd
import pty
import random
import re
import select
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from readable_runner import readable_runner
from waiting import HANG_S, until_heard, wait_until

RUNNER = Path(__file__).resolve().parents[3] / "toolchain" / "vcan" / "with_vcan.py"
PYTHON = "/usr/bin/python3" if os.path.exists("/usr/bin/python3") else sys.executable
UML = [PYTHON, str(RUNNER), "--force", "uml"]
pytestmark = pytest.mark.skipif(shutil.which("linux.uml") is None,
                                reason="the package user-mode-linux is not installed")


def run(*command, options=(), uml=UML, **how):
    return subprocess.run([*uml, *options, *command], capture_output=True, timeout=HANG_S, **how)


def start(*command, **how):
    return subprocess.Popen([*UML, *command], stdout=subprocess.PIPE, text=True, **how)


def mark_of(runner):
    return f"voltlap-vcan-{os.getuid()}-{runner.pid}-"


def folders(runner):
    """Of the guest of one runner."""
    return [str(path) for path in Path("/tmp").glob(mark_of(runner) + "*")]


def processes(runner):
    """Of the guest of one runner, which has its folder in its command line."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        try:
            if mark_of(runner).encode() in (process / "cmdline").read_bytes():
                found.append(process.name)
        except OSError:
            pass
    return found


def assert_nothing_left(runner):
    assert folders(runner) + processes(runner) == []


# ---- as in a shell ----

def test_vcan0_carries_what_cansend_sends_to_candump():
    done = run("sh", "-c", f"candump -n 2 -L vcan0 & {until_heard('vcan0')}; cansend vcan0 123#DEADBEEF;"
                           "cansend vcan0 18FF0001#11; wait", text=True)
    assert done.returncode == 0, done.stderr
    assert re.findall(r"vcan0 (\S+)", done.stdout) == ["123#DEADBEEF", "18FF0001#11"]


def test_both_interfaces_are_up_and_loopback_too():
    done = run("ip", "-brief", "link", "show", "up", text=True)
    assert [line.split()[0] for line in done.stdout.splitlines()] == ["lo", "vcan0", "vcan1"]


def test_other_interfaces_can_be_asked_for():
    done = run("ip", "-brief", "link", "show", "type", "vcan", options=["--interfaces", "vcan5"], text=True)
    assert [line.split()[0] for line in done.stdout.splitlines()] == ["vcan5"]


def test_listeners_may_have_a_large_buffer():
    text = ("import socket; s = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW);"
            "s.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 64 << 20);"
            "print(s.getsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF) >> 20)")
    assert run(PYTHON, "-c", text, text=True).stdout == "128\n"  # the kernel doubles it


@pytest.mark.parametrize("command, code", [("exit 0", 0), ("exit 255", 255), ("kill -9 $$", 137)])
def test_exit_code_is_the_commands(command, code):
    assert run("sh", "-c", command).returncode == code


@pytest.mark.parametrize("command, code, reason", [("no-such-program", 127, b"command not found"),
                                                   ("/etc/passwd", 126, b"Permission denied")])
def test_command_that_cannot_start_is_named(command, code, reason):
    done = run(command)
    assert done.returncode == code
    assert command.encode() in done.stderr and reason in done.stderr


def test_arguments_arrive_as_they_were_given():
    words = ["a b", "", "quote\" and '", "line\nbreak", "$HOME `x` \\", "--help", "--yes", "*", "\udcff"]
    script = "import os, sys; sys.stdout.buffer.write(b'\\0'.join(map(os.fsencode, sys.argv[1:])))"
    done = run(PYTHON, "-c", script, *words)
    assert done.stdout == b"\0".join(map(os.fsencode, words))


def test_environment_folder_and_umask_are_the_callers(tmp_path):
    folder = tmp_path / "a folder"
    folder.mkdir()
    mask = os.umask(0o027)
    try:
        done = run("sh", "-c", 'printf "%s|" "$ODD" "$PWD"; umask; : >made', cwd=folder, text=True,
                   env={**os.environ, "ODD": "1 2\n'3\"", "PWD": str(folder)})
    finally:
        os.umask(mask)
    assert done.stdout == f"1 2\n'3\"|{folder}|0027\n"
    assert (folder / "made").stat().st_mode & 0o777 == 0o640


def test_files_written_inside_are_there_when_it_has_ended(tmp_path):
    assert run("sh", "-c", "head -c 3000000 /dev/zero >file; mv file renamed", cwd=tmp_path).returncode == 0
    assert (tmp_path / "renamed").stat().st_size == 3000000
    assert os.listdir(tmp_path) == ["renamed"]


def test_devices_and_proc_behave():
    done = run("sh", "-c", "echo x >/dev/null && head -c 4 /dev/zero | wc -c && head -c 4 /dev/urandom | wc -c && "
                           "echo y >/dev/stdout && test -d /proc/self/fd && test -w /tmp && echo z >/dev/stderr",
               text=True)
    assert (done.stdout, done.stderr, done.returncode) == ("4\n4\ny\n", "z\n", 0)


def test_clocks_run_like_the_hosts():
    """Each look at the guest's clocks lies between two at the host's."""
    text = "import time\nwhile True: input(); print(time.time(), time.monotonic(), flush=True)"
    runner = start(PYTHON, "-c", text, stdin=subprocess.PIPE)

    def look():
        before = time.time(), time.monotonic()
        runner.stdin.write("\n")
        runner.stdin.flush()
        inside = tuple(map(float, runner.stdout.readline().split()))
        return before, inside, (time.time(), time.monotonic())

    first = look()
    time.sleep(1.0)
    second = look()
    runner.stdin.close()
    assert runner.wait(HANG_S) == 1  # input() has met the end
    for before, inside, after in (first, second):
        assert before[0] - 0.5 < inside[0] < after[0] + 0.5
    for clock in (0, 1):
        at_least, at_most = second[0][clock] - first[2][clock], second[2][clock] - first[0][clock]
        assert at_least - 0.1 < second[1][clock] - first[1][clock] < at_most + 0.1


# ---- streams ----

NOISE = random.Random(1).randbytes(1 << 20)


def test_a_megabyte_of_any_bytes_passes_unchanged_through_both_outputs(tmp_path):
    (tmp_path / "noise").write_bytes(NOISE)
    done = run("sh", "-c", "cat noise & cat noise >&2; wait", cwd=tmp_path)
    assert done.stdout == NOISE and done.stderr == NOISE


def test_a_megabyte_of_any_bytes_passes_unchanged_through_the_input():
    assert run("cat", input=NOISE).stdout == NOISE


def test_input_from_a_file_ends_where_the_file_ends(tmp_path):
    (tmp_path / "noise").write_bytes(NOISE[:100_000])
    with open(tmp_path / "noise", "rb") as file:
        assert run("wc", "-c", stdin=file).stdout == b"100000\n"


def test_command_that_reads_nothing_is_not_held_up_by_its_input():
    assert run("true", input=NOISE).returncode == 0


def test_outputs_that_are_one_file_keep_their_order():
    script = "for i in 1 2 3 4 5 6; do echo out $i; echo err $i >&2; done"
    done = subprocess.run([*UML, "sh", "-c", script], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          timeout=HANG_S)
    assert done.stdout == "".join(f"out {i}\nerr {i}\n" for i in range(1, 7))


def test_lines_appear_as_they_come():
    runner = start("sh", "-c", "for i in 1 2 3; do echo $i; read answer; done", stdin=subprocess.PIPE)
    for i in (1, 2, 3):
        assert runner.stdout.readline() == f"{i}\n"
        runner.stdin.write("go on\n")
        runner.stdin.flush()
    assert runner.wait(HANG_S) == 0


def test_command_whose_reader_has_gone_is_ended():
    runner = start("yes")
    runner.stdout.readline()
    runner.stdout.close()
    assert runner.wait(timeout=HANG_S) == 128 + signal.SIGPIPE
    assert_nothing_left(runner)


def test_terminal_reaches_the_command(tmp_path):
    ours, theirs = pty.openpty()
    os.set_blocking(ours, False)
    script = ("tty; stty size; read word; echo got $word; trap 'echo int; exit 5' INT; echo armed;"
              "while :; do sleep 0.1; done")
    runner = subprocess.Popen([*UML, "sh", "-c", script], stdin=theirs, stdout=theirs, stderr=theirs,
                              start_new_session=True,
                              preexec_fn=lambda: os.close(os.open(os.ttyname(theirs), os.O_RDWR)))
    shown = b""

    def wait_for(text):
        nonlocal shown
        limit = time.monotonic() + HANG_S
        while text not in shown and time.monotonic() < limit:
            if select.select([ours], [], [], 0.1)[0]:
                shown += os.read(ours, 4096)
        assert text in shown, shown

    wait_for(b"/dev/pts/0")
    os.write(ours, b"hello\r")
    wait_for(b"got hello")
    wait_for(b"armed")
    os.write(ours, b"\x03")
    wait_for(b"int")
    assert runner.wait(timeout=HANG_S) == 5
    assert_nothing_left(runner)


# ---- ends ----

def test_interrupt_reaches_the_command_and_its_code_comes_back():
    runner = start("sh", "-c", "trap 'echo caught; exit 9' INT; echo up; while :; do sleep 0.1; done")
    assert runner.stdout.readline() == "up\n"
    runner.send_signal(signal.SIGINT)
    assert runner.stdout.read() == "caught\n"
    assert runner.wait(HANG_S) == 9
    assert_nothing_left(runner)


def test_command_that_a_signal_ends_gives_128_and_its_number():
    runner = start("sh", "-c", "echo up; exec sleep 100")
    runner.stdout.readline()
    runner.send_signal(signal.SIGTERM)
    assert runner.wait(HANG_S) == 128 + signal.SIGTERM
    assert_nothing_left(runner)


def test_third_interrupt_ends_the_guest_of_a_command_that_does_not_heed_it():
    runner = start("sh", "-c", "trap 'echo heard' INT; echo up; while :; do sleep 0.1; done")
    runner.stdout.readline()
    for _ in range(2):
        runner.send_signal(signal.SIGINT)
        assert runner.stdout.readline() == "heard\n"
    runner.send_signal(signal.SIGINT)
    assert runner.wait(timeout=HANG_S) == 128 + signal.SIGINT
    assert_nothing_left(runner)


def test_guest_that_ends_by_itself_just_before_it_is_told_to_is_ended(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(Path(__file__).parents[3] / "toolchain/vcan")
    import uml

    class Quiet:
        close = dismiss = lambda self: None

    guest = object.__new__(uml.Guest)
    guest.process = subprocess.Popen(["true"], start_new_session=True)
    guest.line = guest._console = guest.guard = Quiet()
    guest.folder = tmp_path
    ends_within, asked = guest._ends_within, []

    def late(seconds):
        asked.append(seconds)
        return ends_within(HANG_S) and len(asked) > 1  # at the first look it had not ended

    guest._ends_within = late
    guest.end(0.0)
    assert len(asked) == 2 and guest.process.returncode == 0


@pytest.mark.parametrize("there", [folders, processes])
def test_interrupt_while_it_starts_leaves_nothing(there):
    runner = start("sleep", "10000")
    wait_until(lambda: there(runner))
    runner.send_signal(signal.SIGINT)
    assert runner.wait(timeout=HANG_S) == 128 + signal.SIGINT
    assert_nothing_left(runner)


@pytest.mark.parametrize("there", [folders, processes, lambda runner: runner.stdout.readline()],
                         ids=["folder", "guest", "command"])
def test_killed_runner_leaves_nothing(there):
    runner = start("sh", "-c", "echo up; sleep 10000")
    wait_until(lambda: there(runner))
    runner.kill()
    runner.wait(HANG_S)
    wait_until(lambda: not folders(runner) and not processes(runner))


def test_what_the_command_leaves_running_ends_with_it():
    runner = start("sh", "-c", "sleep 10000 & sleep 20000 >/dev/null & echo done")
    assert runner.stdout.read() == "done\n"
    assert runner.wait(HANG_S) == 0
    assert_nothing_left(runner)


def test_what_is_left_running_is_asked_to_end_before_it_is_made_to(tmp_path):
    script = ("sh -c 'trap \"echo asked >note; exit\" TERM; echo up; : >armed; while :; do sleep 0.1; done' &"
              "until [ -e armed ]; do sleep 0.05; done")
    assert run("sh", "-c", script, cwd=tmp_path).stdout == b"up\n"
    assert (tmp_path / "note").read_text() == "asked\n"


# ---- whose, and errors ----

@pytest.mark.skipif(os.getuid() != 0, reason="only root can play another user")
def test_ordinary_user_stays_who_he_is():
    nobody = pwd.getpwnam("nobody")
    done = run("sh", "-c", "id -u; id -g; cansend vcan0 001#00 && echo sent", user=nobody.pw_uid, group=nobody.pw_gid,
               extra_groups=[], cwd="/", text=True, env={"PATH": os.defpath},
               uml=[*readable_runner(), "--force", "uml"])
    assert done.stdout == f"{nobody.pw_uid}\n{nobody.pw_gid}\nsent\n", done.stderr


def test_missing_kernel_is_told_with_the_line_that_installs_it(tmp_path):
    copy = tmp_path / "vcan"
    shutil.copytree(RUNNER.parent, copy, ignore=shutil.ignore_patterns("__pycache__"))
    (copy / "uml.py").write_text((copy / "uml.py").read_text().replace('"linux.uml"', '"no-linux.uml"'))
    done = subprocess.run([PYTHON, copy / "with_vcan.py", "--force", "uml", "true"], capture_output=True, text=True)
    assert done.returncode == 4
    assert "no-linux.uml is not installed" in done.stderr and "apt-get install" in done.stderr
    assert "user-mode-linux" in done.stderr


def changed_runner(tmp_path, *changes):
    """Command line of a copy whose uml.py has each of these pairs replaced."""
    copy = tmp_path / "vcan"
    shutil.copytree(RUNNER.parent, copy, ignore=shutil.ignore_patterns("__pycache__"))
    text = (copy / "uml.py").read_text()
    for before, after in changes:
        assert before in text
        text = text.replace(before, after)
    (copy / "uml.py").write_text(text)
    return [PYTHON, str(copy / "with_vcan.py"), "--force", "uml"]


def test_processor_with_more_registers_than_the_kernel_keeps_is_told_by_its_flags():
    sys.path.insert(0, str(RUNNER.parent))
    import uml
    assert uml.needs_wide_registers("model name\t: amx_tile\nflags\t\t: fpu avx512f amx_bf16 amx_tile amx_int8\n")
    assert not uml.needs_wide_registers("model name\t: amx_tile\nflags\t\t: fpu sse2 avx512f\n")
    assert not uml.needs_wide_registers("")


@pytest.mark.skipif(os.uname().machine != "x86_64", reason="registers of another processor")
def test_guest_whose_registers_are_passed_on_computes_as_the_host_does(tmp_path):
    sums = [sys.executable, "-c", "print(sum(k ** 0.5 for k in range(100000)), 'x' * 70 + str(hash(0.1)))"]
    told = run(*sums, uml=changed_runner(tmp_path, ('"amx_tile"', '"fpu"')), text=True)
    assert told.returncode == 0, told.stderr
    assert told.stdout == subprocess.run(sums, capture_output=True, text=True, check=True).stdout


def test_missing_compiler_is_told_where_one_is_needed(tmp_path):
    without = changed_runner(tmp_path, ('"amx_tile"', '"fpu"'), ('which("cc"', 'which("no-cc"'),
                             ('which("gcc"', 'which("no-gcc"'))
    told = run("true", uml=without, text=True)
    assert told.returncode == 4
    assert "AMX" in told.stderr and "apt-get install" in told.stderr and "gcc" in told.stderr


@pytest.mark.parametrize("options, word", [(["--memory", "lots"], '"lots"'), (["--memory", "1M"], '"1M"'),
                                           (["--interfaces", "a b"], '"a b"'), (["--nope"], "--nope")])
def test_wrong_flags_are_usage_errors(options, word):
    done = run("true", options=options, text=True)
    assert done.returncode == 2
    assert word in done.stderr


def test_no_command_is_a_usage_error():
    assert run().returncode == 2


def test_folder_that_is_not_inside_is_named():
    done = run("true", cwd="/proc/self/task", text=True)
    assert done.returncode == 3
    assert "cannot be entered" in done.stderr
