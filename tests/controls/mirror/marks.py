# SPDX-License-Identifier: Apache-2.0
"""What the answers are worth: shares with Wilson's 95 % intervals by rho, kind and cause; sizes and gains."""

from dataclasses import dataclass

from bank.statistics import median, share

BINS = (("rho below 1", 0.0, 1.0), ("rho 1 to 3", 1.0, 3.0), ("rho of 3 and more", 3.0, float("inf")))
CLEAR = 3.0
WITHIN = 0.10  # of what was promised


@dataclass(frozen=True)
class Said:
    """One case with the answer of one engine."""

    outcome: object
    judged: object
    gain: dict | None

    @property
    def label(self):
        return self.outcome.label

    @property
    def alarm(self):
        return self.judged.answer.verdict != "no_discrepancy"

    @property
    def failing(self):
        """A sound log accused, a wrong name, or an effect of three times the practical size that was passed over."""
        if self.label["ask"] == "sound":
            return self.alarm
        return self.judged.misnamed or (self.label["visible"] and self.label["rho"] >= CLEAR and not self.judged.found)


def said_by(engine, outcomes):
    return [Said(o, o.judged[engine], o.gains.get(engine)) for o in outcomes if engine in o.judged]


def sound(said):
    return [s for s in said if s.label["ask"] == "sound"]


def effects(said, visible=True):
    return [s for s in said if s.label["ask"] == "single" and s.label["visible"] == visible]


def asked_alone(said, alone):
    """Those without references, or those with."""
    return [s for s in said if (s.label.get("references", 0) == 0) == alone]


def in_bin(said, low, high):
    return [s for s in said if low <= s.label["rho"] < high]


def shares(said):
    """{what: Share} of cases with an effect."""
    judged = [s.judged for s in said]
    return {
        "found": share(j.found for j in judged),
        "named": share(j.named for j in judged),
        "in the set": share(j.in_set for j in judged),
        "misnamed": share(j.misnamed for j in judged),
    }


def sizes(said):
    """(median error of a size, intervals that cover) of the named ones."""
    given = [p for p in (s.judged.parameter() for s in said) if p]
    errors = [abs(value / true - 1.0) for true, value, _, _ in given]
    return median(errors), share(low <= true <= high for true, _, low, high in given)


def gains(said):
    """(median of real over the true model's, how many, real within 10 % of what was promised)."""
    got = [s.gain for s in said if s.gain]
    close = share(abs(g["real"] - g["promised"]) <= WITHIN * abs(g["promised"]) for g in got)
    return median([g["real"] / g["true"] for g in got]), len(got), close


def left_of_sound(said, channel):
    """Median RMS that the model leaves of a sound log, by the engine's own account, and how many said it."""
    got = [s.judged.answer.gain[channel]["heldout_rms_before"] for s in sound(said) if channel in s.judged.answer.gain]
    return median(got), len(got)


def alarms(said):
    return share(s.alarm for s in sound(said))


def instead(said):
    """What was said instead of the right name, {words: count}."""
    out = {}
    for s in said:
        if not s.judged.named:
            answer = s.judged.answer
            text = answer.failed or " + ".join([answer.verdict, *[c["name"] for c in answer.causes]])
            out[text] = out.get(text, 0) + 1
    return out


def smallest_failing(said):
    """The failing case with the least to read; None where nothing fails."""
    failing = [s for s in said if s.failing]
    return min(failing, key=lambda s: (s.outcome.weight, s.label["number"]), default=None)


def invisible(outcomes):
    """[(what, cases)] of effects that no log of their kind can show, and the share of all effects."""
    single = [o for o in outcomes if o.label["ask"] == "single"]
    hidden = [o for o in single if not o.label["visible"]]
    names = {}
    for o in hidden:
        what = f"{o.label['effects'][0]['name']} ({o.label['kind']}, {o.label['format']})"
        names[what] = names.get(what, 0) + 1
    return sorted(names.items(), key=lambda item: (-item[1], item[0])), share(not o.label["visible"] for o in single)
