# SPDX-License-Identifier: Apache-2.0
"""Effects put exactly into recordings of real cars: what a sensor or a contact does to a log needs no model.

Of pieces of 20 s of the untouched recording every third identifies the model, every third makes the three known good
logs, in turn, and the rest is asked about, once as it is and then with each effect at 1.5, 3 and 10 times the detectable size:
three different thirds, since a model is better on what it was made from than known good logs are allowed to be.
(Halves would not do: a recording is one discharge, and the second half has charges that the first never saw.) That size
comes from the recording itself: 3.3 standard errors of the effect's size, from how a regression of the voltage on the
current, its two lags and the charge misses it, minute by minute.
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
REFERENCES = 3
PIECE = 20.0  # s; short, since a battery is heated by its measured voltage, which holes hide
AT_FIRST = 30.0  # s that every part keeps: the charge at which the recording begins


@dataclass(frozen=True)
class Recording:
    name: str
    file: str  # below the folder of measured data
    columns: dict  # role: column
    begin_s: float  # where the contactors have closed
    end_s: float  # before a cell is nearly empty: what a piece there shows no other has
    series: int
    parallel: int
    kinds: tuple  # of what is put into it: a constant current tells no sensor of it from the cells
    test: str = ""  # a cell's own test, where the recording's constant current tells no resistance from the charge


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
UCD = "ucd_fe6_fsae/fsae_lincoln_2019_endurance_stint1.csv.gz"
KSU = "ksu_ks6e_fsae/fsae_michigan_ev_2023_endurance_stint1.csv.gz"
RECORDINGS = (
    Recording("ucd_fe6", UCD, METER, 60.0, np.inf, 28, 1, OF_METER),
    Recording("ksu", KSU, METER, 30.0, np.inf, 72, 8, OF_METER),
    Recording(
        "leaf_stack",
        "leaf_cell_ornl/pack6s2p_discharge_1_0c.csv.gz",
        STACK,
        0.0,
        2700.0,
        6,
        2,
        ("weak_cell", "thermistor_lag"),
        "leaf_cell_ornl/hppc_25C.csv.gz",
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
    keep = closed & (log["time"] >= recording.begin_s) & (log["time"] <= recording.end_s)
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


def third(part, reference=None):
    """Pieces for the model (0), the known good logs (1, one of them where it is given), and the questions (2)."""

    def use(piece):
        mine = piece % 3 == part
        return mine if reference is None else mine and piece // 3 % REFERENCES == reference

    return use


def columns(log):
    """{role: column, unit} of a plain table of a pack."""
    known = {"current": ("pack_current_a", "A"), "pack_voltage": ("pack_voltage_v", "V")}
    unit = {role: ("_v", "V") if role.startswith("cell") else ("_c", "degC") for role in log if role != "time"}
    return {role: known.get(role, (role + end, name)) for role, (end, name) in unit.items()}


def write_map(path, log):
    """The sign of the current is declared: a constant one with holes tells it by weak evidence only."""
    lines = ["[roles]", 'time = {column = "time_s", unit = "s"}']
    for role, (column, unit) in columns(log).items():
        sign = ', discharge = "+"' if role == "current" else ""
        lines.append(f'{role} = {{column = "{column}", unit = "{unit}"{sign}}}')
    path.write_text("\n".join(lines) + "\n")


def write(path, log, use):
    """A plain table of a pack; only the current is there in pieces that are not used."""
    roles = [role for role in log if role != "time"]
    names = [column for column, _ in columns(log).values()]
    begin = log["time"][0]
    lines = [",".join(["time_s", *names])]
    for time, *values in zip(log["time"], *(log[role] for role in roles)):
        used = time - begin < AT_FIRST or use(int((time - begin) // PIECE))
        shown = ["%.4f" % value if used or role == "current" else "" for role, value in zip(roles, values)]
        lines.append(",".join(["%.3f" % time, *shown]))
    path.write_text("\n".join(lines) + "\n")


def identify(binary, data, folder, recording):
    """The model from its pieces of the untouched recording, which are then taken away, or from a test of its cell."""
    out = folder / "cell.toml"
    pack = ("--cells-in-series", recording.series, "--cells-in-parallel", recording.parallel, "--rc", 2)
    source = ("--temperature", 25, data / recording.test) if recording.test else (folder / "untouched.csv", *pack)
    command = [binary, "identify", *source, "--out", out]
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

    @property
    def named(self):
        """The verdict is `named`, and every cause in it stands for what was injected."""
        return self.answer.verdict == "named" and self.right and not self.misnamed

    @property
    def misnamed(self):
        """The verdict is `named`, with a cause that was not put there and cannot stand for it."""
        stands = set(self.injection.names)
        return self.answer.verdict == "named" and any(
            not stands & {cause["name"], *cause.get("equivalent_to", [])} for cause in self.answer.causes
        )


def run(binary, data, folder, running, tell):
    """All recordings, one question after the other. `tell(text)` is progress."""
    out = []
    for recording in RECORDINGS:
        log = load(data, recording)
        place = folder / secrets.token_hex(8)
        place.mkdir()
        write(place / "untouched.csv", log, third(0))
        identify(binary, data, place, recording)
        write_map(place / "map.toml", log)
        for k in range(REFERENCES):
            write(place / f"reference_{k + 1}.csv", log, third(1, k))
        for injection, times, size, changed in questions(log, recording.kinds):
            tell(f"{recording.name}, question {len(out) + 1}")
            write(place / "log.csv", changed, third(2))
            answer = tool.ask(binary, place, 1, "", running)
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
    lines.append(f"untouched and clean: {share(it.right for it in outcomes if it.injection is None)}")
    for times in TIMES:
        asked = [it for it in outcomes if it.injection is not None and it.times == times]
        lines.append(
            f"at {times:g} times the detectable size: reported {share(it.right for it in asked)}, "
            f"by a verdict `named` {share(it.named for it in asked)}, "
            f"by one that names something else {share(it.misnamed for it in asked)}"
        )
    return "\n".join(lines)
