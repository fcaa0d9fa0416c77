# SPDX-License-Identifier: Apache-2.0
import can
import pytest

from voltlap_hil.errors import InputError
from voltlap_hil.frame import EXTENDED, Frame
from voltlap_hil.record import Recorder

FRAMES = [Frame(0xB1, bytes(range(8)), 0.0), Frame(0x18FF1234 | EXTENDED, b"\x01\x02", 10.0),
          Frame(0xC0, b"\xff" * 8, 20.0)]
SYNC = Frame(0x7E0, bytes(8), 5.0)


@pytest.mark.parametrize("suffix", [".log", ".asc", ".blf"])
def test_what_is_recorded_is_read_back_without_lockstep_frames(tmp_path, suffix):
    path = tmp_path / f"run{suffix}"
    with Recorder(path, "vcan0") as record:
        record.write([FRAMES[0], SYNC, *FRAMES[1:]])
    read = list(can.LogReader(path))
    assert [(m.arbitration_id, m.is_extended_id, bytes(m.data)) for m in read] == [
        (f.id & ~EXTENDED, bool(f.id & EXTENDED), f.data) for f in FRAMES]
    assert [round(m.timestamp - read[0].timestamp, 6) for m in read] == [0.0, 0.01, 0.02]


def test_a_log_has_the_lines_of_candump(tmp_path):
    with Recorder(tmp_path / "run.log", "vcan0") as record:
        record.write(FRAMES)
    assert (tmp_path / "run.log").read_text().splitlines() == [
        "(0.000000) vcan0 0B1#0001020304050607", "(0.010000) vcan0 18FF1234#0102",
        "(0.020000) vcan0 0C0#FFFFFFFFFFFFFFFF"]


def test_an_unknown_suffix_and_a_folder_that_is_not_there_are_told(tmp_path):
    with pytest.raises(InputError, match="found .txt, expected one of .log, .asc, .blf"):
        Recorder(tmp_path / "run.txt", "vcan0")
    with pytest.raises(InputError, match="cannot write"):
        Recorder(tmp_path / "none" / "run.log", "vcan0")
