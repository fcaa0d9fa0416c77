# SPDX-License-Identifier: Apache-2.0
"""The statements of a DBC file with their lines, and what of them cantools can read.

cantools reads a file whole or not at all. Where it does not, the statements that it cannot read are found by halving
and left out, each with its line and cantools' own reason; the rest stays usable."""
from __future__ import annotations

import re
import time
from dataclasses import dataclass, field

import cantools
from cantools.database.can.formats.dbc.dbc_loader import DbcParser

INDEPENDENT = "VECTOR__INDEPENDENT_SIG_MSG"  # holds signals that are on no bus
KEYWORDS = frozenset(
    "BA_ BA_DEF_ BA_DEF_DEF_ BA_DEF_DEF_REL_ BA_DEF_REL_ BA_DEF_SGTYPE_ BA_REL_ BA_SGTYPE_ BO_ BO_TX_BU_ BS_ BU_ CAT_ "
    "CAT_DEF_ CM_ ENVVAR_DATA_ EV_ EV_DATA_ FILTER NS_ NS_DESC_ SG_ SG_MUL_VAL_ SGTYPE_ SGTYPE_VAL_ SIG_GROUP_ "
    "SIG_TYPE_REF_ SIG_VALTYPE_ SIGTYPE_VALTYPE_ VAL_ VAL_TABLE_ VERSION".split())
OPEN_ENDED = frozenset(("BO_", "SG_", "BS_", "BU_", "NS_", "VERSION", ""))  # end where the next one begins
AFTER_NAMES = frozenset(("BS_", "BU_", "BO_"))  # what may follow NS_, which lists the other keywords
# Strings as cantools takes them: \" stands within one.
TOKEN = re.compile(r'//[^\n]*|"(?:\\"|[^"])*?"|[A-Za-z0-9_]+|[ \t\r\n]+|.', re.DOTALL)
FIRST_IN_LINE = re.compile(rf"\n[ \t]*(?:{'|'.join(sorted(KEYWORDS - {'SG_', 'FILTER'}))})(?=[ \t:\"])")
SECONDS = 30.0       # of processor time for finding what cannot be read
MOST_CASES = 65536   # of the multiplexer values that cantools writes out one by one


class TooMuchUnreadable(Exception):
    """More of a file cannot be read than can be looked at one by one."""


@dataclass
class Statement:
    keyword: str
    line: int
    begin: int
    end: int = 0
    words: list[str] = field(default_factory=list)  # without blanks and comments, the keyword first


@dataclass
class Unit:
    """A frame with its signals, or one other statement."""
    statements: list[Statement]
    text: str

    @property
    def keyword(self):
        return self.statements[0].keyword

    @property
    def line(self):
        return self.statements[0].line

    @property
    def words(self):
        return self.statements[0].words

    @property
    def is_frame(self):
        return self.keyword == "BO_" and len(self.words) > 2

    @property
    def is_sent(self):
        return self.is_frame and self.words[2] != INDEPENDENT

    @property
    def number(self):
        """Identifier of the frame that a statement is about, None when it is about none."""
        digits = self.words[1] if len(self.words) > 1 else ""
        return int(digits) if digits.isdecimal() else None


@dataclass
class Refused:
    """What was left out: the whole of a frame, or one statement."""
    unit: Unit
    reason: str


def statements_of(text: str, line: int = 1) -> list[Statement]:
    out: list[Statement] = []
    current: Statement | None = None
    for match in TOKEN.finditer(text):
        token = match.group()
        begins = token in KEYWORDS and (current is None or current.keyword in OPEN_ENDED)
        if current is not None and current.keyword == "NS_" and token not in AFTER_NAMES:
            begins = False
        if token[0] not in " \t\r\n" and not token.startswith("//"):
            if begins or current is None:
                current = Statement(token if begins else "", line, match.start())
                out.append(current)
            current.words.append(token)
            current.end = match.end()
            if token == ";" and (current.keyword not in OPEN_ENDED or current.keyword == ""):
                current = None
        line += token.count("\n")
    return out


def units_of(text: str, line: int = 1) -> list[Unit]:
    units: list[Unit] = []
    for statement in statements_of(text, line):
        if statement.keyword == "SG_" and units and units[-1].keyword == "BO_":
            units[-1].statements.append(statement)
            units[-1].text = text[units[-1].statements[0].begin:statement.end]
        else:
            units.append(Unit([statement], text[statement.begin:statement.end]))
    return units


def load(units: list[Unit]):
    return cantools.database.load_string("\n".join(unit.text for unit in units), "dbc", strict=False, sort_signals=None)


def reason_of(error: Exception) -> str:
    text = str(getattr(error, "e_dbc", None) or error) or type(error).__name__
    return " ".join(re.sub(r"^DBC: ", "", text).split())[:300]


def failing(units: list[Unit], read, deadline: float) -> list[Refused]:
    """Of units that do not need each other: those that `read` refuses, found by halving."""
    if not units:
        return []
    try:
        read(units)
        return []
    except Exception as error:  # whatever cantools raises for a text: its own errors, ValueError, KeyError, ...
        if len(units) == 1:
            return [Refused(units[0], reason_of(error))]
    if time.process_time() > deadline:
        raise TooMuchUnreadable(units[0].line)
    half = len(units) // 2
    return failing(units[:half], read, deadline) + failing(units[half:], read, deadline)


def syntax(units: list[Unit]) -> None:
    # Blank lines in front make the line in cantools' message that of the file.
    # A frame behind them shows that the last one has an end: the grammar forgives the end of a file in its middle.
    DbcParser().parse("\n" * (units[0].line - 1) + "\n".join(unit.text for unit in units) + "\nBO_ 1 End: 0 X\n")


def without_noise(entry: Refused) -> tuple[Unit | None, Refused]:
    """A frame has no end of its own: what stands in the lines behind it and is no statement is not part of it."""
    unit = entry.unit
    last = unit.statements[-1].begin - unit.statements[0].begin
    cut = unit.text.find("\n", last)
    if not unit.is_frame or cut < 0:
        return None, entry
    frame = Unit(unit.statements, unit.text[:cut])
    line = unit.line + unit.text.count("\n", 0, cut) + 1
    noise = Unit([Statement("", line, unit.statements[0].begin + cut, words=["noise"])], unit.text[cut + 1:])
    if failing([frame], syntax, 0.0):
        return None, entry
    return frame, Refused(noise, entry.reason)


def readable_units(text: str, deadline: float) -> tuple[list[Unit], list[Refused]]:
    """The units that follow the grammar. A string that is never closed would hide everything to the next quote: such
    a statement ends before the next line that begins with a keyword, and what follows is looked at anew."""
    refused: list[Refused] = []
    good: list[Unit] = []
    begin, line = 0, 1
    while True:
        units = units_of(text[begin:], line)
        bad = failing(units, syntax, deadline)
        torn = next((entry for entry in bad if FIRST_IN_LINE.search(entry.unit.text)), None)
        if time.process_time() > deadline:
            raise TooMuchUnreadable(line)
        if torn is None:
            mended = {id(entry.unit): without_noise(entry) for entry in bad}
            for unit in units:
                frame, entry = mended.get(id(unit), (unit, None))
                good += [frame] if frame else []
                refused += [entry] if entry else []
            return good, refused
        before = units[:units.index(torn.unit)]
        left_out = {id(entry.unit) for entry in bad}
        good += [unit for unit in before if id(unit) not in left_out]
        refused += [entry for entry in bad if entry.unit in before]
        cut = FIRST_IN_LINE.search(torn.unit.text).start() + 1
        first = torn.unit.statements[0]
        refused.append(Refused(Unit([first], torn.unit.text[:cut]), torn.reason))
        begin += first.begin + cut
        line = torn.unit.line + torn.unit.text.count("\n", 0, cut)


def without_owner(unit: Unit, signals: set[tuple[int, str]]) -> bool:
    """Names of values and value types of signals that no frame has, which decoding does not need."""
    if unit.keyword not in ("VAL_", "SIG_VALTYPE_") or unit.number is None or len(unit.words) < 3:
        return False
    return (unit.number, unit.words[2]) not in signals


def too_many_cases(unit: Unit) -> bool:
    pairs = re.findall(r"(\d+)\s*-\s*(\d+)", unit.text.split(unit.words[3], 1)[-1]) if len(unit.words) > 3 else []
    return sum(int(last) - int(first) + 1 for first, last in pairs) > MOST_CASES


def meaningful(units: list[Unit], deadline: float) -> tuple[list[Unit], list[Refused]]:
    """The units that cantools reads together: frames first, then the statements about them, as many as it takes."""
    frames = [unit for unit in units if unit.is_frame]
    signals = {(unit.number, statement.words[1]) for unit in frames if unit.is_sent
               for statement in unit.statements[1:] if len(statement.words) > 1}
    others = [unit for unit in units if not unit.is_frame and not without_owner(unit, signals)]
    refused = [Refused(unit, f"more than {MOST_CASES} values of a multiplexer") for unit in others
               if unit.keyword == "SG_MUL_VAL_" and too_many_cases(unit)]
    others = [unit for unit in others if all(entry.unit is not unit for entry in refused)]
    bad_frames = failing(frames, load, deadline)
    refused += bad_frames
    kept = [unit for unit in frames if all(entry.unit is not unit for entry in bad_frames)]
    known = {unit.number for unit in kept}
    others = [unit for unit in others if unit.keyword not in ("VAL_", "SIG_VALTYPE_") or unit.number in known]

    def add(chunk: list[Unit]) -> None:
        nonlocal kept
        found = failing(chunk, lambda part: load(kept + part), deadline) if len(chunk) == 1 else None
        if found is None:
            try:
                load(kept + chunk)
                found = []
            except Exception as error:
                if time.process_time() > deadline:
                    raise TooMuchUnreadable(chunk[0].line) from error
        if found is not None:
            refused.extend(found)
            kept = kept + [unit for unit in chunk if all(entry.unit is not unit for entry in found)]
            return
        add(chunk[:len(chunk) // 2])
        add(chunk[len(chunk) // 2:])

    # Definitions of attributes are needed by what uses them.
    others.sort(key=lambda unit: not unit.keyword.startswith("BA_DEF_"))
    if others:
        add(others)
    return kept, refused


def read_statements(text: str):
    """(database, the units of its frames in its order, what was left out)."""
    units = units_of(text)
    if not any(unit.keyword == "SG_MUL_VAL_" and too_many_cases(unit) for unit in units):
        try:
            database = cantools.database.load_string(text, "dbc", strict=False, sort_signals=None)
            return database, [unit for unit in units if unit.is_sent], []
        except Exception:  # nothing is lost: what cannot be read is found statement by statement
            pass
    deadline = time.process_time() + SECONDS
    units, torn = readable_units(text, deadline)
    units, refused = meaningful(units, deadline)
    frames = [unit for unit in units if unit.is_sent]
    database = load(units) if frames else None
    return database, frames, torn + refused
