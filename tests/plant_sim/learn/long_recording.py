# SPDX-License-Identifier: Apache-2.0
"""A recording of a day, made up: a cell with one branch, a pause of two hours, at the end an open contactor."""
import math

CAPACITY_AH, R0, R1, TAU_S = 3.0, 0.030, 0.020, 40.0
PAUSE_AT_S, PAUSE_S, OPEN_ROWS = 31000, 7200, 25


def current_at(time_s):
    """Rests of an hour, a pulse, and a slow discharge of twenty minutes, again and again."""
    phase = time_s % 5400
    if phase < 3600:
        return 0.0
    return 3.0 if phase < 3640 else 0.0 if phase < 3720 else 0.7


def step_after(time_s):
    """Rows come each second about a pulse, and slower elsewhere."""
    return 1 if 3590 <= time_s % 5400 < 3730 else 10


def write(path, first_v=4.1, hours=24):
    """Rows of time, current and voltage; the time of the row behind the pause."""
    soc, branch, time_s, lines, behind = 1.0, 0.0, 0.0, ["time_s,current_a,voltage_v"], 0.0
    while time_s < hours * 3600:
        current, step = current_at(time_s), step_after(time_s)
        branch += (R1 * current - branch) * (1 - math.exp(-step / TAU_S))
        soc -= current * step / 3600 / CAPACITY_AH
        voltage = first_v - 0.9 * (1 - soc) - 0.15 * math.sin(4 * soc) - R0 * current - branch
        lines.append(f"{time_s:.1f},{current:.3f},{voltage + 0.0005 * math.sin(time_s):.4f}")
        time_s += step
        if time_s == PAUSE_AT_S:
            time_s, branch = time_s + PAUSE_S, 0.0
            behind = time_s
    lines += [f"{time_s + 10 * k:.1f},0.000,2.1000" for k in range(OPEN_ROWS)]
    path.write_text("\n".join(lines) + "\n")
    return behind
