# SPDX-License-Identifier: Apache-2.0
"""Drawn recordings, and the programs of voltlap_logs called on them. VOLTLAP_TEST_SEED chooses the draws."""
import io
import json
import os
import random
import sys
from pathlib import Path
from typing import NamedTuple

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "plant_sim" / "python"))
from voltlap_logs import frames as frames_program  # noqa: E402
from voltlap_logs import write_frames as write_program  # noqa: E402
from voltlap_logs.candump import ERROR, EXTENDED, FD_LENGTHS, NS, Frame, line, parse  # noqa: E402

SEED = int(os.environ.get("VOLTLAP_TEST_SEED", "1"))
START_NS = 1763828454 * NS


class Answer(NamedTuple):
    code: int
    out: str
    err: str

    @property
    def frames(self):
        return [parse(text) for text in self.out.splitlines()]

    @property
    def report(self):
        return json.loads(self.err.splitlines()[-1])


def generator(draw):
    return random.Random(f"{SEED} {draw}")


def told(draw):
    return f"VOLTLAP_TEST_SEED={SEED}, draw {draw}"


def drawn_frame(chance, time_ns, bus):
    id = chance.randrange(1 << 29) | EXTENDED if chance.random() < 0.4 else chance.randrange(1 << 11)
    kind = chance.random()
    if kind < 0.1:
        return Frame(time_ns, bus, id, b"", None, chance.randrange(9))
    if kind < 0.2:
        return Frame(time_ns, bus, ERROR | chance.choice((0x04, 0x80, 0x88)), chance.randbytes(8))
    if kind < 0.5:
        return Frame(time_ns, bus, id, chance.randbytes(chance.choice(FD_LENGTHS)), chance.randrange(4))
    return Frame(time_ns, bus, id, chance.randbytes(chance.randrange(9)))


def drawn(draw, count=300, buses=("can1", "can2", "can3")):
    """Frames of every kind; several of one time, a pause, and stamps of whole nanoseconds."""
    chance, time_ns, found = generator(draw), START_NS + generator(draw).randrange(NS), []
    for _ in range(count):
        time_ns += chance.choice((0, chance.randrange(1000), chance.randrange(5_000_000), chance.randrange(60 * NS)))
        found.append(drawn_frame(chance, time_ns, chance.choice(buses)))
    return found


def text_of(frames):
    return "".join(line(frame) for frame in frames)


def read(capsys, path, *flags):
    capsys.readouterr()
    code = frames_program.main([str(path), *flags])
    return Answer(code, *capsys.readouterr())


def write(capsys, monkeypatch, path, key, frames):
    capsys.readouterr()
    text = frames if isinstance(frames, str) else text_of(frames)
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(text.encode())))
    code = write_program.main(["--format", key, str(path)])
    return Answer(code, *capsys.readouterr())


def to_microseconds(frame):
    return frame._replace(time_ns=(frame.time_ns + 500) // 1000 * 1000)
