# SPDX-License-Identifier: Apache-2.0
"""The command line: `voltlap orion import` and `voltlap orion show`."""
from __future__ import annotations

import argparse
import os
import pathlib
import sys
import tempfile

from voltlap_logs.errors import LogError, run

from voltlap_orion.bean_file import read_bean
from voltlap_orion.cell_choice import ASSUMED, choose_cell
from voltlap_orion.pack_file import cell_doubt, pack_text
from voltlap_orion.profile import Profile
from voltlap_orion.show import profile_lines

WHAT = "The profile of an Orion BMS 2 (.o2bms), shown or made into a pack file of ours."
EPILOG = f"""voltlap orion import PROFILE [--cell CELL] [--output PACK.toml]
  a pack file for `voltlap replay --pack` and `voltlap endurance --vehicle`: cells, capacity, limits, each with the
  place that it comes from, and what has no counterpart. Without --cell the cell is assumed: {ASSUMED}.
voltlap orion show PROFILE [--all]
  its settings with units, whether certain or inferred; --all: every other property as it stands, too

Example: voltlap orion import car.o2bms --output pack.toml
docs/orion.md says how the units were found. Exit code: 0; 2 usage or input."""


def parser() -> argparse.ArgumentParser:
    out = argparse.ArgumentParser(prog="voltlap orion", description=WHAT, epilog=EPILOG, allow_abbrev=False,
                                  formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = out.add_subparsers(dest="command", required=True, metavar="import|show")
    importing = commands.add_parser("import", help="a pack file from a profile", allow_abbrev=False)
    importing.add_argument("profile", metavar="PROFILE", help="profile of an Orion BMS 2 (.o2bms)")
    importing.add_argument("--cell", help=f"name of a cell or path of a cell file (assumed: {ASSUMED})")
    importing.add_argument("--output", metavar="PACK.toml", help="file to write; without it standard output")
    showing = commands.add_parser("show", help="what is in a profile", allow_abbrev=False)
    showing.add_argument("profile", metavar="PROFILE", help="profile of an Orion BMS 2 (.o2bms)")
    showing.add_argument("--all", action="store_true", help="the properties that are not understood, too")
    return out


def check_output(output: pathlib.Path, inputs: list[pathlib.Path]) -> None:
    """No result is written over a file that the run reads, however the names are spelled."""
    for path in inputs:
        if output.exists() and output.samefile(path):
            raise LogError(f"--output: found {output}, which is {path}; expected a file that is not read. "
                           "Give another name.")
    if output.is_dir() or not output.name:
        raise LogError(f"--output: found the folder {output}; expected a file. Give a name in it.")


def write_whole(output: pathlib.Path, text: str) -> None:
    """The file is there as a whole, or as it was."""
    if output.exists() and not output.is_file():  # a device, a pipe
        output.write_text(text, encoding="utf-8")
        return
    target = output.resolve()
    handle, name = tempfile.mkstemp(prefix=f".{target.name}.", dir=target.parent)
    try:
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        mask = os.umask(0)
        os.umask(mask)
        os.chmod(name, target.stat().st_mode & 0o777 if target.exists() else 0o666 & ~mask)
        os.replace(name, target)
    except BaseException:
        pathlib.Path(name).unlink(missing_ok=True)
        raise


def import_profile(arguments: argparse.Namespace) -> int:
    cell = choose_cell(arguments.cell)
    output = pathlib.Path(arguments.output) if arguments.output is not None else None
    if output is not None:
        check_output(output, [pathlib.Path(arguments.profile), cell.path])
    profile = Profile(read_bean(arguments.profile))
    text, doubt = pack_text(profile, cell), cell_doubt(profile, cell)
    if output is None:
        sys.stdout.write(text)
        return 0
    try:
        write_whole(output, text)
    except OSError as error:
        raise LogError(f"--output: {output} cannot be written ({error.strerror or error}). "
                       "Give a file in a folder that is there.") from error
    print(f"{output}: pack of {arguments.profile}, cell {cell.name}" + (" (assumed)" if cell.assumed else ""))
    if doubt:
        print(f"  {doubt} --cell takes a file of it")
    return 0


def show_profile(arguments: argparse.Namespace) -> int:
    profile = Profile(read_bean(arguments.profile))
    sys.stdout.write("\n".join(list(profile_lines(profile, arguments.all))) + "\n")
    return 0


def main(words: list[str] | None = None) -> int:
    arguments = parser().parse_args(words)
    command = {"import": import_profile, "show": show_profile}[arguments.command]
    return run(lambda: command(arguments))


if __name__ == "__main__":
    sys.exit(main())
