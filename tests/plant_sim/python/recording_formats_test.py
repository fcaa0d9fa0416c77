# SPDX-License-Identifier: Apache-2.0
"""Recordings as other programs write them: each kind of line and object becomes the frame that it is, the rest is
counted, and a format that is not read is called by its name."""
import os
import struct
import zlib
from pathlib import Path

import pytest
from recordings import drawn, generator, read, text_of, told

for package in ("asammdf", "can", "numpy"):
    pytest.importorskip(package, reason="needs toolchain/requirements/logs.txt")
import can  # noqa: E402
from voltlap_logs.candump import ERROR, EXTENDED, ID_MASK  # noqa: E402
from voltlap_logs.writers.blf import message  # noqa: E402

DATA = os.environ.get("VOLTLAP_DATA")

TRC_1_0 = """;  Start time: 11.09.2002 10:31:11
;----+- ---+--- ----+--- + -+ -- -- ...
     1)      1841     0001 8 00 00 00 00 00 00 00 00
     2)      1842 FFFFFFFF 4 00 00 00 04 -- -- -- -- BUSLIGHT
     3)      1843 18FFF001 2 AB CD
     4)      1850     0101 3 RTR
"""
TRC_1_1 = """;$FILEVERSION=1.1
;$STARTTIME=45982.5
     1)      17535.4  Tx         0300  8  00 00 01 02 03 04 05 06
     2)      17700.3  Rx     18EFC034  4  F1 1A 06 E2
     3)      17873.8  Warng  FFFFFFFF  4  00 00 00 08  BUSHEAVY
     4)      19295.5  Error      0002  4  00 02 00 00
"""
TRC_1_3 = """;$FILEVERSION=1.3
;$STARTTIME=45982.5
     1)      1000.1 1  Rx        0300 -  3    11 22 33
     2)      1000.2 2  Tx    1FFFFFFF -  0
"""
TRC_2_0 = """;$FILEVERSION=2.0
;$STARTTIME=45982.5
;$COLUMNS=N,O,I,T,d,l,D
      1      1059.900 0300 DT Rx 7  00 00 00 00 04 00 00
      2      1059.901 1FFFFFFF FB Tx 12  00 11 22 33 44 55 66 77 88 99 AA BB
      3      1059.902 0301 RR Rx 8
      4      1059.903 - ST Rx 0
"""
TRC_2_1 = """;$FILEVERSION=2.1
;$STARTTIME=45982.5
;$COLUMNS=N,O,T,B,I,d,R,L,D
      1      1059.900 DT 1      0300 Rx -  3    00 11 22
      2      1059.901 FE 2  18FF0000 Rx -  9    00 01 02 03 04 05 06 07 08 09 0A 0B
      3      1059.902 ER 1         - Rx -  5    04 00 02 00 00
      4      1059.903 EC 1         - Rx -  2    02 02
      5      1059.904 BI 1      0123 Tx -  1    7F
"""
GATEWAY = """;$FILEVERSION=2.0
;$STARTTIME=2025-11-22 16:20:54.721518
;$COLUMNS=N,O,T,I,d,L,B1,B2,B3,B4,B5,B6,B7,B8
     1)   0.000000  can0 Rx 1FFFFFF0 8 01 19 00 07 08 00 00 43
     2)   0.109600  can1 Tx 00000356 6 6E 0B 00 00 A0 00 -- --
"""
GVRET = """Time Stamp,ID,Extended,Dir,Bus,LEN,D1,D2,D3,D4,D5,D6,D7,D8
166064000,0000021A,false,Rx,0,8,FE,36,12,FE,69,05,07,AD,
166065123,18FF0001,true,Tx,1,2,A,B,
"""
GVRET_WITHOUT_DIRECTION = """Time Stamp,ID,Extended,Bus,LEN,D1,D2,D3,D4,D5,D6,D7,D8
1000000,123,false,2,1,7F
"""
GVRET_FD = "Time Stamp,ID,Extended,Dir,Bus,LEN,D1,D2\n5,00000123,false,Rx,0,12,0,1,2,3,4,5,6,7,8,9,A,B,\n"
BUSMASTER = """***BUSMASTER Ver 3.2.2***
***PROTOCOL CAN***
***NOTE: PLEASE DO NOT EDIT THIS DOCUMENT***
***[START LOGGING SESSION]***
***START DATE AND TIME 22:11:2025 12:00:00:250***
***HEX***
***{mode} MODE***
***START CHANNEL BAUD RATE***
***CHANNEL 1 - Kvaser - 500000 bps***
***END CHANNEL BAUD RATE***
***<Time><Tx/Rx><Channel><CAN ID><Type><DLC><DataBytes>***
{times[0]} Rx 1 0x0C5 s 8 23 00 00 00 00 00 00 FF
{times[1]} Tx 2 0x18FFF001 x 2 AB CD
{times[2]} Rx 1 0x101 sr 3
***END DATE AND TIME 22:11:2025 12:00:03:000***
***[STOP LOGGING SESSION]***
"""
NOON = 1763769600 + 43200  # 2025-11-22 12:00 UTC, 45983.5 days; 45982.5 is the day before
BUSMASTER_FRAMES = ["({}) can1 0C5#23000000000000FF", "({}) can2 18FFF001#ABCD", "({}) can1 101#R3"]
BUSMASTER_AT = [f"{NOON}.750000", f"{NOON + 1}.250100", f"{NOON + 2}.000000"]


def busmaster(mode, *times):
    return BUSMASTER.format(mode=mode, times=times)


TEXTS = {
    "TRC 1.0": (TRC_1_0, ["(1.841000) can1 001#0000000000000000", "(1.843000) can1 18FFF001#ABCD",
                          "(1.850000) can1 101#R3"], {"hardware status": 1}),
    "TRC 1.1": (TRC_1_1, [f"({NOON - 86383}.535400) can1 300#0000010203040506",
                          f"({NOON - 86383}.700300) can1 18EFC034#F11A06E2",
                          f"({NOON - 86381}.295500) can1 20000088#0000020000000000"], {"warnings": 1}),
    "TRC 1.3": (TRC_1_3, [f"({NOON - 86399}.000100) can1 300#112233", f"({NOON - 86399}.000200) can2 1FFFFFFF#"], {}),
    "TRC 2.0": (TRC_2_0, [f"({NOON - 86399}.059900) can1 300#00000000040000",
                          f"({NOON - 86399}.059901) can1 1FFFFFFF##100112233445566778899AABB",
                          f"({NOON - 86399}.059902) can1 301#R8"], {"hardware status": 1}),
    "TRC 2.1": (TRC_2_1, [f"({NOON - 86399}.059900) can1 300#001122",
                          f"({NOON - 86399}.059901) can2 18FF0000##3000102030405060708090A0B",
                          f"({NOON - 86399}.059902) can1 20000088#0000040000000000",
                          f"({NOON - 86399}.059904) can1 123##27F"], {"error counters": 1}),
    "TRC of a gateway": (GATEWAY, ["(1763828454.721518) can0 1FFFFFF0#0119000708000043",
                                   "(1763828454.831118) can1 356#6E0B0000A000"], {}),
    "GVRET": (GVRET, ["(166.064000) can0 21A#FE3612FE690507AD", "(166.065123) can1 18FF0001#0A0B"], {}),
    "GVRET without Dir": (GVRET_WITHOUT_DIRECTION, ["(1.000000) can2 123#7F"], {}),
    "GVRET FD": (GVRET_FD, ["(0.000005) can0 123##0000102030405060708090A0B"], {}),
    "BUSMASTER absolute": (busmaster("ABSOLUTE", "0:00:00:5000", "0:00:01:0001", "0:00:01:7500"),
                           [frame.format(at) for frame, at in zip(BUSMASTER_FRAMES, BUSMASTER_AT, strict=True)], {}),
    "BUSMASTER system": (busmaster("SYSTEM", "12:00:00:7500", "12:00:01:2501", "12:00:02:0000"),
                         [frame.format(at) for frame, at in zip(BUSMASTER_FRAMES, BUSMASTER_AT, strict=True)], {}),
    "BUSMASTER relative": (busmaster("RELATIVE", "0:00:00:5000", "0:00:00:5001", "0:00:00:7499"),
                           [frame.format(at) for frame, at in zip(BUSMASTER_FRAMES, BUSMASTER_AT, strict=True)], {}),
    "BUSMASTER decimal": (busmaster("ABSOLUTE", *["0:00:00:0000"] * 3).replace("HEX", "DEC").replace(
        "0x0C5 s 8 23 00 00 00 00 00 00 FF", "197 s 2 035 255").replace("0x18FFF001 x 2 AB CD", "419426305 x 1 171")
        .replace("0x101", "257"), [f"({NOON}.250000) can1 0C5#23FF", f"({NOON}.250000) can2 18FFF001#AB",
                                   f"({NOON}.250000) can1 101#R3"], {}),
}


@pytest.mark.parametrize("ends", ["\n", "\r\n"])
@pytest.mark.parametrize("name", TEXTS)
def test_lines_become_frames(name, ends, tmp_path, capsys):
    text, expected, skipped = TEXTS[name]
    path = tmp_path / "recording"
    path.write_text(text, newline=ends)
    answer = read(capsys, path)
    assert (answer.code, answer.out.splitlines()) == (0, expected)
    assert (answer.report["frames"], answer.report["skipped"]) == (len(expected), skipped)
    assert answer.report["format"].lower().startswith(name.split()[0].lower().replace("trc", "peak trc"))


@pytest.mark.parametrize("name", TEXTS)
def test_a_line_that_is_no_frame_is_counted_and_the_rest_is_read(name, tmp_path, capsys):
    text, expected, skipped = TEXTS[name]
    path = tmp_path / "recording"
    path.write_text(text + "what is this\n")
    answer = read(capsys, path)
    assert (answer.code, answer.out.splitlines()) == (0, expected)
    assert answer.report["skipped"] == skipped | {"unreadable lines": 1}
    assert f"line {len(text.splitlines()) + 1}: 'what is this'" in answer.err


def test_a_clock_that_passes_midnight_goes_on(tmp_path, capsys):
    path = tmp_path / "night.log"
    path.write_text(busmaster("SYSTEM", "23:59:59:9000", "0:00:00:1000", "0:00:01:0000"))
    times = [frame.time_ns for frame in read(capsys, path).frames]
    assert [later - earlier for earlier, later in zip(times, times[1:], strict=False)] == [200_000_000, 900_000_000]


# ---- files that python-can wrote ----

def by_python_can(writer, frames, first_channel=0):
    for frame in frames:
        writer.on_message_received(message(frame, frame.time_ns * 1e-9, int(frame.bus[3:]) - first_channel))
    writer.stop()


def nearly(frames, expected):
    """The same frames; stamps as doubles have them."""
    assert [frame._replace(time_ns=0) for frame in frames] == [frame._replace(time_ns=0) for frame in expected]
    assert all(abs(a.time_ns - b.time_ns) <= 1500 for a, b in zip(frames, expected, strict=True))


def test_blf_of_python_can(tmp_path, capsys):
    frames = drawn("python-can blf")
    by_python_can(can.BLFWriter(tmp_path / "a.blf"), frames, first_channel=1)
    nearly(read(capsys, tmp_path / "a.blf").frames, frames)


@pytest.mark.parametrize("writer", [can.CSVWriter, can.SqliteWriter])
def test_csv_and_sqlite_of_python_can(writer, tmp_path, capsys):
    frames = drawn(writer.__name__)
    path = tmp_path / "a"
    by_python_can(writer(path), frames)
    fd = [frame._replace(bus="can0", fd_flags=0 if frame.fd_flags is not None and len(frame.data) > 8 else None)
          for frame in frames]
    nearly(read(capsys, path).frames, fd)


def test_trc_of_python_can(tmp_path, capsys):
    frames = [frame for frame in drawn("python-can trc") if frame.fd_flags is None and not frame.id & ERROR
              and frame.remote_length is None]
    for version in (can.TRCFileVersion.V2_1, can.TRCFileVersion.V1_0):
        writer = can.TRCWriter(tmp_path / "a.trc")
        writer.file_version = version
        by_python_can(writer, frames)
        found = read(capsys, tmp_path / "a.trc").frames
        assert [(f.id, f.data) for f in found] == [(f.id, f.data) for f in frames], version


def test_mf4_of_python_can(tmp_path, capsys):
    frames = sorted(drawn("python-can mf4", 40), key=lambda f: (f.time_ns, bool(f.id & ERROR)))
    by_python_can(can.MF4Writer(tmp_path / "a.mf4"), frames)
    found = read(capsys, tmp_path / "a.mf4").frames
    assert sorted(f._replace(time_ns=0) for f in found if f.remote_length is None) == sorted(
        f._replace(time_ns=0) for f in frames if f.remote_length is None)
    assert [f.time_ns for f in found] == sorted(f.time_ns for f in found)


# ---- objects of BLF that python-can does not write ----

def blf(objects, packed=True, cut=200, tick=1):
    """Objects of (type, body) in containers of `cut` bytes, so that they cross borders; a tick is 1 ns or 10000."""
    stream = b""
    for k, (kind, body) in enumerate(objects):
        size = 32 + len(body)
        stream += struct.pack("<4sHHLLLHHQ", b"LOBJ", 32, 1, size, kind, 2 if tick == 1 else 1, 0, 0,
                              1_000_010_000 // tick * k) + body
        stream += b"\0" * (size % 4)
    out = b""
    for begin in range(0, len(stream), cut):
        part = stream[begin:begin + cut]
        data = zlib.compress(part) if packed else part
        out += struct.pack("<4sHHLLH6xL4x", b"LOBJ", 16, 1, 32 + len(data), 10, 2 if packed else 0, len(part)) + data
        out += b"\0" * ((32 + len(data)) % 4)
    start = struct.pack("<8H", 2025, 11, 6, 22, 12, 0, 0, 250)
    header = struct.pack("<4sL8B2Q2L", b"LOGG", 144, 1, 0, 0, 0, 2, 6, 8, 1, 144 + len(out), len(stream),
                         len(objects), 0)
    return (header + start + start).ljust(144, b"\0") + out


FD_64 = struct.pack("<BBBBLLLLLLLHBBL", 3, 9, 12, 0, 0x123, 0, 0x1000 | 0x2000, 0, 0, 0, 0, 0, 0, 0, 0)
OBJECTS = [
    (1, struct.pack("<HBBL8s", 1, 0, 8, 0x356, bytes(range(8)))),
    (86, struct.pack("<HBBL8sLBBH", 2, 1, 2, 0x98FFF001, b"\xab\xcd", 0, 0, 0, 0)),
    (1, struct.pack("<HBBL8s", 1, 0x80, 5, 0x101, b"")),
    (1, struct.pack("<HBBL8s", 1, 2, 8, 0x777, b"")),
    (101, FD_64 + bytes(range(12))),
    (101, FD_64 + bytes(range(5))),
    (100, struct.pack("<HBBLLBBB5x64s", 4, 0, 15, 0x124, 0, 0, 1 | 4, 64, bytes(range(64)))),
    (73, struct.pack("<HHLBBBxLLH2x8s", 1, 0, 0, 0, 0, 0, 0, 0x555, 0, b"")),
    (2, struct.pack("<HHL", 2, 0, 0)),
    (65, b"text"), (11, b"LIN message "), (200, b"new!"),
]
AFTER = [0, 1, 2, 4, 5, 6, 7, 8]
BLF_FRAMES = ["can1 356#0001020304050607", "can2 18FFF001#ABCD", "can1 101#R5", "can3 123##1000102030405060708090A0B",
              "can3 123##1000102030400000000000000", "can4 124##2" + bytes(range(64)).hex().upper(),
              "can1 20000080#0000000000000000", "can2 20000080#0000000000000000"]


@pytest.mark.parametrize("packed", [True, False])
@pytest.mark.parametrize("cut", [40, 200, 1 << 17])
@pytest.mark.parametrize("tick", [1, 10_000])
def test_blf_objects_of_vector(packed, cut, tick, tmp_path, capsys):
    (tmp_path / "a.blf").write_bytes(blf(OBJECTS, packed, cut, tick))
    answer = read(capsys, tmp_path / "a.blf")
    expected = [f"({NOON + k}.{250_000_000 + 10_000 * k:09d}) {frame}"
                for k, frame in zip(AFTER, BLF_FRAMES, strict=True)]
    assert (answer.code, answer.out.splitlines()) == (0, expected)
    assert answer.report["skipped"] == {
        "requests to transmit": 1, "text": 1, "LIN objects": 1, "objects of type 200": 1}


# ---- PCAP ----

def socketcan(frame):
    remote = 0x40000000 if frame.remote_length is not None else 0
    length = frame.remote_length if remote else len(frame.data)
    flags = 0 if frame.fd_flags is None else frame.fd_flags | 4
    return struct.pack(">IBBH", frame.id | remote, length, flags, 0) + frame.data


def pcap_of(order, tick, frames):
    data = struct.pack(order + "IHHiIII", 0xA1B23C4D if tick == 1 else 0xA1B2C3D4, 2, 4, 0, 0, 65535, 227)
    for frame in frames:
        packet = socketcan(frame)
        data += struct.pack(order + "IIII", frame.time_ns // 10**9, frame.time_ns % 10**9 // tick, len(packet),
                            len(packet)) + packet
    return data


@pytest.mark.parametrize("order", "<>")
@pytest.mark.parametrize("tick", [1000, 1])
def test_pcap(order, tick, tmp_path, capsys):
    frames = [frame._replace(bus="can0") for frame in drawn("pcap")]
    data = pcap_of(order, tick, frames)
    (tmp_path / "a").write_bytes(data)
    assert read(capsys, tmp_path / "a").frames == [
        frame._replace(time_ns=frame.time_ns // tick * tick) for frame in frames], told("pcap")
    (tmp_path / "b").write_bytes(data[:20] + struct.pack(order + "I", 1) + data[24:])
    other = read(capsys, tmp_path / "b")
    assert other.code == 2 and "link type 1" in other.err and "227" in other.err


def block(order, kind, body):
    body += b"\0" * (-len(body) % 4)
    return struct.pack(order + "II", kind, len(body) + 12) + body + struct.pack(order + "I", len(body) + 12)


BUSES = ("can7", "powertrain")


def pcapng_of(order, frames):
    data = block(order, 0x0A0D0D0A, struct.pack(order + "IHHq", 0x1A2B3C4D, 1, 0, -1))
    for name in (bus.encode() for bus in BUSES):
        padded = name.ljust(-(-len(name) // 4) * 4, b"\0")
        data += block(order, 1, struct.pack(order + "HHIHH", 227, 0, 0, 2, len(name)) + padded
                      + struct.pack(order + "HHB3xHH", 9, 1, 9, 0, 0))
    for frame in frames:
        packet = socketcan(frame)
        data += block(order, 6, struct.pack(order + "IIIII", frame.bus == "powertrain", frame.time_ns >> 32,
                                            frame.time_ns & 0xFFFFFFFF, len(packet), len(packet)) + packet)
    return data


@pytest.mark.parametrize("order", "<>")
def test_pcapng_with_two_interfaces(order, tmp_path, capsys):
    frames = drawn("pcapng", buses=BUSES)
    (tmp_path / "a").write_bytes(pcapng_of(order, frames))
    assert read(capsys, tmp_path / "a").frames == frames, told("pcapng")


# ---- formats that are known and not read ----

KNOWN = {
    "a.ld": (b"\x40\0\0\0\0\0\0\0" + bytes(100), "MoTeC"), "a.xrk": (b"<hCNF", "AiM"),
    "a.vbo": (b"File created on 01/02/2025 at 10:00:00\n\n[header]\nsatellites\n", "RaceLogic"),
    "a.mat": (b"MATLAB 5.0 MAT-file, Platform: GLNXA64", "MATLAB"), "a.h5": (b"\x89HDF\r\n\x1a\n", "HDF5"),
    "a.xlsx": (b"PK\x03\x04" + bytes(30), "ZIP"), "a.7z": (b"7z\xbc\xaf\x27\x1c", "7-Zip"),
    "a.xz": (b"\xfd7zXZ\0", "xz"), "a.bz2": (b"BZh91AY", "bzip2"), "a.kme50": (b"\x01\x02\x03", "Kvaser"),
    "a.pdf": (b"%PDF-1.7", "PDF"),
    "a.parquet": (b"PAR1", "Parquet"), "a.blf": (b"\x01\x02\x03\x04", "damaged"),
    "a.bin": (b"\x01\x02\x03", "no format"),
    "a.log": (b"(1436509052.249713) vcan0 044#2A36\n", "candump"), "a.asc": (b"date Sat\nbase hex\n", "Vector ASC"),
    "empty.blf": (b"", "empty"), "a.mf3": (b"MDF     3.30    ", "tables"),
}


@pytest.mark.parametrize("name", KNOWN)
def test_what_is_not_read_is_called_by_its_name_with_what_to_do(name, tmp_path, capsys):
    content, expected = KNOWN[name]
    (tmp_path / name).write_bytes(content)
    answer = read(capsys, tmp_path / name)
    assert answer.code == 2 and not answer.out
    assert len(answer.err.splitlines()) == 1 and name in answer.err and expected in answer.err


def test_the_format_is_told_by_the_content_whatever_the_file_is_called(tmp_path, capsys):
    for name, (text, expected, _) in TEXTS.items():
        (tmp_path / "a.blf").write_text(text)
        assert read(capsys, tmp_path / "a.blf").out.splitlines() == expected, name
        assert read(capsys, tmp_path / "a.blf", "--sniff").out.split("\t")[1] == "read"


FORMATS = ("blf", "trc", "csv", "db", "mf4", "gvret", "busmaster", "pcap", "pcapng")


@pytest.mark.parametrize("key", FORMATS)
def test_a_file_that_is_not_of_the_format_that_was_asked_for(key, tmp_path, capsys):
    for content in (b"hello\nworld\n", bytes(range(256)) * 4, b"LOGG\n"):
        (tmp_path / "a").write_bytes(content)
        answer = read(capsys, tmp_path / "a", "--format", key)
        assert answer.code == 2 and not answer.out and str(tmp_path / "a") in answer.err, answer.err


def damaged(content, chance):
    out = bytearray(content)
    for _ in range(chance.randrange(1, 8)):
        at = chance.randrange(len(out))
        out[at:at + chance.randrange(3)] = chance.randbytes(chance.randrange(3))
    return bytes(out[:chance.randrange(1, len(out))] if chance.random() < 0.3 else out)


@pytest.mark.parametrize("draw", range(20))
def test_whatever_is_wrong_in_a_file_is_told_in_words(draw, tmp_path, capsys):
    contents = {name: text.encode() for name, (text, _, _) in TEXTS.items()}
    contents |= {"pcap": pcap_of("<", 1, drawn("pcap", 30)), "pcapng": pcapng_of(">", drawn("pcapng", 30, BUSES)),
                 "blf": blf(OBJECTS), "blf unpacked": blf(OBJECTS, packed=False)}
    for name, content in contents.items():
        (tmp_path / "a").write_bytes(damaged(content, generator(f"{name} {draw}")))
        answer = read(capsys, tmp_path / "a")
        assert answer.code in (0, 2, 3), (name, told(draw))
        assert answer.code or answer.report["frames"] == len(answer.frames), (name, told(draw))


@pytest.mark.skipif(not DATA, reason="VOLTLAP_DATA is not set")
def test_a_gateway_s_trc_of_a_real_car(capsys):
    path = Path(DATA) / "orion2_conversion_candump/candump-2025-11-22_161709.trc.gz"
    answer = read(capsys, path)
    assert answer.code == 0 and answer.report == {"frames": 50660, "skipped": {}, "format": "PEAK TRC 2.0"}
    times = [frame.time_ns for frame in answer.frames]
    assert times == sorted(times)
    assert {frame.bus for frame in answer.frames} == {"can0"}
    assert all((frame.id & ID_MASK > 0x7FF) == bool(frame.id & EXTENDED) for frame in answer.frames)
    assert text_of(answer.frames[:1]).startswith("(1763828454.721518000) can0 1FFFFFF0#")
