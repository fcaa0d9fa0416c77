# SPDX-License-Identifier: Apache-2.0
"""Runs a command of this program with the firmware of another commit: python -m voltlap_firmware_at COMMIT -- ARGUMENTS

The tree that is built is this checkout as it stands, with the folders firmware/ and can_dbc/ of the commit in the place
of its own, in build/firmware_at. Prints the commit's name. Exit code 2: what a person can mend, in words.
"""
import contextlib
import fcntl
import filecmp
import io
import os
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
OF_THE_COMMIT = ("firmware", "can_dbc")
PROGRAM = "voltlap-replay"
EXIT_INPUT = 2
ANSWERED = (0, 1)  # 1: our own bus, not answered as recorded; that is what is asked


class Refused(Exception):
    """What a person can mend."""


def git(*arguments):
    done = subprocess.run(["git", "-C", ROOT, *arguments], capture_output=True)
    return done.stdout if done.returncode == 0 else None


def commit_of(name):
    if shutil.which("git") is None or git("rev-parse", "--git-dir") is None:
        raise Refused(f"--firmware {name}: {ROOT} is no git checkout, so that there is no other version in it")
    found = git("rev-parse", "--verify", "--quiet", "--end-of-options", name + "^{commit}")
    if found is None:
        raise Refused(f"--firmware {name}: there is no such commit here; `git log --oneline` lists them")
    return found.decode().strip()


def put(source, target):
    """A file that is as it was keeps its time, so that it is not compiled again."""
    if target.is_file() and filecmp.cmp(source, target, shallow=False):
        return
    target.parent.mkdir(parents=True, exist_ok=True)
    shutil.copy(source, target)


def lay_out(commit, tree):
    """This checkout's files, but for the folders of the commit; what neither has any more goes."""
    listed = git("ls-files", "-z", "--cached", "--others", "--exclude-standard").decode().split("\0")
    present = {name for name in listed if name and name.split("/")[0] not in OF_THE_COMMIT and (ROOT / name).is_file()}
    with tempfile.TemporaryDirectory(dir=tree.parent) as scratch:
        archive = git("archive", commit, *OF_THE_COMMIT)
        if archive is None:
            raise Refused(f"commit {commit[:12]} does not hold {' and '.join(OF_THE_COMMIT)}")
        with tarfile.open(fileobj=io.BytesIO(archive)) as tar:
            tar.extractall(scratch, **({"filter": "data"} if hasattr(tarfile, "data_filter") else {}))
        other = {str(path.relative_to(scratch)) for path in Path(scratch).rglob("*") if path.is_file()}
        for name in present:
            put(ROOT / name, tree / name)
        for name in other:
            put(Path(scratch) / name, tree / name)
    for path in [path for path in tree.rglob("*") if path.is_file()]:
        name = path.relative_to(tree)
        if str(name) not in present | other and "__pycache__" not in name.parts:
            path.unlink()


def as_started():
    """Without what is set for this module alone: the build's own Python programs import their neighbours."""
    return {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "PYTHONSAFEPATH")}


def build(commit, tree, folder):
    configure = ["cmake", "-S", tree, "-B", folder, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=RelWithDebInfo",
                 f"-DVOLTLAP_PYTHON={sys.executable}"]
    if shutil.which("ccache"):
        configure.append("-DCMAKE_CXX_COMPILER_LAUNCHER=ccache")
    for command in (configure, ["ninja", "-C", folder, PROGRAM]):
        done = subprocess.run(command, capture_output=True, text=True, errors="replace", env=as_started())
        if done.returncode != 0:
            said = done.stdout + done.stderr
            lines = [line for line in said.splitlines() if re.search(r"error|No space|Killed", line)]
            raise Refused(f"--firmware {commit[:12]}: its firmware does not fit this program; the first errors:\n"
                          + "\n".join((lines or said.splitlines()[-8:])[:4])
                          + "\nCheck that commit out whole (git worktree add FOLDER COMMIT), replay there with --json, "
                            "and give its result as --baseline here")
    return folder / "bin" / PROGRAM


def run(name, arguments):
    commit = commit_of(name)
    place = ROOT / "build" / "firmware_at" / commit[:12]
    place.mkdir(parents=True, exist_ok=True)
    with open(place / "lock", "w", encoding="utf-8") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # two who ask for one commit build it once
        lay_out(commit, place / "source")
        program = build(commit, place / "source", place / "build")
    done = subprocess.run([program, *arguments], capture_output=True, text=True, errors="replace")
    if done.returncode not in ANSWERED:
        raise Refused(f"the firmware of {commit[:12]} was built, but ended with {done.returncode}:\n{done.stderr.strip()}")
    subject = (git("show", "-s", "--format=%h", commit) or commit.encode()).decode().strip()
    print(subject, end="")


def main():
    name, dashes, *arguments = sys.argv[1:]
    assert dashes == "--"
    try:
        with contextlib.suppress(BrokenPipeError):
            run(name, arguments)
    except Refused as reason:
        print(reason, file=sys.stderr)
        return EXIT_INPUT
    except OSError as error:
        print(f"{error.filename or ROOT}: {os.strerror(error.errno or 0)}", file=sys.stderr)
        return EXIT_INPUT
    return 0


if __name__ == "__main__":
    sys.exit(main())
