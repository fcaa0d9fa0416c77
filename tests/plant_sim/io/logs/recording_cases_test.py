# SPDX-License-Identifier: Apache-2.0
"""Recordings as loggers, clocks and exporters of the field make them. Each is the same test: a current of 0 and 100 A
in turns of 20 s, a voltage of 96 V - 0.05 ohm I, a row each 0.4 s, 120 s. A right reader gives that, or says why
not."""
import gzip
import os
import shutil
import struct
import subprocess
from pathlib import Path

import pytest

BIN = Path(os.environ["VOLTLAP_BUILD_DIR"]) / "tests/bin"
ROWS, STEP_S, BEGIN_S = 300, 0.4, 1.7e9
SIGNALS = ' SG_ I : 0|16@1- (0.1,0) [-3000|3000] "A" X\n SG_ V : 16|16@1+ (0.01,0) [0|600] "V" X\n'
DBC = 'VERSION ""\n\nBS_:\n\nBU_: BMS X\n\nBO_ 256 Pack: 8 BMS\n' + SIGNALS
FRAME = 'frame = 0x100, dbc = "a.dbc"'


def current(k):
    return 0.0 if int(k * STEP_S / 20) % 2 == 0 else 100.0


def voltage(k):
    return 96.0 - 0.05 * current(k)


def payload(k):
    return struct.pack("<hHxxxx", round(10 * current(k)), round(100 * voltage(k))).hex().upper()


def candump(stamps=None, bus="can0", rows=range(ROWS)):
    stamps = stamps or (lambda k: BEGIN_S + STEP_S * k)
    return [f"({stamps(k):.6f}) {bus} 100#{payload(k)}" for k in rows]


def role_map(extra="", signal_i="I", signal_v="V"):
    return (f'[roles]\ncurrent = {{{FRAME}, signal = "{signal_i}", unit = "A", discharge = "+"{extra}}}\n'
            f'pack_voltage = {{{FRAME}, signal = "{signal_v}", unit = "V"{extra}}}\n')


class Reading:
    def __init__(self, done):
        self.code, self.err, self.out = done.returncode, done.stderr, done.stdout
        self.channels = {}
        for line in done.stdout.splitlines():
            if line.startswith("channel "):
                _, role, samples, begin, end, low, high = line.split(" ")
                self.channels[role] = (int(samples), float(end) - float(begin), float(low), float(high))


@pytest.fixture(scope="module")
def cache(tmp_path_factory):
    return tmp_path_factory.mktemp("cache")


@pytest.fixture
def read(tmp_path, cache):
    def run(recording, dbc=DBC, roles=None, name="a.log"):
        (tmp_path / "a.dbc").write_text(dbc)
        (tmp_path / "a.toml").write_text(roles or role_map())
        text = recording if isinstance(recording, (str, bytes)) else "\n".join(recording) + "\n"
        (tmp_path / name).write_bytes(text if isinstance(text, bytes) else text.encode())
        return Reading(subprocess.run([BIN / "show_log", tmp_path / name, tmp_path / "a.toml"], capture_output=True,
                                      text=True, env={**os.environ, "XDG_CACHE_HOME": str(cache)}))
    return run


def check_whole(reading, samples=ROWS, span=(ROWS - 1) * STEP_S, lowest=0.0):
    assert reading.code == 0, reading.err
    count, seconds, low, high = reading.channels["current"]
    assert (count, low, high) == (samples, lowest, 100.0), reading.out
    assert seconds == pytest.approx(span, abs=2e-3), reading.out
    assert reading.channels["pack_voltage"][2:] == pytest.approx((91.0, 96.0 - 0.05 * lowest))


def test_the_recording_itself(read):
    check_whole(read(candump()))


# Several buses

def two_buses():
    other = [f"({BEGIN_S + STEP_S * k + 0.01:.6f}) can1 100#D007D0070000AAAA" for k in range(ROWS)]
    return [line for pair in zip(candump(), other) for line in pair]


def test_one_identifier_on_two_buses_is_refused_until_the_map_names_one(read):
    refused = read(two_buses())
    assert refused.code == 1 and "0x100 on can0 and on can1" in refused.err and 'bus = "can0"' in refused.err
    check_whole(read(two_buses(), roles=role_map(', bus = "can0"')))


def test_the_other_bus_is_its_own_signal(read):
    reading = read(two_buses(), roles=role_map(', bus = "can1"'))
    assert reading.channels["current"][2:] == (200.0, 200.0)


def test_channels_of_asc_are_buses(read):
    lines = ["base hex  timestamps absolute"]
    for k in range(ROWS):
        data = " ".join(payload(k)[n:n + 2] for n in range(0, 16, 2))
        lines += [f"{STEP_S * k:.6f} 1  100 Rx d 8 {data}",
                  f"{STEP_S * k + 0.01:.6f} 2  100 Rx d 8 00 00 00 00 00 00 00 00"]
    assert read(lines).code == 1
    check_whole(read(lines, roles=role_map(', bus = "can1"')))


def test_buses_one_behind_the_other_are_refused(read):
    lines = candump() + [line.replace("can0", "can1").replace("100#", "200#") for line in candump()]
    refused = read(lines)
    assert refused.code == 1 and "can1" in refused.err and "sort" in refused.err
    check_whole(read(sorted(lines)))


# Clocks

@pytest.mark.parametrize("late_s", [0.005, 0.3, 2.0])
def test_frames_written_late_are_sorted(read, late_s):
    between_s = 0.9 * late_s
    other = [(BEGIN_S + STEP_S * k + between_s, f"({BEGIN_S + STEP_S * k + between_s:.6f}) can1 0C4065A7#AF00")
             for k in range(ROWS)]
    own = [(BEGIN_S + STEP_S * k + late_s, line) for k, line in enumerate(candump())]
    reading = read([line for _, line in sorted(other + own)])
    check_whole(reading)
    assert "out of order, sorted" in reading.out


@pytest.mark.parametrize("back_s", [40.0, 7.0, 3600.0])
def test_a_clock_that_is_set_back_is_joined_and_said(read, back_s):
    reading = read(candump(lambda k: BEGIN_S + STEP_S * k - (back_s if k >= 150 else 0.0)))
    check_whole(reading)
    assert "line 151: the clock was set" in reading.out and "2 parts" in reading.out


@pytest.mark.parametrize("first", [12, 100, 290])
def test_a_clock_that_is_set_after_boot_makes_no_gap(read, first):
    reading = read(candump(lambda k: STEP_S * k + (BEGIN_S if k >= first else 0.0)))
    check_whole(reading)
    assert "the clock was set" in reading.out and "gap" not in reading.out


@pytest.mark.parametrize("width_s", [65.536, 4294.967296])
def test_a_counter_that_wraps_goes_on(read, width_s):
    check_whole(read(candump(lambda k: (width_s - 30.0 + STEP_S * k) % width_s)))


@pytest.mark.parametrize("stamp", ["1e308", "9999999999999999", "0.0", "4000000000.0"])
def test_one_bad_stamp_costs_one_frame(read, stamp):
    lines = candump()
    lines[100] = f"({stamp}) can0 100#{payload(100)}"
    reading = read(lines)
    assert reading.channels["current"][0] == ROWS - 1, reading.out
    assert reading.channels["current"][1] == pytest.approx((ROWS - 1) * STEP_S, abs=1e-3)
    assert "1 x" in reading.out


# Formats

def asc_lines(kind, relative=False):
    lines = ["date Mon Nov 24 10:00:00.000 am 2025", f"base hex  timestamps {'relative' if relative else 'absolute'}"]
    for k in range(ROWS):
        data = " ".join(payload(k)[n:n + 2] for n in range(0, 16, 2))
        stamp = (STEP_S / 2 if k else 0.0) if relative else STEP_S * k
        frame = {"d": f"{stamp:.6f} 1  100 Rx   d 8 {data}",
                 "fd": f"{stamp:.6f} CANFD   1 Rx 100   1 0 8 08 {data} 0 0 3000 0 0 0 0 0",
                 "fd name": f"{stamp:.6f} CANFD   1 Rx        100  Pack_Message    0 0 8  8 {data} 102203 131 0"}[kind]
        lines.append(frame)
        if relative:
            lines.append(f"{STEP_S / 2:.6f} 1  ErrorFrame")
    return lines


@pytest.mark.parametrize("kind", ["d", "fd", "fd name"])
@pytest.mark.parametrize("relative", [False, True])
def test_vector_asc(read, kind, relative):
    check_whole(read(asc_lines(kind, relative), name="a.asc"))


@pytest.mark.parametrize("stamp", ["({t:.6f})", "({date})", "(000.400000)"])
def test_candump_on_the_screen(read, stamp):
    lines = []
    for k in range(ROWS):
        data = " ".join(payload(k)[n:n + 2] for n in range(0, 16, 2))
        date = f"2023-11-14 22:{13 + int(STEP_S * k) // 60:02d}:{(STEP_S * k) % 60:09.6f}"
        lines.append(f" {stamp.format(t=BEGIN_S + STEP_S * k, date=date)}  can0  100   [8]  {data}")
    check_whole(read(lines))


def slcan(end="\n", stamped=True, turn=60000):
    return "".join(f"t1008{payload(k)}" + (f"{round(400 * k) % turn:04X}" if stamped else "") + end
                   for k in range(ROWS))


@pytest.mark.parametrize("end", ["\n", "\r", "\r\n"])
@pytest.mark.parametrize("turn", [60000, 65536])
def test_slcan_with_stamps(read, end, turn):
    check_whole(read(slcan(end, turn=turn)))


def test_slcan_without_stamps_needs_an_interval(read):
    refused = read(slcan(stamped=False))
    assert refused.code == 1 and "without stamps" in refused.err and "period_s" in refused.err
    given = read(slcan(stamped=False), roles=role_map(", period_s = 0.4"))
    check_whole(given)
    assert "every 400 ms is the clock" in given.out
    cycle = DBC + '\nBA_DEF_ BO_ "GenMsgCycleTime" INT 0 10000;\nBA_DEF_DEF_ "GenMsgCycleTime" 0;\n' \
                  'BA_ "GenMsgCycleTime" BO_ 256 400;\n'
    check_whole(read(slcan(stamped=False), dbc=cycle))


def test_without_stamps_only_one_bus_is_the_clock(read):
    lines = []
    for k in range(ROWS):
        data = " ".join(payload(k)[n:n + 2] for n in range(0, 16, 2))
        lines += [f"  can{bus}  100   [8]  {data}" for bus in (2, 0, 1)]
    check_whole(read(lines, roles=role_map(', bus = "can0", period_s = 0.4')))


def test_a_bus_that_the_recording_does_not_have_is_named(read):
    refused = read(candump(), roles=role_map(', bus = "can7"'))
    assert refused.code == 1 and "can7" in refused.err and "can0" in refused.err


def test_frames_by_name_have_their_identifier_at_the_end_of_the_line(read):
    lines = ["base hex  timestamps absolute"]
    for k in range(ROWS):
        data = " ".join(payload(k)[n:n + 2] for n in range(0, 16, 2))
        lines.append(f"{STEP_S * k:.6f} 1  Pack_Message   Rx   d 8 {data}  Length = 230000 BitCount = 118 ID = 256")
    check_whole(read(lines, name="a.asc"))


@pytest.mark.parametrize("pack", [gzip.compress, None])
def test_a_packing_cut_in_its_first_block_breaks_off(read, pack):
    data = "\n".join(candump(rows=range(3))).encode()
    data = pack(data) if pack else subprocess.run(["zstd", "-q", "-c"], input=data, capture_output=True).stdout
    refused = read(data[:len(data) // 2])
    assert refused.code == 1 and "breaks off" in refused.err, refused.err


def test_a_pipe_is_called_a_pipe(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    done = subprocess.run([BIN / "show_log", tmp_path / "pipe"], capture_output=True, text=True, timeout=20)
    assert done.returncode == 1 and "a pipe" in done.stderr


def test_of_j1939_the_parameter_group_counts_whoever_sends_it(read):
    dbc = ('VERSION ""\n\nBU_: BMS X\n\nBO_ 2566844926 Pack: 8 BMS\n' + SIGNALS
           + '\nBA_DEF_ "ProtocolType" STRING ;\nBA_DEF_DEF_ "ProtocolType" "";\nBA_ "ProtocolType" "J1939";\n')
    lines = [line.replace(" 100#", " 18FEF117#") for line in candump()]
    roles = role_map().replace("0x100", "0x18FEF117")
    check_whole(read(lines, dbc=dbc, roles=roles))
    assert read(lines, dbc=dbc.replace('"J1939";', '"Other";'), roles=roles).code == 1


@pytest.mark.parametrize("pack", ["gzip", "zstd", "plain"])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_packings_and_ends_of_lines(read, pack, end):
    data = (end.join(candump()) + end).encode()
    if pack == "gzip":
        data = gzip.compress(data)
    if pack == "zstd":
        if not shutil.which("zstd"):
            pytest.skip("zstd is not there")
        data = subprocess.run(["zstd", "-q", "-c"], input=data, capture_output=True, check=True).stdout
    check_whole(read(data))


def test_a_stream_that_breaks_off_is_refused(read):
    data = gzip.compress(("\n".join(candump()) + "\n").encode())
    reading = read(data[:len(data) * 2 // 3])
    assert reading.code == 1 and "breaks off" in reading.err


# DBC files

def floats():
    return [f"({BEGIN_S + STEP_S * k:.6f}) can0 100#{struct.pack('<ff', current(k), voltage(k)).hex()}"
            for k in range(ROWS)]


@pytest.mark.parametrize("comment", [r'shunt bar 1\" wide', r'a \\', 'two\nlines; SG_ of "', "ends in a backslash"])
def test_floats_behind_any_comment(read, comment):
    text = comment.replace('"', r'\"') if '\\"' not in comment and '"' in comment else comment
    dbc = ('VERSION ""\n\nBU_: BMS X\n\nBO_ 256 Pack: 8 BMS\n SG_ I : 0|32@1- (1,0) [0|0] "A" X\n'
           f' SG_ V : 32|32@1- (1,0) [0|0] "V" X\n\nCM_ SG_ 256 I "{text}";\n'
           "SIG_VALTYPE_ 256 I : 1;\nSIG_VALTYPE_ 256 V : 1;\n")
    check_whole(read(floats(), dbc=dbc))


@pytest.mark.parametrize("ranges, samples", [("0-3", ROWS), ("0-1, 3-3", ROWS * 3 // 4), ("0-0, 2-2", ROWS // 2)])
def test_ranges_of_a_multiplexer(read, ranges, samples):
    dbc = ('VERSION ""\n\nBU_: BMS X\n\nBO_ 256 Pack: 8 BMS\n SG_ Mux M : 0|8@1+ (1,0) [0|3] "" X\n'
           ' SG_ I m0 : 8|16@1- (0.1,0) [-3000|3000] "A" X\n SG_ V m0 : 24|16@1+ (0.01,0) [0|600] "V" X\n\n'
           f"SG_MUL_VAL_ 256 I Mux {ranges};\nSG_MUL_VAL_ 256 V Mux {ranges};\n")
    lines = [f"({BEGIN_S + STEP_S * k:.6f}) can0 100#{k % 4:02X}{payload(k)[:8]}000000" for k in range(ROWS)]
    assert read(lines, dbc=dbc).channels["current"][0] == samples


@pytest.mark.parametrize("dbc", [
    DBC.replace("BO_ ", "BO_\t").replace(" SG_ ", "\tSG_\t"),
    DBC.replace("\n", "\r\n"),
    "\ufeff" + DBC,
    DBC.replace('"A" X\n SG_ V', '"A" X SG_ V'),
    DBC.replace(" : 0|16", ":0|16").replace('[-3000|3000] "A"', '[-3000|3000]  "A"'),
])
def test_dbc_files_as_people_write_them(read, dbc):
    check_whole(read(candump(), dbc=dbc))


def test_a_frame_that_is_there_twice_hurts_only_itself(read):
    twice = DBC + "\nBO_ 512 Other: 8 BMS\n SG_ A : 0|8@1+ (1,0) [0|0] \"\" X\n" * 2
    check_whole(read(candump(), dbc=twice))
    refused = read(candump(), dbc=DBC + "\nBO_ 256 Again: 8 BMS\n" + SIGNALS)
    assert refused.code == 1 and "0x100" in refused.err and "a.dbc:" in refused.err


# Codes and signs

@pytest.mark.parametrize("bits, top", [(8, 255), (16, 65535)])
def test_full_throttle_is_full_throttle(read, bits, top):
    dbc = DBC + f'\nBO_ 513 Pedal: 8 VCU\n SG_ Throttle : 0|{bits}@1+ ({100 / top:.9g},0) [0|100] "%" X\n'
    lines = []
    for k, line in enumerate(candump()):
        raw = min(top, max(0, round(top * ((k % 100) / 50 if k % 100 < 60 else 0.0))))
        lines += [line, f"({BEGIN_S + STEP_S * k + 0.001:.6f}) can0 201#{raw.to_bytes(8, 'little').hex()}"]
    roles = role_map() + 'accelerator = {frame = 0x201, signal = "Throttle", dbc = "a.dbc", unit = "%"}\n'
    reading = read(lines, dbc=dbc, roles=roles)
    assert reading.channels["accelerator"][3] == pytest.approx(1.0, abs=1e-6)
    assert "accelerator" not in "".join(line for line in reading.out.splitlines() if "invalid" in line)


def test_a_code_that_the_dbc_names_is_no_value(read):
    dbc = DBC + '\nCM_ SG_ 256 V "pack voltage, 65535 = not available";\n'
    lines = candump()
    for k in (50, 51, 200):
        lines[k] = lines[k][:-16] + lines[k][-16:-12] + "FFFF" + lines[k][-8:]
    reading = read(lines, dbc=dbc)
    check_whole(reading)
    assert "invalid" in reading.out


@pytest.mark.parametrize("lowest", [-30.0, -1.0])
@pytest.mark.parametrize("limits", ["[0|6553.5]", "[0|0]", "[0|1000]", "[-3000|3000]"])
def test_an_unsigned_current_that_wraps_is_named(read, lowest, limits):
    dbc = DBC.replace("0|16@1- (0.1,0) [-3000|3000]", f"0|16@1+ (0.1,0) {limits}")
    lines = []
    for k in range(ROWS):
        amps = current(k) if current(k) > 0 else lowest + (k % 5) * 0.1
        data = struct.pack("<hHxxxx", round(10 * amps), round(100 * (96 - 0.05 * amps))).hex()
        lines.append(f"({BEGIN_S + STEP_S * k:.6f}) can0 100#{data}")
    reading = read(lines, dbc=dbc)
    assert reading.code == 0, reading.err
    assert reading.channels["current"][2:] == pytest.approx((lowest, 100.0))
    assert "unsigned" in reading.out and "read as signed" in reading.out
