# SPDX-License-Identifier: Apache-2.0
"""Two tapes of a run have one hash only when every frame is the same, and the first that differs is named."""
import struct

import pytest
from voltlap_hil.tape import Tape


def record(can_id=0x0C1, data=b"\1\2", who=1):
    return struct.pack("<IBBH8s", can_id, len(data), who, 0, data)


def tape(*batches):
    out = Tape()
    for tick, records in enumerate(batches):
        out.add(tick, records)
    return out


def test_equal_tapes_have_one_hash_and_no_difference(dbc):
    assert tape(record()).hash == tape(record()).hash
    assert tape(record(), b"").first_difference(tape(record(), b""), dbc) == ""


@pytest.mark.parametrize(("other", "said"), [
    (record(data=b"\1\3"), "tick 1 (0.01 s): found 0x0C1 BmsStatus [01 02] of BMS, expected 0x0C1 BmsStatus [01 03]"),
    (record(who=2), "of BMS, expected 0x0C1 BmsStatus [01 02] of master"),
    (record(0x123), "expected 0x123 [01 02] of BMS"),
    (record() + record(), "found no frame more, expected 0x0C1"),
    (b"", "expected no frame more"),
])
def test_the_first_frame_that_differs_is_named(dbc, other, said):
    mine, theirs = tape(b"", record(), record()), tape(b"", other, b"")
    assert mine.hash != theirs.hash
    assert said in mine.first_difference(theirs, dbc)


def test_a_run_that_ends_early_differs(dbc):
    assert tape(record()).first_difference(tape(record(), record()), dbc) == "found 1 batches of frames, expected 2"
    assert tape(record()).hash != tape(record(), b"").hash
