# SPDX-License-Identifier: Apache-2.0
"""Reads a recording of a CAN bus and writes its frames as candump lines.

    python -m voltlap_logs.frames FILE [--format NAME]
    python -m voltlap_logs.frames --sniff FILE

The format is told by the content. The frames go to stdout in the order of the file; a bus is called by its interface's
name where the file has one, else `can<number of the channel in the file>`. Stamps have six decimals, nine where the
format carries nanoseconds. Receiving and sending are not told apart. The last line on stderr is JSON: how many frames,
what was skipped, the format. Exit code 0; 2 nothing could be read; 3 the file breaks off, and what stood before that
was written.
"""
from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from .errors import BROKE_OFF, BrokenOff, LogError, run
from .readers import blf, busmaster, gvret, mf4, pcap, python_can, trc
from .sniff import KNOWN, NATIVE, READABLE, TABLE, Format, sniff
from .source import Progress, Source
from .tally import Tally

PROGRAM = "voltlap_logs.frames"
READERS: dict[str, Callable[[Source, Tally], Iterator[str]]] = {
    "blf": blf.read, "trc": trc.read, "csv": python_can.read_csv, "db": python_can.read_sqlite, "mf4": mf4.read,
    "gvret": gvret.read, "busmaster": busmaster.read, "pcap": pcap.read_pcap, "pcapng": pcap.read_pcapng,
}


def chosen(source: Source, key: str | None) -> Format:
    """The format asked for, else what the content says; a LogError when this program does not read it."""
    if key:
        return next(format for format in READABLE if format.key == key)
    if not source.size:
        raise LogError(f"{source.path}: is empty; expected a recording: copy it from the logger again")
    found = sniff(source)
    if found is None:
        raise LogError(f"{source.path}: no format that is known begins with {source.head(24)!r}; expected one of "
                       f"{', '.join(format.name for format in READABLE)}: export it as one of these, or name it with "
                       "--format")
    if found.how == NATIVE:
        raise LogError(f"{source.path}: a {found.name}, which the programs read themselves: give it to `voltlap` as it "
                       "is")
    if found.how == TABLE:
        raise LogError(f"{source.path}: {found.name} holds signals, not frames: list them with "
                       "`python -m voltlap_logs.tables`")
    if found.how == KNOWN:
        raise LogError(f"{source.path}: {found.name}, which is not read here: {found.advice}")
    return found


def write_lines(source: Source, tally: Tally, lines: Iterator[str]) -> str | None:
    """Everything that the reader gives, to stdout. Where the recording breaks off, or None."""
    progress, parts, size = Progress(str(source.path)), [], 0
    broken = None
    try:
        for text in lines:
            tally.frames += text.count("\n")
            parts.append(text)
            size += 1
            if size >= 4096 or len(text) > 4096:
                sys.stdout.write("".join(parts))
                parts, size = [], 0
                share = source.part_read()
                progress.tell(f"{tally.frames} frames" + (f", {100 * share:.0f} %" if share is not None else ""))
    except BrokenOff as at:
        broken = str(at)
    finally:
        sys.stdout.write("".join(parts))
        sys.stdout.flush()
        progress.done()
    return source.broken or broken


def convert(path: Path, key: str | None) -> int:
    with Source(path) as source:
        format = chosen(source, key)
        tally = Tally(format.name)
        try:
            broken = write_lines(source, tally, READERS[format.key](source, tally))
        except LogError as error:
            if source.broken:
                raise LogError(f"{path}: breaks off before its first frame: {source.broken}; copy it again") from error
            raise
    if not tally.frames and not source.broken and tally.skipped["unreadable lines"]:
        raise LogError(f"{path}: no line of it is a frame of {tally.format}, the first: "
                       f"{tally.first['unreadable lines']}; expected that format: leave --format out, or look at the "
                       "file")
    for kind, where in tally.first.items():
        print(f"{path}: {tally.skipped[kind]} {kind}, the first: {where}", file=sys.stderr)
    if broken:
        print(f"{path}: breaks off: {broken}; {tally.frames} frames before that were read", file=sys.stderr)
    print(tally.json(), file=sys.stderr)
    return BROKE_OFF if broken else 0


def arguments(given: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(PROGRAM, description="Reads a recording of a CAN bus, writes candump lines.")
    parser.add_argument("file", type=Path)
    parser.add_argument("--format", choices=[format.key for format in READABLE], help="default: told by the content")
    parser.add_argument("--sniff", action="store_true", help="print the name of the format and read nothing")
    return parser.parse_args(given)


def main(given: Sequence[str] | None = None) -> int:
    options = arguments(given)

    def work() -> int:
        if not options.sniff:
            return convert(options.file, options.format)
        with Source(options.file) as source:
            found = sniff(source)
        print(f"{found.key}\t{found.how}\t{found.name}" if found else "unknown")
        return 0

    return run(work)


if __name__ == "__main__":
    sys.exit(main())
