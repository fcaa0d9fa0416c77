# SPDX-License-Identifier: Apache-2.0
"""What is done with a cell: pulses, discharges, drives, a slow pair; and how a cut-off voltage ends it."""
from dataclasses import dataclass, replace

import numpy as np

from . import cell as cells


@dataclass(frozen=True)
class Segment:
    seconds: float
    current_a: float
    ends: str = ""  # what a limit of voltage does: "rest" ends the program with a rest, "next" goes on with the next


@dataclass(frozen=True)
class Program:
    kind: str
    temperature_c: float
    rate: float  # largest current over the capacity
    segments: tuple
    sample_s: float
    phase_s: float  # of the reading after its row's time; the current changes at multiples of sample_s
    sparse: bool  # reads rests and long loads ten times slower


ROWS_MAX = 30000  # of a drive


def whole(seconds, sample):
    return max(1, round(seconds / sample)) * sample


def hppc(rng, cell, rate, sample):
    q, pulse, rest = cell.capacity_ah, whole(rng.choice([10, 18, 30]), sample), whole(40, sample)
    step = rng.choice([0.05, 0.1, 0.1])
    down = rng.choice([0.5, 1.0])
    out = [Segment(whole(rng.choice([120, 600]), sample), 0.0)]
    for k in range(int(round(1 / step))):
        out += [Segment(pulse, rate * q, "next"), Segment(rest, 0.0)]
        if k * step >= 0.1:
            out += [Segment(whole(10, sample), -0.6 * rate * q, "next"), Segment(rest, 0.0)]
        out += [Segment(whole(3600 * step / down, sample), down * q, "rest"),
                Segment(whole(rng.choice([600, 1800]), sample), 0.0)]
    return out


def discharge(rng, cell, rate, sample):
    return [Segment(whole(rng.choice([60, 300]), sample), 0.0),
            Segment(whole(1.3 * 3600 / rate, sample), rate * cell.capacity_ah, "rest")]


def pair(rng, cell, rate, sample):
    slow = cell.capacity_ah * rate
    return [Segment(whole(600, sample), 0.0), Segment(whole(1.1 * 3600 / rate, sample), slow, "next"),
            Segment(whole(3600, sample), 0.0), Segment(whole(1.1 * 3600 / rate, sample), -slow, "next"),
            Segment(whole(3600, sample), 0.0)]


def drive(rng, cell, rate, sample):
    """Held steps of a lap that comes again and again: pulls, coasting, braking."""
    step = max(whole(1.0, sample), sample * (2 if sample > 1 else 1))
    lap = []
    while len(lap) * step < 90:
        pull = rate * rng.beta(1.2, 2.0)
        lap += [pull * g for g in rng.uniform(0.8, 1.0, int(rng.integers(1, 6)))]
        lap += [0.05 * rate] * int(rng.integers(0, 4))
        lap += [-0.5 * rate * rng.random()] * int(rng.integers(0, 3))
    mean = np.mean(lap)
    out = [Segment(whole(60, sample), 0.0)]
    drawn = 0.0
    while drawn < 1.2 and len(out) * step / sample < ROWS_MAX:
        scale = rng.uniform(0.8, 1.0)
        out += [Segment(step, float(scale * (g if drawn > 0.1 else max(g, 0.0)) * cell.capacity_ah),
                        "rest" if g > 0 else "") for g in lap]
        drawn += scale * mean * len(lap) * step / 3600
    return out


KINDS = {"hppc": hppc, "discharge": discharge, "drive": drive, "pair": pair}


def make(rng, cell, kind, temperature_c, rate, logger):
    sample = logger.sample_s
    if kind == "drive":
        sample = min(sample, 2.0)
    elif kind == "pair":
        sample = max(sample, 5.0)
    segments = KINDS[kind](rng, cell, rate, sample)
    return Program(kind, temperature_c, rate, tuple(segments), sample, logger.phase * sample,
                   logger.sparse or sample < 1.0)


def grid(program):
    """(fine times, current over the step that ends there, whether a reading is taken there, segment)."""
    t, current, read, place = [np.zeros(1)], [np.zeros(1)], [np.array([program.phase_s == 0.0])], [np.zeros(1, int)]
    begin = 0.0
    for k, s in enumerate(program.segments):
        end = begin + s.seconds
        rows = np.arange(np.ceil((begin - program.phase_s) / program.sample_s - 1e-6),
                         np.floor((end - program.phase_s) / program.sample_s + 1e-6) + 1)
        at = rows * program.sample_s
        if program.sparse:
            at = at[(at - begin < 60) | (np.mod(rows, 10) == 0) | (end - at < 1.5 * program.sample_s)]
        at = at + program.phase_s
        at = at[(at > begin + 1e-9) & (at <= end + 1e-9)]
        fine = np.unique(np.concatenate([[0.01, 0.03, 0.1, 0.2, 0.4], np.arange(0.7, 12, 0.3), np.arange(12, 60, 1.0),
                                         np.arange(60, s.seconds, 4.0), [s.seconds]]))
        fine = begin + fine[fine <= s.seconds]
        both = np.unique(np.round(np.concatenate([fine, at]), 6))
        t.append(both)
        current.append(np.full(len(both), s.current_a))
        read.append(np.isin(both, np.round(at, 6)))
        place.append(np.full(len(both), k))
        begin = end
    return tuple(np.concatenate(x) for x in (t, current, read, place))


def run(cell, program, begin=(1.0, -1.0)):
    """(response, readings as a mask): the program, cut where the voltage meets a limit."""
    for _ in range(30):
        t, current, read, place = grid(program)
        answer = cells.respond(cell, t, current, program.temperature_c, begin)
        ends = np.array([s.ends for s in program.segments])[place]
        beyond = (((answer.v < cell.v_min) & (current > 0)) | ((answer.v > cell.v_max) & (current < 0))
                  | ~np.isfinite(answer.v)) & (ends != "")
        if not beyond.any():
            return answer, read
        first = int(np.argmax(beyond))
        k = place[first]
        start = sum(s.seconds for s in program.segments[:k])
        lasted = whole(max(np.floor((t[first] - start) / program.sample_s), 1) * program.sample_s, program.sample_s)
        cut = replace(program.segments[k], seconds=lasted, ends="")
        rest = (Segment(whole(900, program.sample_s), 0.0),)
        after = program.segments[k + 1:] if ends[first] == "next" else rest
        program = replace(program, segments=(*program.segments[:k], cut, *after))
    return answer, read
