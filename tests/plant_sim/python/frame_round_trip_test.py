# SPDX-License-Identifier: Apache-2.0
"""Frames through a writer and back, by this package and by the field's own libraries, are the same frames."""
import gzip
import shutil

import pytest
from recordings import Answer, drawn, read, text_of, to_microseconds, told, write

for package in ("asammdf", "can", "zstandard"):
    pytest.importorskip(package, reason="needs toolchain/requirements/logs.txt")
import asammdf  # noqa: E402
import can  # noqa: E402
import zstandard  # noqa: E402
from voltlap_logs.candump import ERROR, EXTENDED, ID_MASK  # noqa: E402

DRAWS = range(5)


def as_trc_has_it(frame):
    """Of an error frame: bit, form or stuff error, else just an error."""
    frame = to_microseconds(frame)
    if not frame.id & ERROR:
        return frame
    kind = frame.data[2] if frame.data[2] in (1, 2, 4) else 0
    return frame._replace(id=ERROR | (0x88 if kind else 0x80), data=bytes((0, 0, kind, 0, 0, 0, 0, 0)))


def without_fd_flags(frame):
    """FD is told by the length alone."""
    return to_microseconds(frame)._replace(fd_flags=0 if frame.fd_flags is not None and len(frame.data) > 8 else None)


def only_data(frame):
    return without_fd_flags(frame) if frame.remote_length is None and not frame.id & ERROR else None


def mf4_order(frame):
    """Data, remote and error frames are groups of their own: the order of different kinds at one time is lost."""
    return frame.time_ns, 2 if frame.id & ERROR else frame.remote_length is not None


HOLDS = {"blf": lambda frame: frame, "mf4": lambda frame: frame, "trc": as_trc_has_it, "db": without_fd_flags,
         "csv": only_data}


@pytest.mark.parametrize("key", HOLDS)
@pytest.mark.parametrize("draw", DRAWS)
def test_frames_come_back_as_far_as_the_format_holds_them(key, draw, tmp_path, capsys, monkeypatch):
    frames, path = drawn(draw), tmp_path / f"drive.{key}"
    written = write(capsys, monkeypatch, path, key, frames)
    assert written.code == 0, written.err
    expected = [held for frame in frames if (held := HOLDS[key](frame))]
    expected = sorted(expected, key=mf4_order) if key == "mf4" else expected
    again = read(capsys, path)
    assert again.code == 0
    assert [frame._replace(time_ns=0) for frame in again.frames] == [frame._replace(time_ns=0) for frame in expected]
    tolerance = 1000 if key == "db" else 0  # a double: 240 ns, then to a microsecond
    assert all(abs(frame.time_ns - other.time_ns) <= tolerance
               for frame, other in zip(again.frames, expected, strict=True)), told(draw)
    assert written.report["frames"] == again.report["frames"] == len(expected), told(draw)
    assert sum(written.report["skipped"].values()) == len(frames) - len(expected), told(draw)
    assert [child.name for child in tmp_path.iterdir()] == [path.name]


@pytest.mark.parametrize("key", HOLDS)
def test_channels_below_the_first_of_a_format_are_moved_up_together(key, tmp_path, capsys, monkeypatch):
    frames = drawn("buses", buses=("can0", "can4", "powertrain"))
    written = write(capsys, monkeypatch, tmp_path / f"a.{key}", key, frames)
    again = read(capsys, tmp_path / f"a.{key}")
    names = {bus: f"can{number}" for bus, number in written.report.get("channels", {}).items()}
    assert names == {} if key == "db" else len(set(names.values())) == 3
    if key in ("blf", "trc", "mf4"):
        assert names == {"can0": "can1", "can4": "can5", "powertrain": "can2"}
        assert int(names["can4"][3:]) - int(names["can0"][3:]) == 4
    expected = [names.get(held.bus, held.bus) for frame in frames if (held := HOLDS[key](frame))]
    assert sorted(frame.bus for frame in again.frames) == sorted(expected)


@pytest.mark.parametrize("key", HOLDS)
@pytest.mark.parametrize("first_ns", [0, 123_456_000, -2_500_000_000])
def test_a_clock_that_does_not_count_from_1970_keeps_its_times(key, first_ns, tmp_path, capsys, monkeypatch):
    frames = drawn("own clock", 50)
    frames = [frame._replace(time_ns=frame.time_ns - frames[0].time_ns + first_ns) for frame in frames]
    moved = write(capsys, monkeypatch, tmp_path / "a", key, frames).report.get("moved_s", 0.0)
    assert moved == (2.5 if key == "blf" and first_ns < 0 else 0.0)
    got = read(capsys, tmp_path / "a").frames
    expected = sorted(frame.time_ns for frame in frames if HOLDS[key](frame))
    assert [frame.time_ns - moved * 1e9 for frame in got] == pytest.approx(expected, abs=600)


READERS = {"blf": can.BLFReader, "trc": can.TRCReader, "db": can.SqliteReader, "asc": can.ASCReader,
           "mf4": can.MF4Reader}


def seen_by_python_can(message):
    return (message.arbitration_id, message.is_extended_id, message.is_remote_frame, message.is_error_frame,
            bytes(message.data))


@pytest.mark.parametrize("key", READERS)
def test_python_can_reads_what_was_written(key, tmp_path, capsys, monkeypatch):
    frames, path = drawn(key), tmp_path / f"drive.{key}"
    if key in ("trc", "mf4"):  # python-can's readers know no error frames of TRC, and take MF4 a group at a time
        frames = [frame for frame in frames if not frame.id & ERROR and frame.remote_length is None]
    if key == "asc":  # python-can's reader takes an FD frame without data for a remote one
        frames = [frame for frame in frames if frame.fd_flags is None or frame.data]
    assert write(capsys, monkeypatch, path, key, frames).code == 0
    messages = list(READERS[key](path))
    assert len(messages) == len(frames), told(key)
    for message, frame in zip(messages, frames, strict=True):
        error = bool(frame.id & ERROR)
        expected = (frame.id & ID_MASK, bool(frame.id & EXTENDED), frame.remote_length is not None, error, frame.data)
        if error and key == "asc":  # has no class of error
            assert message.is_error_frame
        else:
            assert seen_by_python_can(message) == expected, (told(key), frame)
        at = frame.time_ns - (frames[0].time_ns if key == "asc" else 0)
        assert message.timestamp - (messages[0].timestamp if key == "asc" else 0) == pytest.approx(at * 1e-9, abs=2e-6)


def test_asammdf_decodes_the_bus_logging(tmp_path, capsys, monkeypatch):
    dbc = tmp_path / "a.dbc"
    dbc.write_text('VERSION ""\nNS_ :\nBS_:\nBU_: X\nBO_ 291 Pack: 8 X\n SG_ Voltage : 0|16@1+ (0.1,0) [0|0] "V" X\n')
    frames = [f"({1000 + k}.5) can1 123#{k:02X}01000000000000\n" for k in range(100)]
    assert write(capsys, monkeypatch, tmp_path / "a.mf4", "mf4", "".join(frames)).code == 0
    with asammdf.MDF(tmp_path / "a.mf4") as recording:
        decoded = recording.extract_bus_logging({"CAN": [(dbc, 0)]})
        voltage = decoded.get("Voltage")
    assert list(voltage.samples) == pytest.approx([(256 + k) / 10 for k in range(100)])
    assert list(voltage.timestamps) == pytest.approx(range(100))


def packed_with_gzip(path):
    with path.open("rb") as plain, gzip.open(f"{path}.gz", "wb") as out:
        shutil.copyfileobj(plain, out)
    return f"{path}.gz"


def packed_with_zstd(path):
    packed = path.with_name(path.name + ".zst")
    data = path.read_bytes()
    compressor = zstandard.ZstdCompressor()
    packed.write_bytes(compressor.compress(data[:100]) + compressor.compress(data[100:]))  # two frames in one file
    return packed


@pytest.mark.parametrize("pack", [packed_with_gzip, packed_with_zstd])
@pytest.mark.parametrize("key", HOLDS)
def test_a_packed_recording_reads_like_the_plain_one(key, pack, tmp_path, capsys, monkeypatch):
    path = tmp_path / "plain"  # told by the content: no suffix
    write(capsys, monkeypatch, path, key, drawn("packed"))
    plain = read(capsys, path)
    assert plain.code == 0 and plain.frames
    packed = read(capsys, pack(path))
    assert (packed.code, packed.out, packed.report) == (0, plain.out, plain.report)


def test_two_readings_of_one_recording_by_way_of_another_format_agree(tmp_path, capsys, monkeypatch):
    """BLF to MF4 to BLF: nothing is lost between the two that hold everything."""
    first = Answer(0, text_of(drawn("there and back")), "")
    for step, key in enumerate(("blf", "mf4", "blf")):
        write(capsys, monkeypatch, tmp_path / f"{step}.{key}", key, first.out)
        first = read(capsys, tmp_path / f"{step}.{key}")
    assert first.frames == sorted(drawn("there and back"), key=mf4_order)


def test_a_line_that_is_no_frame_stops_the_writing_and_leaves_the_old_file(tmp_path, capsys, monkeypatch):
    path = tmp_path / "drive.blf"
    path.write_text("old")
    for bad in ("(1.0) can0 123#11\nnonsense\n", "(1.0) can0 123#11\n(2.0) can0 999#11\n", "(1.0) can0 123#1\n",
                "(1.0) can0 123##0" + "00" * 9 + "\n"):
        answer = write(capsys, monkeypatch, path, "blf", bad)
        assert answer.code == 2 and "line " in answer.err and "expected" in answer.err
        assert len(answer.err.splitlines()) == 1
        assert path.read_text() == "old" and list(tmp_path.iterdir()) == [path]
