# SPDX-License-Identifier: Apache-2.0
"""A recording that is cut or damaged anywhere: what stood before is given, the place is told, nothing is made up, and
no Python shows."""
import gzip
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from recordings import drawn, generator, read, text_of, told, write

for package in ("asammdf", "can", "zstandard"):
    pytest.importorskip(package, reason="needs toolchain/requirements/logs.txt")
import zstandard  # noqa: E402

ROOT = Path(__file__).resolve().parents[3]
ENVIRONMENT = os.environ | {"PYTHONPATH": str(ROOT / "plant_sim" / "python")}
KEYS = ("blf", "trc", "csv", "db", "mf4")


def recorded(key, path, capsys, monkeypatch, count=300):
    assert write(capsys, monkeypatch, path, key, drawn(key, count)).code == 0
    return read(capsys, path).out.splitlines()


def check(answer, whole, draw):
    """Exit codes and words; the frames are the first of the whole file."""
    lines = answer.out.splitlines()
    assert answer.code in (0, 2, 3), draw
    assert lines == whole[:len(lines)], draw
    assert "Traceback" not in answer.err
    if answer.code == 2:
        assert len(answer.err.splitlines()) == 1 and not lines, (draw, answer.err)
    else:
        assert answer.report["frames"] == len(lines), draw
    if answer.code == 3:
        assert "breaks off" in answer.err, draw
    return answer.code


@pytest.mark.parametrize("key", KEYS)
def test_a_recording_cut_anywhere_gives_what_stood_before(key, tmp_path, capsys, monkeypatch):
    whole = recorded(key, tmp_path / "whole", capsys, monkeypatch)
    data, codes = (tmp_path / "whole").read_bytes(), []
    for draw in range(40):
        size = generator(f"{key} {draw}").randrange(1, len(data))
        (tmp_path / f"cut.{key}").write_bytes(data[:size])
        answer = read(capsys, tmp_path / f"cut.{key}")
        codes.append(check(answer, whole, f"{told(draw)}, {size} of {len(data)} bytes: {answer.err}"))
    assert 3 in codes or key in ("mf4", "db")
    if key in ("blf", "mf4"):
        assert 0 not in codes, told(key)


@pytest.mark.parametrize("key", KEYS)
def test_a_recording_with_damaged_bytes_never_ends_in_python_s_words(key, tmp_path, capsys, monkeypatch):
    recorded(key, tmp_path / "whole", capsys, monkeypatch, 100)
    data = (tmp_path / "whole").read_bytes()
    for draw in range(60):
        chance, damaged = generator(f"damage {key} {draw}"), bytearray(data)
        for _ in range(chance.randrange(1, 20)):
            damaged[chance.randrange(len(data))] = chance.randrange(256)
        (tmp_path / f"damaged.{key}").write_bytes(damaged)
        answer = read(capsys, tmp_path / f"damaged.{key}")
        assert answer.code in (0, 2, 3) and "Traceback" not in answer.err, (told(draw), answer.err)
        assert answer.code != 2 or len(answer.err.splitlines()) <= 2, (told(draw), answer.err)


def test_a_library_that_a_signal_ends_is_a_file_that_breaks_off():
    """What it gave before counts, what was counted, too; its own words and an unknown error stay behind."""
    from voltlap_logs.errors import BrokenOff
    from voltlap_logs.isolated import isolated
    from voltlap_logs.tally import Tally

    def ends(last):
        def lines(tally):
            tally.skip("rows of signals", count=3)
            yield "one\n"
            last()
            yield "two\n"
        return lines

    def segfault():
        os.kill(os.getpid(), signal.SIGSEGV)

    def unknown():
        raise ValueError("zip() argument 2\nis shorter")

    for last, words, counted in ((segfault, "ends the library", 0), (unknown, "argument 2 is shorter", 3)):
        tally, given = Tally("MF4"), []
        with pytest.raises(BrokenOff, match=words):
            for text in isolated(ends(last), tally):
                given.append(text)
        assert given == ["one\n"] and tally.skipped["rows of signals"] == counted
    assert list(isolated(ends(lambda: None), Tally("MF4"))) == ["one\n", "two\n"]


@pytest.mark.parametrize("pack", [gzip.compress, zstandard.ZstdCompressor().compress])
@pytest.mark.parametrize("key", ("blf", "trc", "csv"))
def test_a_packing_that_breaks_off_gives_what_was_in_it(key, pack, tmp_path, capsys, monkeypatch):
    whole = recorded(key, tmp_path / "whole", capsys, monkeypatch, 5000)
    data, most = pack((tmp_path / "whole").read_bytes()), 0
    for share in (0.2, 0.6, 0.95):
        (tmp_path / "cut").write_bytes(data[:int(len(data) * share)])
        answer = read(capsys, tmp_path / "cut")
        assert check(answer, whole, share) in (2, 3) and "packing" in answer.err, answer.err
        most = max(most, len(answer.frames))
    assert most > 0


def test_an_unfinished_mf4_is_read_and_called_unfinished(tmp_path, capsys, monkeypatch):
    whole = recorded("mf4", tmp_path / "whole", capsys, monkeypatch)
    data = bytearray((tmp_path / "whole").read_bytes())
    data[:8] = b"UnFinMF "
    (tmp_path / "unfinished.mf4").write_bytes(data)
    answer = read(capsys, tmp_path / "unfinished.mf4")
    assert (answer.code, answer.out.splitlines()) == (3, whole)
    assert "did not close" in answer.err


def started(module, *arguments, **more):
    return subprocess.Popen([sys.executable, "-m", f"voltlap_logs.{module}", *arguments], env=ENVIRONMENT, text=True,
                            stdout=subprocess.PIPE, stderr=subprocess.PIPE, **more)


def test_who_reads_may_stop_early(tmp_path, capsys, monkeypatch):
    recorded("csv", tmp_path / "a.csv", capsys, monkeypatch, 20_000)
    program = started("frames", str(tmp_path / "a.csv"))
    assert program.stdout.readline()
    program.stdout.close()
    assert "Traceback" not in program.stderr.read() and program.wait() != 0


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("key", KEYS)
def test_a_writer_that_is_stopped_leaves_nothing_behind(key, number, tmp_path):
    program = started("write_frames", "--format", key, str(tmp_path / f"a.{key}"), stdin=subprocess.PIPE)
    program.stdin.write(text_of(drawn("stopped", 50)))
    program.stdin.flush()
    time.sleep(0.7)
    program.send_signal(number)
    _, words = program.communicate()
    assert program.returncode != 0 and "Traceback" not in words
    assert not list(tmp_path.iterdir())


def test_a_package_that_is_missing_is_named_with_what_installs_it(tmp_path, capsys, monkeypatch):
    recorded("mf4", tmp_path / "a.mf4", capsys, monkeypatch)
    monkeypatch.setitem(sys.modules, "asammdf", None)
    answer = read(capsys, tmp_path / "a.mf4")
    assert answer.code == 2 and "asammdf is missing" in answer.err and "./voltlap log" in answer.err


def test_files_that_are_not_there(tmp_path, capsys, monkeypatch):
    assert "there is no such file" in read(capsys, tmp_path / "none.blf").err
    assert "is a folder" in read(capsys, tmp_path).err
    assert "there is no folder" in write(capsys, monkeypatch, tmp_path / "none" / "a.blf", "blf", drawn("x", 3)).err
