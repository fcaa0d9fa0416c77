# SPDX-License-Identifier: Apache-2.0
"""A log that begins when the car drives, and one whose logger was down for a minute or two: nobody knows what was drawn
before, and that alone is no cause. Drawn cuts of drawn drives; VOLTLAP_TEST_SEED repeats a draw."""
import pathlib

import pytest

from drawn_drives import EFFECTS, Draw, explained, rows_of, write

LEAST_S = 60.0  # of the drive after a gap


def stamp(line):
    return float(line[1:line.index(")")])


def cut(log, folder, keeps):
    """The rows or frames whose time `keeps` keeps."""
    if not log.endswith(".log"):
        names, rows = rows_of(log)
        return write(folder / "cut.csv", names, [row for row in rows if keeps(float(row[names.index("time_s")]))])
    lines = pathlib.Path(log).read_text().splitlines(keepends=True)
    begin = stamp(lines[0])
    out = folder / "cut.log"
    out.write_text("".join(line for line in lines if keeps(stamp(line) - begin)))
    return out


def drawn_cut(draw, end_s):
    """From a drawn second on, without what is in a drawn gap."""
    begin = draw.random.choice([0.0, draw.random.uniform(5.0, 90.0)])
    length = draw.random.uniform(61.0, 130.0) if begin == 0.0 else draw.random.choice([0.0, 70.0])
    gap = draw.random.uniform(begin + 20.0, max(begin + 21.0, end_s - length - LEAST_S))
    print(f"from {begin:.1f} s, without {gap:.1f} to {gap + length:.1f} s of {end_s:.0f} s")
    return lambda time: time >= begin and not gap < time < gap + length


@pytest.mark.parametrize("candump", [False, True])
@pytest.mark.parametrize("hidden", [False, True])
def test_what_was_drawn_before_the_log_or_in_a_gap_is_no_cause_and_hides_none(tmp_path, candump, hidden):
    draw = Draw(f"cut{candump}{hidden}")
    key, low, high, name, parameter, says = draw.random.choice(EFFECTS)
    size = float(f"{draw.random.uniform(low, high):.4g}")
    log = draw.drive(tmp_path, *([key.format(size)] if hidden else []), candump=candump)
    answer, said = explained(tmp_path, cut(log, tmp_path, drawn_cut(draw, 280.0)))
    causes = [cause for cause in answer["causes"] if cause["name"] != "dropped_or_late_frames"]
    if not hidden:
        assert answer["verdict"] != "unknown" and causes == [], said
        return
    named = {n for cause in causes for n in (cause["name"], *cause["equivalent_to"])}
    assert name in named, (key.format(size), said)
    for cause in causes:
        if cause["name"] == name:
            value = cause["parameters"][parameter]["value"]
            assert abs(value - says(size)) < max(0.1 * abs(says(size)), 0.05 if name == "weak_cell" else 0.0), said
