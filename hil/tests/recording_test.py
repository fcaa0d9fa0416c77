# SPDX-License-Identifier: Apache-2.0
import gzip
import random

import can
import pytest

from voltlap_hil.errors import InputError
from voltlap_hil.frame import EXTENDED
from voltlap_hil.recording import Recording

BEGIN = 1_700_000_000.0
FRAMES = [(BEGIN + 0.01 * k, 0x18FF0001 if k % 3 == 0 else 0x100 + k, bytes(range(k % 9))) for k in range(40)]


def candump_line(stamp, can_id, data, bus="can0"):
    return f"({stamp:.6f}) {bus} {can_id:0{8 if can_id > 0x7FF else 3}X}#{data.hex().upper()}\n"


def screen_line(stamp, can_id, data):
    return f" ({stamp:.6f})  can0  {can_id:0{8 if can_id > 0x7FF else 3}X}   [{len(data)}]  {data.hex(' ').upper()}\n"


def slcan_line(stamp, can_id, data):
    kind = f"T{can_id:08X}" if can_id > 0x7FF else f"t{can_id:03X}"
    return f"{kind}{len(data)}{data.hex().upper()}{round(stamp * 1e3) % 60000:04X}\r\n"


def read(path):
    recording = Recording(path)
    return recording, list(recording)


def written(path, kind):
    if kind in ("candump", "screen", "slcan"):
        line = {"candump": candump_line, "screen": screen_line, "slcan": slcan_line}[kind]
        path.write_text("".join(line(*frame) for frame in FRAMES))
    else:
        with can.Logger(str(path)) as logger:
            for stamp, can_id, data in FRAMES:
                logger(can.Message(timestamp=stamp, arbitration_id=can_id, is_extended_id=can_id > 0x7FF, data=data,
                                   channel=0))
    return path


@pytest.mark.parametrize("kind, name", [("candump", "a.log"), ("screen", "a.txt"), ("slcan", "a.slcan"),
                                        ("asc", "a.asc"), ("blf", "a.blf"), ("trc", "a.trc")])
@pytest.mark.parametrize("packed", [False, True])
def test_every_format_gives_the_same_frames(tmp_path, kind, name, packed):
    path = written(tmp_path / name, kind)
    if packed:
        path = tmp_path / f"{name}.gz"
        path.write_bytes(gzip.compress((tmp_path / name).read_bytes()))
    recording, frames = read(path)
    assert [(f.id & ~EXTENDED, bool(f.id & EXTENDED), f.data) for f in frames] == \
        [(can_id, can_id > 0x7FF, data) for _, can_id, data in FRAMES]
    assert [f.time_s for f in frames] == pytest.approx([stamp - BEGIN for stamp, *_ in FRAMES], abs=2e-3)
    assert recording.frames == len(FRAMES) and not recording.skipped and not recording.notes


def test_buses_keep_their_names(tmp_path):
    path = tmp_path / "a.log"
    path.write_text(candump_line(1.0, 0x10, b"\1", "can0") + candump_line(1.1, 0x10, b"\2", "vcan7"))
    assert [f.bus for f in read(path)[1]] == ["can0", "vcan7"]


def test_what_is_no_frame_is_counted_by_its_kind(tmp_path):
    path = tmp_path / "a.log"
    path.write_text(candump_line(1.0, 0x10, b"\1") + "(1.1) can0 010#R8\nrubbish\n(1.2) can0 20000080#00\n"
                    + candump_line(1.3, 0x10, b"\2"))
    recording, frames = read(path)
    assert len(frames) == 2
    assert recording.skipped == {"remote frame, without data": 1, "line that is no frame": 1, "error frame": 1}


def test_can_fd_frames_are_read(tmp_path):
    path = tmp_path / "a.log"
    path.write_text(f"(1.0) can0 123##1{bytes(range(12)).hex()}\n")
    assert read(path)[1][0].data == bytes(range(12))


def test_a_clock_that_was_set_goes_on_and_small_disorder_does_not_run_back(tmp_path):
    path = tmp_path / "a.log"
    stamps = [5.0, 5.2, 5.1, 5.3] + [1_700_000_000.0 + 0.1 * k for k in range(8)]
    path.write_text("".join(candump_line(stamp, 0x10, b"") for stamp in stamps))
    recording, frames = read(path)
    assert [f.time_s for f in frames[:4]] == pytest.approx([0.0, 0.1, 0.2, 0.3], abs=1e-6)
    assert 0.3 < frames[4].time_s < 0.6 and frames[-1].time_s - frames[4].time_s == pytest.approx(0.7, abs=1e-6)
    assert any("the clock was set" in note for note in recording.notes)
    assert "1 x out of order, sorted" in recording.notes


def test_slcan_clock_goes_on_over_its_minute(tmp_path):
    path = tmp_path / "a.slcan"
    path.write_text("".join(slcan_line(0.5 * k, 0x10, b"\0") for k in range(400)))
    assert read(path)[1][-1].time_s == pytest.approx(199.5, abs=1e-3)


def test_frames_without_stamps_need_the_cycle_of_a_dbc_file(tmp_path):
    path, dbc = tmp_path / "a.slcan", tmp_path / "a.dbc"
    path.write_text("t10020102\nt10020103\n")
    with pytest.raises(InputError, match="without stamps"):
        read(path)
    dbc.write_text('VERSION ""\nBU_: X\nBO_ 256 A: 2 X\n SG_ S : 0|8@1+ (1,0) [0|0] "" X\n\n'
                   'BA_DEF_ BO_ "GenMsgCycleTime" INT 0 10000;\nBA_DEF_DEF_ "GenMsgCycleTime" 0;\n'
                   'BA_ "GenMsgCycleTime" BO_ 256 50;\n')
    assert [(f.time_s, f.data) for f in Recording(path, [dbc])] == [(0.0, b"\1\2"), (0.05, b"\1\3")]


def test_asc_in_decimal_with_relative_stamps(tmp_path):
    path = tmp_path / "a.asc"
    path.write_text("date Sat Nov 1 06:12:33 pm 2025\nbase dec timestamps relative\nno internal events logged\n"
                    "   0.500000 1  291             Rx   d 2 16 255\n   0.250000 Start of measurement\n"
                    "   0.250000 2  291x            Tx   d 1 1\n   0.1 1 ErrorFrame\n")
    recording, frames = read(path)
    assert [(f.id, f.bus, f.data) for f in frames] == [(291, "can1", b"\x10\xff"), (291 | EXTENDED, "can2", b"\1")]
    assert frames[1].time_s == pytest.approx(0.5)
    assert recording.skipped == {"error frame": 1}


def test_a_cut_packing_keeps_what_stands_before_it(tmp_path):
    path = tmp_path / "a.log.gz"
    random.seed(1)
    text = "".join(candump_line(1.0 + 0.01 * k, 0x10, random.randbytes(8)) for k in range(3000))
    path.write_bytes(gzip.compress(text.encode())[:-2000])
    recording, frames = read(path)
    assert 1000 < len(frames) < 3000
    assert "breaks off" in recording.notes[0]


@pytest.mark.parametrize("content", [b"time,a\n1,2\n", b"PK\x03\x04zip", b"\0\1\2\3" * 50, b"BO_ 1 A: 8 X\n"])
def test_what_is_no_recording_is_refused(tmp_path, content):
    path = tmp_path / "a.log"
    path.write_bytes(content)
    with pytest.raises(InputError, match=str(path)):
        read(path)
