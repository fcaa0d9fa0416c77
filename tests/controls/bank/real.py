# SPDX-License-Identifier: Apache-2.0
"""Effects put exactly into recordings of real cars: what a sensor or a contact does to a log needs no model.

The model is identified from every other minute of the untouched recording, and the minutes between are asked about, once
as they are and then with each effect at 1.5, 3 and 10 times the detectable size. (Halves would not do: a recording is one
discharge, and the second half has charges that the first never saw.) That size comes from the recording itself: 3.3 standard errors of the effect's size, from how a regression of the voltage on the current, its
two lags and the charge misses it, minute by minute.
"""

import gzip
import secrets
import subprocess
from dataclasses import dataclass

import numpy as np

from . import tool
from .statistics import share

DETECTABLE = 3.3
TIMES = (1.5, 3.0, 10.0)


@dataclass(frozen=True)
class Recording:
    name: str
    file: str  # below the folder of measured data
    columns: dict  # role: column
    begin_s: float  # where the contactors have closed
    series: int
    parallel: int
    kinds: tuple  # of what is put into it: a constant current tells no sensor of it from the cells


METER = {"current": "i_a", "pack_voltage": "v_v"}
STACK = {
    "current": "i_a",
    "pack_voltage": "v_pack_v",
    **{f"cell_voltage_{k}": f"c{k}_v" for k in range(1, 7)},
    **{f"temperature_{k}": f"t{k}_c" for k in range(1, 4)},
}
OF_METER = (
    "current_gain",
    "current_offset",
    "time_skew",
    "contact_resistance",
    "quantisation",
    "dropped_or_late_frames",
)
RECORDINGS = (
    Recording("ucd_fe6", "ucd_fe6_fsae/fsae_lincoln_2019_endurance_stint1.csv.gz", METER, 60.0, 28, 1, OF_METER),
    Recording("ksu", "ksu_ks6e_fsae/fsae_michigan_ev_2023_endurance_stint1.csv.gz", METER, 30.0, 72, 8, OF_METER),
    Recording(
        "leaf_stack", "leaf_cell_ornl/pack6s2p_discharge_1_0c.csv.gz", STACK, 0.0, 6, 2, ("weak_cell", "thermistor_lag")
    ),
)


def load(folder, recording):
    """{role: values} with time, the contactors closed."""
    with gzip.open(folder / recording.file, "rt") as lines:
        names = next(lines).strip().split(",")
        rows = np.genfromtxt(lines, delimiter=",")
    log = {role: rows[:, names.index(column)] for role, column in recording.columns.items()}
    log["time"] = rows[:, names.index("t_s")]
    closed = log["pack_voltage"] > 0.6 * np.nanmedian(log["pack_voltage"])
    keep = closed & (log["time"] >= recording.begin_s)
    return {role: values[keep] for role, values in log.items()}


def lagged(values, time, lag_s):
    out = np.empty_like(values)
    state = values[0]
    for k, value in enumerate(values):
        step = time[k] - time[k - 1] if k else 0.0
        state += (1.0 - np.exp(-step / lag_s)) * (value - state)
        out[k] = state
    return out


def regressors(log):
    current, time = log["current"], log["time"]
    charge = np.concatenate(([0.0], np.cumsum(current[:-1] * np.diff(time)))) / 3600.0
    unit = charge / max(np.abs(charge).max(), 1e-9)
    return np.stack(
        [
            np.ones_like(unit),
            current,
            lagged(current, time, 10.0),
            lagged(current, time, 100.0),
            unit,
            unit**2,
            unit**3,
        ],
        1,
    )


def standard_error(log, changed, size, channel):
    """Of the size of an effect as the recording lets it be measured in a channel, in units of `size`.

    What the regression misses of the untouched part is all that such a model gets wrong. Each minute gives an estimate
    of the effect from that residual; their scatter is the error of the whole.
    """
    fit, *_ = np.linalg.lstsq(regressors(log), channel(log), rcond=None)
    left = channel(log) - regressors(log) @ fit
    change = (channel(changed) - regressors(changed) @ fit) - left
    minute = ((log["time"] - log["time"][0]) // 60.0).astype(int)
    weight = np.bincount(minute, change * change)
    product = np.bincount(minute, change * left)
    mean = product.sum() / weight.sum()
    return size * float(np.sqrt(((product - mean * weight) ** 2).sum()) / weight.sum())


def pack_voltage(log):
    return log["pack_voltage"]


def second_cell(log):
    """Against the mean of all cells, as whoever looks for a weak one does it."""
    return log["cell_voltage_2"] - np.mean([log[f"cell_voltage_{k}"] for k in range(1, 7)], 0)


def first_thermistor(log):
    return log["temperature_1"]


def gain(log, size):
    return {**log, "current": log["current"] * (1.0 + size)}


def offset(log, size):
    return {**log, "current": log["current"] + size}


def skew(log, size):
    return {**log, "current": np.interp(log["time"] - size, log["time"], log["current"])}


def contact(log, size):
    return {**log, "pack_voltage": log["pack_voltage"] - size * log["current"]}


def one_cell(log, size):
    drop = size * log["current"]
    return {**log, "cell_voltage_2": log["cell_voltage_2"] - drop, "pack_voltage": log["pack_voltage"] - drop}


def slow_thermistor(log, size):
    return {**log, "temperature_1": lagged(log["temperature_1"], log["time"], size)}


def quantised(log, size):
    return {**log, "current": np.round(log["current"] / size) * size}


def dropped(log, size):
    keep = np.random.default_rng(0).random(log["time"].size) > size
    return {role: values[keep] for role, values in log.items()}


@dataclass(frozen=True)
class Injection:
    """`names`: causes that may stand for it; from a pack's voltage and current alone some cannot be told apart."""

    kind: str
    names: tuple
    change: object
    nominal: float
    channel: object = pack_voltage  # in which it shows
    sizes: tuple = ()  # given where nothing that is measured tells what is detectable


ALL_RESISTANCE = (
    "series_resistance",
    "contact_resistance",
    "resistance_temperature",
    "resistance_current",
    "resistance_soc",
    "current_gain",
    "capacity",
)
INJECTIONS = (
    Injection("current_gain", ("current_gain", *ALL_RESISTANCE), gain, 0.02),
    Injection("current_offset", ("current_offset", "capacity", "self_discharge"), offset, 1.0),
    Injection("time_skew", ("time_skew", "polarization_resistance"), skew, 0.1),
    Injection("contact_resistance", ("contact_resistance", *ALL_RESISTANCE), contact, 0.01),
    Injection(
        "weak_cell",
        ("weak_cell", "voltage_gain", "voltage_offset"),
        one_cell,
        1e-4,
        second_cell,
    ),
    Injection("thermistor_lag", ("thermistor_lag",), slow_thermistor, 30.0, first_thermistor),
    Injection("quantisation", ("quantisation",), quantised, 0.0, sizes=(2.0, 5.0, 20.0)),
    Injection("dropped_or_late_frames", ("dropped_or_late_frames",), dropped, 0.0, sizes=(0.01, 0.03, 0.1)),
)


def write(path, log):
    """A plain table of a pack."""
    roles = [role for role in log if role != "time"]
    units = {"current": "pack_current_a", "pack_voltage": "pack_voltage_v"}
    names = [units.get(role, role + ("_v" if role.startswith("cell") else "_c")) for role in roles]
    rows = zip(log["time"], *(log[role] for role in roles))
    text = "\n".join(",".join(["%.3f" % row[0], *("%.4f" % value for value in row[1:])]) for row in rows)
    path.write_text(",".join(["time_s", *names]) + "\n" + text + "\n")


def identify(binary, folder, recording):
    """The model from the even minutes of the untouched recording, which is then taken away."""
    out = folder / "cell.toml"
    command = [
        binary,
        "identify",
        folder / "untouched.csv",
        "--cells-in-series",
        recording.series,
        "--cells-in-parallel",
        recording.parallel,
        "--rc",
        "2",
        "--blocks",
        "60:even",
        "--out",
        out,
    ]
    result = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    (folder / "untouched.csv").unlink()
    if result.returncode != 0:
        raise RuntimeError(f"voltlap identify failed on {recording.name}: " + result.stderr.strip())
    (folder / "model.toml").write_text(
        f'[battery]\ncell = "cell.toml"\ncells_in_series = {recording.series}\n'
        f"cells_in_parallel = {recording.parallel}\ninitial_soc = 1.0\ninitial_temperature_c = 30.0\n"
        "lookup_current_floor_a = 5.0\n"
    )


def questions(log, kinds):
    """[(injection or None, times detectable, size, log)] for a recording."""
    out = [(None, 0.0, 0.0, log)]
    for injection in INJECTIONS:
        if injection.kind not in kinds:
            continue
        if injection.sizes:
            sizes = zip(TIMES, injection.sizes)
        else:
            changed = injection.change(log, injection.nominal)
            one = DETECTABLE * standard_error(log, changed, injection.nominal, injection.channel)
            sizes = [(times, times * one) for times in TIMES]
        out += [(injection, times, size, injection.change(log, size)) for times, size in sizes]
    return out


@dataclass(frozen=True)
class Outcome:
    recording: str
    injection: object  # None: the recording as it is
    times: float
    size: float
    answer: object
    before: frozenset = frozenset()  # what was said about the recording as it is

    @property
    def said(self):
        names = {cause["name"] for cause in self.answer.causes}
        for cause in self.answer.causes:
            names |= set(cause.get("equivalent_to", []))
        for group in self.answer.alternatives:
            names |= set(group)
        return names

    @property
    def right(self):
        """The untouched recording is clean; what was injected, or what such a log cannot tell from it, is newly reported."""
        if self.injection is None:
            return self.answer.verdict == "no_discrepancy"
        return bool((self.said - self.before) & set(self.injection.names))


def run(binary, data, folder, running, tell):
    """All recordings, one question after the other. `tell(text)` is progress."""
    out = []
    for recording in RECORDINGS:
        log = load(data, recording)
        place = folder / secrets.token_hex(8)
        place.mkdir()
        write(place / "untouched.csv", log)
        identify(binary, place, recording)
        for injection, times, size, changed in questions(log, recording.kinds):
            tell(f"{recording.name}, question {len(out) + 1}")
            write(place / "log.csv", changed)
            answer = tool.ask(binary, place, 1, "", running, ("explain.fit_blocks=odd",))
            if injection is None:
                before = frozenset(Outcome(recording.name, None, 0.0, 0.0, answer).said)
            out.append(Outcome(recording.name, injection, times, size, answer, before))
            (place / "answer.json").unlink(missing_ok=True)
    return out


def text_of(outcomes):
    lines = [f"{'recording':10} {'put into it':24} {'times detectable':>16} {'size':>9}  {'right':5} verdict, causes"]
    for it in outcomes:
        kind = "nothing" if it.injection is None else it.injection.kind
        words = it.answer.failed or ", ".join([it.answer.verdict] + [cause["name"] for cause in it.answer.causes])
        right = "yes" if it.right else "no"
        lines.append(f"{it.recording:10} {kind:24} {it.times:16.1f} {it.size:9.4g}  {right:5} {words}")
    for times in TIMES:
        lines.append(
            f"reported at {times:g} times the detectable size: "
            f"{share(it.right for it in outcomes if it.injection is not None and it.times == times)}"
        )
    return "\n".join(lines)
