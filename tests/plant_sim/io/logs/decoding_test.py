# SPDX-License-Identifier: Apache-2.0
"""The native decoder against cantools on the same frames: the project's DBC files, and those of other teams where
VOLTLAP_DATA has them."""
import math
import os
import random
import subprocess
from pathlib import Path

import cantools
import pytest

ROOT = Path(__file__).resolve().parents[4]
DECODE = Path(os.environ["VOLTLAP_BUILD_DIR"]) / "tests/bin/decode_frames"
DATA = os.environ.get("VOLTLAP_DATA")
OWN = sorted((ROOT / "can_dbc").glob("*.dbc"))
FOREIGN = sorted(Path(DATA).glob("**/*.dbc")) if DATA else []
REFUSED = ("for the second time", "ends in byte", "second multiplexer", "nested")


def random_frames(database, generator, each=6):
    """Frames of every message, with each value of its multiplexer; (identifier with flag, data)."""
    frames = []
    for message in database.messages:
        if message.length > 8 or message.name == "VECTOR__INDEPENDENT_SIG_MSG":
            continue
        identifier = message.frame_id | (0x80000000 if message.is_extended_frame else 0)
        for _ in range(each):
            frames.append((identifier, bytes(generator.randrange(256) for _ in range(message.length))))
        switch = [signal for signal in message.signals if signal.is_multiplexer]
        cases = sorted({case for signal in message.signals for case in signal.multiplexer_ids or ()})
        if switch and switch[0].start == 0 and switch[0].length == 8:
            for case in cases:
                data = bytes([case]) + bytes(generator.randrange(256) for _ in range(message.length - 1))
                frames.append((identifier, data))
    return frames


def candump(frames):
    def name(identifier):
        return f"{identifier & 0x1FFFFFFF:08X}" if identifier >> 31 else f"{identifier:03X}"

    return "".join(f"({k}.0) can0 {name(i)}#{d.hex().upper()}\n" for k, (i, d) in enumerate(frames))


def native(dbc, log):
    return subprocess.run([DECODE, dbc, log], capture_output=True, text=True)


def compare(dbc, tmp_path):
    log = tmp_path / "frames.log"
    log.write_text("(0.0) can0 7FF#00\n")
    probe = native(dbc, log)
    if probe.returncode != 0:
        assert any(reason in probe.stderr for reason in REFUSED), probe.stderr
        assert ":" in probe.stderr.split(" ")[0], "file and line are named"
        return None
    try:
        database = cantools.database.load_file(dbc, strict=False)
    except cantools.database.UnsupportedDatabaseFormatError:
        return 0  # names of values without a frame, for instance, which decoding does not need
    frames = random_frames(database, random.Random(7))
    log.write_text(candump(frames))
    got = {}
    result = native(dbc, log)
    assert result.returncode == 0, result.stderr
    for line in result.stdout.splitlines():
        number, _, signal, value = line.split(" ")
        got[int(number) - 1, signal] = float(value)
    count = 0
    for k, (identifier, data) in enumerate(frames):
        message = database.get_message_by_frame_id(identifier & 0x1FFFFFFF)
        try:
            expected = message.decode(data, decode_choices=False, allow_truncated=True)
        except (KeyError, cantools.database.DecodeError):
            continue  # a case of the multiplexer that the file does not define
        for signal, value in expected.items():
            mine = got.pop((k, signal))
            if math.isnan(value):
                assert math.isnan(mine)
                continue
            assert mine == pytest.approx(value, rel=1e-12, abs=1e-12), (signal, data.hex())
            count += 1
    return count


@pytest.mark.parametrize("dbc", OWN, ids=lambda path: path.name)
def test_own_files_are_decoded_as_cantools_does(dbc, tmp_path):
    assert compare(dbc, tmp_path) > 50


@pytest.mark.skipif(not FOREIGN, reason="VOLTLAP_DATA has no DBC files")
def test_files_of_other_teams_are_decoded_as_cantools_does_or_refused_with_the_line(tmp_path):
    results = {dbc.name: compare(dbc, tmp_path) for dbc in FOREIGN}
    refused = sorted(name for name, count in results.items() if count is None)
    assert refused == ["ksu_Orion_CANBUS_ks5e.dbc", "ksu_Orion_CANBUS_ks6e.dbc"]
    assert sum(count or 0 for count in results.values()) > 5000
