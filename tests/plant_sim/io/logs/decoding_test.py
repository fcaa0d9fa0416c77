# SPDX-License-Identifier: Apache-2.0
"""The native decoder against cantools on the same frames: the project's DBC files, cantools' own test files, and those
of other teams where VOLTLAP_DATA has them. Drawn payloads, every case of every multiplexer, frames that are too short,
CAN FD, identifiers of 29 bits."""
import math
import os
import random
import re
import subprocess
import sys
import tarfile
from pathlib import Path

import cantools
import pytest

ROOT = Path(__file__).resolve().parents[4]
BUILD = Path(os.environ["VOLTLAP_BUILD_DIR"])
DECODE = BUILD / "tests/bin/decode_frames"
DATA = os.environ.get("VOLTLAP_DATA")
OWN = sorted((ROOT / "can_dbc").glob("*.dbc"))
FOREIGN = sorted(Path(DATA).glob("**/*.dbc")) if DATA else []
KINDS = (".dbc", ".kcd", ".sym", ".arxml")
EXTENDED = 1 << 31

sys.path.insert(0, str(ROOT / "plant_sim/python"))
from voltlap_logs.dbc_json import FileRefused, text_of  # noqa: E402
from voltlap_logs.dbc_statements import read_statements  # noqa: E402


@pytest.fixture(autouse=True)
def cache_of_its_own(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


def messages_of(path):
    """As cantools reads them; of a DBC file that it does not read as a whole, those that are left."""
    if path.suffix.lower() == ".dbc":
        database = read_statements(text_of(path))[0]
    else:
        database = cantools.database.load_file(path, strict=False)
    return database.messages if database else []


def placed(data, signal, raw):
    """The payload with these bits in the place of the signal."""
    bits = [int(bit) for byte in data for bit in f"{byte:08b}"]  # in the order of the bytes, highest first
    for k in range(signal.length):  # k = 0: lowest
        if signal.byte_order == "little_endian":
            at = signal.start + k
        else:
            begin = 8 * (signal.start // 8) + 7 - signal.start % 8
            linear = begin + signal.length - 1 - k
            at = 8 * (linear // 8) + 7 - linear % 8
        bits[8 * (at // 8) + 7 - at % 8] = raw >> k & 1
    return bytes(int("".join(map(str, bits[k:k + 8])), 2) for k in range(0, len(bits), 8))


def in_its_case(message, signal, generator, data):
    """The payload with every multiplexer above the signal on one of its cases."""
    by_name = {each.name: each for each in message.signals}
    while signal.multiplexer_signal in by_name:
        above = by_name[signal.multiplexer_signal]
        data = placed(data, above, generator.choice(sorted(signal.multiplexer_ids)))
        signal = above
    return data


def frames_of(message, generator, each=8):
    def payload():
        return bytes(generator.randrange(256) for _ in range(message.length))

    frames = [payload() for _ in range(each)]
    frames += [payload()[:generator.randrange(message.length + 1)] for _ in range(2)]
    frames += [bytes(message.length), bytes([255] * message.length)]
    for signal in message.signals:
        if signal.multiplexer_ids:
            frames += [in_its_case(message, signal, generator, payload()) for _ in range(3)]
    return frames


def native(*arguments):
    return subprocess.run([DECODE, *arguments], capture_output=True, text=True)


def number_of(message):
    return message.frame_id | (EXTENDED if message.is_extended_frame else 0)


def same(mine, value):
    """Bit by bit, except for the order of rounding in scale and offset."""
    return (math.isnan(value) and math.isnan(mine)) or mine == value or math.isclose(mine, value, rel_tol=1e-12,
                                                                                     abs_tol=1e-12)


def decoded(message, data):
    return message.decode(data, decode_choices=False, allow_truncated=True)


def alone(message, signal):
    return cantools.database.can.Message(message.frame_id, message.name, message.length, [signal], strict=False,
                                         is_extended_frame=message.is_extended_frame)


def expected_of(message, data):
    """What cantools decodes. Signals that overlap it decodes one at a time only."""
    try:
        return decoded(message, data)
    except (KeyError, cantools.database.DecodeError) as error:
        if "unpacking failed" not in str(error) or any(each.is_multiplexer for each in message.signals):
            return None  # a case of the multiplexer that the file does not define, or cut off with its multiplexer
    out = {}
    for signal in message.signals:
        out |= decoded(alone(message, signal), data)
    return out


def as_orion_means(message, name, value):
    """Orion's exporter marks its currents and temperatures unsigned; they are two's complement."""
    signal = message.get_signal_by_name(name)
    of_orion = message.name.startswith("MSGID_0X") and "Third_Party_Device" in signal.receivers
    means = {"Celsius": r"\w+_Temperature", "Amps": r"(?!Abs)\w+_Current"}.get(signal.unit)
    if not of_orion or means is None or not re.fullmatch(means, name) or signal.is_signed:
        return value
    raw = round((value - signal.offset) / signal.scale)
    return signal.offset + signal.scale * (raw - (1 << signal.length) * (raw >> (signal.length - 1)))


def compare(path, tmp_path, seed=7):
    """(values compared, identifiers refused) of a file; None for one that is refused as a whole."""
    probe = native(path)
    if probe.returncode == 1:
        assert str(path) in probe.stderr
        return None
    assert probe.returncode == 0, probe.stderr
    refused = {int(line.split(" ")[1]) for line in probe.stdout.splitlines()}
    generator = random.Random(seed)
    frames = [(message, data) for message in messages_of(path) if number_of(message) not in refused
              for data in frames_of(message, generator)]
    listing = tmp_path / "frames.txt"
    listing.write_text("".join(f"{number_of(message):X} {data.hex()}\n" for message, data in frames))
    result = native(path, listing)
    assert result.returncode == 0, result.stderr
    got = {}
    for line in result.stdout.splitlines():
        if not line.startswith("refused"):
            number, rest = line.split(" ", 1)
            signal, value = rest.rsplit(" ", 1)
            got.setdefault(int(number) - 1, {})[signal] = float(value)
    count = 0
    for k, (message, data) in enumerate(frames):
        expected = expected_of(message, data)
        if expected is None:
            continue
        mine = got.get(k, {})
        assert mine.keys() == expected.keys(), (path.name, message.name, data.hex(), seed)
        for signal, value in expected.items():
            value = as_orion_means(message, signal, value)
            assert same(mine[signal], value), (path.name, message.name, signal, data.hex(), mine[signal], value, seed)
        count += len(expected)
    return count, refused


@pytest.mark.parametrize("dbc", OWN, ids=lambda path: path.name)
def test_own_files_are_decoded_as_cantools_does(dbc, tmp_path):
    count, refused = compare(dbc, tmp_path)
    assert count > 50 and not refused


@pytest.mark.skipif(not FOREIGN, reason="VOLTLAP_DATA has no DBC files")
def test_files_of_other_teams_are_decoded_as_cantools_does(tmp_path):
    results = {dbc.name: compare(dbc, tmp_path) for dbc in FOREIGN}
    assert None not in results.values()
    # Frames that stand twice in their file, or have a signal twice.
    assert {name for name, (_, refused) in results.items() if refused} == {"ksu_Orion_CANBUS_ks5e.dbc",
                                                                            "ksu_Orion_CANBUS_ks6e.dbc"}
    assert sum(count for count, _ in results.values()) > 20000


@pytest.fixture(scope="module")
def cantools_files():
    """cantools' own test files, from its source package; fetched once."""
    wanted = re.search(r"^cantools==\S+", (ROOT / "toolchain/requirements/run.txt").read_text(), re.MULTILINE).group()
    folder = BUILD / "cantools_sources"
    package = folder / f"{wanted.replace('==', '-')}.tar.gz"
    if not package.exists():
        folder.mkdir(exist_ok=True)
        fetch = subprocess.run([sys.executable, "-m", "pip", "download", "--quiet", "--no-binary", ":all:", "--no-deps",
                                "--dest", folder, wanted], capture_output=True, text=True, timeout=300)
        if fetch.returncode != 0 or not package.exists():
            pytest.skip(f"the source package of {wanted} cannot be fetched: {fetch.stderr.strip()[-200:]}")
    files = folder / package.name.removesuffix(".tar.gz") / "tests/files"
    if not files.is_dir():
        with tarfile.open(package) as archive:
            archive.extractall(folder, **({"filter": "data"} if hasattr(tarfile, "data_filter") else {}))
    return sorted(path for path in files.rglob("*") if path.suffix.lower() in KINDS)


def test_test_files_of_cantools_are_decoded_as_cantools_does(cantools_files, tmp_path):
    """A quarter of them, drawn by VOLTLAP_TEST_SEED, beside those of each kind; all with VOLTLAP_TEST_WHOLE=1: each
    starts Python anew, two minutes together."""
    always = ("fd_test.dbc", "floating_point.dbc", "issue_184_extended_mux_cascaded.dbc", "multiplex_2.dbc",
              "issue_184_extended_mux_multiple_values.dbc", "motohawk.dbc", "signed.dbc", "vehicle.dbc")
    assert len(cantools_files) > 100
    seed = os.environ.get("VOLTLAP_TEST_SEED", "1")
    drawn = set(random.Random(seed).sample(cantools_files, len(cantools_files) // 4))
    whole = os.environ.get("VOLTLAP_TEST_WHOLE") == "1"
    print(f"VOLTLAP_TEST_SEED={seed}")
    compared = {path: compare(path, tmp_path) for path in cantools_files
                if whole or path in drawn or path.name in always}
    counts = {path.name: result[0] for path, result in compared.items() if result and path.suffix == ".dbc"}
    for name in always:
        assert counts[name] > 0, name
    assert sum(result[0] for result in compared.values() if result) > (15000 if whole else 5000)


def drawn_dbc(generator):
    """A file with frames of every kind: both byte orders, lengths to 64 bits, floats, nested multiplexers with ranges
    of cases, 29-bit identifiers, CAN FD."""
    frames, tail = [], []
    for k in range(12):
        identifier = (EXTENDED | generator.randrange(1 << 29)) if k % 3 == 0 else 0x100 + k
        size = generator.choice((1, 2, 8, 8, 8, 12, 24, 64))
        lines = [f"BO_ {identifier} F{k}: {size} X"]
        nested = k % 2 == 0 and size >= 8
        motorola = not nested and generator.random() < 0.5  # of a frame whose signals do not overlap
        if nested:
            sign = generator.choice("+-")
            lines += [" SG_ Outer M : 0|4@1+ (1,0) [0|0] \"\" X", f" SG_ Inner m1M : 4|4@1{sign} (1,0) [0|0] \"\" X"]
            tail.append(f"SG_MUL_VAL_ {identifier} Inner Outer 1-3, 7-7;")
        free = 8 if nested else 0  # the first bit that no signal has
        for n in range(generator.randrange(1, 9)):
            overlapping = k % 4 == 1  # allowed: real files have it
            room = 8 * size - (0 if overlapping else free)
            kind = generator.randrange(6)
            length = {0: generator.choice((16, 32)), 1: 64}.get(kind, generator.randrange(1, 65))
            if length > room:
                continue
            begin = generator.randrange(room - length + 1) if overlapping else free
            free = begin + length
            big = generator.random() < 0.5 if overlapping else motorola
            start = 8 * (begin // 8) + 7 - begin % 8 if big else begin
            mark = ""
            if nested:
                low = generator.randrange(6)
                mark, above = generator.choice(((" m2", "Outer"), (" m4", "Inner"), ("", "")))
                if above:
                    tail.append(f"SG_MUL_VAL_ {identifier} S{n} {above} {low}-{low + 2};")
            scale, offset = generator.choice(((1, 0), (0.1, 0), (-0.25, 100), (1e-3, -40.5)))
            lines.append(f" SG_ S{n}{mark} : {start}|{length}@{0 if big else 1}{generator.choice('+-')} "
                         f"({scale},{offset}) [0|0] \"\" X")
            if kind < 2:
                tail.append(f"SIG_VALTYPE_ {identifier} S{n} : {kind + 1};")
        frames.append("\n".join(lines))
    return "\n\n".join(frames) + "\n\n" + "\n".join(tail) + "\n"


@pytest.mark.parametrize("seed", range(20))
def test_drawn_files_are_decoded_as_cantools_does(seed, tmp_path):
    dbc = tmp_path / f"drawn_{seed}.dbc"
    dbc.write_text(drawn_dbc(random.Random(seed)))
    count, refused = compare(dbc, tmp_path, seed)
    assert count > 100 and not refused, seed


def test_file_that_is_refused_as_a_whole_is_named(tmp_path):
    path = tmp_path / "notes.dbc"
    path.write_text("nothing of a bus\n")
    assert compare(path, tmp_path) is None
    with pytest.raises(FileRefused):
        text_of(tmp_path / "no_such.dbc")
