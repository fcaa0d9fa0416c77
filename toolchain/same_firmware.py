#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Whether a change of the firmware left its behaviour alone: both nodes of an earlier commit and of this checkout are
given the same drawn frames, call by call, and every frame that they send is compared, byte by byte.

The inputs come from a drawn car with its driver, so that the nodes get into all their states, with troubles in the car,
frames that are lost, late, repeated or damaged, power-downs, and other configurations. A difference is printed decoded,
with the shortest input that was found to show it. The same seed draws the same inputs.
"""
import argparse
import contextlib
import functools
import io
import json
import os
import shutil
import signal
import subprocess
import sys
import tarfile
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
DRIVER = Path(__file__).resolve().parent / "same_firmware"
SOURCES = ("firmware", "can_dbc")
NODES = ("base", "codec", "bms", "master", "app")  # folders of firmware/ that make the nodes, with those inside
COMPARISON = ("car", "bus", "settings", "pair", "run", "shrink", "main")
EXIT_DIFFERENT, EXIT_USAGE, EXIT_BUILD, EXIT_DEFECT, EXIT_INTERRUPTED = 1, 2, 5, 70, 130
LINES_SHOWN = 30  # of the short input; all of it goes to the file
NINJA = """\
nodes_flags = -std=c++17 -fno-exceptions -fno-rtti -fno-threadsafe-statics -fPIC -fvisibility=hidden
rule nodes
  command = cd $folder && {compiler} -O2 $nodes_flags -Ifirmware -Icodecs -I{driver} -MD -MF $out.d -c $source -o $out
  depfile = $out.d
  description = compiling $source
rule library
  command = {compiler} -shared -o $out $in
rule comparison
  command = {compiler} -O2 -std=c++20 -I{present}/firmware -I{present}/codecs -I{driver} $in -o $out -ldl
"""


class Refused(Exception):
    """What a person can mend, with the exit code."""

    def __init__(self, code, text):
        super().__init__(text)
        self.code = code


def arguments():
    parser = argparse.ArgumentParser(
        prog="voltlap same-firmware", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="Example: ./voltlap same-firmware HEAD~1\n"
               "Exit code: 0 equal, 1 different, 2 usage, 5 a version does not build or does not fit, 130 interrupted.")
    parser.add_argument("old", metavar="COMMIT", help="the version to compare with, as git names it")
    parser.add_argument("--calls", type=int, default=10_000_000, metavar="N", help="calls of a node (10 million)")
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="of everything drawn, 0 to 2^31 - 1 (1)")
    parser.add_argument("--present", type=Path, default=ROOT, metavar="DIR",
                        help="another checkout in place of this one")
    given = parser.parse_args()
    if given.calls < 1:
        parser.error(f"--calls {given.calls}: 1 or more is expected")
    if not 0 <= given.seed < 2**31:
        parser.error(f"--seed {given.seed}: 0 to 2^31 - 1 is expected")
    for part in SOURCES:
        if not (given.present / part).is_dir():
            parser.error(f"--present {given.present}: there is no folder {part} in it")
    return given


def run(command, **settings):
    """Output of a command that leaves nothing running, whatever ends this program."""
    # An interruption amid the start would leave a process that nobody knows: it waits until there is one to end.
    before = signal.pthread_sigmask(signal.SIG_BLOCK, (signal.SIGINT, signal.SIGTERM))
    hear = functools.partial(signal.pthread_sigmask, signal.SIG_SETMASK, before)
    try:
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True,
                                   preexec_fn=hear, **settings)
    except BaseException:
        hear()
        raise
    with process:
        try:
            hear()
            output, errors = process.communicate()
        except BaseException:
            with contextlib.suppress(ProcessLookupError):  # it has just ended by itself
                os.killpg(process.pid, signal.SIGTERM)
            process.wait()
            raise
    return subprocess.CompletedProcess(command, process.returncode, output, errors)


def checked(command, code, what, **settings):
    done = run(command, **settings)
    if done.returncode != 0:
        said = (done.stdout + done.stderr).decode(errors="replace").strip()
        raise Refused(code, f"{what}\n{said[-4000:]}")
    return done.stdout


def commit_of(name):
    if shutil.which("git") is None or run(["git", "-C", ROOT, "rev-parse", "--git-dir"]).returncode != 0:
        raise Refused(EXIT_USAGE, f"{ROOT} is no git checkout, so that there is no earlier version in it")
    done = run(["git", "-C", ROOT, "rev-parse", "--verify", "--quiet", "--end-of-options", name + "^{commit}"])
    if done.returncode != 0:
        raise Refused(EXIT_USAGE, f"there is no commit {name!r} here; `git log --oneline` lists them")
    return done.stdout.decode().strip()


def extract(commit, folder):
    archive = checked(["git", "-C", ROOT, "archive", commit, *SOURCES], EXIT_BUILD,
                      f"commit {commit[:12]} does not hold {' and '.join(SOURCES)}")
    with tarfile.open(fileobj=io.BytesIO(archive)) as tar:
        tar.extractall(folder, **({"filter": "data"} if hasattr(tarfile, "data_filter") else {}))


def copy(present, folder):
    for part in SOURCES:
        shutil.copytree(present / part, folder / part, ignore=shutil.ignore_patterns("__pycache__"))


def generate_codecs(folder, name):
    checked([sys.executable, "can_dbc/generate.py", "--out", "codecs"], EXIT_BUILD,
            f"the codecs of {name} cannot be generated from its can_dbc:", cwd=folder)


def node_objects(folder):
    """Lines of the build file for one version, and its shared object."""
    sources = [path for part in NODES for path in sorted((folder / "firmware" / part).rglob("*.cpp"))]
    lines, objects = [], []
    for source in [*sources, DRIVER / "nodes.cpp"]:
        inside = source.relative_to(folder) if source.is_relative_to(folder) else source
        objects.append(folder / "objects" / (str(inside).strip("/").replace("/", "_") + ".o"))
        lines.append(f"build {objects[-1]}: nodes\n  folder = {folder}\n  source = {inside}")
    library = folder / "nodes.so"
    return [*lines, f"build {library}: library {' '.join(map(str, objects))}"], library


def build(folder, old_name):
    """(program, shared object of the old version, of the present one)."""
    compiler = " ".join(filter(None, [shutil.which("ccache"), os.environ.get("CXX", "c++")]))
    old, present = folder / "old", folder / "present"
    text = [NINJA.format(compiler=compiler, driver=DRIVER, present=present)]
    libraries = {}
    for version in (present, old):
        (version / "objects").mkdir()
        lines, libraries[version] = node_objects(version)
        text += lines
    program = folder / "same_firmware"
    sources = [*(DRIVER / f"{name}.cpp" for name in COMPARISON), present / "firmware/codec/seal.cpp",
               present / "firmware/base/require.cpp"]
    text.append(f"build {program}: comparison {' '.join(map(str, sources))}")
    (folder / "build.ninja").write_text("\n".join(text) + "\n")
    ninja = ["ninja", "-C", folder, "--quiet"]
    door = DRIVER.name + "/nodes.cpp"
    checked([*ninja, program, libraries[present]], EXIT_BUILD,
            f"the present version does not build, or no longer has the interface that {door} is written for:")
    checked([*ninja, libraries[old]], EXIT_BUILD,
            f"{old_name} does not build with {door}: its nodes do not have the interface that the present ones have:")
    return program, libraries[old], libraries[present]


class Words:
    """Frames and codes as the DBC files of the present version name them."""

    def __init__(self, can_dbc):
        import cantools
        sys.path.insert(0, str(can_dbc))
        import model  # the names of the bits, which are an attribute of this project
        files = [can_dbc / name for name in ("car.dbc", "orion.dbc", "charger.dbc", "pm100.dbc", "amk.dbc")]
        self.base = cantools.database.Database()
        for file in files:
            self.base.add_dbc_file(file)
        self.bits = {(message.name, s.name): s.bit_names for message in model.load(files).messages
                     for s in message.signals if s.bit_names}

    def codes(self, message, signal_name):
        choices = self.base.get_message_by_name(message).get_signal_by_name(signal_name).choices
        return [str(choices[code]) for code in sorted(choices)]

    def signals(self, frame):
        """Name of the message, and its signals as texts; what cannot be decoded stays in hexadecimal."""
        identifier, data = frame[0], bytes.fromhex(frame[1])
        try:
            message = self.base.get_message_by_frame_id(identifier)
        except KeyError:
            return f"0x{identifier:03X}", {"data": frame[1]}
        if len(data) != message.length:
            return message.name, {"data": frame[1], "length": str(len(data))}
        decoded = message.decode(data, allow_truncated=False)
        return message.name, {s.name: self.value(message.name, s, decoded[s.name]) for s in message.signals}

    def value(self, message, signal_of_base, value):
        names = self.bits.get((message, signal_of_base.name))
        if names and isinstance(value, int):
            return " and ".join(name for bit, name in enumerate(names) if value >> bit & 1) or "none"
        number = f"{value:.10g}" if isinstance(value, (int, float)) else str(value)
        return f"{number} {signal_of_base.unit or ''}".strip()

    def text(self, frame):
        name, signals = self.signals(frame)
        told = (f"{key} {value}" for key, value in signals.items() if key not in ("Crc", "Counter"))
        return f"{name}: " + ", ".join(told)


def entered(words, message, signal_name, counts):
    names = words.codes(message, signal_name)
    return ", ".join(f"{name} {count}" for name, count in zip(names, counts) if count or name != "Invalid")


def text_of_equal(result, words, old_name, seed):
    drive_states = entered(words, "MasterStatus", "DriveState", result["drive_states"])
    bms_states = entered(words, "BmsStatus", "State", result["bms_states"])
    master_faults, bms_faults = (sum(map(bool, result[name])) for name in ("master_faults", "bms_faults"))
    text = (f"equal: {result['calls']} node calls in {result['runs']} runs, seed {seed}, {old_name} and present; "
            f"entered: drive states {drive_states}; BMS states {bms_states}; torque in {result['torque_ticks']} ticks; "
            f"faults seen: {master_faults} of the master, {bms_faults} of the BMS")
    return text + (f"; {result['failures']} requirements failed in both" if result["failures"] else "")


def lines_of_answers(step, words):
    """What the versions sent differently in a step."""
    old, present = step["old"], step["present"]
    for name, answer in (("old", old), ("present", present)):
        if answer["failure"]:
            yield f"  {name}: stopped, {answer['failure']} is not so"
    if old["failure"] or present["failure"]:
        return
    for a, b in zip(old["frames"], present["frames"]):
        if a == b:
            continue
        (name, before), (other, after) = words.signals(a), words.signals(b)
        yield f"  {name} old {a[0]:03X}#{a[1]}, {other} present {b[0]:03X}#{b[1]}"
        for key in before:
            if before[key] != after.get(key):
                yield f"    {key}: {before[key]} old, {after.get(key, 'absent')} present"
    if len(old["frames"]) != len(present["frames"]):
        yield f"  {len(old['frames'])} frames old, {len(present['frames'])} present"


def lines_of_input(result, words):
    settings = ", ".join(f"{name} {value}" for name, value in result["settings"].items())
    yield f"  settings: {settings or 'those of the firmware by itself'}"
    for step in result["steps"]:
        begin = "; power off and on before it" if step["restart"] else ""
        yield f"  at {step['now_ms']} ms{begin}" + (", no frame" if not step["rx"] else "")
        yield from (f"    {words.text(frame)}" for frame in step["rx"])


def print_difference(result, words, old_name, seed, file):
    print(f"different: seed {seed}, run {result['run'] & 0xFFFFFFFF}, tick {result['tick']}, {result['node']} node, "
          f"{old_name} against present; in the short input:")
    answers, given = list(lines_of_answers(result["steps"][-1], words)), list(lines_of_input(result, words))
    print("\n".join(answers))
    print(f"shortest input found: {len(result['steps'])} steps of {result['steps_before']} since power-on")
    print("\n".join(given[:LINES_SHOWN]))
    if len(given) > LINES_SHOWN:
        print(f"  ... {len(given) - LINES_SHOWN} lines more")
    file.write_text("\n".join([*given, "answers to the last step:", *answers]) + "\n")
    print(f"all of it: {file}")


def compare(given, folder):
    file = folder.parent / "difference.txt"
    file.unlink(missing_ok=True)
    commit = commit_of(given.old)
    old_name = given.old if commit.startswith(given.old) else f"{given.old} ({commit[:12]})"
    extract(commit, folder / "old")
    copy(given.present, folder / "present")
    for version, name in (("old", old_name), ("present", "the present version")):
        generate_codecs(folder / version, name)
    program, old, present = build(folder, old_name)
    done = run([program, old, present, str(given.calls), str(given.seed)])
    if done.returncode not in (0, EXIT_DIFFERENT):
        raise Refused(EXIT_DEFECT, f"the comparison itself ended with {done.returncode}: "
                                   f"{done.stderr.decode(errors='replace')}")
    result, words = json.loads(done.stdout), Words(folder / "present" / "can_dbc")
    if done.returncode == 0:
        print(text_of_equal(result, words, old_name, given.seed))
    else:
        print_difference(result, words, old_name, given.seed, file)
    return done.returncode


def main():
    given = arguments()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.default_int_handler)
    place = ROOT / "build" / "same_firmware"
    try:
        place.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=place) as folder:
            return compare(given, Path(folder))
    except Refused as reason:
        print(f"same-firmware: {reason}", file=sys.stderr)
        return reason.code
    except KeyboardInterrupt:
        print("\nsame-firmware: interrupted; nothing is kept", file=sys.stderr)
        return EXIT_INTERRUPTED


if __name__ == "__main__":
    sys.exit(main())
