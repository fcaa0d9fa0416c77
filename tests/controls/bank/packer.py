# SPDX-License-Identifier: Apache-2.0
"""Logs as a team's logger would write them: other units, names, signs, orders, with a role map or with plain names.

One logger a world: its log and the references come from the same one. What is written tells nothing about the case.
"""

import gzip
from dataclasses import dataclass, field

import numpy as np

# role stem: unit of the plain name, {other unit: value in it = value in SI * scale + offset}, decimals in SI
UNITS = {
    "time": ("s", {"ms": (1e3, 0.0)}, 2),
    "current": ("a", {"mA": (1e3, 0.0)}, 3),
    "voltage": ("v", {"mV": (1e3, 0.0)}, 5),
    "pack_voltage": ("v", {"mV": (1e3, 0.0)}, 4),
    "bus_voltage": ("v", {"mV": (1e3, 0.0)}, 4),
    "cell_voltage": ("v", {"mV": (1e3, 0.0)}, 5),
    "temperature": ("c", {"K": (1.0, 273.15), "degF": (1.8, 32.0)}, 3),
    "ambient": ("c", {"K": (1.0, 273.15)}, 2),
    "soc": ("", {"%": (100.0, 0.0)}, 5),
    "speed": ("mps", {"km/h": (3.6, 0.0), "mph": (1 / 0.44704, 0.0)}, 3),
    "wheel_speed": ("mps", {"km/h": (3.6, 0.0)}, 3),
    "accelerator": ("", {"%": (100.0, 0.0)}, 4),
    "brake": ("", {"%": (100.0, 0.0)}, 4),
    "motor_speed": ("rpm", {}, 2),
    "motor_torque": ("nm", {}, 2),
}
SI_UNIT = {"s": "s", "a": "A", "v": "V", "c": "degC", "mps": "m/s", "rpm": "rpm", "nm": "Nm", "": "1"}
RPM = 60.0 / (2.0 * np.pi)


def stem(role):
    return role.rstrip("0123456789").rstrip("_")


def plain_name(role, kind):
    """Column of the plain tables."""
    unit = UNITS[stem(role)][0]
    name = "pack_current" if role == "current" and kind != "cell" else role
    return f"{name}_{unit}" if unit else name


@dataclass
class Logger:
    """How one car's logger writes."""

    kind: str
    mapped: bool
    unit: dict = field(default_factory=dict)  # role stem: other unit
    name: dict = field(default_factory=dict)  # role: column
    order: list = field(default_factory=list)
    discharge_sign: float = 1.0
    start_s: float = 0.0
    packed: bool = False


def logger_of(rng, kind, roles):
    roles = ["time", *roles]
    out = Logger(
        kind,
        mapped=bool(rng.integers(2)),
        start_s=float(np.round(rng.uniform(0.0, 5e3), 1)),
        packed=bool(rng.integers(2)),
    )
    out.discharge_sign = float(rng.choice([1.0, -1.0]))
    out.order = [roles[k] for k in rng.permutation(len(roles))]
    for role in roles:
        out.name[role] = plain_name(role, kind)
    if out.mapped:
        for part in sorted({stem(role) for role in roles}):
            others = [""] + sorted(UNITS[part][1])
            out.unit[part] = str(rng.choice(others))
        for number, role in enumerate(out.order):
            out.name[role] = f"ch{number:02d}"
    return out


def role_map(logger):
    """Text of the map, or None where the plain names need none."""
    if not logger.mapped:
        return None
    lines = ["[roles]"]
    for role in logger.order:
        part = stem(role)
        unit = logger.unit[part] or SI_UNIT[UNITS[part][0]]
        sign = ', discharge = "auto"' if role == "current" else ""
        told = "temperature_1" if role == "temperature" else role  # the plain table of a cell has no number
        lines.append(f'{told} = {{column = "{logger.name[role]}", unit = "{unit}"{sign}}}')
    return "\n".join(lines) + "\n"


def columns(logger, log, step_s):
    """{role: values as they are written}."""
    steps = len(next(iter(log.values())))
    values = {"time": logger.start_s + np.arange(steps) * step_s, **log}
    values["current"] = values["current"] * logger.discharge_sign
    if "motor_speed" in values:
        values["motor_speed"] = values["motor_speed"] * RPM
    out = {}
    for role in logger.order:
        scale, offset = UNITS[stem(role)][1].get(logger.unit.get(stem(role), ""), (1.0, 0.0))
        out[role] = values[role] * scale + offset
    return out


def decimals(logger, role):
    scale, _ = UNITS[stem(role)][1].get(logger.unit.get(stem(role), ""), (1.0, 0.0))
    return max(0, UNITS[stem(role)][2] - int(round(np.log10(scale))))


def write_log(path, logger, log, step_s, keep=None):
    """`keep`: the rows that were not lost. Returns the path."""
    data = columns(logger, log, step_s)
    rows = slice(None) if keep is None else keep
    texts = [[f"%.{decimals(logger, role)}f" % value for value in data[role][rows]] for role in logger.order]
    text = ",".join(logger.name[role] for role in logger.order) + "\n" + "\n".join(map(",".join, zip(*texts))) + "\n"
    if str(path).endswith(".gz"):
        with gzip.GzipFile(path, "wb", compresslevel=1, mtime=0) as out:
            out.write(text.encode())
    else:
        path.write_text(text)
    return path
