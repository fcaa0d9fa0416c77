# SPDX-License-Identifier: Apache-2.0
"""Which format a recording has, by what stands in it; the name of the file only breaks a tie."""
from __future__ import annotations

import re
from collections.abc import Callable
from typing import NamedTuple

from .readers import busmaster, gvret, pcap, python_can
from .source import Source

NATIVE, READ, TABLE, KNOWN = "native", "read", "table", "known"


class Format(NamedTuple):
    key: str  # for --format
    name: str
    how: str = READ  # by: NATIVE: the programs; READ: this package; TABLE: the same, as signals; KNOWN: nothing
    advice: str = ""


BLF, TRC, CSV = Format("blf", "Vector BLF"), Format("trc", "PEAK TRC"), Format("csv", "python-can CSV")
DB, MF4 = Format("db", "python-can SQLite"), Format("mf4", "MF4")
GVRET, BUSMASTER = Format("gvret", "GVRET CSV"), Format("busmaster", "BUSMASTER log")
PCAP, PCAPNG = Format("pcap", "PCAP"), Format("pcapng", "PCAPNG")
READABLE = (BLF, TRC, CSV, DB, MF4, GVRET, BUSMASTER, PCAP, PCAPNG)

CANDUMP = Format("candump", "candump log", NATIVE)
ASC = Format("asc", "Vector ASC", NATIVE)
SLCAN = Format("slcan", "SLCAN text", NATIVE)
HEX = Format("hex", "raw hex lines", NATIVE)
MDF3 = Format("mdf3", "MDF 3", TABLE)
PARQUET = Format("parquet", "Parquet", TABLE)
RACE_CAPTURE = "export it as CSV from the logger's own program"


def known(key: str, name: str, advice: str) -> Format:
    return Format(key, name, KNOWN, advice)


VSB = known("vsb", "Intrepid VSB", "export it as BLF, ASC or MF4 from Vehicle Spy")
SIGNATURES: tuple[tuple[int, bytes, Format], ...] = (
    (0, b"LOGG", BLF), (0, b"SQLite format 3\0", DB), (0, pcap.PCAPNG, PCAPNG), (0, b"PAR1", PARQUET),
    *((0, magic, PCAP) for magic in pcap.PCAP),
    (0, b"\x89HDF\r\n\x1a\n", known("hdf5", "HDF5 (or MATLAB 7.3)", "write its columns as CSV or Parquet")),
    (0, b"MATLAB 5.0 MAT-file", known("mat", "MATLAB .mat", "write its columns as CSV: `writetable(t, 'log.csv')`")),
    (0, b"<h", known("xrk", "AiM XRK/DRK", "export it as CSV from RaceStudio")),
    (0, b"\x40\0\0\0\0\0\0\0", known("ld", "MoTeC LD", "export it as CSV from MoTeC i2")),
    (0, b"icsbin", VSB),
    (0, b"PK\x03\x04", known("zip", "a ZIP archive (or an Excel sheet)", "unzip it; save a sheet as CSV")),
    (0, b"7z\xbc\xaf\x27\x1c", known("7z", "a 7-Zip archive", "unpack it with `7z x`")),
    (0, b"\xfd7zXZ\0", known("xz", "an xz packing", "unpack it with `xz -d`")),
    (0, b"BZh", known("bz2", "a bzip2 packing", "unpack it with `bunzip2`")),
    (0, b"Rar!\x1a\x07", known("rar", "a RAR archive", "unpack it with `unrar x`")),
    (257, b"ustar", known("tar", "a tar archive", "unpack it with `tar xf`")),
    (0, b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", known("xls", "an old Excel sheet", "save it as CSV")),
    (0, b"%PDF", known("pdf", "a PDF document", "name the recording itself")),
    (0, b"\x89PNG", known("png", "a picture", "name the recording itself")),
    (0, b"\x89MCAP0\r\n", known("mcap", "MCAP", "it was made from a recording: name that one")),
    (0, b"ICSLOG", VSB),
)
SUFFIXES: dict[str, Format] = {  # where the content says nothing
    ".kme50": known("kme", "Kvaser Memorator KME", "convert it to ASC, BLF or MF4 with Kvaser Converter"),
    ".kme60": known("kme", "Kvaser Memorator KME", "convert it to ASC, BLF or MF4 with Kvaser Converter"),
    ".kme40": known("kme", "Kvaser Memorator KME", "convert it to ASC, BLF or MF4 with Kvaser Converter"),
    ".kmf": known("kmf", "Kvaser Memorator KMF", "convert it to ASC, BLF or MF4 with Kvaser Converter"),
    ".ld": known("ld", "MoTeC LD", "export it as CSV from MoTeC i2"),
    ".ldx": known("ldx", "MoTeC LDX (notes beside a recording)", "export the .ld as CSV from MoTeC i2"),
    ".xrk": known("xrk", "AiM XRK/DRK", "export it as CSV from RaceStudio"),
    ".drk": known("xrk", "AiM XRK/DRK", "export it as CSV from RaceStudio"),
    ".xrz": known("xrz", "AiM XRZ", "export it as CSV from RaceStudio"),
    ".vsb": VSB,
    ".blf": known("blf", "Vector BLF without its mark LOGG", "the file is damaged: copy it from the logger again"),
    ".mat": known("mat", "MATLAB .mat", "write its columns as CSV: `writetable(t, 'log.csv')`"),
}
VBO = known("vbo", "RaceLogic VBO", "export it as CSV from the VBOX tools or Circuit Tools")
SEEN = re.compile(rb"\([-\d.]+\) +\S+ +[0-9A-Fa-f]+#")
SCREEN = re.compile(rb" *(?:\([-\d.: ]+\))? *\S+ +(?:R?X +[-BE]+ +)?[0-9A-Fa-f]{3,8} +\[\d+\]")
ASC_LINE = re.compile(rb"(?:date |base (?:hex|dec)|\s*\d+\.\d+ +(?:\d+|CANFD) )")
TRC_LINE = re.compile(rb"\s*\d+\) +[\d.]+ ")
HEX_LINE = re.compile(rb"[0-9A-Fa-f]{8}x[0-9A-Fa-f]{24}$")
SLCAN_LINE = re.compile(rb"(?:[tr][0-9A-Fa-f]{3}|[TRx][0-9A-Fa-f]{8})[0-8](?:[0-9A-Fa-f]{2})*[\r\n]?$")
TEXTS: tuple[tuple[Callable[[bytes], object], Format], ...] = (
    (SEEN.match, CANDUMP), (HEX_LINE.match, HEX), (SLCAN_LINE.match, SLCAN), (SCREEN.match, CANDUMP),
    (TRC_LINE.match, TRC), (ASC_LINE.match, ASC),
)


def text_format(head: bytes) -> Format | None:
    lines = [line.strip(b"\r") for line in head.removeprefix(b"\xef\xbb\xbf").split(b"\n")]
    first = next((line for line in lines if line.strip()), b"").lower()
    if first.startswith(busmaster.MAGIC.lower().encode()):
        return BUSMASTER
    if first.replace(b" ,", b",").startswith(gvret.HEADER.encode()):
        return GVRET
    if first == python_can.CSV_HEADER.encode():
        return CSV
    if first.startswith(b"file created on ") and b"[header]" in head.lower():
        return VBO
    if first.startswith(b";$fileversion") or first.startswith(b";###"):
        return TRC
    for line in lines[:50]:
        for matches, format in TEXTS:
            if matches(line):
                return format
    return None


def mdf(head: bytes) -> Format | None:
    if head[:8] not in (b"MDF     ", b"UnFinMF "):
        return None
    return MF4 if head[8:9] == b"4" else MDF3


def sniff(source: Source) -> Format | None:
    head = source.head()
    found = mdf(head)
    for at, magic, format in () if found else SIGNATURES:
        if head.startswith(magic, at):
            found = format
            break
    if found:
        return found
    text = None if b"\0" in head else text_format(head)
    return text or SUFFIXES.get(source.suffix)
