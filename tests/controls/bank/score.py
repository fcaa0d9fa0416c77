# SPDX-License-Identifier: Apache-2.0
"""What the answers are worth: shares with intervals, by mark, by cause, by d', by rho.

A label is what cases.py made, an answer what tool.py read. Marks count cases whose d' is 10 or more; curves count all.
rho is how large an effect is for a person: RMS of what it adds to the channel that shows it best, over what is worth
a word there (truth/hide.py).
"""

import math
from dataclasses import dataclass

from .statistics import median, share

CLEAR = 10.0
ALIKE = 0.9  # cosine above which two effects of a pair count as one class
EDGES = (0.0, 1.0, 3.3, 10.0, 30.0, 100.0, math.inf)
BY_RHO = (  # from, to, bounds of the shares
    (0.0, 1.0, {}),
    (1.0, 3.0, {"found": (0.75, "least"), "in the set": (0.60, "least"), "misnamed": (0.04, "most")}),
    (3.0, math.inf, {"found": (0.95, "least"), "named": (0.75, "least"), "in the set": (0.85, "least"),
                     "misnamed": (0.03, "most")}),
)
ALARMS = ("named", "ambiguous", "unknown")


@dataclass(frozen=True)
class Judged:
    """One case with its answer."""

    name: str
    label: dict
    answer: object
    without: str = ""

    @property
    def truth(self):
        return [effect["name"] for effect in self.label["effects"]]

    @property
    def ask(self):
        return self.label["ask"]

    @property
    def clear(self):
        return all(effect["d_prime"] >= CLEAR for effect in self.label["effects"])

    @property
    def found(self):
        return self.answer.verdict in ALARMS

    @property
    def classes(self):
        """The causes that were named, each with those that it cannot be told from."""
        return [{cause["name"], *cause.get("equivalent_to", [])} for cause in self.answer.causes]

    @property
    def named(self):
        """Every effect is named and nothing else."""
        if self.answer.verdict != "named" or len(self.classes) != len(self.truth):
            return False
        left = list(self.classes)
        for name in self.truth:
            fitting = [group for group in left if name in group]
            if not fitting:
                return False
            left.remove(min(fitting, key=len))
        return True

    @property
    def misnamed(self):
        """Sure and wrong: a cause is named that is not there. A case without an effect has no right name."""
        return self.answer.verdict == "named" and any(not group & set(self.truth) for group in self.classes)

    @property
    def reported(self):
        """All classes that were reported as possible."""
        groups = list(self.classes)
        for names in self.answer.alternatives:
            groups += [{name} for name in names if not any(name in group for group in groups)]
        return groups if self.answer.verdict in ("named", "ambiguous") else []

    @property
    def in_set(self):
        return all(any(name in group for group in self.reported) for name in self.truth)

    def parameter(self):
        """(true value, value, low, high) of the main parameter of the one effect, when it is given by that name."""
        if not self.named or len(self.truth) != 1:
            return None
        effect = self.label["effects"][0]
        cause = next((c for c in self.answer.causes if c["name"] == effect["name"]), None)
        name, true = next(
            (item for item in effect["parameters"].items() if item[0] not in ("cell", "channel")), (None, 0)
        )
        given = (cause or {}).get("parameters", {}).get(name)
        if given is None or not isinstance(given.get("value"), (int, float)) or not true:
            return None
        return true, given["value"], given["ci95_low"], given["ci95_high"]

    def gain_share(self):
        """Of the squares that the true model takes from the held-out error, the part that the named cause took.

        In the channel where the true model takes the largest share. What it leaves is what the given model leaves of
        the same drive with the same noise and without the effect.
        """
        least = 0.05  # of the squares: less is not worth a share
        ways = []
        for name, gain in self.answer.gain.items():
            before, after, sound = gain["heldout_rms_before"], gain["heldout_rms_after"], self.answer.sound_rms.get(name)
            if sound is None or before <= 0 or before**2 - sound**2 <= least * before**2:
                continue
            ways.append((1.0 - (sound / before) ** 2, 1.0 - (after / before) ** 2))
        if not ways:
            return None
        way, went = max(ways)
        return went / way


@dataclass(frozen=True)
class Mark:
    """One line of the table. `value` against `bound`: "most" or "least"."""

    text: str
    value: float
    shown: str
    bound: float
    side: str
    cases: int

    @property
    def met(self):
        if self.cases == 0 or math.isnan(self.value):
            return None
        return self.value <= self.bound if self.side == "most" else self.value >= self.bound


def of_share(text, flags, bound, side):
    it = share(flags)
    return Mark(text, it.value, str(it), bound, side, it.of)


def of_number(text, value, shown, bound, side, cases):
    return Mark(text, value, shown if cases else "no case", bound, side, cases)


def marks(judged):
    clean = [j for j in judged if j.ask == "clean"]
    single = [j for j in judged if j.ask == "single" and j.clear]
    pairs = [j for j in judged if j.ask == "pair" and j.clear and abs(j.label.get("likeness", 0.0)) < ALIKE]
    left_out = [j for j in judged if j.ask == "left_out" and j.clear]
    sets = [len(j.reported) for j in single if j.reported]
    size = sum(sets) / len(sets) if sets else math.nan
    parameters = [p for p in (j.parameter() for j in single) if p]
    errors = [abs(value / true - 1.0) for true, value, _, _ in parameters]
    gains = [g for g in (j.gain_share() for j in single if j.named) if g is not None]
    covered = share(low <= true <= high for true, _, low, high in parameters)
    out = [
        of_share("false alarms on clean logs", [j.answer.verdict != "no_discrepancy" for j in clean], 0.02, "most"),
        of_share("found, d' of 10 or more", [j.found for j in single], 0.97, "least"),
        of_share("named", [j.named for j in single], 0.90, "least"),
        of_share("truth in the reported set", [j.in_set for j in single], 0.97, "least"),
        of_number("mean size of the set", size, f"{size:.2f} over {len(sets)}", 1.5, "most", len(sets)),
        of_share("confidently misnamed", [j.misnamed for j in single], 0.05, "most"),
        of_share("pairs: both named", [j.named for j in pairs], 0.80, "least"),
        of_share(
            "left out: unknown or ambiguous",
            [j.answer.verdict in ("unknown", "ambiguous") for j in left_out],
            0.80,
            "least",
        ),
        of_share("left out: confidently misnamed", [j.answer.verdict == "named" for j in left_out], 0.05, "most"),
        of_number(
            "parameter error, median",
            median(errors),
            f"{100 * median(errors):.1f} % over {len(errors)}",
            0.10,
            "most",
            len(errors),
        ),
        of_share(
            "intervals that cover: at least 85 %",
            [low <= true <= high for true, _, low, high in parameters],
            0.85,
            "least",
        ),
        Mark("intervals that cover: at most 99 %", covered.value, str(covered), 0.99, "most", covered.of),
        of_number(
            "held-out gain over that of the true model",
            median(gains),
            f"{median(gains):.2f} over {len(gains)}",
            0.8,
            "least",
            len(gains),
        ),
    ]
    return out


def in_bin(d_prime):
    return next(k for k in range(len(EDGES) - 1) if EDGES[k] <= d_prime < EDGES[k + 1])


def curve(judged):
    """[(low, high, found, named, misnamed)] by d' of the single effects, each a Share."""
    single = [j for j in judged if j.ask == "single"]
    out = []
    for k in range(len(EDGES) - 1):
        here = [j for j in single if in_bin(j.label["d_prime"]) == k]
        out.append(
            (
                EDGES[k],
                EDGES[k + 1],
                share(j.found for j in here),
                share(j.named for j in here),
                share(j.misnamed for j in here),
            )
        )
    return out


def by_cause(judged):
    """{name: (clear cases, found, named, in the set, misnamed)}; what the tool said instead, {name: {words: count}}."""
    rows, instead = {}, {}
    for name in sorted({j.truth[0] for j in judged if j.ask in ("single", "gate")}):
        here = [
            j for j in judged if j.ask in ("single", "gate") and j.truth[0] == name and (j.clear or j.ask == "gate")
        ]
        if not here:
            continue
        rows[name] = (
            len(here),
            share(j.found for j in here),
            share(j.named for j in here),
            share(j.in_set for j in here),
            share(j.misnamed for j in here),
        )
        for j in here:
            if j.named:
                continue
            words = j.answer.failed or " + ".join([j.answer.verdict] + [c["name"] for c in j.answer.causes])
            instead.setdefault(name, {}).setdefault(words, 0)
            instead[name][words] += 1
    return rows, instead


def by_rho(judged):
    """[(low, high, {mark: Mark})] of the single effects."""
    single = [j for j in judged if j.ask == "single"]
    ways = {
        "found": lambda j: j.found,
        "named": lambda j: j.named,
        "in the set": lambda j: j.in_set,
        "misnamed": lambda j: j.misnamed,
    }
    out = []
    for low, high, bounds in BY_RHO:
        here = [j for j in single if low <= j.label["rho"] < high]
        made = {}
        for name, way in ways.items():
            bound, side = bounds.get(name, (math.nan, "least"))
            made[name] = of_share(name, [way(j) for j in here], bound, side)
        out.append((low, high, made))
    return out
