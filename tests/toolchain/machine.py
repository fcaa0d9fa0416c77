# SPDX-License-Identifier: Apache-2.0
"""A machine for the start script, played by stand-ins for the programs that it calls."""
import os
import shutil
import subprocess
import sys

from copies import BUILT_FROM, HANG_S, LEFT_OUT, PROJECT, copy_project

BASH = shutil.which("bash")
CHMOD = shutil.which("chmod")
# Programs of a minimal Debian that the script may use as they are.
BORROWED = ("bash", "cat", "dirname", "env", "flock", "grep", "head", "mkdir", "nproc", "readlink", "rm", "sed",
            "sleep", "tail", "tee", "tr")


class Machine:
    """A copy of the project in a folder with a blank, and a PATH of stand-ins: dpkg knows every package, and what
    builds only writes down that it was called and makes what the script looks for."""

    def __init__(self, folder):
        self.project, self.tools, self.calls = folder / "my project", folder / "tools", folder / "calls"
        self.tools.mkdir(parents=True)
        self.apt_lists = folder / "lists"
        self.calls.touch(0o666)
        copy_project(self.project, without=BUILT_FROM)
        shutil.copytree(PROJECT / "plant_sim" / "python", self.project / "plant_sim" / "python",
                        ignore=shutil.ignore_patterns(*LEFT_OUT))  # commands that nothing is built for
        packages = self.project / "toolchain" / "setup" / "packages.sh"
        packages.write_text(packages.read_text().replace("/usr/bin/python3", str(self.tools / "python3"))
                            .replace("/var/lib/apt/lists", str(self.apt_lists)))
        for name in BORROWED:
            (self.tools / name).symlink_to(shutil.which(name))
        self.is_root()
        self.knows_packages()
        self.configures()
        self.builds()
        self.makes_environments()

    def stand_in(self, name, body):
        path = self.tools / name
        path.unlink(missing_ok=True)
        path.write_text(f'#!{BASH}\necho "{name} $*" >>"{self.calls}"\n{body}\n')
        path.chmod(0o755)

    def is_root(self, yes=True):
        self.stand_in("id", f"echo {0 if yes else 1000}")

    def knows_packages(self, but=("-",)):
        self.stand_in("dpkg-query", f'for name in "${{@:3}}"; do case $name in {"|".join(but)}) ;; '
                                    '*) echo "$name installed";; esac; done')

    def distributes(self, but=()):
        """apt, which has every package but these, and knows it after an update."""
        self.stand_in("apt-get", f"""[ "$1" = update ] || exit 0
            mkdir -p "{self.apt_lists}"; : >"{self.apt_lists}/a_Packages" """)
        self.stand_in("apt-cache", f'case "$2" in {"|".join(but) or "-"}) echo "  Candidate: (none)";; '
                                   '*) echo "  Candidate: 1.0";; esac; printf "%.0s  Version table\n" {1..20000}')

    def configures(self):
        """cmake, which keeps what the script asks the cache for."""
        self.stand_in("cmake", """mkdir -p build/default; : >build/default/build.ninja
            echo "CMAKE_HOME_DIRECTORY:INTERNAL=$PWD" >build/default/CMakeCache.txt
            for flag in "$@"; do
              case $flag in -D*=ON) flag=${flag#-D}; echo "${flag%=ON}:BOOL=ON" >>build/default/CMakeCache.txt;; esac
            done""")

    def builds(self, first=""):
        """ninja, which makes the program; the program echoes its arguments."""
        self.stand_in("ninja", f"""{first}
            mkdir -p "$2/bin"; printf '#!{BASH}\\necho "program: $*"\\n' >"$2/bin/voltlap"
            {CHMOD} +x "$2/bin/voltlap" """)

    def makes_environments(self, pip=""):
        """python3 -m venv --clear DIR; other calls are Python's own."""
        self.stand_in("python3", f"""[ "$1 $2" = "-m venv" ] || exec "{sys.executable}" "$@"
            rm -rf "$4"/*; mkdir -p "$4/bin"
            printf '#!{BASH}\\necho "python $*" >>"{self.calls}"\\n{pip}\\n' >"$4/bin/python"
            {CHMOD} +x "$4/bin/python" """)

    def environment(self, **more):
        clean = {key: value for key, value in os.environ.items() if key not in ("CI", "VOLTLAP_BUILD_DIR")}
        return {**clean, "PATH": str(self.tools), **more}

    def start(self, *arguments, script=None, folder=None, user=None, **more):
        return subprocess.run([script or self.project / "voltlap", *arguments], cwd=folder, user=user,
                              env=self.environment(**more), stdin=subprocess.DEVNULL, capture_output=True, text=True,
                              timeout=HANG_S)

    def called(self, name):
        """The calls of one stand-in since the last look at any."""
        lines = self.calls.read_text().splitlines()
        self.calls.write_text("")
        return [line.removeprefix(name + " ") for line in lines if line.split(" ")[0] == name]
